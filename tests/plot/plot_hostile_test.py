#!/usr/bin/env python3
"""What goes wrong with figures is said, with the status that it has elsewhere, and nothing is left half written.

usage: plot_hostile_test.py FACETFIT"""
import os
import random
import subprocess
import sys
import tempfile

program = os.path.abspath(sys.argv[1])
USAGE, INPUT, OUTPUT = 2, 3, 4
failures = count = 0


def check(good, what):
    global failures, count
    count += 1
    if not good:
        failures += 1
        print("failed:", what)


def run(*args, stdin=None):
    return subprocess.run([program, *args], capture_output=True, cwd=scratch, input=stdin, timeout=120)


def refused(status, says, *args, stdin=None):
    got = run(*args, stdin=stdin)
    what = " ".join(args)[:150]
    error = got.stderr.decode(errors="replace")
    check(got.returncode == status, f"{what}: status {got.returncode}, expected {status}: {error}")
    check(says in error, f"{what}: '{says}' is not said: {error}")
    check(not got.stdout, f"{what}: something is printed")
    check(not os.path.exists(os.path.join(scratch, "new.svg")), f"{what}: a file is left")
    check(not [f for f in os.listdir(scratch) if ".part-" in f], f"{what}: an unfinished file is left")


def words():
    kinds = "slice, polar, profile, image, residuals, coverage, ndf, masking, fresnel, albedo, forest, correlation, likelihood, bootstrap, sweep"
    refused(USAGE, kinds, "plot", "pie", "paint.csv")
    refused(USAGE, "did you mean 'profile'", "plot", "profil", "paint.csv")
    refused(USAGE, "KIND", "plot")
    for kind in kinds.split(", "):
        if kind not in ("ndf", "masking"):
            refused(USAGE, "SOURCE is missing", "plot", kind)
    for name in ("a.png", "a", "a.svg.gz", "svg", "a.pdfx"):
        refused(USAGE, ".svg, .pdf or .csv", "plot", "ndf", "-o", name)
    for flag, values in {"--width": ("0", "nan", "1e9", "-5mm", "85 mm", "85km", "mm", "", "inf", "0x10mm", "19mm", "1e999mm"),
                         "--height": ("0", "nan", "1e9"), "--font-size": ("0", "nan", "1e9pt", "2pt", "-8pt")}.items():
        for value in values:
            refused(USAGE, "expected a length from", "plot", "ndf", flag, value, "-o", "new.svg")
    refused(USAGE, "no room", "plot", "ndf", "ggx", "--width", "20mm", "--font-size", "72pt", "-o", "new.svg")
    refused(USAGE, "no room", "plot", "slice", "ggx", "--height", "15mm", "-o", "new.svg")
    refused(USAGE, "--incidence", "plot", "slice", "ggx", "--incidence", "91")
    refused(USAGE, "--incidence", "plot", "slice", "ggx", "--incidence", "nan")
    refused(USAGE, "at most", "plot", "ndf", "--roughness", ",".join(["0.1"] * 33))
    refused(USAGE, "--roughness", "plot", "ndf", "--roughness", "0")
    refused(USAGE, "--per-row", "plot", "ndf", "--per-row", "0")
    refused(USAGE, "of one file, or of models", "plot", "slice", "paint.csv", "paint.csv")
    refused(USAGE, "of one file, or of models", "plot", "albedo", "ggx", "fit.json")
    refused(USAGE, "no parameter 'kd'", "plot", "albedo", "ggx", "beckmann", "--set", "kd=0.1")
    check(run("plot", "albedo", "ggx", "ggx+lambert", "--set", "kd=0.1").returncode == 0, "a value that one of two models has")
    refused(USAGE, "no parameter 'kd'", "plot", "albedo", "ggx kd=0.1", "ggx+lambert")
    refused(USAGE, "", "plot", "albedo", "ggx alpha", "-o", "new.svg")
    refused(USAGE, "", "plot", "albedo", "ggx alpha=" + "1" * 3000, "-o", "new.svg")
    refused(USAGE, "", "plot", "albedo", "ggx alpha=-1", "-o", "new.svg")
    refused(INPUT, "neither a file nor a model", "plot", "albedo", " alpha=0.1")
    refused(INPUT, "neither a file nor a model", "plot", "albedo", "x" * 5000 + " alpha=0.1")
    refused(USAGE, "not of the model", "plot", "coverage", "ggx")
    refused(USAGE, "not of the model", "plot", "forest", "ggx")
    refused(USAGE, "not of a result", "plot", "likelihood", "fit.json")
    refused(USAGE, "not of a result", "plot", "coverage", "fit.json")
    refused(USAGE, "leave out --from", "plot", "bootstrap", "paint.csv", "--from", "fit.json")
    refused(USAGE, "has no effect on 'albedo'", "plot", "albedo", "ggx", "--incidence", "30")
    refused(USAGE, "has no effect on 'coverage'", "plot", "coverage", "paint.csv", "--log")
    refused(USAGE, "has no effect on 'slice'", "plot", "slice", "paint.csv", "--bootstrap", "100")
    refused(USAGE, "--set is of models", "plot", "slice", "paint.csv", "--set", "alpha=0.1")
    refused(USAGE, "--roughness is of models", "plot", "albedo", "fit.json", "--roughness", "0.1")
    refused(USAGE, "shows one model", "plot", "image", "ggx", "beckmann")
    refused(USAGE, "is the input", "plot", "slice", "paint.csv", "-o", "paint.csv")
    refused(USAGE, "one model", "plot", "slice", "paint.csv", "--ndf", "ggx")
    refused(USAGE, "unexpected", "plot", "ndf", *["ggx"] * 40)


def names():
    refused(USAGE, "no channel 'x'; there are: r, g, b", "plot", "slice", "paint.csv", "--channel", "x")
    refused(USAGE, "no channel", "plot", "albedo", "ggx", "--channel", "r")
    refused(USAGE, "no free parameter 'x'; there are: alpha_x", "plot", "likelihood", "paint.csv", "--parameter", "x")
    refused(USAGE, "none of the parameters", "plot", "correlation", "paint.csv", "--parameter", "x")
    refused(USAGE, "no parameter", "plot", "forest", "paint.csv", "--parameter", "x")
    refused(USAGE, "two free parameters", "plot", "bootstrap", "paint.csv", "--parameter", "alpha_x")
    refused(INPUT, "neither a file nor a model", "plot", "ndf", "gxx")
    refused(INPUT, "No such file", "plot", "slice", "none.csv")
    refused(USAGE, "no lobe", "plot", "profile", "lambert")
    refused(USAGE, "no distribution", "plot", "ndf", "lambert")
    refused(USAGE, "no masking", "plot", "masking", "lambert")


def files():
    for name, content in {"empty.csv": b"", "empty.json": b"", "array.json": b"[1,2]", "other.json": b'{"schema": "facetfit.info/1"}',
                          "null.json": b"null", "text.csv": b"hello\n", "zero.csv": bytes(5000)}.items():
        with open(os.path.join(scratch, name), "wb") as f:
            f.write(content)
        for kind in ("slice", "forest"):
            refused(INPUT, name, "plot", kind, name, "-o", "new.svg")
    refused(INPUT, "not the result of a fit", "plot", "slice", "other.json")
    refused(INPUT, "not the result of a fit", "plot", "slice", "paint.csv", "--from", "other.json")
    refused(INPUT, "", "plot", "slice", "folder", "-o", "new.svg")
    run("info", "paint.csv", "--json", "info.json")
    refused(INPUT, "not the result of a fit", "plot", "forest", "info.json")
    with open(os.path.join(scratch, "fit.json"), "rb") as f:
        whole = f.read()
    for n in range(0, len(whole) - 2, 97):
        with open(os.path.join(scratch, "cut.json"), "wb") as f:
            f.write(whole[:n])
        got = run("plot", "correlation", "cut.json", "-o", "new.svg")
        check(got.returncode == INPUT, f"{n} bytes of a result: status {got.returncode}: {got.stderr.decode()}")
    dice = random.Random(int(os.environ.get("FF_TEST_SEED", "0")))
    for _ in range(150):
        damaged = bytearray(whole)
        for _ in range(dice.randint(1, 4)):
            damaged[dice.randrange(len(damaged))] = dice.choice(b'0123456789-e.,:"[]{}nx\\\xff\x00 ')
        with open(os.path.join(scratch, "cut.json"), "wb") as f:
            f.write(damaged)
        for kind in ("forest", "slice"):
            got = run("plot", kind, "cut.json")
            check(got.returncode in (0, USAGE, INPUT), f"a damaged result: status {got.returncode}: {got.stderr.decode(errors='replace')}")
    # a stream is read as a file is
    check(run("plot", "forest", "-", stdin=whole).stdout == run("plot", "forest", "fit.json").stdout, "standard input")


def outputs():
    path = os.path.join(scratch, "old.svg")
    with open(path, "w") as f:
        f.write("old")
    run("plot", "slice", "none.csv", "-o", "old.svg")
    run("plot", "slice", "paint.csv", "--channel", "x", "-o", "old.svg")
    run("plot", "ndf", "ggx", "--width", "20mm", "--font-size", "72pt", "-o", "old.svg")
    with open(path) as f:
        check(f.read() == "old", "a figure that failed takes the place of another")
    refused(OUTPUT, "folder/none/a.svg", "plot", "ndf", "-o", "folder/none/a.svg")
    if os.path.exists("/dev/full"):
        os.symlink("/dev/full", os.path.join(scratch, "full.svg"))
        got = run("plot", "ndf", "-o", "full.svg")
        check(got.returncode == OUTPUT, f"a full disk: status {got.returncode}: {got.stderr.decode()}")
    got = run("plot", "ndf", "--title", "x" * 20000)
    check(got.returncode == 0 and len(got.stdout) < 200000, "a long title")
    got = run("plot", "slice", "paint.csv", "--model", "beckmann+lambert", "--max-iterations", "0", "-o", "failed.svg")
    check(got.returncode == 1 and os.path.exists(os.path.join(scratch, "failed.svg")), "a fit that did not converge is drawn, with status 1")
    with open(os.path.join(scratch, "failed.svg")) as f:
        check("did not converge" in f.read(), "and the figure says so")


def sparse():
    head = "theta_i,phi_i,theta_o,phi_o,f\n"
    data = {"one": "30,0,30,180,0.5\n", "two": "30,0,30,180,0.5\n30,0,10,180,0.4\n", "zeros": "".join(f"30,0,{t},180,0\n" for t in range(0, 80, 5)),
            "negative": "".join(f"30,0,{t},180,{-0.1 - t}\n" for t in range(0, 80, 5)), "out": "".join(f"30,0,{t},90,0.1\n" for t in range(20, 80, 5)),
            "same": "30,0,30,180,0.5\n" * 30, "steep": "".join(f"{t / 100},0,{t / 100},180,1e300\n" for t in range(20)),
            "wide": "".join(f"30,0,{t},180,{10.0 ** (3 * t - 100)}\n" for t in range(0, 80, 2))}
    for name, rows in data.items():
        with open(os.path.join(scratch, name + ".csv"), "w") as f:
            f.write(head + rows)
        for kind in ("slice", "polar", "profile", "image", "residuals", "coverage", "forest", "correlation", "likelihood", "bootstrap", "sweep"):
            got = run("plot", kind, name + ".csv", *(["--bootstrap", "20"] if kind == "bootstrap" else []), "-o", "sparse.svg")
            check(got.returncode in (0, 1, INPUT), f"{kind} of {name}: status {got.returncode}: {got.stderr.decode()}")


with tempfile.TemporaryDirectory() as scratch:
    run("simulate", "ggx+lambert", "--set", "alpha=0.3,f0=0.5:0.4:0.3,kd=0.2", "--noise", "0.04", "-o", "paint.csv")
    run("fit", "paint.csv", "--json", "fit.json")
    os.mkdir(os.path.join(scratch, "folder"))
    for test in (words, names, files, outputs, sparse):
        before = failures
        test()
        print(f"{'FAILED' if failures > before else 'passed'}    {test.__name__}")
print(f"{count} checks, {failures} failures")
sys.exit(failures > 0)
