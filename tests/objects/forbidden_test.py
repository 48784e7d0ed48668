#!/usr/bin/env python3
"""forbidden_test.py NM CC SOURCE_DIR BUILD_DIR OBJECTS: no built object (the file OBJECTS lists them, with semicolons between) imports
what forbidden.txt names; the exceptions that stand there are all in use."""
import os
import re
import subprocess
import sys
import tempfile

from arrows_test import source_of

HERE = os.path.dirname(os.path.abspath(__file__))


def read_list(text):
    """{name: why}, {(file, name)} of the exceptions."""
    why, exceptions = {}, set()
    for line in text.splitlines():
        if not line.strip() or line.startswith("#"):
            continue
        names, reason = line.split(":", 1)
        words = names.split()
        if "/" in words[0] or "." in words[0]:
            exceptions |= {(words[0], name) for name in words[1:]}
        else:
            why.update({name: reason.strip() for name in words})
    return why, exceptions


def imported(nm, paths):
    """{path: the names it imports}; one run of nm for all, each line of which begins with the path."""
    found = {path: set() for path in paths}
    for line in subprocess.run([nm, "-A", "-P", "-u", *paths], capture_output=True, text=True, check=True).stdout.splitlines():
        path, _, rest = line.partition(": ")
        found[path].add(re.split(r"[@\s]", rest)[0])
    return found


def check(nm, objects, text):
    """objects: [(source, path)]. What is wrong, a sentence each."""
    why, exceptions = read_list(text)
    names = imported(nm, [path for _, path in objects])
    used = {(source, name) for source, path in objects for name in names[path] & set(why)}
    bad = [f"{source} imports {name}: {why[name]}" for source, name in sorted(used - exceptions)]
    return bad + [f"the exception of {source} for {name} is not in use" for source, name in sorted(exceptions - used)]


# ---- the check, checked ----------------------------------------------------------------------------------------------------------

LIST = "# names\nstrtok lgamma: one for all\n"
TOKENS = "#include <string.h>\nchar *f(char *a) { return strtok(a, \",\"); }\n"
CASES = [("nothing", "#include <string.h>\nchar *f(char *a, char **b) { return strtok_r(a, \",\", b); }\n", LIST, None),
         ("a forbidden call", TOKENS, LIST, "a.c imports strtok: one for all"),
         ("a pointer to one", "#include <math.h>\ndouble (*const f)(double) = lgamma;\n", LIST, "a.c imports lgamma: one for all"),
         ("an exception", TOKENS, LIST + "a.c strtok: alone\n", None),
         ("one of another file", TOKENS, LIST + "b.c strtok: alone\n", "a.c imports strtok: one for all"),
         ("one that is not needed", "int a;\n", LIST + "a.c strtok: alone\n", "the exception of a.c for strtok is not in use")]


def self_test(nm, cc):
    failed = 0
    for title, source, text, expected in CASES:
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "a.c")
            with open(path, "w") as file:
                file.write(source)
            subprocess.run([cc, "-c", path, "-o", path + ".o"], check=True)
            found = check(nm, [("a.c", path + ".o")], text)
        if expected is None and found or expected and expected not in found:
            print(f"the check is wrong about {title}: it says {found}")
            failed = 1
    return failed


def main():
    nm, cc, top, build, listed = sys.argv[1:6]
    with open(listed) as file:
        paths = [path for path in file.read().strip().split(";") if path]
    with open(os.path.join(HERE, "forbidden.txt")) as file:
        text = file.read()
    objects = [(source_of(top, build, path), path) for path in paths]
    if not any(source.startswith("data_formats/formats/images/") for source, _ in objects):
        text = "\n".join(line for line in text.splitlines() if not line.startswith("data_formats/formats/images/"))
    failed = self_test(nm, cc)
    bad = check(nm, objects, text)
    print(f"{len(objects)} objects, {len(read_list(text)[0])} forbidden names, {len(bad)} findings")
    print("\n".join(bad), end="\n" if bad else "")
    return failed or bool(bad) or not objects


if __name__ == "__main__":
    sys.exit(main())
