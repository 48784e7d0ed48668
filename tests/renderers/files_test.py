#!/usr/bin/env python3
"""files_test.py PROGRAM: what `facetfit export` writes is what the formats ask for, and the renderers show what was fitted.

glTF by Khronos' validator, MaterialX by MaterialX itself, USD by tinyusdz; the exported script of Blender renders a sphere that is equal to
the fit within 1 %; the exported glTF through three.js. Ends with 77 where one of them is not installed."""
import json
import os
import shutil
import subprocess
import sys
import tempfile

import numpy as np

import measure

PROGRAM = os.path.abspath(sys.argv[1])
failures = 0
FOLDER = tempfile.TemporaryDirectory()
os.chdir(FOLDER.name)
DATA = {"dielectric": ("ggx/smith-height-correlated/schlick+lambert", "alpha=0.25,f0=0.05,kd=0.6:0.3:0.1"),
        "metal": ("ggx/smith-height-correlated/schlick", "alpha_x=0.25,alpha_y=0.4,r_xy=0.3,f0=0.9:0.7:0.4"),
        "round": ("ggx/smith-height-correlated/schlick", "alpha=0.3,f0=0.9:0.7:0.4")}


def check(right, what):
    global failures
    if not right:
        failures += 1
        print("failed:", what)


def run(*words):
    done = subprocess.run([PROGRAM, *words], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    check(done.returncode == 0, f"{' '.join(words)}: {done.stderr[-400:]}")


def export(data, target, path):
    """The model of the fit, as an expression and settings for eval."""
    run("fit", data + ".csv", "--for", target, "--cut-off", "0", "--json", "fit.json")
    run("export", "fit.json", "--to", target.split(":")[0], "-o", path)
    with open("fit.json") as f:
        fit = json.load(f)["fits"][0]
    settings = [f"{name}={':'.join(map(repr, p['value'])) if isinstance(p['value'], list) else repr(p['value'])}" for name, p in fit["parameters"].items()]
    return fit["model"], ",".join(settings)


def formats():
    files = []
    for data, target, extension in (("dielectric", "gltf:dielectric", "gltf"), ("metal", "gltf:metal", "gltf"), ("metal", "gltf:metal", "glb"),
                                    ("round", "three-r187:metal", "gltf"), ("dielectric", "filament:dielectric", "glb"),
                                    ("dielectric", "openpbr:dielectric", "mtlx"), ("metal", "openpbr:metal", "mtlx"),
                                    ("dielectric", "standard-surface:dielectric", "mtlx"), ("metal", "standard-surface:metal", "mtlx"),
                                    ("dielectric", "usd:dielectric", "usda"), ("round", "usd:metal", "usda")):
        files.append(f"{len(files)}-{target.replace(':', '-')}.{extension}")
        export(data, target, files[-1])
    validate = ["node", os.path.join(measure.HERE, "validate.mjs")]
    done = subprocess.run([*validate, *files], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    print(done.stdout, end="")
    check(done.returncode == 0 and done.stdout.count("right") == len(files), "a file is not what its format asks for")
    for name, damage in (("0-gltf-dielectric.gltf", ('"roughnessFactor": 0', '"roughnessFactor": 7')), ("5-openpbr-dielectric.mtlx", ("open_pbr_surface", "open_pbr_surfac")),
                         ("9-usd-dielectric.usda", ("def Shader", "def {"))):  # the validators see what is wrong
        with open(name) as f:
            text = f.read()
        check(damage[0] in text, f"{name} has no {damage[0]}")
        with open("damaged-" + name, "w") as f:
            f.write(text.replace(*damage))
        check(subprocess.run([*validate, "damaged-" + name], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL).returncode == 1, f"damaged {name} passes")


def blender():
    for data, target in (("dielectric", "blender:dielectric"), ("metal", "blender:metal"), ("metal", "blender-glossy:ggx")):
        model, settings = export(data, target, "made.py")
        done = subprocess.run(["blender", "--background", "-noaudio", "--python-exit-code", "1", "--python", os.path.join(measure.HERE, "sphere.py"), "--",
                               "made.py", os.path.abspath("sphere.npy")], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        if done.returncode:
            raise SystemExit(done.stdout[-3000:])
        rows = np.load("sphere.npy")
        f = measure.evaluate(PROGRAM, model, settings, rows)
        off = np.sqrt(np.mean((rows[:, 4:7] - f)**2) / np.mean(f**2))
        worst = np.max(np.abs(rows[:, 4:7] - f)) / np.max(f)
        print(f"sphere of {target}: {len(rows)} pixels, rms {off:.2g} of the value, at most {worst:.2g} of the brightest")
        check(off < 0.01 and worst < 0.01, f"sphere of {target}: rms {off:.3g}, at most {worst:.3g}")


def three():
    for module, revision, target, data, tolerance in (("three", "170", "three-r170", "dielectric", 1e-3), ("three-r187", "187", "three-r187", "round", 5e-3)):
        model, settings = export(data, target, "made.gltf")
        with open("made.gltf") as f:
            material = json.load(f)["materials"][0]
        rows = measure.three(module, revision, {"made": material}, 24, [30, 80])["made"]
        f = measure.evaluate(PROGRAM, model, settings, rows)
        bright = (f > 1e-3 * f.max()) & (rows[:, 2] < 84)[:, None]
        off = np.abs(rows[:, 4:7] / np.where(bright, f, 1) - 1)[bright].max()
        print(f"exported glTF in three.js r{revision}: off by at most {off:.2g}")
        check(off <= tolerance, f"exported glTF in three.js r{revision}: {off:.3g}, allowed {tolerance:g}")


def main():
    for tool in ("node", "blender", "chromium"):
        if not shutil.which(tool):
            measure.skip(tool)
    for module in ("gltf-validator", "tinyusdz", "@needle-tools/materialx", "three-r187"):
        if not os.path.isdir(os.path.join(measure.MODULES, module)):
            measure.skip(module)
    for name, (model, settings) in DATA.items():
        run("simulate", model, "--set", settings, "--noise", "0.01", "-o", name + ".csv")
    formats()
    blender()
    three()
    print(f"{failures} failures")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
