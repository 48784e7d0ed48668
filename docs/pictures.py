#!/usr/bin/env python3
"""pictures.py PROGRAM [FOLDER]: writes the pictures of lit spheres of the gallery and the README into FOLDER, docs/figures unless given, by the
commands under "What it looks like" in docs/figures.md."""
import pathlib
import shlex
import shutil
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent


def main(program, folder):
    section = (HERE / "figures.md").read_text().split("\n## What it looks like\n")[1].split("\n## ")[0]
    with tempfile.TemporaryDirectory() as scratch:
        for line in section.splitlines():
            if line.startswith("    facetfit ") and "--html" not in line:
                subprocess.run([program, *shlex.split(line)[1:]], cwd=scratch, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        for picture in sorted(pathlib.Path(scratch).glob("*.png")):
            shutil.copy(picture, folder / picture.name)
            print(picture.name)


main(str(pathlib.Path(sys.argv[1]).resolve()), pathlib.Path(sys.argv[2]) if len(sys.argv) > 2 else HERE / "figures")
