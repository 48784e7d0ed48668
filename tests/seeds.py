#!/usr/bin/env python3
"""Runs the randomised tests with other seeds and prints a table: test, seeds, failures, the seeds that failed.

  seeds.py BUILD [N] [FIRST] [--tests PATTERN] [--limit SECONDS] [--budget SECONDS] [--sites] [--markdown FILE]

FF_TEST_SEED is FIRST .. FIRST + N - 1 (20 from 1); a program has the arguments that ctest gives it. A test that takes longer than the limit (60 s) with its first seed is run with that
one alone; with a budget none begins another seed after so many seconds of its own. The column of seeds says how many there were. With
--sites the checks are listed that no seed came to. With --markdown the table is also written to FILE, each row as soon as it is known,
rows of other tests that stand there already are kept. Returns 1 when a test failed with any seed.
"""
import argparse
import datetime
import glob
import json
import os
import platform
import re
import subprocess
import sys
import time


def programs(build, pattern):
    """Programs of the build tree that read the seed: they are linked from ff_test.h."""
    found = []
    for path in sorted(glob.glob(os.path.join(build, "tests", "**", "*"), recursive=True)):
        name = os.path.basename(path)
        if not os.path.isfile(path) or not os.access(path, os.X_OK) or not re.search(r"_test$|^test_formats_", name):
            continue
        with open(path, "rb") as f:
            if b"FF_TEST_SEED" in f.read() and re.search(pattern, name):
                found.append(os.path.abspath(path))
    return found


def arguments(build):
    """What ctest gives each program, by its path: that of the first of its tests."""
    listed = subprocess.run(["ctest", "--test-dir", build, "--show-only=json-v1"], stdout=subprocess.PIPE, check=True).stdout
    given = {}
    for test in json.loads(listed)["tests"]:
        command = test.get("command", [])
        if command:
            given.setdefault(os.path.realpath(command[0]), command[1:])
    return given


def run(command, seed, limit, sites):
    """(exit code, seconds, output) with one seed; a skip, 77, is no failure."""
    environment = dict(os.environ, FF_TEST_SEED=str(seed))
    if sites:
        environment["FF_TEST_SITES"] = "1"
    begin = time.time()
    try:
        p = subprocess.run(command, cwd=os.path.dirname(command[0]), env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=4 * limit)
        return p.returncode, time.time() - begin, p.stdout.decode(errors="replace")
    except subprocess.TimeoutExpired as e:
        return 1, time.time() - begin, (e.stdout or b"").decode(errors="replace") + "\ntoo slow\n"


HEAD = """# Other seeds

Every randomised test with seeds that nobody has looked at: each number it draws is another one. Failures are of the seeds, not of single
checks. `skipped` needs data that are not here. Made by

    python3 tests/seeds.py BUILD 20 1 --markdown reports/seeds.md

| test | seeds | failures | s each | failed with | machine | date |
|---|---:|---:|---:|---|---|---|
"""


def machine():
    """As `uname -srm`, and the processor."""
    model = platform.processor()
    try:
        with open("/proc/cpuinfo", encoding="utf-8") as f:
            model = re.search(r"^model name\s*:\s*(.*)$", f.read(), re.M)[1]
    except (OSError, TypeError):
        pass
    u = os.uname()
    return f"{u.sysname} {u.release} {u.machine}, {model}"


def write_row(path, name, cells):
    """Puts the row of a test into the table of a file, in the order of the names."""
    rows = {}
    if os.path.exists(path):
        with open(path, encoding="utf-8") as f:
            rows = {line.split("|")[1].strip(): line for line in f if re.match(r"\| \w+ \|", line) and not line.startswith("| test |")}
    rows[name] = "| " + " | ".join(map(str, [name, *cells])) + " |\n"
    with open(path, "w", encoding="utf-8") as f:
        f.write(HEAD + "".join(rows[key] for key in sorted(rows)))


def main():
    a = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    a.add_argument("build")
    a.add_argument("n", nargs="?", type=int, default=20)
    a.add_argument("first", nargs="?", type=int, default=1)
    a.add_argument("--tests", default="")
    a.add_argument("--limit", type=float, default=60)
    a.add_argument("--budget", type=float, default=float("inf"))
    a.add_argument("--sites", action="store_true")
    a.add_argument("--markdown", metavar="FILE")
    o = a.parse_args()
    wrong, unreached, given = 0, [], arguments(o.build)
    print(f"{'test':34} {'seeds':>5} {'failures':>8} {'s each':>7}  failed with")
    for path in programs(o.build, o.tests):
        failed, count, seconds, skipped, never, shown = [], 0, 0, 0, None, ""
        for seed in range(o.first, o.first + o.n):
            code, took, output = run([path, *given.get(os.path.realpath(path), [])], seed, o.limit, o.sites)
            count, seconds = count + 1, seconds + took
            here = set(re.findall(r"^never reached: (\S+)", output, re.M))
            never = here if never is None else never & here
            if code not in (0, 77):
                failed.append(seed)
                shown = shown or "\n".join(re.findall(r"^.*: failed: .*\n.*", output, re.M)[:4]) or output[-400:]
            skipped += code == 77
            if took > o.limit or seconds > o.budget or code == 77:
                break
        wrong += bool(failed)
        unreached += sorted(never or [])
        name = os.path.basename(path)
        print(f"{name:34} {count:5} {len(failed):8} {seconds / count:7.1f}  {' '.join(map(str, failed))}", flush=True)
        if o.markdown:
            write_row(o.markdown, name, [count if not skipped else "skipped", len(failed), f"{seconds / count:.1f}",
                                         " ".join(map(str, failed)), machine(), datetime.date.today()])
        if shown:
            print("    " + shown.replace("\n", "\n    "), flush=True)
    for place in unreached:
        print("never reached:", place)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
