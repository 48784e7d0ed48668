#!/usr/bin/env python3
"""calls_test.py NM OBJECT;OBJECT...: no files of the program call each other in a circle, and each calls only what stands before it.

A call is a symbol that one object needs and another defines; a pointer to a function counts."""
import os
import re
import subprocess
import sys

# What may call only what stands before it in this list; all cmd_*.c are one place, since none may call another.
ORDER = ["terminal", "messages", "fields", "inputs", "jobs", "journal", "rows", "summary", "changes", "thumbnail", "index", "engine", "words", "forms", "expression", "definitions", "values", "style", "files", "parse", "text", "help", "about", "man", "page", "completion",
         "outputs", "shared", "calibration", "reading", "boxes", "polarization", "constraints", "combinations", "renderers", "again", "fitting", "trust", "pages", "figure", "plot_fits", "sources", "plot_subject", "render_scene", "render_subject", "signals", "walking", "batch_words", "batch_summary", "batch", "cmd_", "commands", "main"]


def symbols(nm, path):
    defined, needed = set(), set()
    for line in subprocess.run([nm, path], stdout=subprocess.PIPE, check=True, text=True).stdout.splitlines():
        kind, name = re.match(r"[0-9a-f ]* (\w) (\S+)", line).groups()
        if kind == "U":
            needed.add(name)
        elif kind.isupper():
            defined.add(name)
    return defined, needed


def graph(objects):
    """file -> files that it calls"""
    owner = {name: file for file, (defined, _) in objects.items() for name in defined}
    return {file: {owner[name] for name in needed if owner.get(name, file) != file} for file, (_, needed) in objects.items()}


def circle(calls):
    """Files of a circle, [] when there is none."""
    state, path = {}, []

    def visit(file):
        state[file] = 1
        path.append(file)
        for to in sorted(calls[file]):
            if state.get(to) == 1:
                return path[path.index(to):]
            found = to not in state and visit(to)
            if found:
                return found
        state[file] = 2
        path.pop()
        return []

    for file in sorted(calls):
        found = file not in state and visit(file)
        if found:
            return found
    return []


def place(file):
    return ORDER.index("cmd_" if file.startswith("cmd_") else file)


def upwards(calls):
    return [f"{file} calls {to}" for file in sorted(calls) for to in sorted(calls[file]) if place(to) >= place(file)]


def main():
    nm, paths = sys.argv[1], sys.argv[2].split(";")
    objects = {re.sub(r"\.c(\.o)?$", "", os.path.basename(path)): symbols(nm, path) for path in paths}
    calls = graph(objects)
    unknown = [file for file in calls if not file.startswith("cmd_") and file not in ORDER]
    if unknown:
        print("files that have no place in the order of this test:", unknown)
        return 1
    found, wrong = circle(calls), upwards(calls)
    arrows = sum(len(to) for to in calls.values())
    print(f"{len(calls)} files, {arrows} arrows, circle {found or 'none'}")
    print("\n".join(wrong), end="\n" if wrong else "")
    # is a planted circle found?
    planted = dict(calls, messages=calls["messages"] | {"main"})
    if not circle(planted) or not upwards(planted):
        print("a planted circle is not found")
        return 1
    return 1 if found or wrong or arrows < 50 else 0


if __name__ == "__main__":
    sys.exit(main())
