#!/usr/bin/env python3
"""The pictures of docs/figures are those that docs/pictures.py draws with this program, to 2 of 255; the README and docs/render.md show one.

usage: render_gallery_test.py FACETFIT"""
import os
import subprocess
import sys
import tempfile
try:
    import numpy as np
except ImportError:
    print("skipped: this needs python3-numpy")
    sys.exit(77)
sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import pictures

TOP = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
KEPT, CLOSE = os.path.join(TOP, "docs", "figures"), 2
failures = []

with tempfile.TemporaryDirectory() as folder:
    done = subprocess.run([sys.executable, os.path.join(TOP, "docs", "pictures.py"), sys.argv[1], folder], stdout=subprocess.PIPE, check=True, text=True)
    drawn = done.stdout.split()
    kept = sorted(name for name in os.listdir(KEPT) if name.endswith(".png"))
    if drawn != kept:
        failures.append(f"docs/pictures.py draws {drawn}, docs/figures has {kept}")
    for name in set(drawn) & set(kept):
        new, old = (pictures.png(os.path.join(where, name)).astype(int) for where in (folder, KEPT))
        off = np.abs(new - old).max() if new.shape == old.shape else None
        print(f"{name}: {new.shape[1]} x {new.shape[0]}, furthest from the kept one by {off}")
        if off is None or off > CLOSE:
            failures.append(f"docs/figures/{name} is not what docs/pictures.py draws: {off}")
for page, shows in (("README.md", "docs/figures/spheres_readme.png"), ("docs/render.md", "figures/spheres_readme.png")):
    with open(os.path.join(TOP, page), encoding="utf-8") as f:
        if f"]({shows})" not in f.read():
            failures.append(f"{page} does not show {shows}")
print("\n".join(failures) or "all as kept")
sys.exit(bool(failures))
