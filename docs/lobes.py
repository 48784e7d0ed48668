#!/usr/bin/env python3
"""lobes.py PROGRAM OUT.svg: the picture of the README. Simulates a measurement, fits two models to it, and draws samples and fits in
the plane of incidence. Everything drawn comes out of the program: `simulate`, `fit --json` and `eval`."""
import csv
import json
import math
import os
import subprocess
import sys
import tempfile

TRUTH = ("ggx+lambert", "alpha=0.3,f0=0.3,kd=0.2")
FITS = [("ggx+lambert", "GGX", "#2f81f7", ""), ("beckmann+lambert", "Beckmann", "#db6d28", "6 4")]
INCIDENT = (0, 30, 45)
INK = "#7d8590"  # legible on white and on black
WIDTH, HEIGHT, LEFT, TOP, RIGHT, BOTTOM = 800, 300, 46, 40, 10, 44
HIGHEST = 0.45


def run(program, *words, text=None):
    return subprocess.run([program, *words], input=text, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, check=True, text=True).stdout


def rows_of(text):
    return list(csv.DictReader(line for line in text.splitlines() if not line.startswith("#")))


def cos_deg(theta):
    return math.cos(math.radians(theta))


def signed(row):
    """theta_o in the plane of incidence, positive on the side of the mirror direction; None outside of the plane."""
    turn = (float(row["phi_o"]) - float(row["phi_i"])) % 360
    theta = float(row["theta_o"])
    return theta if turn == 180 or theta == 0 else -theta if turn == 0 else None


def fitted(program, path, model):
    fit = json.loads(run(program, "fit", path, "--model", model, "--shape", "isotropic", "--json", "-"))["fits"][0]
    values = {name: p["value"] for name, p in fit["parameters"].items() if name in ("alpha_x", "alpha_y", "f0", "kd")}
    flat = {name: v[0] if isinstance(v, list) else v for name, v in values.items()}
    return ",".join(f"{name}={value!r}" for name, value in flat.items()), flat["alpha_x"]


def curve(program, model, setting, theta_i):
    angles = list(range(-80, 81))
    text = "theta_i,phi_i,theta_o,phi_o\n" + "".join(f"{theta_i},0,{abs(t)},{180 if t >= 0 else 0}\n" for t in angles)
    rows = rows_of(run(program, "eval", model, "--set", setting, text=text))
    return [(t, float(row["f"]) * cos_deg(theta_i)) for t, row in zip(angles, rows)]


def panel(number, theta_i, samples, curves):
    width = (WIDTH - LEFT - RIGHT) / len(INCIDENT)
    x0, height = LEFT + number * width, HEIGHT - TOP - BOTTOM

    def at(t, f):
        return f"{x0 + 6 + (t + 85) / 170 * (width - 12):.1f},{TOP + height * (1 - f / HIGHEST):.1f}"
    out = [f'<path d="M{at(-85, 0)}L{at(85, 0)}" stroke="{INK}" stroke-width="1"/>']
    for t in (-60, -30, 0, 30, 60):
        x, y = at(t, 0).split(",")
        out.append(f'<path d="M{x},{y}v4" stroke="{INK}"/><text x="{x}" y="{float(y) + 17}" text-anchor="middle">{t}</text>'.replace(">-", ">−"))
    x, y = at(theta_i, HIGHEST * 0.99).split(",")
    out.append(f'<path d="M{at(theta_i, 0)}L{x},{TOP + 6}" stroke="{INK}" stroke-dasharray="1 4"/>')
    out.append(f'<text x="{x0 + 10:.1f}" y="{TOP + 12}">light at {theta_i}°</text>')
    out += [f'<circle cx="{c.split(",")[0]}" cy="{c.split(",")[1]}" r="2.6" fill="{INK}"/>' for c in (at(t, f) for t, f in samples)]
    for points, (_, _, colour, dashes) in zip(curves, FITS):
        out.append(f'<polyline points="{" ".join(at(t, f) for t, f in points)}" fill="none" stroke="{colour}" stroke-width="2"'
                   + (f' stroke-dasharray="{dashes}"' if dashes else "") + "/>")
    return out


def legend(alphas):
    out, x = [], LEFT + 6
    out.append(f'<circle cx="{x + 4}" cy="16" r="2.6" fill="{INK}"/><text x="{x + 14}" y="20">samples, 4 % noise</text>')
    for (_, title, colour, dashes), alpha, x in zip(FITS, alphas, (x + 180, x + 400)):
        out.append(f'<path d="M{x},16h30" stroke="{colour}" stroke-width="2"' + (f' stroke-dasharray="{dashes}"' if dashes else "")
                   + f'/><text x="{x + 38}" y="20">{title}: α = {alpha:.3f}</text>')
    return out


def main(program, target):
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "samples.csv")
        run(program, "simulate", TRUTH[0], "--set", TRUTH[1], "--noise", "0.04", "--seed", "1", "-o", path)
        with open(path, encoding="utf-8") as f:
            rows = rows_of(f.read())
        fits = [fitted(program, path, model) for model, *_ in FITS]
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" font-family="sans-serif" font-size="12" fill="none">',
           '<title>Samples of a simulated surface and two models fitted to them</title>', f'<g fill="{INK}">', *legend([alpha for _, alpha in fits])]
    for number, theta_i in enumerate(INCIDENT):
        samples = [(signed(r), float(r["f"]) * cos_deg(theta_i)) for r in rows
                   if float(r["theta_i"]) == theta_i and signed(r) is not None and abs(signed(r)) <= 80]
        out += panel(number, theta_i, samples, [curve(program, model, setting, theta_i) for (model, *_), (setting, _) in zip(FITS, fits)])
    out += [f'<text x="{(LEFT + WIDTH - RIGHT) / 2}" y="{HEIGHT - 8}" text-anchor="middle">angle of the detector in the plane of incidence, degrees</text>',
            f'<text x="14" y="{(TOP + HEIGHT - BOTTOM) / 2}" text-anchor="middle" transform="rotate(-90 14 {(TOP + HEIGHT - BOTTOM) / 2})">f cos θ of the light, 1/sr</text>']
    for f in (0, 0.1, 0.2, 0.3, 0.4):
        y = TOP + (HEIGHT - TOP - BOTTOM) * (1 - f / HIGHEST)
        out.append(f'<text x="{LEFT - 4}" y="{y + 4:.1f}" text-anchor="end">{f:g}</text>')
    out.append("</g></svg>")
    with open(target, "w", encoding="utf-8") as f:
        f.write("\n".join(out) + "\n")


if __name__ == "__main__":
    main(*sys.argv[1:])
