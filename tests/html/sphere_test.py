#!/usr/bin/env python3
"""A lit sphere drawn by the script of a page is the picture of `render`: of a model within 1 of 255 in every pixel and channel, of data
between whose nodes the script interpolates within a few on average, under lights that the page was not made for.

usage: sphere_test.py FACETFIT ASSETS"""
import json
import os
import re
import shutil
import struct
import subprocess
import sys
import tempfile
import zlib

program, assets = os.path.abspath(sys.argv[1]), os.path.abspath(sys.argv[2])
HERE = os.path.dirname(os.path.abspath(__file__))
SIZE = 64
MEAN_ISOTROPIC, MEAN_TURNED = 1, 2
failures = 0


def check(good, what):
    global failures
    if not good:
        failures += 1
        print("failed:", what)


def run(*args):
    done = subprocess.run([program, *args], capture_output=True, text=True, cwd=scratch, check=False)
    check(done.returncode in (0, 1), f"{' '.join(args)}: {done.stderr}")


def read_png(path):
    """Rows of bytes, with the number of channels; 8 bits, not interlaced."""
    with open(path, "rb") as f:
        data = f.read()
    at, idat, head = 8, b"", None
    while at < len(data):
        n, kind = struct.unpack(">I4s", data[at:at + 8])
        body = data[at + 8:at + 8 + n]
        head = struct.unpack(">IIBBBBB", body) if kind == b"IHDR" else head
        idat += body if kind == b"IDAT" else b""
        at += 12 + n
    width, height, _, colour = head[:4]
    step = {2: 3, 6: 4, 0: 1}[colour]
    raw, rows, before = zlib.decompress(idat), [], bytearray(width * step)
    for j in range(height):
        kind, line = raw[j * (width * step + 1)], bytearray(raw[j * (width * step + 1) + 1:(j + 1) * (width * step + 1)])
        for i in range(len(line)):
            a, b, c = (line[i - step] if i >= step else 0), before[i], (before[i - step] if i >= step else 0)
            if kind == 4:
                p = a + b - c
                nearest = min((abs(p - a), 0, a), (abs(p - b), 1, b), (abs(p - c), 2, c))[2]
            line[i] = (line[i] + {0: 0, 1: a, 2: b, 3: (a + b) // 2, 4: nearest if kind == 4 else 0}[kind]) & 255
        rows.append(line)
        before = line
    return width, height, step, rows


def page_data():
    with open(os.path.join(scratch, "page.html"), encoding="utf-8") as f:
        return json.loads(re.search(r'<script type="application/json" id="page">(.*?)</script>', f.read(), re.S)[1])


def compare(expression, settings, light, words):
    """The largest difference over pixels that the sphere covers whole; how many these are."""
    run("simulate", expression, "--set", settings, "--grid", "goniometer:30", "-o", "data.csv")
    run("fit", "data.csv", "--model", expression, "--html", "page.html", "--json", "fit.json")
    run("render", "fit.json", "--size", str(SIZE), "--light", words, "--background", "black", "-o", "picture.png")
    page = page_data()
    with open(os.path.join(scratch, "fit.json"), encoding="utf-8") as f:
        fit = json.load(f)["fits"][0]
    parameters = {k: p["value"] if isinstance(p["value"], list) else [p["value"]] for k, p in fit["parameters"].items()}
    with open(os.path.join(scratch, "job.json"), "w", encoding="ascii") as f:
        json.dump({"model": page["models"][0], "parameters": parameters, "channels": len(fit["channels"]), "size": SIZE, "light": light}, f)
    differences, lit = against_picture()
    return max(differences), len(differences) / 3, lit


def compare_data(light, words):
    """The mean difference of the data of page.html to data.csv."""
    run("render", "data.csv", "--size", str(SIZE), "--light", words, "--background", "black", "-o", "picture.png")
    sphere = page_data()["sphere"]
    with open(os.path.join(scratch, "job.json"), "w", encoding="ascii") as f:
        json.dump({"sphere": sphere, "channels": len(sphere["channels"]), "size": SIZE, "light": light}, f)
    differences, _ = against_picture()
    return sum(differences) / len(differences)


def against_picture():
    """What the script draws of job.json to picture.png: differences where the sphere covers a pixel whole; how many values are lit."""
    done = subprocess.run([node, os.path.join(HERE, "sphere.mjs"), assets, os.path.join(scratch, "job.json")], capture_output=True, text=True, check=True)
    got = json.loads(done.stdout)
    width, height, step, rows = read_png(os.path.join(scratch, "picture.png"))
    check((width, height) == (SIZE, SIZE), f"a picture of {width} x {height}")
    differences, lit = [], 0
    for j in range(SIZE):
        for i in range(SIZE):
            at = 4 * (j * SIZE + i)
            if got[at + 3] < 255:
                continue
            for c in range(3):
                shown = rows[j][i * step + (c if step >= 3 else 0)]
                differences.append(abs(got[at + c] - shown))
                lit += shown > 20
    return differences, lit


def main():
    cases = [("ggx+lambert", "alpha=0.3,f0=0.9:0.6:0.3,kd=0.1:0.05:0.2", [-0.5, 0.5, 0.5 ** 0.5], "45,135"),
             ("beckmann/v-cavity/schlick+oren-nayar", "alpha_x=0.15,alpha_y=0.4,f0=0.5:0.4:0.3,kd=0.2", [0.7, 0.1, 0.5 ** 0.5], "0.7,0.1,0.70710678118654757"),
             ("gtr/smith-separable/dielectric+lambert", "alpha=0.2,gamma=1.5,kd=0.4", [0.2, -0.3, -0.4], "0.2,-0.3,-0.4")]
    for expression, settings, light, words in cases:
        length = sum(x * x for x in light) ** 0.5
        worst, whole, lit = compare(expression, settings, [x / length for x in light], words)
        print(f"{expression}: off by {worst} of 255 in {whole} pixels, {lit} values lit")
        check(worst <= 1 and whole > 0.7 * SIZE * SIZE and lit > 300, f"{expression}: off by {worst}")
    # is another light seen?
    worst, _, _ = compare(*cases[0][:2], [-0.5, 0.45, 0.74], "45,135")
    check(worst > 1, "another light is not seen")
    # data: of an isotropic surface, and of one that has a direction
    lights = [([-0.5, 0.5, 0.5 ** 0.5], "45,135"), ([0.7, 0.1, 0.5 ** 0.5], "0.7,0.1,0.70710678118654757")]
    for settings, side, most in (("alpha=0.3,f0=0.9:0.6:0.3,kd=0.1", 0, MEAN_ISOTROPIC), ("alpha_x=0.2,alpha_y=0.5,f0=0.9:0.6:0.3,kd=0.1", 25, MEAN_TURNED)):
        run("simulate", "ggx+lambert", "--set", settings, "--grid", "goniometer:5", "-o", "data.csv")
        run("fit", "data.csv", "--html", "page.html")
        check(page_data()["sphere"]["side"] == side, f"{settings}: other nodes")
        for light, words in lights:
            mean = compare_data(light, words)
            print(f"data of {settings}, light {words}: off by {mean:.2f} of 255 on average")
            check(mean < most, f"data of {settings}, light {words}: off by {mean:.2f}")
        mean = compare_data([-0.5, 0.1, 0.74 ** 0.5], lights[0][1])
        check(mean > most, f"data of {settings}: another light is not seen: {mean:.2f}")
    return failures != 0


node = shutil.which("node")
if not node:
    print("skipped: node is not there (./setup renderers)")
    sys.exit(77)
with tempfile.TemporaryDirectory() as scratch:
    sys.exit(main())
