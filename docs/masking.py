#!/usr/bin/env python3
"""masking.py DATA FIGURE: the tables of docs/masking.md, as Markdown on standard output, and its figure as SVG, from the numbers that
masking_data.py has made."""
import json
import math
import sys

data = json.load(open(sys.argv[1]))


def smith(alpha, theta):
    if theta == 0:
        return 0
    a = 1 / (alpha * math.tan(math.radians(theta)))
    return 0.5 * (math.erf(a) - 1 + math.exp(-a * a) / (a * math.sqrt(math.pi)))


def v_cavity(alpha, theta, n=300):
    """G1 of the facets that face the view, each by its own area."""
    o = math.sin(math.radians(theta)), math.cos(math.radians(theta))
    top = bottom = 0
    for i in range(n):
        for j in range(n // 2):
            sx, sy = 4 * alpha * (2 * (i + 0.5) / n - 1), 4 * alpha * (j + 0.5) / (n // 2)
            mz = 1 / math.sqrt(1 + sx * sx + sy * sy)
            om = (o[1] - sx * o[0]) * mz
            if om > 0:
                area = math.exp(-(sx * sx + sy * sy) / alpha ** 2) / mz
                bottom += area
                top += area * min(1, 2 * mz * o[1] / om)
    return top / bottom


def table(head, rows):
    print("| " + " | ".join(head) + " |\n|" + "---|" * len(head))
    for row in rows:
        print("| " + " | ".join(str(x) for x in row) + " |")
    print()



def lobes():
    rows = []
    for l in data["lobes"]:
        w, t, v = l["walk"][0], l["traced"][0], l["v-cavity"]
        rows.append([l["alpha"], "%.1f" % l["theta"]] + ["%.3f %+.2f %.2f" % (x["albedo"], x["x"], x["z"]) for x in (w, v, t)] +
                    ["%.3f %.3f" % (t["albedo_error"], t["z_error"])])
    table(["alpha", "theta", "Smith", "V-cavity", "traced", "its errors"], rows)


def orders():
    rows = []
    for l in data["lobes"]:
        if l["alpha"] < 0.4:
            continue
        rows.append([l["alpha"], "%.1f" % l["theta"]] + ["%.3f %.2f, %.3f %.2f" % (l["walk"][k]["albedo"], l["walk"][k]["z"],
                    l["traced"][k]["albedo"], l["traced"][k]["z"]) for k in (1, 2)])
    table(["alpha", "theta", "order 2: walk, traced", "3 and more: walk, traced"], rows)


def seen():
    rows = []
    for alpha in (0.4, 1):
        at = {s["correlation"]: s for s in data["seen"] if s["alpha"] == alpha}
        for k, theta in enumerate(at[32]["thetas"]):
            l, r = smith(alpha, theta), at[32]["rows"][k]
            rows.append([alpha, theta, "%.3f" % (1 / (1 + l)), "%.3f" % v_cavity(alpha, theta), "%.3f (%.3f)" % (r["g1"], r["g1_error"]),
                         "%.3f" % (1 / (1 + 2 * l)), "%.3f" % (1 / (1 + l) ** 2)] + ["%.3f" % at[c]["rows"][k]["g2"] for c in (8, 16)] +
                        ["%.3f (%.3f)" % (r["g2"], r["g2_error"])])
    table(["alpha", "theta", "G1 Smith", "V-cavity", "traced", "G2 height-correlated", "separable", "traced, 8 cells", "16", "32"], rows)


def convergence():
    rows = []
    for c in data["convergence"]:
        rows.append([c["alpha"], c["correlation"]] + ["%.4f (%.4f) %+.3f %.3f" % (r["albedo"], r["albedo_error"], r["x"], r["z"]) for r in c["rows"]])
    table(["alpha", "cells", "60 degrees", "85.9 degrees"], rows)


def ranking():
    rows = []
    for r in data["ranking"]:
        first = r["order"][0][1]
        v = [o / first for name, o in r["order"] if name == "v-cavity"]
        rows.append([r["alpha"], r["incidences"], r["best"], "%.4f" % r["found"], "%.3f" % v[0]])
    table(["alpha", "incidences", "first", "alpha found", "V-cavity's objective over the first"], rows)


def diffuse():
    table(["alpha", "theta", "coupled facets, walk", "hammon", "Lambert's facets, walk", "eon"],
          [[r["alpha"], r["theta"]] + ["%.3f" % r[k] for k in ("coupled", "hammon", "lambert facets", "eon")] for r in data["diffuse"]])


def figure(path):
    """Mean z of the lobe at 1.5 radians, and G1, against alpha and theta."""
    colours = {"walk": "#1f77b4", "v-cavity": "#d62728", "traced": "#222"}
    out = ['<svg xmlns="http://www.w3.org/2000/svg" width="720" height="300" font-family="sans-serif" font-size="12">',
           '<rect width="720" height="300" fill="white"/>']

    def axes(x0, title, xs, label):
        out.append('<path d="M%d 30V250H%d" fill="none" stroke="#888"/><text x="%d" y="20">%s</text><text x="%d" y="290">%s</text>' % (x0, x0 + 280, x0, title, x0 + 120, label))
        for v in (0, 0.25, 0.5, 0.75, 1):
            out.append('<text x="%d" y="%d" text-anchor="end">%g</text>' % (x0 - 6, 254 - 220 * v, v))
        for at, text in xs:
            out.append('<text x="%d" y="268" text-anchor="middle">%s</text>' % (x0 + at, text))

    def line(x0, points, colour, dashed=False):
        out.append('<polyline points="%s" fill="none" stroke="%s" stroke-width="2"%s/>' % (" ".join("%.1f,%.1f" % (x0 + x, 250 - 220 * y) for x, y in points), colour, ' stroke-dasharray="5 4"' if dashed else ""))

    axes(60, "mean z of order 1, theta_o = 1.5 rad", [(210 * a, "%g" % a) for a in (0.1, 0.4, 0.7, 1, 1.3)], "alpha")
    for kind in ("walk", "v-cavity", "traced"):
        grazing = [l for l in data["lobes"] if l["theta"] > 80]
        line(60, [(210 * l["alpha"], (l[kind] if kind == "v-cavity" else l[kind][0])["z"]) for l in grazing], colours[kind], kind == "traced")
    axes(410, "G1 by the facets' area, alpha = 1", [(3 * t, "%d" % t) for t in (0, 30, 60, 90)], "theta, degrees")
    s = [x for x in data["seen"] if x["alpha"] == 1 and x["correlation"] == 32][0]
    line(410, [(3 * t, 1 / (1 + smith(1, t))) for t in range(0, 90, 2)], colours["walk"])
    line(410, [(3 * t, v_cavity(1, t, 100)) for t in range(0, 90, 3)], colours["v-cavity"])
    line(410, [(3 * t, r["g1"]) for t, r in zip(s["thetas"], s["rows"])], colours["traced"], True)
    for k, (kind, name) in enumerate((("walk", "Smith"), ("v-cavity", "V-cavity"), ("traced", "traced"))):
        out.append('<text x="%d" y="%d" fill="%s">%s</text>' % (270, 180 + 18 * k, colours[kind], name))
    with open(path, "w") as f:
        f.write("\n".join(out + ["</svg>"]) + "\n")


for name in ("lobes", "orders", "seen", "convergence", "ranking", "diffuse"):
    if ("lobes" if name == "orders" else name) in data:
        print("### " + name + "\n")
        globals()[name]()
figure(sys.argv[2])
