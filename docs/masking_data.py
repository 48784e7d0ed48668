#!/usr/bin/env python3
"""masking_data.py PROGRAM OUT [quick]: the numbers of docs/masking.md, as JSON; docs/masking.py makes the page of them.

Rays on Gaussian height fields, walks on Smith's surface, and the models, all by the program's own commands. An hour on two cores;
`quick` takes a tenth of the paths."""
import json
import math
import os
import subprocess
import sys
import tempfile

program, out = sys.argv[1], sys.argv[2]
scale = 0.1 if len(sys.argv) > 3 else 1
SMITH = "smith-height-correlated"
ALPHAS = (0.1, 0.4, 0.7, 1, 1.3)
THETAS = (0, 60, math.degrees(1.5))


def says(*words):
    done = subprocess.run([program, *map(str, words)], capture_output=True, text=True)
    if done.returncode:
        sys.exit("%s: %s" % (" ".join(map(str, words)), done.stderr))
    return done.stdout


def rows(*words):
    lines = says(*words).strip().split("\n")
    names = lines[0].split(",")
    return [dict(zip(names, (float(x) for x in line.split(",")))) for line in lines[1:]]


def paths(n):
    return ["--paths", max(1000, int(n * scale))]


def mus(thetas):
    return ",".join("%.6f" % max(math.cos(math.radians(t)), 1e-6) for t in thetas)


def of_v_cavity(alpha, theta):
    """Albedo and mean direction of the lobe, by samples of the model."""
    n = int(400000 * max(scale, 0.25))
    lines = says("sample", "beckmann/v-cavity/none", "--set", f"alpha={alpha}", "--theta", theta, "-n", n).strip().split("\n")[1:]
    w = x = z = 0
    for line in lines:
        t, p, _, _, weight = (float(v) for v in line.split(","))
        w += weight
        x += weight * math.sin(math.radians(t)) * math.cos(math.radians(p))
        z += weight * math.cos(math.radians(t))
    return {"albedo": w / n, "x": x / w, "z": z / w}


def lobes():
    found = []
    for alpha in ALPHAS:
        for theta in THETAS:
            model = [f"beckmann/{SMITH}/none", "--set", f"alpha={alpha}", "--mu", mus([theta]), "--orders", "1,2,3+"]
            found.append({"alpha": alpha, "theta": theta, "v-cavity": of_v_cavity(alpha, theta),
                          "walk": rows("furnace", *model, "--walk", *paths(4000000)),
                          "traced": rows("furnace", *model, "--surface", "gaussian", *paths(800000), "--realisations", 24)})
    return found


def seen():
    thetas = (30, 45, 60, 70, 75, 80, 85)
    found = []
    for alpha in (0.4, 1):
        for cells in (8, 16, 32):
            got = rows("furnace", "beckmann", "--set", f"alpha={alpha}", "--surface", "gaussian", "--visible", "--mu", mus(thetas),
                       "--correlation", cells, "--cells", 32 * cells, *paths(240000), "--realisations", 24)
            found.append({"alpha": alpha, "correlation": cells, "thetas": thetas, "rows": got})
    return found


def convergence():
    """Order 1 at 60 degrees and 1.5 radians by cells in a correlation length."""
    return [{"alpha": alpha, "correlation": cells,
             "rows": rows("furnace", f"beckmann/{SMITH}/none", "--set", f"alpha={alpha}", "--mu", mus(THETAS[1:]), "--orders", "1",
                          "--surface", "gaussian", "--correlation", cells, "--cells", 32 * cells, *paths(400000), "--realisations", 24)}
            for alpha in (0.4, 1) for cells in (4, 8, 16, 32)]


def ranking(folder):
    """What compare says of traced light with 2 % noise, by the incidences that it is given."""
    found = []
    for alpha in (0.1, 0.2, 0.4, 0.7, 1):
        whole = os.path.join(folder, "whole.csv")
        says("simulate", f"beckmann/{SMITH}/none", "--set", f"alpha={alpha}", "--surface", "gaussian", "--orders", 1, "--grid", "goniometer:5",
             "--noise", 0.02, "--sigma", *paths(2000000), "--realisations", 24, "-o", whole)
        lines = open(whole).read().split("\n")
        for most in (0, 30, 45, 60, 75):
            part = os.path.join(folder, "part.csv")
            with open(part, "w") as f:
                for line in lines:
                    head = line.split(",")[0]
                    if not head or not head[0].isdigit() or float(head) <= most:
                        f.write(line + "\n")
            document = os.path.join(folder, "part.json")
            done = subprocess.run([program, "compare", part, "--ndf", "beckmann", "--fresnel", "none", "--diffuse", "none", "--aperture", "2.5",
                                   "--json", document], capture_output=True, text=True)
            if done.returncode not in (0, 1):
                sys.exit(done.stderr)
            told = json.load(open(document))
            best = told["fits"][told["ranking"][0]]
            order = [(told["fits"][k]["masking"], told["fits"][k]["residual"]["objective"]) for k in told["ranking"]]
            found.append({"alpha": alpha, "incidences": most // 15 + 1, "best": best["masking"], "found": best["parameters"]["alpha_x"]["value"],
                          "order": order})
    return found


def diffuse():
    """Light that rough matte facets scatter, against what is fitted to such."""
    found = []
    for alpha in (0.3, 0.6, 1):
        for theta in (0, 45, 75):
            mu = ["--mu", mus([theta])]
            walk = rows("furnace", "ggx+lambert", "--walk", "--facets", "coupled", "--set", f"alpha={alpha},f0=0.04,kd=1", *mu, "--orders", "all", *paths(1000000))
            matte = rows("furnace", "ggx+lambert", "--walk", "--facets", "lambert", "--set", f"alpha={alpha},kd=0.5", *mu, "--orders", "all", *paths(1000000))
            hammon = rows("furnace", "ggx/smith-height-correlated/schlick+hammon", "--set", f"alpha={alpha},f0=0.04,albedo=1", *mu)
            eon = rows("furnace", "eon", "--set", "rho=0.5,r=%g" % min(alpha, 1), *mu)
            found.append({"alpha": alpha, "theta": theta, "coupled": walk[0]["albedo"], "hammon": hammon[0]["albedo"],
                          "lambert facets": matte[0]["albedo"], "eon": eon[0]["albedo"]})
    return found


def main():
    made = {}
    with tempfile.TemporaryDirectory() as folder:
        for name, make in (("lobes", lobes), ("seen", seen), ("convergence", convergence), ("ranking", lambda: ranking(folder)),
                           ("diffuse", diffuse)):
            made[name] = make()
            with open(out, "w") as f:
                json.dump(made, f, indent=1)


main()
