#!/usr/bin/env python3
"""man_test.py PROGRAM: every manual page is one that man shows without a complaint, and has every flag of its command."""
import re
import shutil
import subprocess
import sys

program = sys.argv[1]
failures = []
groff, mandoc, man = shutil.which("groff"), shutil.which("mandoc"), shutil.which("man")


def says(*args, text=None):
    p = subprocess.run(args, input=text, capture_output=True, text=True)
    return p.stdout, p.stderr, p.returncode


def check(condition, what):
    if not condition:
        failures.append(what)


def plain(text):
    return re.sub(r".\x08|\x1b\[[0-9;]*m", "", text)


commands = re.findall(r"^  (\w+) ", says(program, "--help")[0], re.M)
for command in [""] + commands:
    page, said, status = says(program, "man", *command.split())
    check(status == 0 and page.startswith(".TH FACETFIT"), f"{command}: status {status}, {said}")
    if groff:
        _, complaints, status = says(groff, "-man", "-Tutf8", "-ww", "-z", text=page)
        check(status == 0 and not complaints, f"{command}: groff: {complaints}")
    if mandoc:
        # a page has no date: builds of one version are to be the same
        complaints = [line for line in says(mandoc, "-T", "lint", text=page)[0].splitlines() if "missing date" not in line]
        check(not complaints, f"{command}: mandoc: {complaints}")
    if man and command:
        shown, said, status = says(man, "-l", "-", text=page)
        check(status == 0 and not said, f"{command}: man: status {status}, {said}")
        shown = plain(shown)
        for flag in re.findall(r"^ +(?:-\w, +)?(--(?:\[no-\])?[\w-]+)", says(program, command, "--help")[0], re.M):
            check(re.search(r"^ +(-\w, )?%s\b" % re.escape(flag), shown, re.M), f"{command}: the page lacks {flag}")
for failure in failures:
    print("failed:", failure)
print("%d pages, %d failures; by %s" % (len(commands) + 1, len(failures), [t for t in (groff, mandoc, man) if t]))
if not (groff or mandoc or man):
    print("skipped: neither man, groff nor mandoc is installed")
    sys.exit(77)
sys.exit(1 if failures or len(commands) < 12 else 0)
