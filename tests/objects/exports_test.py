#!/usr/bin/env python3
"""exports_test.py NM CC EXPORTS OBJECTS HEADERS: what a shared library of the built objects exports is what the installed headers
declare FF_API, no more and no less. OBJECTS and HEADERS are files that list them, with semicolons between; EXPORTS is the version
script that the library is linked with.

A function that is exported without being declared becomes part of somebody's program and can never change; one that is declared and
not exported lets a program compile and not link."""
import os
import re
import subprocess
import sys
import tempfile

COMMENT = re.compile(r"/\*.*?\*/|//[^\n]*", re.S)
DECLARED = re.compile(r"^FF_API\b[^;{]*?\b(\w+)\s*\(", re.M)
FORGOTTEN = re.compile(r"^(?!FF_API|static|typedef|extern|#)[a-z][\w \t]*[ *]+(\w+)\([^;{]*\)[^;{]*;", re.M)


def read_list(path):
    with open(path) as file:
        return [entry for entry in file.read().strip().split(";") if entry]


def declared(headers):
    """The functions that the headers declare FF_API, and those that they declare without."""
    api, forgotten = set(), set()
    for path in headers:
        with open(path) as file:
            text = COMMENT.sub("", file.read())
        api |= set(DECLARED.findall(text))
        forgotten |= set(FORGOTTEN.findall(text))
    return api, forgotten


def exported(nm, cc, exports, objects, folder):
    """What a shared library of the objects exports. Other libraries need not be there: nothing is run."""
    library, response = os.path.join(folder, "library.so"), os.path.join(folder, "objects")
    with open(response, "w") as file:
        file.write("\n".join('"%s"' % path for path in objects))
    subprocess.run([cc, "-shared", f"-Wl,--version-script={exports}", "-o", library, "@" + response], check=True)
    said = subprocess.run([nm, "-D", "-P", "--defined-only", library], capture_output=True, text=True, check=True).stdout
    return {line.split()[0].split("@")[0] for line in said.splitlines() if line.split()[1] != "A"}


def differences(nm, cc, exports, objects, headers):
    """What is wrong, a sentence each; and how many functions were declared."""
    with tempfile.TemporaryDirectory() as folder:
        found = exported(nm, cc, exports, objects, folder)
    api, forgotten = declared(headers)
    said = [f"{name} is exported, and no installed header declares it" for name in sorted(found - api)]
    said += [f"{name} is declared, and not exported" for name in sorted(api - found)]
    said += [f"{name} is declared without FF_API" for name in sorted(forgotten)]
    said += [f"{name} does not begin with ff_" for name in sorted(found | api) if not name.startswith("ff_")]
    return said, len(api)


# ---- the check, checked ----------------------------------------------------------------------------------------------------------

API = '#define FF_API __attribute__((visibility("default")))\n'
HEADER = API + "/** FF_API int ff_in_a_comment(void); */\nFF_API int ff_one(void);\nFF_API const char *\nff_two(int a,\n    int b);\n"
SOURCE = '#include "ff_h.h"\nint ff_one(void) { return ff_hidden(); }\nconst char *ff_two(int a, int b) { return a < b ? "a" : "b"; }\n'
SOUND = "int ff_hidden(void);\n" + SOURCE + "int ff_hidden(void) { return 1; }\n"
CASES = [
    ("nothing", HEADER, SOUND, None),
    ("a room that is not compiled with hidden visibility", HEADER, SOUND, "ff_hidden is exported, and no installed header declares it"),
    ("a function that no header declares", HEADER, SOUND + API.replace("FF_API", "FF_OWN") + "FF_OWN int ff_planted(void) { return 2; }\n",
     "ff_planted is exported, and no installed header declares it"),
    ("a declared function that is missing", HEADER + "FF_API int ff_gone(void);\n", SOUND, "ff_gone is declared, and not exported"),
    ("a function that is only defined for inside", HEADER + "int ff_hidden(void);\n", SOUND, "ff_hidden is declared without FF_API"),
    ("a name of another kind", HEADER + "FF_API int one(void);\n", SOUND + "int one(void) { return 1; }\n", "one does not begin with ff_"),
]


def planted(nm, cc, exports, header, source, visibility):
    with tempfile.TemporaryDirectory() as folder:
        paths = [os.path.join(folder, name) for name in ("ff_h.h", "a.c", "a.o")]
        for path, text in zip(paths, (header, source)):
            with open(path, "w") as file:
                file.write(text)
        subprocess.run([cc, "-fPIC", f"-fvisibility={visibility}", "-c", paths[1], "-o", paths[2]], check=True)
        return differences(nm, cc, exports, paths[2:], paths[:1])[0]


def main():
    nm, cc, exports, objects, headers = sys.argv[1:6]
    failed = 0
    for title, header, source, expected in CASES:
        said = planted(nm, cc, exports, header, source, "default" if "not compiled with hidden" in title else "hidden")
        if expected is None and said or expected and expected not in said:
            print(f"the check is wrong about {title}: it says {said}, expected '{expected or ''}'")
            failed = 1
    objects, headers = read_list(objects), read_list(headers)
    said, count = differences(nm, cc, exports, objects, headers)
    print(f"{len(objects)} objects, {len(headers)} headers: {count} functions are exported, {len(said)} findings")
    print("\n".join(said), end="\n" if said else "")
    return failed or bool(said) or count == 0


if __name__ == "__main__":
    sys.exit(main())
