#!/usr/bin/env python3
"""example_test.py EXAMPLE: the example is short, runs in a folder of its own, and what it asserts holds."""
import os
import subprocess
import sys
import tempfile

MOST_LINES = 60

try:
    import facetfit
    import pandas
except ImportError as missing:
    print("skipped: " + str(missing))
    sys.exit(0)


def main():
    example = os.path.abspath(sys.argv[1])
    with open(example) as file:
        lines = len(file.readlines())
    with tempfile.TemporaryDirectory() as folder:
        made = subprocess.run([sys.executable, example], cwd=folder, capture_output=True, text=True)
        print(made.stdout + made.stderr, end="")
        files = sorted(os.listdir(folder))
    print(f"{lines} lines, made {', '.join(files) or 'no files'}")
    return made.returncode != 0 or lines >= MOST_LINES or not made.stdout.strip()


if __name__ == "__main__":
    sys.exit(main())
