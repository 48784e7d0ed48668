#!/usr/bin/env python3
"""adding_test.py SOURCE_DIR CMAKE [LAUNCHER]: the recipes of docs/adding.md work as they stand there.

Copies the sources, carries out every recipe (`<!-- new: FILE -->` and `<!-- line: FILE -- before|after: TEXT -->`, each followed by a
block of code), counts the files that each touches, builds the program without optimisation, and uses each new part.
"""
import csv
import math
import os
import re
import shutil
import subprocess
import sys
import tempfile

SOURCE, CMAKE = os.path.abspath(sys.argv[1]), sys.argv[2]
LAUNCHER = sys.argv[3] if len(sys.argv) > 3 else ""
# What each heading promises: new files, files that get lines.
PROMISES = {"A distribution of normals": (1, 1), "A file format": (1, 1), "A loss": (1, 1), "A column of a report": (0, 1),
            "A kind of figure": (1, 1)}
STEP = re.compile(r"<!-- (new|line): (\S+)(?: -- (before|after): (.*?))? -->\n\n```c\n(.*?)```\n", re.S)
failures = 0


def check(condition, text):
    global failures
    if not condition:
        failures += 1
        print("failed: " + text)


def copy_sources(to):
    """What the build needs: the tests and benchmarks stay behind."""
    folders = ["base", "models", "targets", "data_formats", "simulate", "fit", "report", "cli", "python", "cmake", "docs"]
    for name in folders:
        shutil.copytree(os.path.join(SOURCE, name), os.path.join(to, name))
    shutil.copy(os.path.join(SOURCE, "CMakeLists.txt"), to)


def carry_out(kind, path, where, anchor, code, top):
    target = os.path.join(top, path)
    if kind == "new":
        check(not os.path.exists(target), f"{path} is there already")
        with open(target, "w", encoding="utf-8") as f:
            f.write(code)
        return
    with open(target, encoding="utf-8") as f:
        text = f.read()
    line = anchor + "\n"
    check(text.count("\n" + line) >= 1, f"{path} has no line '{anchor}'")
    at = text.index("\n" + line) + 1 + (len(line) if where == "after" else 0)
    with open(target, "w", encoding="utf-8") as f:
        f.write(text[:at] + code + text[at:])


def follow_recipes(top):
    with open(os.path.join(SOURCE, "docs", "adding.md"), encoding="utf-8") as f:
        page = f.read()
    recipes = dict(part.split("\n", 1) for part in page.split("\n## ")[1:])
    check(set(recipes) == set(PROMISES), f"the recipes are {sorted(recipes)}")
    for title, text in recipes.items():
        steps = STEP.findall(text)
        check(len(steps) == text.count("```c"), f"{title}: a block of code that is not carried out")
        for step in steps:
            carry_out(*step, top)
        new = {path for kind, path, *_ in steps if kind == "new"}
        changed = {path for kind, path, *_ in steps if kind == "line"}
        check((len(new), len(changed)) == PROMISES[title], f"{title}: new {sorted(new)}, changed {sorted(changed)}")
        lines = [code for kind, _, _, _, code in steps if kind == "line"]
        check(title == "A column of a report" or [code.count("\n") for code in lines] == [1], f"{title}: more than one line")


def build(top, out):
    """The program alone, for one instruction set and without optimisation: what is tested is that it works, not how fast."""
    room = os.path.join(top, "cmake", "FacetfitRoom.cmake")
    with open(room, encoding="utf-8") as f:
        text = f.read()
    hurried = text.replace("list(APPEND FACETFIT_ISAS avx2 avx512)", "").replace("FACETFIT_KERNEL_FLAGS -O3", "FACETFIT_KERNEL_FLAGS -O0")
    check(hurried != text, "cmake/FacetfitRoom.cmake has changed: the program is built for all instruction sets")
    with open(room, "w", encoding="utf-8") as f:
        f.write(hurried)
    words = ["-DCMAKE_BUILD_TYPE=Debug", "-DCMAKE_C_FLAGS_DEBUG=-O0", "-DCMAKE_CXX_FLAGS_DEBUG=-O0", "-DFACETFIT_TESTS=OFF",
             "-DFACETFIT_BENCH=OFF", "-DFACETFIT_IMAGES=OFF"]
    if LAUNCHER:
        words += [f"-DCMAKE_C_COMPILER_LAUNCHER={LAUNCHER}", f"-DCMAKE_CXX_COMPILER_LAUNCHER={LAUNCHER}"]
    environment = dict(os.environ, CCACHE_BASEDIR=os.path.dirname(top), CCACHE_NOHASHDIR="1")
    for command in ([CMAKE, "-S", top, "-B", out, *words], [CMAKE, "--build", out, "--parallel", "2", "--target", "facetfit_cli"]):
        done = subprocess.run(command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
        if done.returncode:
            print(done.stdout[-4000:])
            sys.exit(f"failed: {' '.join(command)}")
        check("warning:" not in done.stdout, "the compiler warns: " + "\n".join(l for l in done.stdout.splitlines() if "warning:" in l))
    return os.path.join(out, "bin", "facetfit")


def run(program, *words):
    done = subprocess.run([program, *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, check=False)
    check(done.returncode == 0, f"{' '.join(words)} ended with {done.returncode}: {done.stderr}")
    return done.stdout


def use(program, folder):
    data, plane = os.path.join(folder, "data.csv"), os.path.join(folder, "plane.txt")
    check(re.search(r"^  hyperbolic$", run(program, "models"), re.M), "`models` does not list the distribution")
    run(program, "simulate", "hyperbolic+lambert", "--set", "alpha=0.3,f0=0.3,kd=0.2", "--noise", "0.01", "-o", data)
    text = run(program, "fit", data, "--model", "hyperbolic+lambert", "--shape", "isotropic")
    alpha = re.search(r"alpha_x +([\d.]+)", text)
    check("converged" in text and alpha and abs(float(alpha[1]) - 0.3) < 0.005, f"the distribution is not fitted:\n{text}")
    # It is one: the weak white furnace says that D and Lambda go together.
    weak = [float(x) for x in re.findall(r"[\d.]+$", run(program, "furnace", "hyperbolic", "--set", "alpha=0.3", "--weak"), re.M)]
    check(weak and all(abs(x - 1) < 1e-3 for x in weak), f"the weak white furnace is {weak}")

    with open(plane, "w", encoding="utf-8") as f:
        f.write("light,detector,reflectance_factor\n30,-20,0.41\n30,30,2.05\n")
    check(re.search(r"^inplane\b", run(program, "formats", "--table", "csv"), re.M), "`formats` does not list the format")
    check(run(program, "info", plane).startswith(plane + ": inplane\n"), "the file is not recognised")

    text = run(program, "fit", data, "--loss", "asinh")
    check("loss asinh" in text and "converged" in text, f"the loss does not work:\n{text}")

    drawn, slopes = run(program, "plot", "slopes", "beckmann alpha=0.3", "ggx"), os.path.join(folder, "slopes.csv")
    check("slope along x" in drawn and "beckmann alpha=0.3" in drawn, f"the figure is not drawn: {drawn[:300]}")
    run(program, "plot", "slopes", "beckmann alpha=0.3", "-o", slopes)
    with open(slopes, encoding="utf-8") as f:
        density = {float(row["x"]): float(row["y"]) for row in csv.DictReader(f)}
    expected = {s: math.exp(-(s / 0.3) ** 2) / (math.pi * 0.09) for s in density}
    check(len(density) == 201 and all(abs(density[s] - expected[s]) <= 1e-9 * expected[s] + 1e-300 for s in density), "the slopes are not those of Beckmann")
    check("slopes" in run(program, "plot", "--help"), "the help does not name the figure")

    table = [row.split(",") for row in run(program, "compare", data, "--ndf", "ggx,hyperbolic", "--masking", "smith-separable", "--table",
                                           "csv").splitlines()]
    check("condition" in table[0] and float(table[1][table[0].index("condition")]) >= 1, f"the column is not there: {table[0]}")
    check(table[1][1] == "hyperbolic", f"the best fit is {table[1][1]}")


with tempfile.TemporaryDirectory() as scratch:
    sources = os.path.join(scratch, "sources")
    os.mkdir(sources)
    copy_sources(sources)
    follow_recipes(sources)
    use(build(sources, os.path.join(scratch, "build")), scratch)
print(f"{len(PROMISES)} recipes, {failures} failures")
sys.exit(1 if failures else 0)
