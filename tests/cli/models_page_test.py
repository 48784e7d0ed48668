#!/usr/bin/env python3
"""models_page_test.py PROGRAM PAGE: PAGE is what `PROGRAM models --markdown` writes today."""
import difflib
import subprocess
import sys

program, page = sys.argv[1:]
written = subprocess.run([program, "models", "--markdown"], stdout=subprocess.PIPE, check=True).stdout.decode("utf-8")
with open(page, encoding="utf-8") as f:
    kept = f.read()
if written != kept:
    sys.stdout.writelines(list(difflib.unified_diff(kept.splitlines(True), written.splitlines(True), page, "registry", n=0))[:40])
    sys.exit(f"{page} is not the registry's: write it anew with `facetfit models --markdown`")
terms = sum(line.startswith("### ") for line in written.splitlines())
listed = subprocess.run([program, "models"], stdout=subprocess.PIPE, check=True).stdout.decode("utf-8")
names = [line.strip() for line in listed.splitlines() if line.startswith("  ") and not line.startswith("   ")]
missing = [name for name in names if f"### {name}\n" not in written and f"| `{name}` |" not in written]
if missing or terms < 20:
    sys.exit(f"{terms} terms on the page; missing: {missing}")
print(f"{terms} terms, {len(names)} names")
