#!/usr/bin/env python3
"""The rooms of the library say in their own terms what is missing; flags of the command line are named by report/ and cli/ alone.

usage: no_flags_test.py SOURCE_DIR"""
import pathlib
import re
import sys

ROOMS = "base models targets data_formats simulate fit".split()
SOURCES = ".c .h .cpp .def"
# A comment, a character or a string; what is not one of the first two and has a string is looked at.
TOKEN = re.compile(r"""//[^\n]*|/\*.*?\*/|'(?:\\.|[^'\\\n])+'|"(?:\\.|[^"\\\n])*"(?:\s*"(?:\\.|[^"\\\n])*")*""", re.DOTALL)
FLAG = re.compile(r"--[a-z]")


def flags(text):
    """(line, literal) of every string, its pieces joined, that names a flag."""
    for token in TOKEN.finditer(text):
        if token.group()[0] != '"':
            continue
        literal = re.sub(r'"\s*"', "", token.group())
        if FLAG.search(literal) and "blender --python" not in literal:  # a flag of another program, in a file made for it
            yield text.count("\n", 0, token.start()) + 1, literal


def check_the_search():
    found = list(flags('/* "--a" */ x = \'"\'; y("b"); // "--c"\nz("no -" \n "-scale"); w = "-\\"-";'))
    assert found == [(2, '"no --scale"')], found


def main():
    root = pathlib.Path(sys.argv[1])
    check_the_search()
    files = [f for room in ROOMS for f in sorted((root / room).rglob("*")) if f.suffix in SOURCES.split()]
    strings = failures = 0
    for f in files:
        text = f.read_text(encoding="utf-8")
        strings += sum(t.group()[0] == '"' for t in TOKEN.finditer(text))
        for line, literal in flags(text):
            failures += 1
            print("%s:%d: a string of the library names a flag: %s" % (f.relative_to(root), line, literal))
    print("%d strings in %d files, %d name flags" % (strings, len(files), failures))
    return 1 if failures or strings < 1000 else 0


sys.exit(main())
