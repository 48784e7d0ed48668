#!/usr/bin/env python3
"""files_test.py PROGRAM: one file of every format, made by make_files.py of a known surface, is described, converted and fitted.

The values that the program finds are those of the surface at the directions that it finds, so that a direction, a unit, a cosine or an order
that was taken for another shows; and the default fit finds the surface again. No format of the program's is left out.
"""
import json
import os
import subprocess
import sys
import tempfile

try:
    import numpy as np
except ImportError:
    print("skipped: this needs python3-numpy")
    sys.exit(77)
import make_files

PROGRAM = os.path.abspath(sys.argv[1])
# Samples; channels of the truth that are in the file; digits that the format keeps, as a relative error.
ONE, ALL = [0], [0, 1, 2]
EXPECTED = {"merl": (1458000, ALL, 1e-12), "astm": (2448, ALL, 1e-8), "csv": (2448, ALL, 1e-8), "exr": (288 * 288, ALL, 1e-6), "images": (288, ALL, 1e-6),
            "rgl": (8 * 32 * 32, ALL, 2e-5), "utia": (288 * 288, ALL, 1e-12), "alta": (2448, ALL, 1e-8), "alta, cosine": (2448, ONE, 1e-8),
            "zemax": (624, ONE, 1e-8), "cornell": (2448, ALL, 1e-8), "fred": (1292, ONE, 1e-8), "lighttools": (1100, ALL, 1e-8), "mbsdf": (54900, ALL, 1e-6),
            "nist": (2448, ONE, 1e-8), "pgii": (2952, ONE, 1e-8), "planetary": (1040, ALL, 1e-8), "window": (145 * 145, ONE, 1e-8)}
failures = 0


def check(condition, words):
    global failures
    if not condition:
        failures += 1
        print("failed: " + words)
    return condition


def run(*words):
    done = subprocess.run([PROGRAM, *words], capture_output=True, text=True, check=False, timeout=600)
    return done.stdout if check(done.returncode == 0, f"{' '.join(words)} ends with {done.returncode}: {done.stderr}") else None


def table(path):
    """Angles in degrees [n][4] and values [n][channels] of a CSV of the program's."""
    with open(path, encoding="utf-8") as f:
        lines = f.readlines()
    unit = np.degrees(1) if "# angles: radians\n" in lines else 1
    lines = [line for line in lines if not line.startswith("#")]
    names = lines[0].strip().split(",")
    columns = [k for k, name in enumerate(names) if name not in ("weight",) and not name.startswith("sigma")]
    assert names[:4] == ["theta_i", "phi_i", "theta_o", "phi_o"], names
    numbers = np.array([[float(x) if x else np.nan for x in line.rstrip("\n").split(",")] for line in lines[1:]])
    return numbers[:, :4] * unit, numbers[:, [k for k in columns if k > 3]]


def check_values(name, path, folder):
    samples, channels, digits = EXPECTED[name]
    copy = os.path.join(folder, "copy.csv")
    if name == "merl":  # every sample is looked at by the fit; as text they would take a minute
        return
    if run("resample", path, copy) is None:
        return
    angles, found = table(copy)
    if not check(found.shape == (samples, len(channels)), f"{name}: {found.shape}, expected {samples} x {len(channels)}"):
        return
    expected = make_files.at(*angles.T)[:, channels]
    seen = np.isfinite(found).all(-1) & (angles[:, 2] < 89) & (angles[:, 0] < 89)
    error = np.abs(found - expected)[seen] / np.maximum(expected[seen], 1e-3)
    check(seen.sum() > samples / 2 and error.max() <= digits, f"{name}: {seen.sum()} values, off by up to {error.max():.3g} at {angles[seen][error.max(-1).argmax()]}")
    print(f"{name:14} {samples:8} samples, {seen.sum():8} compared, worst relative difference {error.max():.1e}")


def check_fit(name, path):
    samples, channels, digits = EXPECTED[name]
    said = run("fit", path, "--json", "-")
    if said is None:
        return
    document = json.loads(said)
    fit, allowed = document["fits"][0], max(30 * digits, 1e-7)
    check(document["data"]["samples"] == samples and document["data"]["format"] == name.split(",")[0], f"{name}: {document['data']}")
    check(fit["outcome"] == "converged", f"{name}: {fit['outcome']}")
    check(document["data"]["used"] > 0.3 * samples, f"{name}: {document['data']['used']} of {samples} used")
    check(abs(fit["parameters"]["alpha_x"]["value"] / make_files.TRUTH["alpha_x"] - 1) <= allowed, f"{name}: alpha {fit['parameters']['alpha_x']['value']}")
    for parameter in ("f0", "kd"):
        for k, c in enumerate(channels):
            found, truth = fit["parameters"][parameter]["value"][k], make_files.TRUTH[parameter][c]
            check(abs(found - truth) <= allowed, f"{name}: {parameter} {found}, expected {truth}")


def main():
    formats = {f["name"] for f in json.loads(run("formats", "--json", "-"))["formats"]}
    own = {"anisotropicbsdf", "openmaterial", "speos"}  # made in the tests of these formats
    check(formats - own <= set(make_files.FILES), f"no file is made of {sorted(formats - own - set(make_files.FILES))}")
    with tempfile.TemporaryDirectory() as folder:
        for name, path in make_files.make(folder).items():
            if name not in formats and name.split(",")[0] not in formats:
                print(f"{name}: this program was built without it")
                continue
            said = run("info", path) or ""
            check("cosine counted" not in said and "cosine divided" not in said, f"{name}: info suspects a cosine")
            check_values(name, path, folder)
            check_fit(name, path)
    print(f"{len(EXPECTED)} files, {failures} failures")


main()
sys.exit(1 if failures else 0)
