#!/usr/bin/env python3
"""The numbers of figures, read from their CSV, against formulas and against what other commands say.

usage: plot_numbers_test.py FACETFIT"""
import csv
import io
import json
import math
import os
import random
import statistics
import subprocess
import sys
import tempfile

program = os.path.abspath(sys.argv[1])
failures = checks = 0


def check(good, what):
    global failures, checks
    checks += 1
    if not good:
        failures += 1
        if failures < 40:
            print("failed:", what)


def close(a, b, relative, what):
    check(abs(a - b) <= relative * max(abs(b), 1e-300), f"{what}: {a}, expected {b}")


def run(*args, expect=0):
    got = subprocess.run([program, *args], capture_output=True, text=True, cwd=scratch)
    check(got.returncode == expect, f"{' '.join(args)}: status {got.returncode}: {got.stderr}")
    return got.stdout


def plot(*args):
    """{(panel, series): [row]}, numbers as such."""
    name = os.path.join(scratch, "f.csv")
    if os.path.exists(name):
        os.remove(name)
    run("plot", *args, "-o", "f.csv")
    series = {}
    with open(name, newline="") as f:
        for row in csv.DictReader(f):
            numbers = {k: float(row[k]) if row[k] not in ("",) and k not in ("x", "y") else row[k] for k in ("low", "high", "x_low", "x_high", "z", "x", "y")}
            for k in ("x", "y"):
                try:
                    numbers[k] = float(row[k])
                except ValueError:
                    pass
            series.setdefault((int(row["panel"]), row["series"]), []).append(numbers)
    return series


def radians(x):
    return x * math.pi / 180


def ggx(a, t):
    return a * a / (math.pi * ((a * a - 1) * math.cos(t) ** 2 + 1) ** 2)


def beckmann(a, t):
    return math.exp(-(math.tan(t) / a) ** 2) / (math.pi * a * a * math.cos(t) ** 4)


def distributions():
    for a in (0.1, 0.45):
        s = plot("ndf", "--ndf", "ggx,beckmann", "--roughness", str(a), "--no-log")
        for name, formula in (("ggx", ggx), ("beckmann", beckmann)):
            rows = s[1, f"{name}, α = {a}"]
            check(len(rows) == 181, f"{name} has {len(rows)} points")
            for row in rows:
                expected = formula(a, radians(row["x"]))
                check(abs(row["y"] - expected) <= 1e-9 * expected + 1e-290, f"{name} at {row['x']}: {row['y']}, expected {expected}")


def maskings():
    a = 0.4
    s = plot("masking", "--masking", "smith-separable,smith-height-correlated,v-cavity", "--roughness", str(a))
    for panel in (1, 2):
        for row in s[panel, f"smith-separable, α = {a}"]:
            g1 = 2 / (1 + math.sqrt(1 + (a * math.tan(radians(row["x"]))) ** 2))
            close(row["y"], g1 if panel == 1 else g1 * g1, 1e-9, f"G{panel} at {row['x']}")
    for row in s[2, f"smith-height-correlated, α = {a}"]:
        close(row["y"], 1 / math.sqrt(1 + (a * math.tan(radians(row["x"]))) ** 2), 1e-9, f"height-correlated at {row['x']}")
    for row in s[2, f"v-cavity, α = {a}"]:  # the half vector is the normal
        close(row["y"], 1, 1e-9, f"V-cavity in the mirror direction at {row['x']}")
    for row in s[1, f"v-cavity, α = {a}"]:
        t = radians(row["x"])
        close(row["y"], min(1, 2 * math.cos(t / 2) * math.cos(t) / math.cos(t / 2), 2 * math.cos(t / 2) / math.cos(t / 2)), 1e-9, f"V-cavity at {row['x']}")


def light_from_one_side():
    a, ti = 0.6, 35
    g1 = lambda t: 2 / (1 + math.sqrt(1 + (a * math.tan(radians(t))) ** 2))
    s = plot("masking", "--masking", "smith-separable,v-cavity", "--roughness", str(a), "--incidence", f"{ti},70")
    check({panel for panel, _ in s} == {1, 2} and len(s[1, f"v-cavity, α = {a}"]) == 181, "a panel an incidence")
    for row in s[1, f"smith-separable, α = {a}"]:
        close(row["y"], g1(ti) * g1(min(abs(row["x"]), 89.99)), 1e-9, f"G2 at {row['x']}")
    for row in s[1, f"v-cavity, α = {a}"]:  # all in the plane: h is at half the angle between them, on the side of the view
        to = max(min(row["x"], 89.99), -89.99)
        h, d = abs(radians(to - ti) / 2), radians(to + ti) / 2
        close(row["y"], min(1, 2 * math.cos(h) * math.cos(radians(to)) / math.cos(d), 2 * math.cos(h) * math.cos(radians(ti)) / math.cos(d)), 1e-9, f"V-cavity at {to}")


def values_of_one_model():
    """Those in its word are of it alone; those of --set are of all that have the parameter."""
    s = plot("ndf", "ggx alpha=0.2", "beckmann", "vmf kappa=50", "--set", "alpha=0.5", "--no-log")
    for name, formula, alpha in (("ggx alpha=0.2", ggx, 0.2), ("beckmann", beckmann, 0.5)):
        for row in s[1, name]:
            expected = formula(alpha, radians(row["x"]))
            check(abs(row["y"] - expected) <= 1e-9 * expected + 1e-290, f"{name} at {row['x']}: {row['y']}, expected {expected}")
    for row in s[1, "vmf kappa=50"]:
        mu = math.cos(radians(row["x"]))
        expected = 50 / (2 * math.pi * (1 - math.exp(-50))) * math.exp(50 * (mu - 1)) / mu
        check(abs(row["y"] - expected) <= 1e-9 * expected, f"vmf at {row['x']}: {row['y']}, expected {expected}")


def fresnel_terms():
    s = plot("fresnel", "ggx", "ggx/v-cavity/dielectric eta=1.5", "--set", "f0=0.2")
    for row in s[1, "ggx"]:
        close(row["y"], 0.2 + 0.8 * (1 - math.cos(radians(row["x"]))) ** 5, 1e-9, f"Schlick at {row['x']}")
    for row in s[1, "ggx/v-cavity/dielectric eta=1.5"]:
        c = math.cos(radians(row["x"]))
        g = math.sqrt(1.5 ** 2 - 1 + c * c)
        close(row["y"], 0.5 * ((g - c) / (g + c)) ** 2 * (1 + ((c * (g + c) - 1) / (c * (g - c) + 1)) ** 2), 1e-9, f"a dielectric at {row['x']}")
    s = plot("fresnel", "ggx f0=0.9:0.5:0.1", "--channel", "r,b")
    close(s[1, "ggx f0=0.9:0.5:0.1, r"][0]["y"], 0.9, 1e-12, "channel r")
    close(s[1, "ggx f0=0.9:0.5:0.1, b"][0]["y"], 0.1, 1e-12, "channel b")


def albedos():
    for row in plot("albedo", "lambert", "--set", "kd=0.37")[1, "lambert"]:
        close(row["y"], 0.37, 1e-9, f"lambert at {row['x']}")
    rows = plot("albedo", "ggx+lambert", "--set", "alpha=0.35,f0=0.6,kd=0.15")[1, "ggx+lambert"]
    mu = ["%.17g" % math.cos(radians(r["x"])) for r in rows]
    furnace = [line.split(",") for line in run("furnace", "ggx+lambert", "--set", "alpha=0.35,f0=0.6,kd=0.15", "--mu", ",".join(mu)).split()[1:]]
    check(len(furnace) == len(rows) == 31, f"{len(furnace)} and {len(rows)} albedos")
    for row, (_, albedo) in zip(rows, furnace):
        close(row["y"], float(albedo), 1e-5, f"albedo at {row['x']}")


def slices():
    values = "alpha=0.25,f0=0.5,kd=0.3"
    s = plot("slice", "ggx+lambert", "--set", values, "--incidence", "40")
    rows = s[1, "model"]
    pairs = "theta_i,phi_i,theta_o,phi_o\n" + "".join("40,0,%.17g,180\n" % max(min(r["x"], 89.99), -89.99) for r in rows)
    with open(os.path.join(scratch, "pairs.csv"), "w") as f:
        f.write(pairs)
    said = list(csv.DictReader(io.StringIO(run("eval", "ggx+lambert", "--set", values, "pairs.csv"))))
    check(len(said) == len(rows) == 361, f"{len(rows)} points of a slice")
    for row, other, lobe, diffuse in zip(rows, said, s[1, "lobe"], s[1, "diffuse"]):
        close(row["y"], float(other["f"]), 1e-12, f"f at {row['x']}")
        close(lobe["y"] + diffuse["y"], row["y"], 1e-12, f"parts at {row['x']}")
        check(abs(diffuse["y"] - 0.3 / math.pi) < 1e-12 * max(row["y"], 1), f"diffuse at {row['x']}: {diffuse['y']}")
    close(s[1, "mirror direction"][0]["x"], 40, 0, "mirror direction")
    # data: those of the file, in the plane, with the noise that the fit found as bars; beyond 80 degrees apart
    s = plot("slice", "paint.csv", "--incidence", "45", "--channel", "r")
    fit = json.loads(run("fit", "paint.csv", "--json"))["fits"][0]
    with open(os.path.join(scratch, "paint.csv")) as f:
        table = list(csv.DictReader(line for line in f if not line.startswith("#")))
    plane = {}
    for row in table:
        if float(row["theta_i"]) == 45 and abs(math.sin(radians(float(row["phi_o"]) - float(row["phi_i"])))) < 1e-9:
            sign = -1 if math.cos(radians(float(row["phi_o"]) - float(row["phi_i"]))) > 0 else 1
            plane.setdefault(round(sign * float(row["theta_o"]), 6), set()).add(float(row["f_r"]))
    level = fit["noise"]["levels"][0]
    shown = s[1, "data"] + s.get((1, "data, not fitted"), [])
    check(len(plane) == len({round(r["x"], 6) for r in shown}), f"{len(plane)} angles in the plane, {len(shown)} drawn")
    for row in shown:
        check(any(abs(row["y"] - y) <= 1e-12 * abs(y) for y in plane.get(round(row["x"], 6), ())), f"no datum {row['y']} at {row['x']}")
    for row in s[1, "data"]:
        variance = level["constant"] + level["linear"] * row["y"] + level["square"] * row["y"] ** 2
        variance *= math.cos(radians(45)) ** fit["noise"]["cos_i"] * math.cos(radians(row["x"])) ** fit["noise"]["cos_o"]
        close(row["high"] - row["y"], math.sqrt(variance), 1e-6, f"bar at {row['x']}")
        check(abs(row["x"]) <= 80.001, f"{row['x']} was not fitted")
    check(all(abs(r["x"]) > 80 for r in s[1, "data, not fitted"]), "fitted data are called not fitted")


def images():
    s = plot("image", "paint.csv", "--channel", "b")
    check(len(s[1, "data"]) == len(s[3, "residual"]) == 900, "cells")
    with open(os.path.join(scratch, "paint.csv")) as f:
        table = list(csv.DictReader(line for line in f if not line.startswith("#")))
    sums = {}
    for row in table:
        ti, pi, to, po = (radians(float(row[k])) for k in ("theta_i", "phi_i", "theta_o", "phi_o"))
        if max(ti, to) > radians(80) + 1e-9:
            continue
        wi = (math.sin(ti) * math.cos(pi), math.sin(ti) * math.sin(pi), math.cos(ti))
        wo = (math.sin(to) * math.cos(po), math.sin(to) * math.sin(po), math.cos(to))
        h = [a + b for a, b in zip(wi, wo)]
        length = math.sqrt(sum(x * x for x in h))
        th, td = math.acos(min(h[2] / length, 1)), math.acos(min(length / 2, 1))
        sums.setdefault((math.degrees(td) / 3, math.degrees(th) / 3), []).append(float(row["f_b"]))
    cells, edges = {}, set()
    for (x, y), v in sums.items():
        if min(abs(x - round(x)), abs(y - round(y))) < 1e-6:  # on the edge of a cell: either of two
            edges |= {(int(x + dx), int(y + dy)) for dx in (-0.01, 0.01) for dy in (-0.01, 0.01)}
        cells.setdefault((int(x), int(y)), []).extend(v)
    compared = 0
    for data, model, residual in zip(s[1, "data"], s[2, "model"], s[3, "residual"]):
        key = (int(data["x"] / 3), int(data["y"] / 3))
        if key in edges or key not in cells:
            continue
        compared += 1
        close(data["z"], sum(cells[key]) / len(cells[key]), 1e-9, f"cell {key}")
        close(residual["z"], model["z"] / data["z"] - 1, 1e-9, f"residual of cell {key}") if abs(residual["z"]) > 1e-3 else None
    check(compared > 200, f"{compared} cells compared")


def results():
    fit = json.loads(run("fit", "paint.csv", "--json"))["fits"][0]
    names = fit["correlation"]["names"]
    for source in ("paint.csv", "fit.json"):
        for row in plot("correlation", source)[1, "correlation"]:
            close(row["z"], fit["correlation"]["matrix"][names.index(row["y"])][names.index(row["x"])], 1e-12, f"correlation of {row['x']}, {row['y']}")
        s = plot("residuals", source)
        for panel, place in enumerate(("theta_i", "theta_h", "theta_d"), 1):
            bands = [b for b in fit["residual_bands"][place] if b["n"]]
            rows = s[panel, "mean, bars: root mean square"]
            check(len(rows) == len(bands), f"{len(rows)} bands")
            for row, band in zip(rows, bands):
                close(row["y"], 100 * band["mean"], 1e-12, f"mean by {place}")
                close(row["high"] - row["low"], 200 * band["rms"], 1e-9, f"rms by {place}")
        s = plot("forest", source)
        f0 = fit["parameters"]["f0"]
        for c, row in enumerate(s[1, ""]):
            close(row["x"], f0["value"][c], 0, "f0")
            close(row["x_high"], f0["interval"][c][1], 0, "its interval")
    run("compare", "paint.csv", "--ndf", "ggx,beckmann", "--masking", "v-cavity,smith-separable", "--json", "c.json")
    with open(os.path.join(scratch, "c.json")) as f:
        compare = json.load(f)
    s = plot("forest", "c.json", "--parameter", "kd", "--channel", "g")
    ordered = [compare["fits"][k] for k in compare["ranking"]]
    check([r["y"] for r in s[1, ""]] == [f["model"] for f in ordered], "models by rank")
    rows = plot("forest", "c.json", "--parameter", "alpha_x,kd", "--channel", "g")
    check([r["y"] for r in rows[2, ""]] == [f["model"] for f in ordered], "models by rank, in a panel whose names are not drawn")
    svg = run("plot", "forest", "c.json", "--parameter", "alpha_x,kd")
    check("all with schlick+lambert" in svg and svg.count(">ggx/v-cavity<") == 1 and "ggx/v-cavity/" not in svg, "what all models share stands in the note")
    for row, f in zip(s[1, ""], ordered):
        close(row["x"], f["parameters"]["kd"]["value"][1], 0, f"kd of {f['model']}")
    for masking in ("v-cavity", "smith-separable"):
        best = next(f for f in ordered if f["masking"] == masking)
        rows = plot("residuals", "c.json")[2, f"{masking}, {best['ndf']}"]
        close(rows[0]["y"], 100 * best["residual_bands"]["theta_h"][0]["mean"], 1e-12, f"residual of {masking}")
    check(plot("residuals", "paint.csv", "--ndf", "ggx", "--masking", "v-cavity,none").keys() >= {(1, "v-cavity, ggx"), (1, "none, ggx")}, "compared here")


def profiles():
    fit = json.loads(run("fit", "paint.csv", "--profile", "--json"))["fits"][0]
    s = plot("likelihood", "paint.csv", "--parameter", "alpha_x")
    curve, best = s[1, "least objective of all others"], s[1, "fit"][0]
    close(best["y"], fit["residual"]["objective"], 1e-9, "objective")
    close(best["x"], fit["parameters"]["alpha_x"]["value"], 1e-9, "value of the fit")
    check(min(r["y"] for r in curve) >= best["y"] * (1 - 1e-9), "a lower objective than that of the fit")
    low, high = (r["x"] for r in s[1, "95 % interval"])
    for a, b in zip((low, high), fit["parameters"]["alpha_x"]["interval"]):
        close(a, b, 1e-9, "end of the interval")
    limit = s[1, "rise that 95 % allow"][0]["y"]
    for end in (low, high):  # the curve crosses the limit there: to the search's hundredth
        near = sorted(curve, key=lambda r: abs(r["x"] - end))[:2]
        a, b = sorted(near, key=lambda r: r["x"])
        t = (end - a["x"]) / (b["x"] - a["x"])
        rise = lambda r: math.sqrt(max(r["y"] - best["y"], 0))
        close(rise(a) + t * (rise(b) - rise(a)), math.sqrt(limit - best["y"]), 0.03, "the curve at the end of the interval")
    # D as the data have it: of exact data that of the model
    s = plot("profile", "few.csv")
    for row in s[2, "data"]:
        close(row["y"], ggx(0.3, radians(row["x"])), 2e-3, f"D at {row['x']}")


def errors_that_go_together():
    """The cloud is as wide as the errors that the refits give, where neighbours share theirs and where blocks are drawn."""
    dice = random.Random(int(os.environ.get("FF_TEST_SEED", "0")))
    run("simulate", "ggx+lambert", "--set", "alpha=0.3,f0=0.5,kd=0.2", "--grid", "goniometer:5", "-o", "exact.csv")
    drift = 0
    with open(os.path.join(scratch, "exact.csv")) as source, open(os.path.join(scratch, "drift.csv"), "w") as out:
        for line in source:
            if line[0].isdigit():
                drift = 0.97 * drift + 0.02 * dice.gauss(0, 1)
                *angles, f = line.split(",")
                line = ",".join(angles) + f",{float(f) * (1 + drift)!r}\n"
            out.write(line)
    for more in ((), ("--errors", "residuals")):
        s = plot("bootstrap", "drift.csv", "--bootstrap", "200", "--parameter", "alpha_x,f0", *more)
        said = json.loads(run("fit", "drift.csv", "--bootstrap", "200", "--json", *more))["fits"][0]["parameters"]
        for k, name in (("x", "alpha_x"), ("y", "f0")):
            values = [r[k] for r in s[1, "refits"]]
            close(statistics.stdev(values), said[name]["std_error"] if name == "alpha_x" else first(said[name]["std_error"]), 0.01, f"{name} {more}")
    svg = run("plot", "bootstrap", "drift.csv", "--bootstrap", "40", "--parameter", "alpha_x,f0")
    check("times as far apart" in svg, "the figure says what widens the cloud")


def first(x):
    return x[0] if isinstance(x, list) else x


def clouds():
    s = plot("bootstrap", "paint.csv", "--bootstrap", "200", "--seed", "3", "--parameter", "alpha_x,kd[g]")
    rows = s[1, "refits"]
    fit = json.loads(run("fit", "paint.csv", "--bootstrap", "200", "--seed", "3", "--json"))["fits"][0]
    plain = json.loads(run("fit", "paint.csv", "--json"))["fits"][0]
    check(len(rows) == 200, f"{len(rows)} refits")
    for k, name, value in (("x", "alpha_x", lambda p: p["std_error"]), ("y", "kd", lambda p: p["std_error"][1])):
        mean = sum(r[k] for r in rows) / len(rows)
        sd = math.sqrt(sum((r[k] - mean) ** 2 for r in rows) / (len(rows) - 1))
        close(sd, value(fit["parameters"][name]), 0.01, f"spread of {name} and its error by the same refits")
    ellipse = s[1, "95 % by standard errors"]
    half = math.sqrt(5.991464547107979) * plain["parameters"]["alpha_x"]["std_error"]
    close(max(r["x"] for r in ellipse) - min(r["x"] for r in ellipse), 2 * half, 1e-3, "width of the ellipse")
    s = plot("sweep", "paint.csv", "--parameter", "alpha_x")
    last = s[1, "log"][-1]
    other = json.loads(run("fit", "paint.csv", "--loss", "log", "--json"))["fits"][0]["parameters"]["alpha_x"]["value"]
    close(last["x"], 80, 1e-12, "last angle")
    close(last["y"], other, 1e-6, "alpha with the loss log")
    at_40 = next(r for r in s[1, "cosine"] if r["x"] == 40)
    other = json.loads(run("fit", "paint.csv", "--max-theta", "40", "--json"))["fits"][0]["parameters"]["alpha_x"]["value"]
    close(at_40["y"], other, 1e-6, "alpha up to 40 degrees")


def directions():
    s = plot("coverage", "paint.csv")
    with open(os.path.join(scratch, "paint.csv")) as f:
        table = list(csv.DictReader(line for line in f if not line.startswith("#")))
    check(sorted(r["y"] for r in s[1, ""]) == sorted({float(r["theta_i"]) for r in table}), "angles of the light")
    views = {(float(r["theta_o"]), (float(r["phi_o"]) - float(r["phi_i"])) % 360 if float(r["theta_o"]) else 0) for r in table if float(r["theta_o"]) < 90}
    check(len(s[2, ""]) == len(views), f"{len(s[2, ''])} views, expected {len(views)}")


with tempfile.TemporaryDirectory() as scratch:
    run("simulate", "ggx+lambert", "--set", "alpha=0.3,f0=0.5:0.4:0.3,kd=0.2", "--noise", "0.04", "-o", "paint.csv")
    run("simulate", "ggx+lambert", "--set", "alpha=0.3,f0=0.5,kd=0.2", "--grid", "scattered:150", "-o", "few.csv")
    run("fit", "paint.csv", "--json", "fit.json")
    for test in (distributions, maskings, light_from_one_side, values_of_one_model, fresnel_terms, albedos, slices, images, results, profiles, clouds, errors_that_go_together, directions):
        before = failures
        test()
        print(f"{'FAILED' if failures > before else 'passed'}    {test.__name__}")
print(f"{checks} checks, {failures} failures")
sys.exit(failures > 0)
