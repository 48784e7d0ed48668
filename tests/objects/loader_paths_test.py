#!/usr/bin/env python3
"""loader_paths_test.py READELF CMAKE BUILD_DIR CC: no program or library, built or installed, makes the loader search a folder that
depends on where it is started. An entry that is empty or relative means the current directory: a libexpat.so.1 that lies beside
somebody's data would run as the user. $ORIGIN, the folder of the object itself, is allowed."""
import os
import re
import subprocess
import sys
import tempfile

ENTRY = re.compile(r"\((RPATH|RUNPATH)\).*\[(.*)\]")


def is_object(path):
    if os.path.islink(path) or not os.path.isfile(path):
        return False
    with open(path, "rb") as file:
        return file.read(4) == b"\x7fELF"


def bad_entries(readelf, path):
    """The entries of an object's search paths that are neither absolute nor seen from the object."""
    said = subprocess.run([readelf, "-dW", path], capture_output=True, text=True, check=True).stdout
    bad = []
    for kind, value in ENTRY.findall(said):
        for entry in value.split(":"):
            if not (entry.startswith("/") or re.match(r"\$(ORIGIN|\{ORIGIN\})(/|$)", entry)):
                bad.append(f"{path}: {kind} [{value}] has the entry '{entry}'")
    return bad


def objects_below(folder):
    for top, folders, files in os.walk(folder):
        folders[:] = [name for name in folders if name != "CMakeFiles"]
        for name in files:
            path = os.path.join(top, name)
            if is_object(path):
                yield path


def check_tree(readelf, folder):
    paths = list(objects_below(folder))
    return len(paths), [line for path in paths for line in bad_entries(readelf, path)]


def planted(readelf, cc, folder, entry):
    """Is an object with such an entry found out?"""
    source, out = os.path.join(folder, "planted.c"), os.path.join(folder, "planted")
    with open(source, "w") as file:
        file.write("int main(void) { return 0; }\n")
    subprocess.run([cc, source, "-o", out, f"-Wl,-rpath,{entry}"], check=True)
    found = bool(bad_entries(readelf, out))
    os.remove(out)
    return found


def main():
    readelf, cmake, build, cc = sys.argv[1:5]
    failed = 0
    with tempfile.TemporaryDirectory() as folder:
        for entry, is_bad in ((":", 1), ("/usr/lib:", 1), ("lib", 1), ("./lib", 1), ("$ORIGINAL", 1), ("/usr/lib", 0), ("$ORIGIN/../lib", 0)):
            if planted(readelf, cc, folder, entry) != bool(is_bad):
                print(f"the check is wrong about a planted entry '{entry}'")
                failed = 1
        prefix = os.path.join(folder, "installed")
        subprocess.run([cmake, "--install", build, "--prefix", prefix], check=True, stdout=subprocess.DEVNULL)
        for title, tree in (("built", build), ("installed", prefix)):
            count, bad = check_tree(readelf, tree)
            print(f"{title}: {count} objects, {len(bad)} bad entries")
            print("\n".join(bad), end="\n" if bad else "")
            failed |= bool(bad) or count == 0
    return failed


if __name__ == "__main__":
    sys.exit(main())
