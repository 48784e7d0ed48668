#!/usr/bin/env python3
"""library_test.py SOURCE_DIR CC: the C of docs/library.md is C, by the public headers as they are.

The block that calls the library becomes the body of a main(), with the headers that the sentence before it names, and is compiled
without warnings. (tests/install/ builds and runs a longer example against an installation.)
"""
import os
import re
import subprocess
import sys
import tempfile

TOP, CC = os.path.abspath(sys.argv[1]), sys.argv[2]
with open(os.path.join(TOP, "docs", "library.md"), encoding="utf-8") as f:
    page = f.read()
body = re.search(r"^    ff_error err.*\n(?:    .*\n)+", page, re.M)[0]
headers = re.findall(r"`<([\w/]+\.h)>`", page)
public = {}
for folder, folders, names in os.walk(TOP):
    folders[:] = [name for name in folders if not name.startswith(("build", ".", "tests"))]
    public.update({name: os.path.join(folder, name) for name in names if re.match(r"ff_\w+\.(h|def)$", name)})
missing = [h for h in re.findall(r"`(ff_\w+\.h)`", page) if h not in public]
with tempfile.TemporaryDirectory() as scratch:
    os.mkdir(os.path.join(scratch, "facetfit"))
    for name, path in public.items():
        os.symlink(path, os.path.join(scratch, "facetfit", name))
    source = os.path.join(scratch, "example.c")
    with open(source, "w", encoding="utf-8") as f:
        f.write("".join(f"#include <{header}>\n" for header in headers) + "int main(void)\n{\n" + body + "    return 0;\n}\n")
    words = [CC, "-std=c11", "-Wall", "-Wextra", "-Werror", "-fsyntax-only", "-I" + scratch, "-I" + os.path.join(scratch, "facetfit"), source]
    done = subprocess.run(words, stderr=subprocess.PIPE, text=True, check=False)
print(done.stderr)
print(f"{len(headers)} headers included, missing {missing}")
sys.exit(1 if done.returncode or missing or len(headers) < 3 else 0)
