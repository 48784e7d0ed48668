#!/usr/bin/env python3
"""What goes wrong with pictures is said, with the status that it has elsewhere, and nothing is left half written.

usage: render_hostile_test.py FACETFIT"""
import os
import random
import subprocess
import sys
import tempfile

program = os.path.abspath(sys.argv[1])
USAGE, INPUT, OUTPUT = 2, 3, 4
failures = count = 0
rng = random.Random(int(os.environ.get("FF_TEST_SEED", "0")))


def check(good, what):
    global failures, count
    count += 1
    if not good:
        failures += 1
        print("failed:", what)


def run(*args):
    return subprocess.run([program, *args], capture_output=True, cwd=scratch, stdin=subprocess.DEVNULL, timeout=300, check=False)


def refused(status, says, *args, output="new.png"):
    got = run("render", *args, *(["-o", output] if output else []))
    what = " ".join(args)[:150]
    error = got.stderr.decode(errors="replace")
    check(got.returncode == status, f"{what}: status {got.returncode}, expected {status}: {error}")
    check(says in error, f"{what}: '{says}' is not said: {error}")
    check(not got.stdout, f"{what}: something is printed")
    check(not [f for f in os.listdir(scratch) if f.startswith("new")], f"{what}: a file is left")
    check(not [f for f in os.listdir(scratch) if ".part-" in f], f"{what}: an unfinished file is left")


def words():
    refused(USAGE, "SOURCE", output=None)
    refused(USAGE, "-o is missing", "ggx", output=None)
    for name in ("a", "a.jpg", "png", ".png", "a.PNG", "-", "a.png.gz"):
        refused(USAGE, ".png or .exr", "ggx", output=name)
    for flag, values in {"--size": ("0", "-1", "8193", "nan", "1e9", "x", ""), "--samples": ("0", "-1", "65537", "1e30", "x"), "--seed": ("-1", "x"),
                         "--exposure": ("nan", "65", "-inf", "x"), "--clip": ("0", "-1", "nan"), "--perspective": ("-1", "166", "nan"), "--turn": ("nan", "x"),
                         "--tone": ("gamma", "", "SRGBS"), "--background": ("red", ""), "--threads": ("-1", "1025")}.items():
        for value in values:
            refused(USAGE, flag, "ggx", flag, value)
    refused(USAGE, "did you mean 'filmic'", "ggx", "--tone", "filmik")
    for light in ("nan,0", "1", "0,0,0", "1,2,3,4", "", "x,y", "181,0", "inf,0,1", "1,,2", "45;135"):
        refused(USAGE, "--light", "ggx", "--light", light)
    refused(USAGE, "at most 64", "ggx", *["--light", "0,0"] * 65)
    for sky in ("sky:", "sky:91", "sky:-1", "sky:30:1", "sky:30:11", "sky:30:3:2", "sky:30:3:0:0", "sky:nan", "sky:x"):
        refused(USAGE, "ELEVATION", "ggx", "--environment", sky)
    refused(USAGE, "--environment", "ggx", "--environment", "")
    refused(USAGE, "add --environment", "ggx", "--turn", "20")
    for sweep in ("alpha", "alpha=", "=1", "alpha={0.1", "alpha={}", "alpha=x", "alpha[r]=1", "alpha={" + ",".join(["0.1"] * 33) + "}"):
        refused(USAGE, "--across", "ggx", "--across", sweep)
        refused(USAGE, "--down", "ggx", "--down", sweep)
    refused(USAGE, "did you mean 'alpha'", "ggx", "--across", "alfa=0.1")
    refused(USAGE, "--across", "ggx", "--across", "alpha={0.1,-1}")
    refused(USAGE, "--down", "ggx", "ggx", "--down", "alpha=0.1,0.2")
    refused(USAGE, "2^27", "ggx", "--size", "8192", "--across", "alpha=0.1,0.2,0.3")
    refused(USAGE, "of two pictures", "ggx", "--difference")
    refused(USAGE, "of two pictures", "ggx", "ggx", "ggx", "--difference")
    refused(USAGE, "--clip", "ggx", "--clip", "0.1")
    for flag in (["--tone", "linear"], ["--exposure", "1"], ["--background", "black"], ["--labels"]):
        refused(USAGE, "has no effect on OpenEXR", "ggx", *flag, output="new.exr")
    refused(INPUT, "neither a file nor a model", "nothing")
    refused(USAGE, "is not a flag", "ggx", "--roughness", "0.1")


def files():
    refused(INPUT, "missing.csv", "missing.csv")
    refused(INPUT, "folder/none.merl", "folder/none.merl")
    refused(USAGE, "--set is of models", "paint.csv", "--set", "alpha=0.1")
    refused(USAGE, "--across is of models", "paint.csv", "--across", "alpha=0.1,0.2")
    refused(USAGE, "add --from", "paint.csv", "--difference")
    refused(USAGE, "is too much", "paint.csv", "ggx")
    refused(USAGE, "is too much", "ggx", "paint.csv")
    refused(USAGE, "leave it out", "ggx", "--from", "fit.json")
    refused(INPUT, "none.json", "paint.csv", "--from", "none.json")
    refused(INPUT, "paint.csv", "paint.csv", "--from", "paint.csv")
    for name in ("missing.exr", "paint.csv", "empty.hdr", "folder", "cut.hdr", "dark.hdr"):
        got = run("render", "ggx", "--environment", name, "--size", "4", "-o", "new.png")
        error = got.stderr.decode(errors="replace")
        check(got.returncode in (USAGE, INPUT), f"environment {name}: status {got.returncode}: {error}")
        check(name in error, f"environment {name} is not named: {error}")
        check(not os.path.exists(os.path.join(scratch, "new.png")), f"environment {name}: a file is left")
    for form in ("png", "exr"):
        refused(OUTPUT, "nowhere", "ggx", "--size", "8", output=f"nowhere/a.{form}")
        os.symlink("/dev/full", os.path.join(scratch, f"full.{form}"))
        refused(OUTPUT, f"full.{form}", "ggx", "--size", "64", output=f"full.{form}")
    before = open(os.path.join(scratch, "paint.csv"), "rb").read()
    os.symlink("paint.csv", os.path.join(scratch, "same.png"))
    refused(USAGE, "same.png", "paint.csv", "--size", "4", output="same.png")
    check(open(os.path.join(scratch, "paint.csv"), "rb").read() == before, "an input is overwritten")


def damaged_maps():
    """Whatever is in a map: a status of the manual, a message that names it, no crash."""
    whole = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 8\n" + bytes(rng.randrange(1, 256) for _ in range(128))
    for k in range(60):
        damaged = bytearray(whole[:rng.randrange(len(whole))] if k % 2 else whole)
        for _ in range(rng.randrange(1, 6)):
            if damaged:
                damaged[rng.randrange(len(damaged))] = rng.randrange(256)
        with open(os.path.join(scratch, "damaged.hdr"), "wb") as f:
            f.write(damaged)
        got = run("render", "lambert", "--environment", "damaged.hdr", "--size", "3", "--samples", "4", "-o", "d.png")
        error = got.stderr.decode(errors="replace")
        check(got.returncode in (0, USAGE, INPUT), f"damaged map {k}: status {got.returncode}: {error[-300:]}")
        check(got.returncode == 0 or "damaged.hdr" in error or "module" in error, f"damaged map {k}: {error[-300:]}")


def put(name, data):
    with open(os.path.join(scratch, name), "wb") as f:
        f.write(data)


with tempfile.TemporaryDirectory() as scratch:
    os.mkdir(os.path.join(scratch, "folder"))
    run("simulate", "ggx+lambert", "--grid", "goniometer:30", "--noise", "0.02", "-o", "paint.csv")
    run("fit", "paint.csv", "--json", "fit.json")
    put("empty.hdr", b"")
    put("cut.hdr", b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 400 +X 800\nabc")
    put("dark.hdr", b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 2\n" + bytes(16))
    words()
    files()
    damaged_maps()
print(f"{count} checks, {failures} failures")
sys.exit(bool(failures) or count < 400)
