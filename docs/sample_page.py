#!/usr/bin/env python3
"""sample_page.py PROGRAM [FOLDER]: writes the sample page of the gallery, fit.html, into FOLDER, docs/gallery unless given, by the commands
under "A page" in docs/figures.md."""
import os
import pathlib
import shlex
import shutil
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent


def main(program, folder):
    section = (HERE / "figures.md").read_text(encoding="utf-8").split("\n## A page\n")[1].split("\n## ")[0]
    with tempfile.TemporaryDirectory() as scratch:
        os.symlink(program, os.path.join(scratch, "facetfit"))  # the page says by which command it was made
        for line in section.splitlines():
            if line.startswith("    facetfit "):
                words = shlex.split(line)
                subprocess.run(words, cwd=scratch, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                               env=dict(os.environ, PATH=scratch + os.pathsep + os.environ["PATH"]))
        folder.mkdir(exist_ok=True)
        shutil.copy(os.path.join(scratch, "fit.html"), folder / "fit.html")
    print(f"fit.html: {(folder / 'fit.html').stat().st_size} bytes")


main(str(pathlib.Path(sys.argv[1]).resolve()), pathlib.Path(sys.argv[2]) if len(sys.argv) > 2 else HERE / "gallery")
