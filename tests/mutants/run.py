#!/usr/bin/env python3
"""Puts small faults into the sources, one after another, and runs the tests that have to see them.

  run.py BUILD [--only N,..] [--list FILE] [--seconds S] [--until HH:MM]

Each fault of mutants.txt is written into the file (which must have the line), built, run against its tests until one
fails, and taken back. A test that does not end is said: on a busy machine that is no proof. Returns 1 when a fault survived. Do not edit the sources meanwhile.
"""
import argparse
import os
import subprocess
import sys
import time

HERE = os.path.dirname(os.path.abspath(__file__))
TOP = os.path.dirname(os.path.dirname(HERE))


def faults(path):
    lines = [line.rstrip("\n") for line in open(path, encoding="utf-8") if not line.startswith("#")]
    for block in "\n".join(lines).split("\n\n"):
        block = block.strip("\n").split("\n")
        if len(block) != 3:
            sys.exit(f"{path}: three lines expected: {block}")
        room, file, tests = (word.strip() for word in block[0].split("|"))
        yield room, file, [t.strip() for t in tests.split(",")], block[1], block[2]


def target(test):
    return "facetfit_cli" if test.startswith("ctest:") else test.split()[0]


def fails(build, test, seconds):
    if test.startswith("ctest:"):
        command = ["ctest", "--test-dir", build, "-R", "^" + test[6:] + "$", "--no-tests=error"]
    else:
        words = test.split()
        command = [os.path.join(build, "tests", words[0])] + words[1:]
    try:
        code = subprocess.run(command, cwd=os.path.join(build, "tests"), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                              timeout=seconds).returncode
        return code not in (0, 77), ""
    except subprocess.TimeoutExpired:
        return True, ", which did not end"


def outcome(build, tests, seconds):
    for test in tests:
        built = subprocess.run(["ninja", "-j1", "-C", build, target(test)], stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        if built.returncode:
            return "not built"
        killed, how = fails(build, test, seconds)
        if killed:
            return "killed by " + test + how
    return "SURVIVED"


def main():
    a = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    a.add_argument("build")
    a.add_argument("--only", default="")
    a.add_argument("--list", default=os.path.join(HERE, "mutants.txt"))
    a.add_argument("--seconds", type=float, default=60)
    a.add_argument("--until", default="")
    o = a.parse_args()
    o.build = os.path.abspath(o.build)
    only = {int(n) for n in o.only.split(",") if n}
    survived = 0
    for n, (room, file, tests, old, new) in enumerate(faults(o.list), 1):
        if only and n not in only:
            continue
        if o.until and time.strftime("%H:%M", time.gmtime()) >= o.until:
            print(f"stopped before {n}")
            break
        path = os.path.join(TOP, file)
        source = open(path, encoding="utf-8").read()
        if not source.count(old + "\n"):  # of several equal lines the first
            print(f"{n:3} {room:12} {file:44} no such line: {old.strip()}", flush=True)
            continue
        begin = time.time()
        try:
            open(path, "w", encoding="utf-8").write(source.replace(old + "\n", new + "\n", 1))
            result = outcome(o.build, tests, o.seconds)
        finally:
            open(path, "w", encoding="utf-8").write(source)
        survived += result == "SURVIVED"
        print(f"{n:3} {room:12} {file:44} {result:40} {time.time() - begin:5.0f} s  {new.strip()}", flush=True)
    return 1 if survived else 0


if __name__ == "__main__":
    sys.exit(main())
