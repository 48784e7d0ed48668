#!/usr/bin/env python3
"""module_test.py PROGRAM MADE: the module that reads pictures is the one beside the program, whatever name the program is called by.

A file of the module's name that is no module lies where a false argv[0] points, and in the current folder."""
import os
import shutil
import subprocess
import sys
import tempfile

sys.path.insert(0, sys.argv[2])
try:
    import make_files
except ImportError:
    sys.exit(77)

MODULE = "facetfit_images.so"


def main():
    program = os.path.realpath(sys.argv[1])
    if not os.path.exists(os.path.join(os.path.dirname(program), MODULE)):
        print("the module of images is not built")
        return 77
    failed = []
    with tempfile.TemporaryDirectory() as folder:
        name, make = make_files.FILES["images"]
        make(os.path.join(folder, name))
        os.mkdir(os.path.join(folder, "evil"))
        for place in ("evil", "."):
            with open(os.path.join(folder, place, MODULE), "wb") as f:
                f.write(b"planted")
        shutil.copy(program, os.path.join(folder, "evil", "facetfit"))  # so that the path of the false name is one
        for name in ("evil/facetfit", "./facetfit", os.path.join(folder, "evil", "facetfit"), "facetfit", ""):
            p = subprocess.run([name, "info", "stack.csv"], executable=program, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
            if p.returncode or "planted" in p.stderr:
                failed.append(f"called {name!r}: ends with {p.returncode}: {p.stderr.strip()}")
        os.mkdir(os.path.join(folder, "alone"))
        alone = shutil.copy(program, os.path.join(folder, "alone", "facetfit"))
        p = subprocess.run([alone, "furnace", "beckmann", "--surface", "gaussian"], cwd=folder, capture_output=True, text=True)
        if p.returncode != 2 or "facetfit_rays.so" not in p.stderr or "./setup surfaces" not in p.stderr or p.stdout:
            failed.append(f"rays without their module: ends with {p.returncode}: {p.stderr.strip()}")
    print("\n".join(failed) or "5 names, one module; rays are missed without theirs")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
