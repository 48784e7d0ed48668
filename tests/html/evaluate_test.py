#!/usr/bin/env python3
"""The models of a page, evaluated by its script, are those of `eval`: within 1e-5 for every model that the script offers, at random
parameters of the whole box and at random directions. What it does not offer stands on the page as a table, which is the same as `eval` too.

usage: evaluate_test.py FACETFIT MODEL_JS [--all]

Without --all every term once, with it every distribution with every masking."""
import concurrent.futures
import csv
import io
import json
import math
import os
import random
import re
import shutil
import subprocess
import sys
import tempfile

program, script = os.path.abspath(sys.argv[1]), os.path.abspath(sys.argv[2])
everything = "--all" in sys.argv
HERE = os.path.dirname(os.path.abspath(__file__))
TOLERANCE, DRAWS = 1e-5, 3 if os.environ.get("FF_TEST_THOROUGH") else 1
failures = 0


def check(good, what):
    global failures
    if not good:
        failures += 1
        if failures < 30:
            print("failed:", what)


def run(*args, statuses=(0,)):
    done = subprocess.run([program, *args], capture_output=True, text=True, cwd=scratch, check=False)
    check(done.returncode in statuses, f"{' '.join(args)}: status {done.returncode}: {done.stderr}")
    return done.stdout


def terms():
    found = json.loads(run("models", "--json", "-"))
    return {kind: [t["name"] for t in found["terms"] if t["kind"] == kind] for kind in ("distribution", "masking", "fresnel", "diffuse")}


def expressions(known):
    """Those that compose; `tabulated` needs a file."""
    ndfs = [n for n in known["distribution"] if n != "tabulated"]
    if everything:
        yield from (f"{n}/{m}/schlick+lambert" for n in ndfs for m in known["masking"])
    else:
        yield from (f"{n}/{'kelemen' if n.startswith('kelemen') else 'smith-height-correlated'}/schlick+lambert" for n in ndfs)
        yield from (f"{'gtr' if m == 'disney-clearcoat' else 'ggx'}/{m}/schlick+lambert" for m in known["masking"])
    yield from (f"ggx/smith-separable/{f}" for f in known["fresnel"])
    yield from (f"ggx/smith-height-correlated/schlick+{d}" for d in known["diffuse"])
    yield from (f"gaussian/smith-height-correlated/schlick+{d}" for d in known["diffuse"])
    yield from ("ggx+ggx+lambert", "ggx+beckmann/smith-separable/shared+lambert", "student-t+ggx/v-cavity/shared+phong/v-cavity/shared", "lambert",
                "abg")


def page_of(expression):
    """The page's data and the result, of a fit that need not be good; None where the terms do not go together."""
    name = os.path.join(scratch, re.sub(r"\W", "_", expression) + ".html")
    done = subprocess.run([program, "fit", "data.csv", "--model", expression, "--max-iterations", "1", "--html", name, "--threads", "1"],
                          capture_output=True, text=True, cwd=scratch, check=False)
    if done.returncode == 3 or done.returncode == 2:
        return None
    check(done.returncode in (0, 1), f"{expression}: status {done.returncode}: {done.stderr}")
    with open(name, encoding="utf-8") as f:
        text = f.read()
    get = lambda part: json.loads(re.search(rf'<script type="application/json" id="{part}">(.*?)</script>', text, re.S)[1])
    return get("page"), get("result")


def draw(parameters, scales, tilts, random_):
    """A value in the box of every parameter; scales by their logarithm, mean slopes where the surface may be tilted."""
    out = {}
    for name, p in parameters.items():
        lo, hi = p["bounds"]
        bare = name.split(".")[-1]
        if name in scales:
            offset = scales[name]
            out[name] = math.exp(random_.uniform(math.log(lo + offset), math.log(hi + offset))) - offset
            out[name] = min(max(out[name], lo), hi)
        elif bare in ("slope_x", "slope_y"):
            out[name] = random_.uniform(-0.2, 0.2) if tilts else 0.0
        else:
            out[name] = random_.uniform(lo, min(hi, lo + 4))
    return out


def directions(random_, n=160):
    rows = []
    for _ in range(n):
        ti, po = random_.uniform(0, 89), random_.uniform(-180, 180)
        near = random_.random() < 0.5  # of the mirror direction
        rows.append([ti, 0.0 if near else random_.uniform(-180, 180), min(abs(ti + random_.gauss(0, 4)), 89.5) if near else random_.uniform(0, 89.5),
                     180 + random_.gauss(0, 4) if near else po])
    return rows


def evaluated(expression, parameters, rows, name):
    path = os.path.join(scratch, name)
    with open(path, "w", encoding="ascii") as f:
        f.write("theta_i,phi_i,theta_o,phi_o\n" + "".join(",".join(map(repr, r)) + "\n" for r in rows))
    words = [f"{k}={v!r}" for k, v in parameters.items()]
    text = run("eval", expression, path, *[w for word in words for w in ("--set", word)])
    return [float(r["f"]) for r in csv.DictReader(io.StringIO(text))]


def worst_of(got, wanted):
    return max((abs(a - b) / max(abs(b), 1e-12) for a, b in zip(got, wanted) if abs(a - b) > 1e-14), default=0)


def by_script(jobs):
    path = os.path.join(scratch, "jobs.json")
    with open(path, "w", encoding="ascii") as f:
        json.dump(jobs, f)
    done = subprocess.run([node, os.path.join(HERE, "evaluate.mjs"), script, path], capture_output=True, text=True, check=True)
    return json.loads(done.stdout)


def main():
    random_ = random.Random(int(os.environ.get("FF_TEST_SEED", "0")))
    run("simulate", "ggx+lambert", "--set", "alpha=0.3,f0=0.5,kd=0.2", "--grid", "goniometer:30", "--noise", "0.02", "-o", "data.csv")
    wanted = list(dict.fromkeys(expressions(terms())))
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        pages = dict(zip(wanted, pool.map(page_of, wanted)))
    jobs, says, tabled = [], [], 0
    for expression, found in pages.items():
        if not found:
            continue
        page, result = found
        model, fit = page["models"][0], result["fits"][0]
        if not model["live"]:
            rows = list(zip(*(page["samples"][k] for k in ("theta_i", "phi_i", "theta_o", "phi_o"))))
            best = {k: p["value"][0] if isinstance(p["value"], list) else p["value"] for k, p in fit["parameters"].items()}
            worst = worst_of(model["tabled"][0], evaluated(expression, best, rows, "tabled.csv"))
            check(worst < 1e-4, f"{expression}: its table is off by {worst:.2g}")  # angles of six digits
            tabled += 1
            continue
        for k in range(DRAWS):
            parameters, rows = draw(fit["parameters"], model["log"], k and not re.search("v-cavity|kelemen", expression), random_), directions(random_)
            jobs.append({"model": model, "parameters": parameters, "directions": rows})
            says.append((expression, evaluated(expression, parameters, rows, f"d{k}.csv")))
    got = by_script(jobs)
    check(not any(g is None for g in got), "the script does not offer a model that the page calls live")
    worst = {}
    for (expression, values), own, job in zip(says, got, jobs):
        off = worst_of(own or [], values)
        worst[expression] = max(worst.get(expression, 0), off)
        check(own and len(own) == len(values) and off < TOLERANCE, f"{expression} with {job['parameters']}: off by {off:.2g}")
    # is a wrong value seen?
    planted = dict(jobs[0], parameters={k: v * 1.001 for k, v in jobs[0]["parameters"].items()})
    check(worst_of(by_script([planted])[0], says[0][1]) > TOLERANCE, "a parameter that is off by a thousandth is not seen")
    name = max(worst, key=worst.get)
    print(f"{len(worst)} models evaluated, {tabled} tabled, {sum(not p for p in pages.values())} do not compose; worst {worst[name]:.2g}: {name}")
    return 1 if failures or len(worst) < 25 or not tabled else 0


node = shutil.which("node")
if not node:
    print("skipped: node is not there (./setup renderers)")
    sys.exit(77)
with tempfile.TemporaryDirectory() as scratch:
    sys.exit(main())
