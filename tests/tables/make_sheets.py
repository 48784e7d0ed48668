#!/usr/bin/env python3
"""make_sheets.py [DIRECTORY | --check DIRECTORY]: sheets of parameters with the columns of the published ones, of materials that nobody has.

The constants that follow from the parameters come from quadrature of the definition, integral D mz dm = 1 over the hemisphere: kap of the
SGD (D = kap e^-x / (pi x^p mz^4), x = alpha + tan^2 / alpha), and the area that the ABC distribution (1 + B (1 - mz))^-C covers.
"""
import csv
import math
import os
import random
import sys

MATERIALS = 8


def integral(f, step=1 / 64):
    """Of f over (0, infinity), double exponential."""
    total = 0.0
    for k in range(-int(4.4 / step), int(4.4 / step) + 1):
        x = math.exp(math.pi / 2 * math.sinh(k * step))
        total += f(x) * x * math.pi / 2 * math.cosh(k * step)
    return total * step


def over_slopes(d):
    """integral D mz dm with t = tan(theta_m): mz = (1 + t^2)^-1/2, dm mz = 2 pi t mz^4 dt; d(t, mz) is D mz^4."""
    return integral(lambda t: 2 * math.pi * t * d(t, 1 / math.sqrt(1 + t * t)))


def kap(alpha, p):
    def density(t, _):
        x = alpha + t * t / alpha
        return math.exp(-x) / (math.pi * x**p) if x < 700 else 0.0
    return 1 / over_slopes(density)


def abc_area(b, c):
    def density(t, mz):
        return (1 + b * (t * t * mz * mz / (1 + mz)))**-c * mz**4  # 1 - mz without loss
    return over_slopes(density)


def sgd_rows():
    draw = random.Random(1)
    names = "rhoD rhoS alpha p f0 f1 kap".split()
    yield ["material"] + ["%s_%s" % (n, c) for n in names for c in "rgb"]
    for k in range(MATERIALS):
        sets = []
        for _ in "rgb":
            alpha, p, f0 = math.exp(draw.uniform(math.log(0.004), math.log(0.09))), draw.uniform(0.3, 0.8), draw.uniform(0.05, 0.9)
            alpha, p, f0 = float("%.5g" % alpha), float("%.5g" % p), float("%.5g" % f0)
            sets.append([draw.uniform(0.01, 0.3), draw.uniform(0.05, 0.7), alpha, p, f0, f0 * draw.uniform(0.3, 0.9), kap(alpha, p)])
        yield ["made-%d" % k] + ["%.12g" % s[i] if i == 6 else "%.5g" % s[i] for i in range(7) for s in sets]


def abc_rows():
    draw = random.Random(2)
    yield "material kD_r kD_g kD_b A_r A_g A_b B C ior area".split()
    for k in range(MATERIALS):
        b, c = float("%.6g" % math.exp(draw.uniform(math.log(200), math.log(5e4)))), float("%.5g" % draw.uniform(0.6, 1.6))
        area = abc_area(b, c)
        scale = [draw.uniform(0.2, 1.5) / (4 / math.pi * area) for _ in "rgb"]
        yield ["made-%d" % k] + ["%.5g" % draw.uniform(0.02, 0.3) for _ in "rgb"] + ["%.7g" % a for a in scale] + [
            "%.6g" % b, "%.5g" % c, "%.5g" % draw.uniform(1.3, 2.4), "%.12g" % area]


def main(argv):
    directory = argv[-1] if len(argv) > 1 else os.path.dirname(os.path.abspath(argv[0]))
    for name, rows in (("made_sgd.csv", sgd_rows()), ("made_abc.csv", abc_rows())):
        path = os.path.join(directory, name)
        if "--check" in argv:
            with open(path, newline="", encoding="ascii") as f:
                for kept, row in zip(csv.reader(f), rows, strict=True):
                    for a, b in zip(kept, row, strict=True):
                        if a != b and abs(float(a) / float(b) - 1) > 1e-10:
                            sys.exit(f"{path}: {kept[0]}: {a}, the script has {b}")
        else:
            with open(path, "w", newline="", encoding="ascii") as f:
                csv.writer(f, lineterminator="\n").writerows(rows)


main(sys.argv)
