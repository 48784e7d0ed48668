#!/usr/bin/env python3
"""arrows_test.py NM CC SOURCE_DIR BUILD_DIR OBJECTS: who calls whom, read from the built objects (the file OBJECTS lists them, with
semicolons between) and from the #include lines. Two things are wrong wherever they stand:

  an arrow up      a file that includes a header, or uses a symbol, of a folder that does not stand below its own in rooms.txt;
  a circle         files whose functions reach each other: none of them can be read, tested or replaced without the others.

A source that is compiled once per instruction set is one file. A registry points at every entry of its table: it stands above them."""
import os
import re
import subprocess
import sys
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
SOURCE = (".c", ".cpp", ".h", ".def")
INCLUDE = re.compile(r'^\s*#\s*include\s+"([^"]+)"', re.M)


class Wrong(Exception):
    """What is checked cannot be checked: a folder without a place, a file without an object."""


# ---- what may know what ----------------------------------------------------------------------------------------------------------


def read_levels(path):
    """{folder: its line}; the lowest has the smallest."""
    levels = {}
    with open(path) as file:
        for number, line in enumerate(file, 1):
            for folder in line.split("#")[0].split():
                if folder in levels:
                    raise Wrong(f"{path}:{number}: the folder {folder} stands there twice")
                levels[folder] = number
    return levels


def is_up(levels, user, used):
    """May the file `user` not know the file `used`?"""
    own, other = os.path.dirname(user), os.path.dirname(used)
    return own != other and levels[other] >= levels[own]


# ---- what knows what -------------------------------------------------------------------------------------------------------------


def sources_of(top, levels):
    """The source files of all rooms, by their paths from the top. Every folder has its place."""
    files = []
    for room in sorted({folder.split("/")[0] for folder in levels}):
        for folder, _, names in os.walk(os.path.join(top, room)):
            folder = os.path.relpath(folder, top)
            found = [os.path.join(folder, name) for name in sorted(names) if name.endswith(SOURCE)]
            if found and folder not in levels:
                raise Wrong(f"the folder {folder} is new: say in rooms.txt what it stands above")
            files += found
    return files


def includes(top, files):
    """{(file, included file): "#include" line}; system headers are left out. A name is looked for beside the file, from the top, and
    among the public headers."""
    known = set(files)
    public = {os.path.basename(file): file for file in files if os.path.basename(file).startswith("ff_")}
    arrows = {}
    for file in files:
        with open(os.path.join(top, file)) as source:
            for name in INCLUDE.findall(source.read()):
                beside = os.path.normpath(os.path.join(os.path.dirname(file), name))
                used = next((f for f in (beside, name, public.get(name)) if f in known), None)
                if not used:
                    raise Wrong(f"{file} includes \"{name}\", which is no file of any room")
                arrows.setdefault((file, used), f'#include "{name}"')
    return arrows


def source_of(top, build, path):
    """The source of an object: <build>/<folder>/CMakeFiles/<target>.dir/<rest>.o was compiled from <folder>/<rest>."""
    match = re.fullmatch(r"(?:(.*)/)?CMakeFiles/[^/]+\.dir/(.*)\.(?:o|obj)", os.path.relpath(path, build))
    source = match and os.path.normpath(os.path.join(match[1] or "", match[2]))
    if not source or not os.path.isfile(os.path.join(top, source)):
        raise Wrong(f"no source is found for the object {path}")
    return source


def symbols(nm, paths):
    """{path: what it defines for others, what it takes from them}. Weak definitions, C++ templates, are everybody's own. One run of
    nm for all, each line of which begins with the path."""
    found = {path: ([], []) for path in paths}
    for line in subprocess.run([nm, "-A", "-P", "-g", *paths], capture_output=True, text=True, check=True).stdout.splitlines():
        path, _, rest = line.partition(": ")
        words = rest.split()
        if len(words) >= 2 and words[1] in "TDBRCSGUwv":
            found[path][words[1] in "Uwv"].append(words[0])
    return found


def links(nm, top, build, objects):
    """{(file, file whose symbol it uses): the symbols}."""
    defined, wanted, arrows = {}, {}, {}
    both = symbols(nm, objects)
    for path in objects:
        source = source_of(top, build, path)
        own, taken = both[path]
        for name in own:
            if defined.setdefault(name, source) != source:
                raise Wrong(f"{name} is defined by {defined[name]} and by {source}")
        wanted.setdefault(source, set()).update(taken)
    for source, names in sorted(wanted.items()):
        for name in sorted(names):
            if name in defined and defined[name] != source:
                arrows.setdefault((source, defined[name]), []).append(name)
    return arrows


def circles(arrows):
    """The sets of more than one file that reach each other (strongly connected components, Tarjan 1972)."""
    below = {}
    for user, used in arrows:
        below.setdefault(user, []).append(used)
        below.setdefault(used, [])
    index, low, stack, found = {}, {}, [], []
    for root in sorted(below):
        if root in index:
            continue
        work = [(root, iter(below[root]))]
        index[root] = low[root] = len(index)
        stack.append(root)
        while work:
            file, rest = work[-1]
            child = next(rest, None)
            if child is None:
                work.pop()
                if work:
                    low[work[-1][0]] = min(low[work[-1][0]], low[file])
                if low[file] == index[file]:
                    at = stack.index(file)
                    if len(stack) - at > 1:
                        found.append(sorted(stack[at:]))
                    del stack[at:]
            elif child not in index:
                index[child] = low[child] = len(index)
                stack.append(child)
                work.append((child, iter(below[child])))
            elif child in stack:
                low[file] = min(low[file], index[child])
    return found


# ---- the check -------------------------------------------------------------------------------------------------------------------


def shown(names):
    return ", ".join(names[:4]) + (f" and {len(names) - 4} more" if len(names) > 4 else "")


def check(nm, top, build, objects, levels):
    """[(the files concerned, a sentence)], empty where all is well; and how much was read."""
    files = sources_of(top, levels)
    included, linked = includes(top, files), links(nm, top, build, objects)
    for source in {file for arrow in linked for file in arrow}:
        if os.path.dirname(source) not in levels:
            raise Wrong(f"the folder {os.path.dirname(source)} is new: say in rooms.txt what it stands above")
    used_folders = {os.path.dirname(file) for file in files}
    bad = [([folder + "/"], f"rooms.txt names {folder}, which has no sources") for folder in levels if folder not in used_folders]
    bad += [([user, used], f"up: {user} has {line} of {used}") for (user, used), line in included.items() if is_up(levels, user, used)]
    bad += [([user, used], f"up: {user} uses {shown(names)} of {used}") for (user, used), names in linked.items()
            if is_up(levels, user, used)]
    for circle in circles(linked):
        lines = [f"circle of {len(circle)} files"]
        lines += [f"  {a} -> {b}: {shown(n)}" for (a, b), n in linked.items() if a in circle and b in circle]
        bad.append((circle, "\n".join(lines)))
    return bad, (len(files), len(included), len(linked))


# ---- the check, checked ----------------------------------------------------------------------------------------------------------

# What a project of three folders, low < low/upper < high, may not do, and what it may. Each case is its files and what is found.
LOW, UPPER, HIGH = "low/low.c", "low/upper/upper.c", "high/high.c"
SOUND = {
    LOW: '#include "ff_low.h"\nint low(void) { return 1; }\n',
    "low/ff_low.h": "int low(void);\n",
    UPPER: '#include "ff_low.h"\nint upper(void) { return low(); }\n',
    HIGH: '#include "internal_high.h"\n#include "low/upper/internal_upper.h"\nint (*const table[])(void) = {low, upper};\n',
    "high/internal_high.h": '#include "ff_low.h"\n',
    "low/upper/internal_upper.h": "int upper(void);\n",
}
CASES = [
    ("nothing", {}, None),
    ("a call up between rooms", {LOW: "int table(void);\nint low(void) { return table(); }\n", UPPER: "int upper(void) { return 1; }\n",
                                 HIGH: "int table(void) { return 1; }\n"}, "up: low/low.c uses table of high/high.c"),
    ("a pointer up between folders of a room", {LOW: "extern int upper(void);\nint (*const low)(void) = upper;\n",
                                                UPPER: "int upper(void) { return 1; }\n", HIGH: "int high;\n"},
     "up: low/low.c uses upper of low/upper/upper.c"),
    ("an include up between rooms", {LOW: '#include "high/internal_high.h"\nint low(void) { return 1; }\n'},
     'up: low/low.c has #include "high/internal_high.h" of high/internal_high.h'),
    ("an include up out of a header", {"low/ff_low.h": '# include "low/upper/internal_upper.h"\nint low(void);\n'},
     'up: low/ff_low.h has #include "low/upper/internal_upper.h" of low/upper/internal_upper.h'),
    ("a circle in a folder", {LOW: "int second(void);\nint low(void) { return second(); }\n",
                              "low/second.c": "int third(void);\nint second(void) { return third(); }\n",
                              "low/third.c": "int low(void);\nint third(void) { return low(); }\n"}, "circle of 3 files"),
    ("a circle across folders", {LOW: "int upper(void);\nint low(void) { return upper(); }\n"}, "circle of 2 files"),
    ("a new folder", {"low/new/new.c": "int new_one;\n"}, "the folder low/new is new"),
    ("a folder without sources", {"high/high.c": "", "high/internal_high.h": ""}, "rooms.txt names high, which has no sources"),
    ("a file that is nobody's", {LOW: '#include "gone.h"\n'}, 'low/low.c includes "gone.h"'),
]


def build_planted(cc, top, files):
    """Compiles a project as CMake would lay it out, the second time with a suffix, as for a second instruction set."""
    objects = []
    files = {name: text for name, text in files.items() if text}
    for name, text in files.items():
        path = os.path.join(top, name)
        os.makedirs(os.path.dirname(path), exist_ok=True)
        with open(path, "w") as file:
            file.write(text)
    for name in files:
        for isa in ("one", "two") if name == UPPER else ("one",) if name.endswith(".c") else ():
            room, rest = name.split("/", 1)
            out = os.path.join(top, "build", room, "CMakeFiles", f"{room}_{isa}.dir", rest + ".o")
            os.makedirs(os.path.dirname(out), exist_ok=True)
            suffix = [] if isa == "one" else ["-Dupper=upper_two"]
            paths = ["-I", top, "-I", os.path.join(top, "low")]
            done = subprocess.run([cc, *paths, *suffix, "-c", os.path.join(top, name), "-o", out], capture_output=True)
            objects += [out] if done.returncode == 0 else []
    return objects


def planted(nm, cc, changes):
    """What is said of the sound project after such changes."""
    with tempfile.TemporaryDirectory() as top:
        objects = build_planted(cc, top, {**SOUND, **changes})
        levels = {"low": 1, "low/upper": 2, "high": 3}
        try:
            return [text for _, text in check(nm, top, os.path.join(top, "build"), objects, levels)[0]]
        except Wrong as wrong:
            return [str(wrong)]


def self_test(nm, cc):
    failed = 0
    for title, changes, expected in CASES:
        said = planted(nm, cc, changes)
        if expected is None and said or expected and not any(expected in text for text in said):
            print(f"the check is wrong about {title}: it says {said}, expected '{expected or ''}'")
            failed = 1
    return failed


def main():
    nm, cc, top, build, listed = sys.argv[1:6]
    failed = self_test(nm, cc)
    with open(listed) as file:
        objects = [path for path in file.read().strip().split(";") if path]
    try:
        bad, (files, included, linked) = check(nm, top, build, objects, read_levels(os.path.join(HERE, "rooms.txt")))
    except Wrong as wrong:
        print(wrong)
        return 1
    print(f"{len(objects)} objects of {files} files: {included} includes, {linked} pairs of files at link level, {len(bad)} findings")
    for _, text in bad:
        print(text)
    return failed or bool(bad) or not objects


if __name__ == "__main__":
    sys.exit(main())
