#!/usr/bin/env python3
"""figures.py PROGRAM: writes the figures of the gallery, docs/figures/*.svg, by the commands of docs/figures.md; pictures.py those of lit
spheres."""
import os
import pathlib
import shlex
import shutil
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent


def main(program):
    commands = [line.strip() for line in (HERE / "figures.md").read_text().splitlines() if line.startswith("    facetfit ")]
    with tempfile.TemporaryDirectory() as scratch:
        for command in commands:
            subprocess.run([program, *shlex.split(command)[1:]], cwd=scratch, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        for figure in sorted(pathlib.Path(scratch).glob("*.svg")):
            shutil.copy(figure, HERE / "figures" / figure.name)
            print(figure.name)


main(os.path.abspath(sys.argv[1]))
