#!/usr/bin/env python3
"""The sample page docs/gallery/fit.html is what docs/sample_page.py makes with this program: the same text, numbers to 5e-3, pictures to 2 of
255. Times and the digest of the input are of a machine, and left out. With --drive a browser works on the kept page.

usage: gallery_test.py FACETFIT [--drive]"""
import base64
import os
import re
import shutil
import struct
import subprocess
import sys
import tempfile
import zlib

HERE = os.path.dirname(os.path.abspath(__file__))
TOP = os.path.dirname(os.path.dirname(HERE))
sys.path.insert(0, os.path.join(TOP, "tests", "render"))
try:
    import pictures
except ImportError:
    print("skipped: this needs python3-numpy")
    sys.exit(77)

KEPT, MOST, CLOSE, PIXEL = os.path.join(TOP, "docs", "gallery", "fit.html"), 1000000, 5e-3, 2
NUMBER = re.compile(r"(?<![\w.])-?\d+\.?\d*(?:e[+-]?\d+)?")
MACHINE = re.compile(r'"time_s":[^,}]*|\b[0-9a-f]{64}\b')
PNG, CODES = re.compile(r"data:image/png;base64,([A-Za-z0-9+/=]+)"), re.compile(r'"codes":"([A-Za-z0-9+/=]+)"')
failures = []


def check(good, what):
    if not good:
        failures.append(what)


def parts(text):
    """Text without numbers and what is coded; numbers; pictures; codes."""
    text = MACHINE.sub("", text)
    found = [PNG.findall(text), CODES.findall(text)]
    text = CODES.sub("codes", PNG.sub("picture", text))
    return NUMBER.sub("#", text), [float(x) for x in NUMBER.findall(text)], *found


def same_picture(a, b, folder):
    """Pixels of red, green and blue; of a palette, which figures have, nearly all bytes: a cell may have the next colour."""
    kinds, pixels, packed = [], [], []
    for coded in (a, b):
        data = base64.b64decode(coded)
        kinds.append(data[25])
        path = os.path.join(folder, "a.png")
        with open(path, "wb") as f:
            f.write(data)
        if data[25] in (2, 6):
            pixels.append(pictures.png(path).astype(int))
        at = 8
        while at < len(data):
            size, kind = struct.unpack_from(">I4s", data, at)
            if kind == b"IDAT":
                packed.append(zlib.decompress(data[at + 8:at + 8 + size]))
            at += 12 + size
    if kinds[0] != kinds[1]:
        return False
    if pixels:
        return pixels[0].shape == pixels[1].shape and abs(pixels[0] - pixels[1]).max() <= PIXEL
    return len(packed) == 2 and len(packed[0]) == len(packed[1]) and sum(x != y for x, y in zip(*packed)) <= 0.01 * len(packed[0])


def codes(coded):
    data = base64.b64decode(coded)
    return [data[k] << 8 | data[k + 1] for k in range(0, len(data), 2)]


def compare(kept, made, folder):
    (text, numbers, images, coded), (text2, numbers2, images2, coded2) = parts(kept), parts(made)
    if text != text2:
        at = next((k for k, (a, b) in enumerate(zip(text, text2)) if a != b), min(len(text), len(text2)))
        check(False, f"the text differs: kept '{text[max(at - 60, 0):at + 60]}', made '{text2[max(at - 60, 0):at + 60]}'")
        return
    off = [(abs(a - b) / max(abs(a), abs(b)), a, b) for a, b in zip(numbers, numbers2) if a != b]
    check(not off or max(off)[0] <= CLOSE, f"a number differs: {max(off) if off else ''}")
    check(len(images) == len(images2) > 0 and len(coded) == len(coded2) > 0, "no pictures, or no nodes")
    for a, b in zip(images, images2):
        check(same_picture(a, b, folder), "a picture differs")
    for a, b in zip(coded, coded2):
        check(len(a) == len(b) and all(abs(x - y) <= 8 for x, y in zip(codes(a), codes(b))), "nodes of the data differ")  # half a per cent
    print(f"{len(numbers)} numbers, {len(off)} of them not the same to the last digit; {len(images)} pictures, {len(coded)} lists of nodes")


with open(KEPT, encoding="utf-8") as f:
    page = f.read()
check(len(page.encode()) < MOST, f"{len(page.encode())} bytes")
with tempfile.TemporaryDirectory() as scratch:
    subprocess.run([sys.executable, os.path.join(TOP, "docs", "sample_page.py"), sys.argv[1], scratch], check=True)
    with open(os.path.join(scratch, "fit.html"), encoding="utf-8") as f:
        compare(page, f.read(), scratch)
if "--drive" in sys.argv and shutil.which("node"):
    done = subprocess.run([shutil.which("node"), os.path.join(HERE, "drive.mjs"), "fit", KEPT], check=False)
    check(done.returncode in (0, 77), "the browser found something")
for name in ("docs/html.md", "docs/figures.md"):
    with open(os.path.join(TOP, name), encoding="utf-8") as f:
        check("](gallery/fit.html)" in f.read(), f"{name} does not lead to the sample page")
print("\n".join(failures) or "as kept")
sys.exit(bool(failures))
