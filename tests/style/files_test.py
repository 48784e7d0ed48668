#!/usr/bin/env python3
"""Nothing large lies in the tree: measured data, and files that tests make, do not belong there.

usage: files_test.py TOP"""
import os
import sys
import tempfile

MOST = 1 << 20


def large(top):
    """(path, bytes) of files above MOST, but for build trees, what npm installs and the history."""
    for folder, folders, names in os.walk(top):
        folders[:] = [f for f in folders if f not in (".git", "node_modules") and not (folder == top and f.startswith("build"))]
        for name in names:
            path = os.path.join(folder, name)
            size = os.lstat(path).st_size
            if size > MOST:
                yield os.path.relpath(path, top), size


with tempfile.TemporaryDirectory() as scratch:
    with open(os.path.join(scratch, "made.binary"), "wb") as f:
        f.truncate(MOST + 1)
    assert list(large(scratch)) == [("made.binary", MOST + 1)], "the search does not see a large file"
found = sorted(large(sys.argv[1]))
for path, size in found:
    print(f"failed: {path}: {size} bytes, at most {MOST} belong in the tree")
sys.exit(bool(found))
