#!/usr/bin/env python3
"""Runs the randomised tests with other seeds and prints a table: test, seeds, failures, the seeds that failed.

  seeds.py BUILD [N] [FIRST] [--tests PATTERN] [--limit SECONDS] [--sites]

FF_TEST_SEED is FIRST .. FIRST + N - 1 (20 from 1). A test that takes longer than the limit (60 s) with its first seed is run with that
one alone and marked. With --sites the checks are listed that no seed came to. Returns 1 when a test failed with any seed.
"""
import argparse
import glob
import os
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
                found.append(path)
    return found


def run(path, seed, limit, sites):
    """(failed, seconds, output) with one seed; a skip is no failure."""
    environment = dict(os.environ, FF_TEST_SEED=str(seed))
    if sites:
        environment["FF_TEST_SITES"] = "1"
    begin = time.time()
    try:
        p = subprocess.run([path], env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=4 * limit)
        return p.returncode not in (0, 77), time.time() - begin, p.stdout.decode(errors="replace")
    except subprocess.TimeoutExpired as e:
        return True, time.time() - begin, (e.stdout or b"").decode(errors="replace") + "\ntoo slow\n"


def main():
    a = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    a.add_argument("build")
    a.add_argument("n", nargs="?", type=int, default=20)
    a.add_argument("first", nargs="?", type=int, default=1)
    a.add_argument("--tests", default="")
    a.add_argument("--limit", type=float, default=60)
    a.add_argument("--sites", action="store_true")
    o = a.parse_args()
    wrong, unreached = 0, []
    print(f"{'test':34} {'seeds':>5} {'failures':>8} {'s each':>7}  failed with")
    for path in programs(o.build, o.tests):
        failed, count, seconds, never, shown = [], 0, 0, None, ""
        for seed in range(o.first, o.first + o.n):
            bad, took, output = run(path, seed, o.limit, o.sites)
            count, seconds = count + 1, seconds + took
            here = set(re.findall(r"^never reached: (\S+)", output, re.M))
            never = here if never is None else never & here
            if bad:
                failed.append(seed)
                shown = shown or "\n".join(re.findall(r"^.*: failed: .*\n.*", output, re.M)[:4]) or output[-400:]
            if took > o.limit:
                break
        wrong += bool(failed)
        unreached += sorted(never or [])
        name = os.path.basename(path)
        print(f"{name:34} {count:5} {len(failed):8} {seconds / count:7.1f}  {' '.join(map(str, failed))}", flush=True)
        if shown:
            print("    " + shown.replace("\n", "\n    "), flush=True)
    for place in unreached:
        print("never reached:", place)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
