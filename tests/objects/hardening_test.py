#!/usr/bin/env python3
"""hardening_test.py READELF CMAKE BUILD_DIR CC EXPECTED...: what was built, and what is installed, has what limits a mistake to a crash.
EXPECTED says what compiler and linker have (cmake/Hardening.cmake):

  pie        programs can be loaded anywhere, libraries anyway
  now relro  every address is looked up when the program starts, and the tables are read-only from then on
  noexecstack  the stack holds no code
  protector  a function whose array was written beyond its end does not return: __stack_chk_fail
  fortify    calls of the C library whose room is known are checked: __memcpy_chk and the like
  branch     jumps end at marked places (IBT) and returns where they came from (SHSTK): a note in every object that we compile

Programs of the tests and benchmarks must have the first four; what is installed, all. Whether a whole program is marked for `branch`
depends on the start-up files of the C library, too; the objects are what is ours."""
import os
import re
import subprocess
import sys
import tempfile

from loader_paths_test import is_object, objects_below


def said(readelf, *words):
    return subprocess.run([readelf, *words], capture_output=True, text=True, check=True).stdout


def lacks(readelf, path, expected, whole):
    """What an object lacks of what is expected of it. whole: 0: of the layout alone."""
    head, dynamic, segments = said(readelf, "-hW", path), said(readelf, "-dW", path), said(readelf, "-lW", path)
    stack = re.search(r"GNU_STACK\s+(?:0x\w+\s+){5}(\S+)", segments)
    found = set()
    if re.search(r"Type:\s+DYN", head) and ("INTERP" not in segments or re.search(r"FLAGS_1.*\bPIE\b", dynamic)):
        found.add("pie")
    if re.search(r"\bBIND_NOW\b|FLAGS_1.*\bNOW\b", dynamic):
        found.add("now")
    if "GNU_RELRO" in segments:
        found.add("relro")
    if stack and "E" not in stack[1]:
        found.add("noexecstack")
    if whole:
        imported = set(re.findall(r"\bUND (\w+)", said(readelf, "--dyn-syms", "-W", path)))
        found |= {"protector"} if "__stack_chk_fail" in imported else set()
        found |= {"fortify"} if any(name.endswith("_chk") for name in imported) else set()
    asked = set(expected) - {"branch"} - (set() if whole else {"protector", "fortify"})
    return [f"{path} lacks {name}" for name in sorted(asked - found)]


def unmarked(readelf, path):
    """The objects of a file, or of an archive, without the marks of `branch`."""
    notes = re.split(r"^File: ", said(readelf, "-nW", path), flags=re.M)
    return [part.splitlines()[0] if part else path for part in notes[len(notes) > 1:] if not re.search(r"x86 feature:.*IBT.*SHSTK", part)]


def archives_below(folder):
    return [os.path.join(top, name) for top, _, files in os.walk(folder) for name in files if name.endswith(".a")]


def check_tree(readelf, folder, expected, whole):
    paths = [path for path in objects_below(folder) if not path.endswith((".o", ".gch"))]
    bad = [line for path in paths for line in lacks(readelf, path, expected, whole)]
    if "branch" in expected:
        bad += [f"{path}: {name} has unmarked jumps" for path in archives_below(folder) for name in unmarked(readelf, path)]
    return len(paths), bad


# ---- the check, checked ----------------------------------------------------------------------------------------------------------

SOUND = ["-O2", "-fPIE", "-pie", "-Wl,-z,relro", "-Wl,-z,now", "-Wl,-z,noexecstack", "-fstack-protector-strong", "-D_FORTIFY_SOURCE=2"]
SOURCE = """#include <stdio.h>
#include <string.h>
int main(int argc, char **argv) { char a[16]; memcpy(a, argv[0], (size_t)argc); return puts(a); }
"""
CASES = [("nothing", SOUND, None), ("a program at a fixed place", [f for f in SOUND if f != "-pie"] + ["-no-pie"], "pie"),
         ("tables that are filled late", SOUND + ["-Wl,-z,lazy"], "now"), ("tables that stay writable", SOUND + ["-Wl,-z,norelro"], "relro"),
         ("a stack with code", SOUND + ["-Wl,-z,execstack"], "noexecstack"), ("no canaries", SOUND + ["-fno-stack-protector"], "protector"),
         ("calls that are not checked", SOUND + ["-U_FORTIFY_SOURCE"], "fortify")]


def self_test(readelf, cc, expected, folder):
    failed = 0
    source, out = os.path.join(folder, "planted.c"), os.path.join(folder, "planted")
    with open(source, "w") as file:
        file.write(SOURCE)
    for title, flags, missing in CASES:
        if missing and missing not in expected:
            continue
        subprocess.run([cc, *flags, source, "-o", out], check=True, stderr=subprocess.DEVNULL)
        found = lacks(readelf, out, [name for name in expected if name != "branch"], 1)
        if found != ([f"{out} lacks {missing}"] if missing else []):
            print(f"the check is wrong about {title}: it says {found}")
            failed = 1
    for flag, expected_count in (("full", 0), ("none", 1)) if "branch" in expected else ():
        subprocess.run([cc, f"-fcf-protection={flag}", "-c", source, "-o", out + ".o"], check=True)
        if len(unmarked(readelf, out + ".o")) != expected_count:
            print(f"the check is wrong about -fcf-protection={flag}")
            failed = 1
    for path in (source, out, out + ".o"):
        if os.path.exists(path):
            os.remove(path)
    return failed


def main():
    readelf, cmake, build, cc = sys.argv[1:5]
    expected = sys.argv[5:]
    assert is_object(os.path.join(build, "bin", "facetfit"))
    with tempfile.TemporaryDirectory() as folder:
        failed = self_test(readelf, cc, expected, folder)
        prefix = os.path.join(folder, "installed")
        subprocess.run([cmake, "--install", build, "--prefix", prefix], check=True, stdout=subprocess.DEVNULL)
        for title, tree, whole in (("built", build, 0), ("installed", prefix, 1)):
            count, bad = check_tree(readelf, tree, expected, whole)
            print(f"{title}: {count} programs and libraries, {len(bad)} lack something of: {' '.join(expected)}")
            print("\n".join(bad), end="\n" if bad else "")
            failed |= bool(bad) or count == 0
    return failed


if __name__ == "__main__":
    sys.exit(main())
