#!/usr/bin/env python3
"""flags_page_test.py PROGRAM PAGE: PAGE is what `PROGRAM man --markdown` writes today, and has every flag that --help has."""
import difflib
import re
import subprocess
import sys

program, page = sys.argv[1:]


def says(*args):
    return subprocess.run([program, *args], stdout=subprocess.PIPE, check=True).stdout.decode("utf-8")


written = says("man", "--markdown")
with open(page, encoding="utf-8") as f:
    kept = f.read()
if written != kept:
    sys.stdout.writelines(list(difflib.unified_diff(kept.splitlines(True), written.splitlines(True), page, "definitions", n=0))[:40])
    sys.exit(f"{page} is not that of the definitions: write it anew with `facetfit man --markdown`")
sections = dict(re.findall(r"^## (\w+)\n(.*?)(?=^## |\Z)", written, re.M | re.S))
commands = re.findall(r"^  (\w+) ", says("--help"), re.M)
missing = [c for c in commands if c not in sections]
flags = 0
for command in set(commands) & set(sections):
    for flag in re.findall(r"^ +(?:-\w, +)?--(?:\[no-\])?([\w-]+)", says(command, "--help"), re.M):
        flags += 1
        if not re.search(r"^\| `(-\w, )?--(\[no-\])?%s[ `]" % re.escape(flag), sections[command], re.M):
            missing.append(f"{command} --{flag}")
if missing or flags < 100:
    sys.exit(f"{flags} flags; missing on the page: {missing}")
print(f"{len(commands)} commands, {flags} flags")
