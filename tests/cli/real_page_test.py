#!/usr/bin/env python3
"""real_page_test.py PROGRAM SCRIPT: bench/real.py writes pages about files of a known origin whose figures are those of the fits."""
import importlib.util
import os
import re
import subprocess
import sys
import tempfile

program, script = map(os.path.abspath, sys.argv[1:])
failures = 0
SURFACES = {"a": ("ggx/v-cavity+lambert", "ggx / v-cavity"), "b": ("beckmann/none+lambert", "beckmann / none")}


def check(condition, text):
    global failures
    if not condition:
        failures += 1
        print("failed: " + text)


def simulate(folder):
    for name, (model, _) in SURFACES.items():
        subprocess.run([program, "simulate", model, "--set", "alpha=0.4,f0=0.5:0.4:0.3,kd=0.1:0.2:0.3", "--grid", "scattered:700:0.3", "--noise", "0.01", "-o",
                        os.path.join(folder, name + ".astm")], check=True, stderr=subprocess.DEVNULL)


def sections(page):
    return dict(part.split("\n", 1) for part in page.split("\n### ")[1:])


def check_figures(real, name, text, fits):
    """The table of a section is objective over the best's, cell by cell."""
    ndfs = {line.split(" | ")[0][2:]: line[2:-2].split(" | ")[1:] for line in text.splitlines() if line.startswith("| ")}
    check(len(ndfs) == 15, f"{name}: {len(ndfs)} rows")
    best = min(real.objective(fit) for fit in fits)
    for fit in fits:
        if fit["masking"] == "disney-clearcoat":  # that of one distribution; the page has those that go with all
            continue
        cell = ndfs[fit["ndf"]][list(real.MASKINGS).index(fit["masking"])].strip("*?")
        ratio = real.objective(fit) / best
        check(abs(float(cell) / ratio - 1) < 0.006 or (ratio > 10 and abs(float(cell) - ratio) <= 0.5), f"{name}: {real.label(fit)} is {cell}, should be {ratio}")


def with_statistics(real, paint):
    """What the program may report of a comparison, as it would look."""
    for fit in paint.fits:
        fit["effective_samples"] = 321.0
        fit["versus_best"] = None if fit is paint.best else {
            "delta_objective": 1.0, "delta_aic": 2.0, "delta_bic": 2.0, "vuong_z": 9.25, "vuong_p": 0.5, "told_apart": paint.ratio(fit) > 1.5,
            "cross_validation": {"difference": 0.125, "std_error": 0.0625}}
        fit["residual_bands"] = {angle: [{"from": 0, "to": 10, "n": 5, "mean": -0.04, "rms": 0.2}, {"from": 10, "to": 20, "n": 0, "mean": None, "rms": None}]
                                 for angle in real.ANGLES}
    return paint


with tempfile.TemporaryDirectory() as folder:
    spec = importlib.util.spec_from_file_location("real", script)
    real = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(real)
    data, fits, target, report = (os.path.join(folder, name) for name in ("data", "fits", "page.md", "report.md"))
    os.makedirs(os.path.join(data, "astm"))
    empty = subprocess.run([sys.executable, script, program, fits, data, target, report], stderr=subprocess.PIPE, text=True)
    check(empty.returncode == 1 and "astm" in empty.stderr and not os.path.exists(target), f"no data: {empty}")
    simulate(os.path.join(data, "astm"))
    done = subprocess.run([sys.executable, script, program, fits, data, target, report, "--max-theta", "75"], stderr=subprocess.PIPE, text=True)
    check(done.returncode == 0, done.stderr[-500:])
    with open(target, encoding="utf-8") as f:
        page = f.read()
    with open(report, encoding="utf-8") as f:
        files = f.read()
    for text in (page, files):
        check("`bench/real -- --max-theta 75`" in " ".join(text.split()) and "nan" not in text.lower(), "the head of a page")
    check(all(len(line) <= 100 for line in page.splitlines() if not line.startswith("|")), "a line of the page is too long")
    check(len(re.findall(r"^\| \[[ab]\]\(report\.md#[ab]\)", page, re.M)) == 2, "the table of all files")
    paints = []
    for name, (_, winner) in SURFACES.items():
        base = os.path.join(fits, name + ".astm")
        by_loss = {loss: real.load(f"{base}.{loss}.json") for loss in real.LOSSES}
        paints.append(real.Paint(base, by_loss, real.load(f"{base}.{real.RETRIEVED}.json"), real.load(f"{base}.info.json"), 1.0))
        check_figures(real, name, sections(files)[name], paints[-1].fits)
        first = {(fit["ndf"], fit["masking"]) for fit in [paints[-1].best] + paints[-1].not_told_apart()}
        check(tuple(winner.split(" / ")) in first, f"{name}: {winner} is not among the best, {first}")
    paints = [with_statistics(real, p) for p in paints]
    page = " ".join((real.page(paints, program, [], 1.0, "report.md") + real.file_by_file(paints, program, [], 1.0)).split())
    for words in ("Vuong z 9.25 (p 0.5), held-out difference 0.125 +- 0.062", "321 effective samples", "* residual by theta_d, % mean (rms): 0-10: -4.0 (20)",
                  "## Where the winners miss", "| 0 to 10 | 2 | 2 | -4.0 | 4.0 | 20.0 |", "**By angle**", "* not told apart: "):
        check(words in page, f"with the statistics, the page does not say '{words}'")
print(f"{failures} failures")
sys.exit(1 if failures else 0)
