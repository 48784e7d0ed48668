#!/usr/bin/env python3
"""make_golden.py [FILE | --check FILE]: golden values of the specular lobe, by quadrature of the definitions.

No closed form of Lambda, no reduction to a round distribution and no code of the program is used: what is written here of a distribution is
the density of slopes P22(x, y) alone. Of a direction w, with the tangential part seen along the slopes,

    visible(w) = integral max(0, w.z - w.x x - w.y y) P22(x, y) dx dy,   area(w) = w.z - w.x x0 - w.y y0,   Lambda = visible / area - 1

where visible - area is the integral over the facets that face away, which are added up instead: no digits are lost when they are few.
Quadrature is double exponential in both directions of the plane of slopes. G follows from Lambda and the azimuths by the definitions of
Smith's maskings and of the V-cavity (Heitz 2014, eq. 20 to 24), F is Schlick's, f = D F G / (4 w_i.z area(w_o)).

Without arguments the table is printed; --check computes every fifteenth row again with finer steps and compares. Needs numpy.
"""
import csv
import math
import os
import random
import sys
os.environ["OPENBLAS_NUM_THREADS"] = "1"  # threads cost more than these products
try:
    import numpy as np
except ImportError:
    print("skipped: this needs python3-numpy")
    sys.exit(77)

COLUMNS = ("ndf,masking,alpha_x,alpha_y,r_xy,slope_x,slope_y,gamma,f0,theta_i,phi_i,theta_o,phi_o,d,lambda_i,lambda_o,g,fresnel,f").split(",")
MASKINGS = ("none", "smith-separable", "smith-height-correlated", "smith-direction-correlated", "smith-height-direction-correlated", "v-cavity")
SMALLEST, SAME = 1e-20, 1e-8  # below it Lambda is nothing beside 1; what --check allows


def density(row):
    """P22 of a row's surface as a function of arrays of slopes."""
    ax, ay, r, x0, y0 = (row[k] for k in ("alpha_x", "alpha_y", "r_xy", "slope_x", "slope_y"))
    profile = {"beckmann": lambda q2: np.exp(-q2), "ggx": lambda q2: 1 / (1 + q2) ** 2,
               "student-t": lambda q2: np.exp(-row["gamma"] * np.log1p(q2 / (row["gamma"] - 1)))}[row["ndf"]]

    def p22(x, y):
        u, v = (x - x0) / ax, (y - y0) / ay
        return profile((u * u + v * v - 2 * r * u * v) / (1 - r * r)) / (math.pi * ax * ay * math.sqrt(1 - r * r))
    return p22


def direction(theta, phi):
    t, p = math.radians(theta), math.radians(phi)
    return np.array([math.sin(t) * math.cos(p), math.sin(t) * math.sin(p), math.cos(t)])


def area(row, w):
    return w[2] - row["slope_x"] * w[0] - row["slope_y"] * w[1]


def facing_away(row, w, step):
    """Integral of max(0, w.x x + w.y y - w.z) P22: t is the slope along the azimuth of w, beyond cot(theta); s the one across it."""
    tangent = math.hypot(w[0], w[1])
    if tangent == 0:
        return 0.0
    c, s = w[0] / tangent, w[1] / tangent
    u = np.arange(-5.2, 5.2, step)  # up to slopes of 1e61: some tails are long
    ax, ay, r = row["alpha_x"], row["alpha_y"], row["r_xy"]
    along = c * c * ax * ax + s * s * ay * ay + 2 * r * ax * ay * c * s  # of the quadratic form: places the nodes and is no more
    cross = (ay * ay - ax * ax) * c * s + r * ax * ay * (c * c - s * s)
    over = math.sqrt(along) * np.exp(math.pi / 2 * np.sinh(u))
    d_over = over * math.pi / 2 * np.cosh(u)
    width = ax * ay * math.sqrt((1 - r * r) / along)
    aside = width * np.sinh(math.pi / 2 * np.sinh(u))
    d_aside = width * np.cosh(math.pi / 2 * np.sinh(u)) * math.pi / 2 * np.cosh(u)
    x0, y0 = row["slope_x"], row["slope_y"]
    t = w[2] / tangent + over
    ridge = (-s * x0 + c * y0) + cross / along * (t - (c * x0 + s * y0))
    across = ridge[:, None] + aside[None, :]
    with np.errstate(under="ignore", over="ignore", invalid="ignore"):
        p = density(row)(c * t[:, None] - s * across, s * t[:, None] + c * across)
        p = np.where(np.isfinite(p), p, 0)
        return float(tangent * (over * d_over) @ p @ d_aside) * step * step


def smith(row, li, lo):
    dphi = math.radians(abs((row["phi_i"] - row["phi_o"] + 180) % 360 - 180))
    k = 4.41 * dphi / (4.41 * dphi + 1)
    gi, go = 1 / (1 + li), 1 / (1 + lo)
    return {"smith-separable": gi * go, "smith-height-correlated": 1 / (1 + li + lo),
            "smith-direction-correlated": k * gi * go + (1 - k) * min(gi, go),
            "smith-height-direction-correlated": 1 / (1 + max(li, lo) + k * min(li, lo))}[row["masking"]]


def results(row, step=1 / 40):
    wi, wo = direction(row["theta_i"], row["phi_i"]), direction(row["theta_o"], row["phi_o"])
    h = (wi + wo) / np.linalg.norm(wi + wo)
    c = float(wi @ h)
    d = float(density(row)(-h[0] / h[2], -h[1] / h[2])) / h[2] ** 4
    li = lo = None
    if row["masking"] == "none":
        g = 1.0
    elif row["masking"] == "v-cavity":
        g = min(1.0, 2 * h[2] * wi[2] / c, 2 * h[2] * wo[2] / c)
    else:
        li, lo = (facing_away(row, w, step) / area(row, w) for w in (wi, wo))
        g = smith(row, li, lo)
    fresnel = row["f0"] + (1 - row["f0"]) * (1 - c) ** 5
    return {"d": d, "lambda_i": li, "lambda_o": lo, "g": g, "fresnel": fresnel, "f": d * fresnel * g / (4 * wi[2] * area(row, wo))}


def surfaces():
    """A surface of each kind for every distribution and masking: round, stretched, sheared, tilted."""
    draw = random.Random(20)
    for ndf in ("beckmann", "ggx", "student-t"):
        for masking in MASKINGS:
            for kind in range(4 if masking not in ("none", "v-cavity") else 3):
                ax = round(math.exp(draw.uniform(math.log(0.03), math.log(0.9))), 4)
                ay = ax if kind == 0 else round(math.exp(draw.uniform(math.log(0.03), math.log(0.9))), 4)
                yield {"ndf": ndf, "masking": masking, "alpha_x": ax, "alpha_y": ay, "r_xy": round(draw.uniform(-0.85, 0.85), 3) if kind >= 2 else 0.0,
                       "slope_x": round(draw.uniform(-0.2, 0.2), 3) if kind == 3 else 0.0, "slope_y": round(draw.uniform(-0.2, 0.2), 3) if kind == 3 else 0.0,
                       "gamma": round(draw.uniform(1.6, 9), 3) if ndf == "student-t" else None, "f0": round(draw.uniform(0.02, 0.95), 3)}, draw


def rows(step=1 / 40):
    """Five pairs of directions for each surface: two near the mirror direction, and none whose f is next to nothing."""
    for surface, draw in surfaces():
        n = 0
        while n < 5:
            ti, pi = draw.uniform(1, 82), draw.uniform(0, 360)
            to, po = (draw.uniform(1, 82), draw.uniform(0, 360)) if n > 1 else (min(max(ti + draw.uniform(-8, 8), 0.5), 82), pi + 180 + draw.uniform(-8, 8))
            row = dict(surface, theta_i=round(ti, 3), phi_i=round(pi, 3), theta_o=round(to, 3), phi_o=round(po % 360, 3))
            if min(area(row, direction(ti, pi)), area(row, direction(to, po))) < 0.05:
                continue
            row.update(results(row, step))
            if row["f"] > 1e-100:
                n += 1
                yield row


def cell(x):
    return "" if x is None else x if isinstance(x, str) else "%.12g" % x


def check(path):
    worst = 0.0
    with open(path, newline="", encoding="utf-8") as f:
        kept = list(csv.DictReader(line for line in f if not line.startswith("#")))
    for number, (row, line) in list(enumerate(zip(rows(0.25), kept, strict=True), 2))[::15]:
        finer = results(row, 1 / 56)
        for name in COLUMNS:
            if name not in finer:
                assert cell(row[name]) == line[name], f"{path}:{number}: {name} is {line[name]}, the script has {row[name]}"
            elif finer[name] is None or line[name] == "":
                assert finer[name] is None and line[name] == "", f"{path}:{number}: {name}"
            else:
                floor = SMALLEST if name.startswith("lambda") else 0
                error = max(abs(float(line[name]) - finer[name]) - floor, 0) / finer[name] if finer[name] else 0
                worst = max(worst, error)
                assert error <= SAME, f"{path}:{number}: {name} is {line[name]}, with finer steps {finer[name]!r}"
    print(f"{len(kept)} rows, worst relative difference {worst:.1e}")


def main(argv):
    if len(argv) == 3 and argv[1] == "--check":
        check(argv[2])
        return
    with open(argv[1], "w", encoding="utf-8") if len(argv) == 2 else sys.stdout as out:
        print(",".join(COLUMNS), file=out)
        for row in rows():
            print(",".join(cell(row[name]) for name in COLUMNS), file=out)


main(sys.argv)
