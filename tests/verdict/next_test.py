#!/usr/bin/env python3
"""next_test.py PROGRAM [RUNS]: are the incidences that `compare` proposes to measure next worth it? Surfaces whose masking three
incidences near the normal do not show are simulated RUNS times (20; 100 in the long tier); the three proposed ones and three drawn
at random are measured as well. The proposed ones tell the two models apart in at least 80 % of the runs in which the first three
do not, random ones in at most half; and where one model is left, the error that was worst is smaller with them than with random
ones in 80 %, and what was foretold."""
import json
import math
import os
import random
import statistics
import subprocess
import sys
import tempfile

PROGRAM = os.path.abspath(sys.argv[1])
RUNS = int(sys.argv[2]) if len(sys.argv) > 2 else 20
SEED = int(os.environ.get("FF_TEST_SEED", "0"))
REACH = 80
EXITS = [(theta, phi) for theta in range(0, 80, 10) for phi in range(0, 360, 45) if theta or not phi]
# noise relative to the value, surface, parameters, models
SURFACES = {
    "Smith or V-cavity": (0.25, "ggx/smith-height-correlated+lambert", "alpha=0.6,f0=0.5,kd=0.02", ["--ndf", "ggx", "--masking", "smith-height-correlated,v-cavity"]),
    "V-cavity or Smith": (0.6, "ggx/v-cavity+lambert", "alpha=0.4,f0=0.5,kd=0.02", ["--ndf", "ggx", "--masking", "smith-height-correlated,v-cavity"]),
}
START = (0, 10, 20)
CANDIDATES = [t for t in range(5, REACH + 1, 5) if t not in START]


def run(words, text=None):
    return subprocess.run([PROGRAM, *words], input=text, stdout=subprocess.PIPE, stderr=subprocess.PIPE, check=False).stdout


def values_of(expression, words):
    """Directions and values of all incidences, without noise."""
    rows = [(theta, 0, o, (180 + phi) % 360) for theta in sorted(set(START) | set(CANDIDATES)) for o, phi in EXITS]
    text = "theta_i,phi_i,theta_o,phi_o\n" + "".join("%g,%g,%g,%g\n" % r for r in rows)
    out = run(["eval", expression, "--set", words], text.encode()).decode().split("\n")
    lines = [line for line in out if line and line[0].isdigit()]
    return {r: float(line.split(",")[-1]) for r, line in zip(rows, lines)}


def measure(path, values, incidences, relative, noise):
    with open(path, "w", encoding="utf-8") as out:
        out.write("# quantity: brdf\ntheta_i,phi_i,theta_o,phi_o,f\n")
        for row, f in values.items():
            if row[0] in incidences:
                out.write("%g,%g,%g,%g,%.17g\n" % (*row, f * (1 + relative * noise[row])))


def compared(path, models):
    return json.loads(run(["compare", path, *models, "--reach", str(REACH), "--max-theta", "85", "--json", "-"]))


def told_apart(report):
    return any(f["versus_best"]["told_apart"] for f in report["fits"] if f.get("versus_best"))


def choice_of_models(name):
    relative, expression, words, models = SURFACES[name]
    values = values_of(expression, words)
    tried = proposed = drawn = 0
    seed = SEED * 1000003
    while tried < RUNS and seed < SEED * 1000003 + 20 * RUNS:
        seed += 1
        rng = random.Random("%s %d" % (name, seed))
        noise = {row: rng.gauss(0, 1) for row in values}
        measure("first.csv", values, START, relative, noise)
        first = compared("first.csv", models)
        if told_apart(first):
            continue
        tried += 1
        chosen = [round(i["theta_i_deg"]) for i in first["measure_next"][0]["incidences"]]
        measure("more.csv", values, START + tuple(chosen), relative, noise)
        proposed += told_apart(compared("more.csv", models))
        measure("more.csv", values, START + tuple(rng.sample(CANDIDATES, 3)), relative, noise)
        drawn += told_apart(compared("more.csv", models))
    print("%-20s %d runs; told apart with the proposed %d, with random ones %d" % (name, tried, proposed, drawn))
    return tried, proposed, drawn


def worst_error(name):
    """One model: (runs in which the error that was worst is smaller with the proposed than with random ones, median of what it is
    over what was foretold)."""
    relative, expression, words, _ = SURFACES[name]
    values = values_of(expression, words)
    better, over = 0, []
    for k in range(RUNS):
        rng = random.Random("%s error %d %d" % (name, SEED, k))
        noise = {row: rng.gauss(0, 1) for row in values}
        model = ["--model", expression, "--weight", "noise", "--errors", "noise", "--max-theta", "85"]
        measure("first.csv", values, START, relative, noise)
        first = json.loads(run(["fit", "first.csv", *model, "--reach", str(REACH), "--json", "-"]))
        proposal = first["measure_next"][0]

        def error(chosen):
            measure("more.csv", values, START + tuple(chosen), relative, noise)
            report = json.loads(run(["fit", "more.csv", *model, "--json", "-"]))
            p = report["fits"][0]["parameters"][proposal["parameter"]]
            own = (p[0] if isinstance(p, list) else p)["std_error"]
            return (own[0] if isinstance(own, list) else own) or math.inf

        proposed = error([round(i["theta_i_deg"]) for i in proposal["incidences"]])
        better += proposed < error(rng.sample(CANDIDATES, 3))
        over.append(proposed / proposal["then"])
    print("%-20s %d runs; worst error smaller with the proposed %d, %.2f of what was foretold" % (name, RUNS, better, statistics.median(over)))
    return better, statistics.median(over)


def main():
    failures = 0
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        for name in SURFACES:
            tried, proposed, drawn = choice_of_models(name)
            spread = 3 * math.sqrt(0.8 * 0.2 / max(tried, 1)) if RUNS < 100 else 0  # of few runs
            failures += tried < RUNS or proposed < (0.8 - spread) * tried or drawn > (0.5 + spread) * tried
            better, over = worst_error(name)
            failures += better < (0.8 - spread) * RUNS or not 0.8 < over < 1.25
        os.chdir("/")
    print("%d failures" % failures)
    return failures > 0


if __name__ == "__main__":
    sys.exit(main())
