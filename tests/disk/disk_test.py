#!/usr/bin/env python3
"""disk_test.py PROGRAM SHIM [--all]: a disk that is full, fails or loses power, at every single step of every writer.

Whatever happens, the target has what it had or all of what it was to have: never neither, never a part. Where a step fails, the program
says so with status 4, names the file, and leaves the old file and no temporary one; where it says that it is done the new one is there.
Without --all the first step, the last two and one between; with $FF_TEST_THOROUGH the first two and the last four."""
import errno
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time

FAILURES = [errno.ENOSPC, errno.EIO, errno.EDQUOT]
OLD = b"what was here before\n" * 50


def main():
    program, shim = os.path.abspath(sys.argv[1]), os.path.abspath(sys.argv[2])
    every = "--all" in sys.argv
    more = bool(os.environ.get("FF_TEST_THOROUGH"))
    folder = tempfile.mkdtemp(prefix="disk-")
    wrong, runs, crashes = [], 0, 0

    def run(words, **more):
        return subprocess.run([program, *words], cwd=folder, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, timeout=600 if every else 60,
                              env={**os.environ, "LC_ALL": "C", **more})

    def content(name):
        try:
            with open(os.path.join(folder, name), "rb") as f:
                return f.read()
        except FileNotFoundError:
            return None

    def put(name, data):
        path = os.path.join(folder, name)
        if os.path.exists(path):
            os.remove(path)
        if data is not None:
            with open(path, "wb") as f:
                f.write(data)

    def parts():
        return sorted(n for n in os.listdir(folder) if ".part-" in n)

    def check(good, what):
        if not good and what not in wrong:
            wrong.append(what)
            print("failed:", what, flush=True)

    try:
        assert run(["simulate", "ggx+lambert", "--grid", "goniometer:30", "--noise", "0.05", "-o", "in.csv"]).returncode == 0
        formats = subprocess.run([program, "formats", "--json", "-"], stdout=subprocess.PIPE, check=True, text=True).stdout
        writers = [f["name"] for f in json.loads(formats)["formats"] if f["writes"]]
        lines = [(f"resample to {w}", ["resample", "in.csv", "out", "--to", w], "out") for w in writers]
        lines += [("fit --json", ["fit", "in.csv", "--json", "out"], "out"),
                  ("fit --residuals", ["fit", "in.csv", "--residuals", "out.csv"], "out.csv"),
                  ("fit --residuals exr", ["fit", "in.csv", "--residuals", "out.exr"], "out.exr"),
                  ("simulate", ["simulate", "ggx", "--grid", "goniometer:30", "--format", "csv", "-o", "out"], "out"),
                  ("ndf", ["ndf", "in.csv", "-o", "out"], "out"),
                  ("render png", ["render", "in.csv", "--size", "8", "-o", "out.png"], "out.png"),
                  ("render exr", ["render", "in.csv", "--size", "8", "-o", "out.exr"], "out.exr"),
                  ("info --json", ["info", "in.csv", "--json", "out"], "out")]
        for name, words, target in lines:
            put(target, OLD)
            begin = time.time()
            p = run(words, LD_PRELOAD=shim, DISK_COUNT=os.path.join(folder, "count"))
            if p.returncode != 0:
                check(False, f"{name}: ends with {p.returncode} on a sound disk: {p.stderr.decode(errors='replace').strip()[-200:]}")
                continue
            new, steps, slow = content(target), int(content("count").split()[0]), time.time() - begin > 0.5
            check(new != OLD and steps >= 5, f"{name}: {steps} steps on a sound disk")
            stable = re.compile(rb'"time_s": [^,}]*|"date": [^,}]*|"made[^"]*": [^,}]*')
            same = lambda a: a is not None and stable.sub(b"", a) == stable.sub(b"", new)
            chosen = [n for n in range(1, steps + 2) if every or n in (1, steps // 2, steps - 1, steps + 1) or more and not slow and (n <= 2 or n > steps - 4)]
            for n in chosen:
                for old in (OLD, None) if every else (OLD,) if n % 2 else (None,):
                    for reason in FAILURES[:1 + 2 * every] if n <= steps else []:
                        put(target, old)
                        p = run(words, LD_PRELOAD=shim, DISK_FAIL=f"{n}:{reason}")
                        runs += 1
                        said = p.stderr.decode(errors="replace")
                        where = f"{name}: step {n} of {steps} fails ({os.strerror(reason)})"
                        if p.returncode == 0:
                            check(same(content(target)), f"{where}: done, but the file is not what it is on a sound disk")
                        else:
                            check(p.returncode == 4, f"{where}: ends with {p.returncode}: {said.strip()[-200:]}")
                            check(target in said or "out" in said, f"{where}: does not name the file: {said.strip()[-200:]}")
                            check(content(target) == old or same(content(target)), f"{where}: the target is neither old nor new")
                        check(not parts(), f"{where}: leaves {parts()}")
                        for part in parts():
                            os.remove(os.path.join(folder, part))
                    put(target, old)
                    p = run(words, LD_PRELOAD=shim, DISK_CRASH=str(n))
                    runs, crashes = runs + 1, crashes + 1
                    check(p.returncode == 77, f"{name}: power lost before step {n} of {steps}: ends with {p.returncode}")
                    check(content(target) == old or same(content(target)), f"{name}: power lost before step {n} of {steps}: the target is neither old nor new")
                    for part in parts():
                        os.remove(os.path.join(folder, part))
            os.remove(os.path.join(folder, target)) if os.path.exists(os.path.join(folder, target)) else None
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    print(f"{len(lines)} writers, {runs} runs, {crashes} of them without power; {len(wrong)} failures")
    return 1 if wrong or runs < 100 else 0


if __name__ == "__main__":
    sys.exit(main())
