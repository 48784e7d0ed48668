#!/usr/bin/env python3
"""formulas_test.py PROGRAM SOURCE_DIR: what the program computes is what the tables of docs/formulas.md say.

Takes formulas from the tables as they stand there, makes Python of them (`a b` is a product, `^` a power), evaluates them at a few pairs
of directions, and compares with `facetfit eval --terms`.
"""
import csv
import math
import os
import re
import subprocess
import sys

PROGRAM, TOP = sys.argv[1], os.path.abspath(sys.argv[2])
PAIRS = [(30, 10, 50, 150), (60, 0, 20, 20), (5, 40, 40, 10), (70, 5, 65, 200), (45, 0, 45, 180)]
TOLERANCE = 1e-6
failures = compared = 0


def check(condition, text):
    global failures
    if not condition:
        failures += 1
        print("failed: " + text)


def python_of(formula):
    tokens = re.findall(r"\d+\.?\d*(?:e-?\d+)?|[A-Za-z_]\w*|\S", formula.replace("^", " ^ "))
    out = []
    for k, token in enumerate(tokens):
        before = tokens[k - 1] if k else ""
        operand = re.match(r"[\w(]", token)
        after_operand = re.match(r"[\w)]", before)
        call = token == "(" and re.match(r"[A-Za-z_]\w*$", before) and before in FUNCTIONS
        if operand and after_operand and not call:
            out.append("*")
        out.append("**" if token == "^" else token)
    return " ".join(out)


FUNCTIONS = {"sqrt": math.sqrt, "exp": math.exp, "erf": math.erf, "min": min, "max": max, "ln": math.log, "tan": math.tan,
             "lerp": lambda a, b, t: a + (b - a) * t, "G1": lambda x: 1 / (1 + x)}


def value_of(formula, names):
    functions = {name: f for name, f in {**FUNCTIONS, **names}.items() if callable(f)}
    saved = dict(FUNCTIONS)
    FUNCTIONS.update(functions)
    try:
        return eval(python_of(formula), {"__builtins__": {}}, {"pi": math.pi, **functions, **names})  # pylint: disable=eval-used
    finally:
        FUNCTIONS.clear()
        FUNCTIONS.update(saved)


def geometry(pair):
    def unit(theta, phi):
        t, p = math.radians(theta), math.radians(phi)
        return (math.sin(t) * math.cos(p), math.sin(t) * math.sin(p), math.cos(t))
    wi, wo = unit(*pair[:2]), unit(*pair[2:])
    half = [a + b for a, b in zip(wi, wo)]
    length = math.sqrt(sum(x * x for x in half))
    iz, oz, hz = wi[2], wo[2], half[2] / length
    turn = abs(math.radians(pair[3] - pair[1])) % (2 * math.pi)
    return {"iz": iz, "oz": oz, "hz": hz, "c": sum(a * b for a, b in zip(wi, half)) / length, "t2": 1 / hz ** 2 - 1, "mz": hz,
            "phi": min(turn, 2 * math.pi - turn)}


def rows_of(page, heading):
    """name -> formulas in code type of its row, of the tables under a heading."""
    text = re.search(r"^## %s\n(.*?)(?=^## )" % re.escape(heading), page, re.M | re.S)[1]
    found = {}
    for line in text.splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if line.startswith("| `"):
            for name in re.findall(r"`([^`]+)`", cells[0]):
                found[name] = [re.findall(r"`([^`]+)`", cell) for cell in cells[1:]]
    return found


def evaluated(model, setting):
    text = "theta_i,phi_i,theta_o,phi_o\n" + "".join(",".join(map(str, pair)) + "\n" for pair in PAIRS)
    words = [PROGRAM, "eval", model] + (["--set", setting] if setting else []) + (["--terms"] if "/" in model else [])
    done = subprocess.run(words, input=text, stdout=subprocess.PIPE, check=True, text=True)
    return [{key: float(x) for key, x in row.items()} for row in csv.DictReader(done.stdout.splitlines())]


def compare(what, found, expected):
    global compared
    compared += 1
    check(abs(found - expected) <= TOLERANCE * max(abs(found), abs(expected), 1e-9), f"{what}: the program has {found}, the page {expected}")


def check_distributions(page):
    rows = rows_of(page, "Distributions")
    for name in ("beckmann", "ggx"):
        (p,), (lambda_of,) = rows[name][:2]
        for pair, row in zip(PAIRS, evaluated(f"{name}/smith-separable/none", "alpha=0.4")):
            g = geometry(pair)
            compare(f"D of {name}", row["d"], value_of(p, {"q2": g["t2"] / 0.4 ** 2}) / (0.4 ** 2 * g["hz"] ** 4))
            for side, cosine in (("lambda_i", g["iz"]), ("lambda_o", g["oz"])):
                compare(f"Lambda of {name}", row[side], value_of(lambda_of, {"a": cosine / math.sqrt(1 - cosine ** 2) / 0.4}))
    student = rows["student-t"][0][0]
    for pair, row in zip(PAIRS, evaluated("student-t/smith-separable/none", "alpha=0.4,gamma=3")):
        g = geometry(pair)
        compare("D of student-t", row["d"], value_of(student, {"q2": g["t2"] / 0.16, "gamma": 3}) / (0.16 * g["hz"] ** 4))
    for name, masking, own in (("phong", "smith-separable", {"n": 12}), ("vmf", "smith-separable", {"kappa": 40}),
                               ("kelemen-ward", "kelemen", {"m": 0.4}), ("kelemen-phong", "kelemen", {"n": 12})):
        setting = ",".join(f"{key}={x}" for key, x in own.items())
        for pair, row in zip(PAIRS, evaluated(f"{name}/{masking}/none", setting)):
            compare(f"D of {name}", row["d"], value_of(rows[name][0][0], {**geometry(pair), **own, "e": math.e}))


def check_maskings(page):
    rows = rows_of(page, "Masking and shadowing")
    for name, cells in rows.items():
        if name == "none":
            continue
        coat = name == "disney-clearcoat"
        for pair, row in zip(PAIRS, evaluated(f"{'gtr' if coat else 'ggx'}/{name}/none", "alpha=0.4" + (",gamma=1" if coat else ""))):
            g = geometry(pair)
            names = {**g, "Li": row["lambda_i"], "Lo": row["lambda_o"], "i": row["lambda_i"], "o": row["lambda_o"], "alpha": 0.4,
                     "k": 4.41 * g["phi"] / (4.41 * g["phi"] + 1)}
            formula = cells[0][0]
            if name in ("schlick-smith", "disney-clearcoat"):
                names["k"] = 0.2
                inner = cells[0][1].split("=", 1)[1]
                names["g"] = lambda c, k=0.2, inner=inner: value_of(inner, {"c": c, "k": k})
            compare(f"G of {name}", row["g"], value_of(formula, names))
    check(len(rows) >= 10, f"maskings {sorted(rows)}")


def check_fresnel(page):
    rows = rows_of(page, "Fresnel")
    for name, setting, own in (("schlick", "f0=0.3", {"F0": 0.3}), ("sgd", "f0=0.3,f1=0.1", {"F0": 0.3, "F1": 0.1}),
                               ("schlick-karis", "f0=0.3", {"F0": 0.3})):
        for pair, row in zip(PAIRS, evaluated(f"ggx/smith-separable/{name}", setting)):
            compare(f"F of {name}", row["fresnel"], value_of(rows[name][0][0], {**geometry(pair), **own}))
    for name, index in (("dielectric", (1.5, 0)), ("conductor", (0.769, 6.08))):
        setting = "eta=%g" % index[0] + (",k=%g" % index[1] if index[1] else "")
        text = re.search(r"^    F = (.*?),   rs = (.*?),   rp = (.*)$", page, re.M)
        for pair, row in zip(PAIRS, evaluated(f"ggx/smith-separable/{name}", setting)):
            n = complex(*index) ** 2
            c = geometry(pair)["c"]
            names = {"c": c, "N": n, "w": (n - 1 + c * c) ** 0.5}
            rs, rp = (abs(value_of(text[k], names)) for k in (2, 3))
            check(text[1] == "(|rs|^2 + |rp|^2) / 2", f"F is {text[1]}")
            compare(f"F of {name}", row["fresnel"], (rs ** 2 + rp ** 2) / 2)


def check_lobe_and_diffuse(page):
    lobe = re.search(r"^    f = (D F G .*)$", page, re.M)[1]
    for pair, row in zip(PAIRS, evaluated("ggx/v-cavity/schlick", "alpha=0.4,f0=0.3")):
        compare("the lobe", row["f"], value_of(lobe, {**geometry(pair), "D": row["d"], "F": row["fresnel"], "G": row["g"]}))
    rows = rows_of(page, "Diffuse terms")
    for pair, row in zip(PAIRS, evaluated("lambert", "kd=0.4")):
        compare("lambert", row["f"], value_of(rows["lambert"][0][0], {"kd": 0.4}))
    first, second = rows["disney"][0][:2]
    for pair, row in zip(PAIRS, evaluated("disney", "kd=0.4,rough=0.6")):
        names = {**geometry(pair), "kd": 0.4, "rough": 0.6}
        compare("disney", row["f"], value_of(first, {**names, "t": value_of(second.split("=", 1)[1], names)}))


with open(os.path.join(TOP, "docs", "formulas.md"), encoding="utf-8") as file:
    PAGE = file.read()
for one in (check_distributions, check_maskings, check_fresnel, check_lobe_and_diffuse):
    one(PAGE)
check(compared >= 100, f"only {compared} values")
print(f"{compared} values, {failures} failures")
sys.exit(1 if failures else 0)
