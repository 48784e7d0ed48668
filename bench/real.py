#!/usr/bin/env python3
"""real.py PROGRAM FITS DATA PAGE REPORT [WORD...]: fits every distribution under every masking to real paints and writes two pages:
PAGE says what all files together show, REPORT has a section for each file.

Every figure of the pages, those in its sentences too, comes from the JSON of `facetfit compare`, kept in the folder FITS. What a version of
the program does not report (see STATISTICS) is left out of the page, which says so.
"""
import datetime
import glob
import json
import math
import os
import platform
import statistics
import subprocess
import sys
import textwrap
import time

DATA_SETS = [("astm", "*.astm"), ("rgl", "*.bsdf")]
# Columns of a table, and their heads.
MASKINGS = {"smith-separable": "separable", "smith-height-correlated": "height", "smith-direction-correlated": "direction",
            "smith-height-direction-correlated": "height-dir.", "v-cavity": "v-cavity", "kelemen": "kelemen", "none": "none",
            "hammon": "hammon", "schlick-smith": "schlick-smith"}
# What a microsurface can be behind; kelemen and none are simplifications, hammon and schlick-smith go with ggx alone.
SURFACES = list(MASKINGS)[:5]
RETRIEVED = "tabulated"
# Rational approximations of the masking of another row: no distributions of their own.
SAME_DISTRIBUTION = {"beckmann-walter": "beckmann", "phong-walter": "phong"}
STATISTICS = ("versus_best", "effective_samples", "residual_bands")
ANGLES = {"theta_i": "angle of the light", "theta_h": "angle of the half vector", "theta_d": "angle between light and half vector"}
NEAR = 1.01  # objective over the winner's, where the program does not say what can be told apart
TIE = 1.001  # objectives that count as the same in the contests of maskings
COUNTS = 1.02  # worst over best masking, rms, from which on the masking is said to count
LONG_TAIL, LONGEST_TAIL = 1.7, 1.55  # of student-t's gamma
LOSSES = ("cosine", "log")
WIDTH = 100


# ---- running ----------------------------------------------------------------------------------


def say(text):
    print(text, file=sys.stderr, flush=True)


def run(command):
    say("$ " + " ".join(command))
    begin = time.monotonic()
    done = subprocess.run(command, check=False, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    if done.returncode not in (0, 1):  # 1: it ran, and a fit did not converge, which the page says
        raise SystemExit(f"{command[0]} ended with exit status {done.returncode}: {done.stderr.strip()}")
    return time.monotonic() - begin


def load(path):
    with open(path, encoding="utf-8") as f:
        return json.load(f)


def measured_files(data):
    return [path for folder, pattern in DATA_SETS for path in sorted(glob.glob(os.path.join(data, folder, pattern)))]


def formulas(program, folder):
    """Distributions that have a formula, in the registry's order."""
    path = os.path.join(folder, "models.json")
    run([program, "models", "--json", path])
    return [term["name"] for term in load(path)["terms"] if term["kind"] == "distribution" and term["name"] != RETRIEVED]


def compare_file(program, folder, path, ndfs, words):
    """All fits to one file: the formulas by every loss, the retrieved table by the first."""
    base = os.path.join(folder, os.path.basename(path))
    seconds = 0
    for loss in LOSSES:
        seconds += run([program, "compare", path, "--ndf", ",".join(ndfs), "--masking", "all", "--loss", loss, "--json",
                        f"{base}.{loss}.json", *words])
    seconds += run([program, "ndf", path, "--loss", LOSSES[0], "-o", f"{base}.table"])
    seconds += run([program, "compare", path, "--ndf", RETRIEVED, "--masking", "all", "--loss", LOSSES[0], "--ndf-table", f"{base}.table",
                    "--json", f"{base}.{RETRIEVED}.json", *words])
    seconds += run([program, "info", path, "--json", f"{base}.info.json"])
    return Paint(path, {loss: load(f"{base}.{loss}.json") for loss in LOSSES}, load(f"{base}.{RETRIEVED}.json"), load(f"{base}.info.json"),
                 seconds)


# ---- what one file says -----------------------------------------------------------------------


def objective(fit):
    return fit["residual"]["objective"]


def distribution(fit):
    return SAME_DISTRIBUTION.get(fit["ndf"], fit["ndf"])


def masking(fit):
    return fit["masking"]


def label(fit):
    return f"{fit['ndf']} / {MASKINGS.get(fit['masking'], fit['masking'])}"


class Paint:
    """One file: fits by formulas, by the retrieved table, the winner."""

    def __init__(self, path, by_loss, retrieved, info, seconds):
        self.name = os.path.splitext(os.path.basename(path))[0]
        self.data = by_loss[LOSSES[0]]["data"]
        self.max_theta = by_loss[LOSSES[0]]["loss"]["max_theta_deg"]
        self.fits = by_loss[LOSSES[0]]["fits"]
        self.best = min(self.fits, key=objective)
        self.best_by = {loss: min(answer["fits"], key=objective) for loss, answer in by_loss.items()}
        self.retrieved = retrieved["fits"]
        self.info = info
        self.seconds = seconds
        self.all = self.fits + self.retrieved
        self.cell = {(fit["ndf"], fit["masking"]): fit for fit in self.all}

    def ratio(self, fit):
        return objective(fit) / objective(self.best)

    def best_other(self, same):
        """The best fit that is not the winner's as far as same(fit) goes; None when there is none."""
        others = [fit for fit in self.fits if same(fit) != same(self.best)]
        return min(others, key=objective) if others else None

    def statistics(self):
        return all(key in self.best for key in STATISTICS)

    def not_told_apart(self):
        """Fits other than the winner that these data do not tell from it."""
        if self.statistics():
            return [fit for fit in self.fits if fit["versus_best"] and not fit["versus_best"]["told_apart"]]
        return [fit for fit in self.fits if fit is not self.best and self.ratio(fit) <= NEAR]

    def floor(self):
        return min(self.retrieved, key=objective)


def distributions_of(paints, maskings):
    """Distributions that go with all of these maskings, approximations left out."""
    first = paints[0]
    return [ndf for ndf in dict.fromkeys(fit["ndf"] for fit in first.fits)
            if ndf not in SAME_DISTRIBUTION and all((ndf, masking) in first.cell for masking in maskings)]


def shares(paint, ndfs, maskings):
    """Two-way analysis of variance of ln(objective): parts of the sum of squares of distribution, masking and both together."""
    table = [[math.log(objective(paint.cell[ndf, masking])) for masking in maskings] for ndf in ndfs]
    mean = statistics.mean(x for row in table for x in row)
    rows = [statistics.mean(row) - mean for row in table]
    columns = [statistics.mean(column) - mean for column in zip(*table)]
    total = sum((x - mean) ** 2 for row in table for x in row)
    by_row = len(maskings) * sum(r * r for r in rows)
    by_column = len(ndfs) * sum(c * c for c in columns)
    return by_row / total, by_column / total, max(0.0, 1 - (by_row + by_column) / total)


def spreads(paint, ndfs, maskings):
    """Around the best of ndfs x maskings: worst over best rms of the distributions under its masking, and of the maskings of its distribution."""
    ndf, masking = min(((d, m) for d in ndfs for m in maskings), key=lambda key: objective(paint.cell[key]))
    column = [objective(paint.cell[d, masking]) for d in ndfs]
    row = [objective(paint.cell[ndf, m]) for m in maskings]
    return math.sqrt(max(column) / min(column)), math.sqrt(max(row) / min(row))


# ---- words and numbers ------------------------------------------------------------------------


def number(x, digits=3):
    return "-" if x is None else f"{x:.{digits}g}"


def ratio_text(r):
    return f"{r:.4f}" if r < 1.01 else f"{r:.3f}" if r < 1.1 else f"{r:.2f}" if r < 10 else f"{r:.0f}"


def excess_text(r):
    """By how many per cent a ratio exceeds 1."""
    return f"{100 * (r - 1):.2g}" if r < 1.1 else f"{100 * (r - 1):.0f}"


def more(r):
    return f"{excess_text(r)} %"


def value_text(value, error, bound):
    return f"{number(value)}!" if bound else number(value) if error is None else f"{number(value, 4)} +- {number(error, 2)}"


def parameter_text(name, p):
    columns = p["value"], p["std_error"], p["at_bound"]
    values = zip(*columns) if isinstance(p["value"], list) else [columns]
    return f"{name} " + ", ".join(value_text(*one) for one in values)


def parameters_text(fit):
    """Free parameters; of an isotropic stretch one alpha."""
    words = [parameter_text("alpha" if name == "alpha_x" and fit["shape"] == "isotropic" else name, p)
             for name, p in fit["parameters"].items() if not p["held"] and not p.get("tied", False)]
    return "; ".join(words)


def table(head, rows):
    return ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)] + ["| " + " | ".join(row) + " |" for row in rows]


def percent(x):
    return f"{100 * x:+.1f}"


def commas(words):
    return ", ".join(words) or "none"


# ---- the page ---------------------------------------------------------------------------------


def provenance(paints, program, words, seconds):
    with open("/proc/cpuinfo", encoding="utf-8") as f:
        cpu = next((line.split(":", 1)[1].strip() for line in f if line.startswith("model name")), platform.processor())
    version = subprocess.run([program, "--version"], check=False, stdout=subprocess.PIPE, text=True).stdout.strip()
    command = " ".join(["bench/real"] + (["--", *words] if words else []))
    today = datetime.date.today().isoformat()
    fits = sum(len(p.all) + len(p.fits) * (len(LOSSES) - 1) for p in paints)
    return [f"Written by `{command}` on {today}: {version or 'facetfit'}, {cpu}, {os.cpu_count()} cores; {len(paints)} files, {fits} fits, "
            f"{seconds:.0f} s from start to end (reading, retrieving the tables and `info` included)."]


def introduction(paints):
    lines = [
        "# Real paints: what tells the models apart", "",
        "Every distribution of normals under every masking, with Schlick's Fresnel term and Lambert's diffuse part, on measured files: hobby paints of a scatterometer at three wavelengths "
        "(`astm/`), and films, papers and paints of the EPFL goniophotometer in RGB (`rgl/`; Dupuy and Jakob 2018). Schlick's term, Lambert's part and one roughness for all channels are what a first fit would use; that they are "
        "right for any of these is not known. The files are not part of the project.", "",
        "## How to read it", "",
        f"* Minimised is half the weighted sum of squares of (f - y) cos(theta_i), up to {number(paints[0].max_theta)} degrees from the normal ([fitting-reference.md](fitting-reference.md)). A number in a table is this objective over that of the winner of the file, **1**; its "
        "square root is the ratio of the root mean squares.",
        f"* `{RETRIEVED}` is no formula: the distribution found from the same file by `facetfit ndf` under the height-correlated form, some 20 effective parameters that no criterion here charges for. It cannot be a "
        "winner; it shows what the best isotropic distribution could reach with that masking, Schlick's F and Lambert's part.",
        "* cos. rms is the root mean square of (f - y) cos(theta_i), rms that of f - y, both in 1/sr, weighted as the fit; `!` marks a value on its bound, which has no standard error.",
        "* Maskings: Smith's separable, height-correlated, direction-correlated and height-direction-correlated forms, V-cavity, Kelemen's, none; Hammon's and Schlick's approximations of Smith's go with ggx alone. "
        "beckmann-walter and phong-walter are beckmann and phong with Walter's rational masking."]
    if paints[0].statistics():
        lines.append("* Not told apart: Vuong's test between the winner and the model, with a variance that knows of neighbours and of incident directions, is not significant ([fitting-reference.md](fitting-reference.md)). Residual by angle: mean and root mean square of "
                     "(model - data) cos(theta_i) in a band, relative to the mean |data cos(theta_i)| there.")
    else:
        lines.append(f"* Not told apart: this version of the program reports no test between models, no effective number of samples and no residuals by angle. Listed instead are models within {more(NEAR)} of the "
                     "winner's objective, which is a convention and not a test.")
    return lines


def ggx_alpha(p):
    return p.cell["ggx", "smith-height-correlated"]["ellipse"]["alpha_major"]


def gamma(p):
    return p.cell["student-t", "smith-height-correlated"]["parameters"]["gamma"]["value"]


def summary_row(p, ndfs, report):
    by_distribution, by_masking = p.best_other(distribution), p.best_other(masking)
    of_distributions, of_maskings = spreads(p, ndfs, SURFACES)
    return [f"[{p.name}]({report}#{p.name.lower()})", str(p.data["used"]), number(ggx_alpha(p), 2), number(gamma(p)), f"**{label(p.best)}**",
            number(p.best["residual"]["cosine_rmse"]), number(p.best["residual"]["rmse"]),
            f"{label(by_distribution)} {ratio_text(p.ratio(by_distribution))}", f"{label(by_masking)} {ratio_text(p.ratio(by_masking))}",
            ratio_text(p.ratio(p.floor())), label(p.best_by[LOSSES[1]]), excess_text(of_distributions), excess_text(of_maskings),
            " / ".join(f"{100 * x:.0f}" for x in shares(p, ndfs, SURFACES)), f"{p.seconds:.1f}"]


def summary(paints, report):
    ndfs = distributions_of(paints, SURFACES)
    head = ["file", "samples", "alpha", "gamma", "winner", "cos. rms", "rms", "best other distribution", "best other masking", RETRIEVED,
            "winner by log loss", "distributions, %", "maskings, %", "shares, %", "s"]
    return ["## All files", "", *table(head, [summary_row(p, ndfs, report) for p in paints]), "",
            f"*alpha* of ggx and *gamma* of student-t, height-correlated, as measures of roughness and tail (2 is ggx, large beckmann). *distributions, %*, *maskings, %*: around the best of {len(ndfs)} distributions ({commas(ndfs)}) under {len(SURFACES)} maskings "
            f"({commas(MASKINGS[m] for m in SURFACES)}), by how much the rms of the worst distribution under the same masking, and of the worst masking of the same distribution, exceeds it. *shares*: of the variance of "
            f"ln(objective) over these {len(ndfs)} x {len(SURFACES)} fits, what goes with the distribution / with the masking / with particular pairs. The last column is wall clock."]


def contests(paints, maskings, ndfs):
    """Per masking: contests won outright, and its excess over the best. A contest is one distribution on one file."""
    won, excess, ties = dict.fromkeys(maskings, 0), {m: [] for m in maskings}, 0
    for p in paints:
        for ndf in ndfs:
            values = sorted((objective(p.cell[ndf, m]), m) for m in maskings)
            if values[1][0] <= TIE * values[0][0]:
                ties += 1
            else:
                won[values[0][1]] += 1
            for value, m in values:
                excess[m].append(value / values[0][0])
    return won, excess, ties


def contest_table(paints):
    everywhere = list(MASKINGS)[:7]
    ndfs = distributions_of(paints, everywhere)
    among, excess, ties = contests(paints, everywhere, ndfs)
    surfaces, _, surface_ties = contests(paints, SURFACES, ndfs)
    rows = [[head, str(sum(p.best["masking"] == m for p in paints)), str(sum(p.best_by[LOSSES[1]]["masking"] == m for p in paints)),
             str(among[m]) if m in among else "-", str(surfaces[m]) if m in surfaces else "-",
             more(statistics.median(excess[m])) if m in excess else "-"] for m, head in MASKINGS.items()]
    n = len(paints) * len(ndfs)
    return ["## Which masking", "",
            *table(["masking", "files won", "by log loss", f"of {n} contests of all", f"of {n} of surfaces", "median excess"], rows), "",
            f"A contest is one of {len(ndfs)} distributions on one file; of *all*: the {len(everywhere)} maskings that every distribution takes, of *surfaces*: {commas(MASKINGS[m] for m in SURFACES)}. "
            f"Contests whose first two are within {more(TIE)} have no winner: {ties} of all, {surface_ties} of surfaces. *median excess*: of the objective over the best of its contest."]


def distribution_table(paints):
    ndfs = list(dict.fromkeys(distribution(fit) for fit in paints[0].fits))
    rows = []
    for ndf in ndfs:
        ratios = [min(p.ratio(fit) for fit in p.fits if distribution(fit) == ndf) for p in paints]
        rows.append([ndf, str(sum(distribution(p.best) == ndf for p in paints)), str(sum(distribution(p.best_by[LOSSES[1]]) == ndf for p in paints)),
                     ratio_text(statistics.median(ratios)), ratio_text(max(ratios))])
    rows.sort(key=lambda row: float(row[3]))
    return ["## Which distribution", "", *table(["distribution", "files won", "by log loss", "median", "worst"], rows), "",
            "*median*, *worst* over the files: its objective under its best masking over that of the winner."]


def bands_over_files(paints, angle):
    """Residuals of the winners: (from, to) -> list of (mean, rms), one per file that has samples there."""
    bands = {}
    for p in paints:
        for band in p.best["residual_bands"].get(angle) or []:
            if band["n"] and band["mean"] is not None:
                bands.setdefault((band["from"], band["to"]), []).append((band["mean"], band["rms"]))
    return dict(sorted(bands.items()))


def size_of(band):
    return statistics.median(abs(mean) for mean, _ in band)


def too_low(band):
    return sum(mean < 0 for mean, _ in band)


def band_table(paints):
    """Residuals by angle of the winners, over the files; nothing where the program does not report them."""
    if not paints[0].statistics():
        return []
    lines = ["## Where the winners miss"]
    for angle, meaning in ANGLES.items():
        rows = [[f"{number(a)} to {number(b)}", str(len(x)), str(too_low(x)), percent(statistics.median(mean for mean, _ in x)), f"{100 * size_of(x):.1f}",
                 f"{100 * statistics.median(rms for _, rms in x):.1f}"] for (a, b), x in bands_over_files(paints, angle).items()]
        lines += ["", f"By the {meaning}, `{angle}`:", "",
                  *table(["degrees", "files", "model too low in", "median of mean, %", "of its size, %", "median rms, %"], rows)]
    return lines


def band_sentence(paints):
    words = []
    for angle in ANGLES:
        bands = {key: x for key, x in bands_over_files(paints, angle).items() if 2 * len(x) >= len(paints)}
        if bands:
            (a, b), x = max(bands.items(), key=lambda item: size_of(item[1]))
            words.append(f"{angle} {number(a)} to {number(b)} degrees ({100 * size_of(x):.1f} %, too low in {too_low(x)} of {len(x)} files)")
    return f"* **By angle** the winners' mean residual is largest at {commas(words)}: medians of its size over the files, of bands that at least half of them have."


def reading(paints):
    """Sentences about all files, each with the figures it rests on."""
    ndfs, n, median = distributions_of(paints, SURFACES), len(paints), statistics.median
    parts = [shares(p, ndfs, SURFACES) for p in paints]
    around = [spreads(p, ndfs, SURFACES) for p in paints]
    smith = [spreads(p, ndfs, SURFACES[:4])[1] for p in paints]
    other_ndf = [math.sqrt(p.ratio(p.best_other(distribution))) for p in paints]
    other_masking = [math.sqrt(p.ratio(p.best_other(masking))) for p in paints]
    retrieved = [math.sqrt(1 / p.ratio(p.floor())) for p in paints]
    reciprocity = [p.info["reciprocity"]["deviation"] for p in paints if p.info["reciprocity"]["deviation"] is not None]
    close = [p.not_told_apart() for p in paints]
    test = "by the test" if paints[0].statistics() else f"within {more(NEAR)} of the objective"
    matters = [p for p, (_, m) in zip(paints, around) if m > COUNTS]
    idle = [p for p in paints if p not in matters]
    of_ggx = [spreads(p, ["ggx"], SURFACES)[1] for p in paints]

    def files(condition):
        return sum(1 for p in paints if condition(p))

    def long_tail(p):
        return gamma(p) < LONG_TAIL
    lines = [
        "## What the figures say", "",
        f"* **The distribution matters more than the masking.** Around the best fit of a file, the worst distribution has an rms {more(median(d for d, _ in around))} above it, the worst of the {len(SURFACES)} maskings "
        f"{more(median(m for _, m in around))} (medians over {n} files; at most {more(max(d for d, _ in around))} and {more(max(m for _, m in around))}). Of the variance of ln(objective) {100 * median(x[0] for x in parts):.0f} % "
        f"go with the distribution, {100 * median(x[1] for x in parts):.0f} % with the masking (medians); the masking has the larger share in {sum(x[1] > x[0] for x in parts)} of {n} files.",
        f"* **Where the masking counts, the tail is long or the surface rough.** It makes more than {more(COUNTS)} of the rms in {len(matters)} files. In {sum(map(long_tail, matters))} of them student-t's gamma (height-correlated) is "
        f"below {LONG_TAIL:g}, in {sum(map(long_tail, idle))} of the other {n - len(matters)}: slopes whose mean is nearly infinite, for which Smith's forms darken all grazing directions and V-cavity's does not. The ggx alpha of the others among the "
        f"{len(matters)}: {commas(number(x, 2) for x in sorted(ggx_alpha(p) for p in matters if not long_tail(p)))}. For ggx, whose tail is shorter, the {len(SURFACES)} maskings differ by {more(median(of_ggx))} of the rms (median; at most {more(max(of_ggx))}).",
        f"* **A gamma next to its bound of 1.51 is a warning**: below {LONGEST_TAIL:g} in {files(lambda p: gamma(p) < LONGEST_TAIL)} of {n} files. The tail of the lobe, and G with it, then compete with Lambert's part for the light far from the peak; "
        "neither gamma nor kd nor the preference for a masking should be read as the surface's there.",
        f"* **Smith's four forms are closer still**: the worst is {more(median(smith))} above the best (median), {more(max(smith))} at most.",
        f"* **At the top the differences shrink.** The best fit with another distribution has an rms {more(median(other_ndf))} above the winner's, the best one with another masking {more(median(other_masking))} (medians). "
        f"Not told apart from the winner ({test}) is a model of another distribution in {sum(any(distribution(f) != distribution(p.best) for f in c) for p, c in zip(paints, close))} of {n} files, one with another masking in "
        f"{sum(any(masking(f) != masking(p.best) for f in c) for p, c in zip(paints, close))}.",
        f"* **The winner's masking is often none of these surfaces'**: kelemen, none, hammon or schlick-smith in {files(lambda p: masking(p.best) not in SURFACES)} of {n} files. They may stand in for what Schlick's term and "
        "Lambert's part lack, and are no evidence about the surface's cavities.",
        f"* **It depends on the yardstick.** By the log loss, for which the dark parts count as well as the peak, another pair wins in {files(lambda p: label(p.best_by[LOSSES[0]]) != label(p.best_by[LOSSES[1]]))} of {n} files, with another "
        f"masking in {files(lambda p: masking(p.best_by[LOSSES[0]]) != masking(p.best_by[LOSSES[1]]))}.",
        f"* **A distribution without a formula does better** in {sum(x > 1 for x in retrieved)} of {n} files: the winner's rms is {more(median(retrieved))} above that of `{RETRIEVED}` in the median, {more(max(retrieved))} at most. So much of "
        "the residual is the shape of D; the rest is something else.",
    ]
    if reciprocity:
        lines.append(f"* **The measurements are not reciprocal**: exchanging light and detector changes values by {100 * median(reciprocity):.2g} % (median over pairs, then over {len(reciprocity)} files; {100 * min(reciprocity):.2g} to "
                     f"{100 * max(reciprocity):.2g} %). No model here follows that, and a difference between two models that is smaller says little about the surface.")
    if paints[0].statistics():
        lines.append(band_sentence(paints))
    unfinished = sum(fit["outcome"] != "converged" for p in paints for fit in p.all)
    if unfinished:
        lines.append(f"* {unfinished} of {sum(len(p.all) for p in paints)} fits did not converge.")
    return lines


def matrix(p):
    """The table of one file: rows distributions, columns maskings."""
    close = {id(fit) for fit in p.not_told_apart()}

    def text(fit):
        if fit is None:
            return "-"
        words = ratio_text(p.ratio(fit)) + ("?" if fit["outcome"] != "converged" else "")
        return "**1**" if fit is p.best else f"*{words}*" if id(fit) in close else words
    ndfs = list(dict.fromkeys(fit["ndf"] for fit in p.all))
    return table(["", *MASKINGS.values()], [[ndf, *(text(p.cell.get((ndf, m))) for m in MASKINGS)] for ndf in ndfs])


def grouped(fits):
    """Models by distribution: "ggx (v-cavity, none); gtr (height)"."""
    by_ndf = {}
    for fit in fits:
        by_ndf.setdefault(fit["ndf"], []).append(MASKINGS.get(masking(fit), masking(fit)))
    return "; ".join(f"{ndf} ({commas(names)})" for ndf, names in by_ndf.items()) or "none"


def against(p, fit):
    """How a fit compares with the winner."""
    words = f"{label(fit)}: objective {ratio_text(p.ratio(fit))}, delta AIC {fit['aic'] - p.best['aic']:.0f}"
    if p.statistics():
        versus = fit["versus_best"]
        words += f", Vuong z {number(versus['vuong_z'])} (p {number(versus['vuong_p'], 2)})"
        held_out = versus.get("cross_validation")
        if held_out:
            words += f", held-out difference {number(held_out['difference'])} +- {number(held_out['std_error'], 2)}"
    return words


def bands_text(p):
    lines = []
    for angle in ANGLES:
        bands = [b for b in p.best["residual_bands"].get(angle) or [] if b["n"] and b["mean"] is not None]
        if bands:
            lines.append(f"* residual by {angle}, % mean (rms): " +
                         "; ".join(f"{number(b['from'])}-{number(b['to'])}: {percent(b['mean'])} ({100 * b['rms']:.0f})" for b in bands))
    return lines


def section(p):
    d = p.data
    rejected = d["rejected"]
    reciprocity = p.info["reciprocity"]["deviation"]
    lines = [f"### {p.name}", "",
             f"{d['format']}, {d['samples']} samples, {d['used']} used ({rejected['invalid']} invalid, {rejected['grazing']} beyond {number(p.max_theta)} degrees, {rejected['below_horizon']} below the horizon left out), channels "
             f"{commas(d['channels'])}, weights by {d['weighting']}" + (f"; light and detector exchanged: {100 * reciprocity:.2g} %" if reciprocity is not None else "") + ".", "",
             *matrix(p), "",
             f"* winner: {label(p.best)}; {parameters_text(p.best)}; cos. rms {number(p.best['residual']['cosine_rmse'])} 1/sr, rms {number(p.best['residual']['rmse'])} 1/sr"
             + (f"; {number(p.best['effective_samples'], 4)} effective samples" if p.statistics() else ""),
             f"* best other distribution: {against(p, p.best_other(distribution))}",
             f"* best other masking: {against(p, p.best_other(masking))}",
             f"* {'not told apart' if p.statistics() else 'within ' + more(NEAR)}: {grouped(p.not_told_apart())}"]
    if p.statistics():
        lines += bands_text(p)
    lines.append(f"* {len(p.all)} fits, {sum(fit['time_s'] for fit in p.all):.1f} s")
    return lines


def wrapped(line):
    """Prose in lines of at most WIDTH characters; tables and headings as they are."""
    if line.startswith(("|", "#")):
        return line
    return textwrap.fill(line, WIDTH, subsequent_indent="  " if line.startswith("* ") else "", break_long_words=False, break_on_hyphens=False)


def joined(blocks):
    return "\n".join("\n".join(wrapped(line) for line in block) + "\n" for block in blocks if block)


def page(paints, program, words, seconds, report):
    """What all files together show; `report` is the way from this page to the one of the files."""
    return joined([introduction(paints), provenance(paints, program, words, seconds), reading(paints), summary(paints, report),
                   contest_table(paints), distribution_table(paints), band_table(paints)])


def file_by_file(paints, program, words, seconds):
    head = ["# Real paints, file by file", "", "The fits behind `docs/real.md`. A number in a table is an objective over that of the winner of the file; **1** the winner, "
            "*italic* what is not told apart from it, `?` a fit that did not converge."]
    return joined([head, provenance(paints, program, words, seconds), *(section(p) for p in paints)])


def write(path, text):
    with open(path + ".part", "w", encoding="utf-8") as f:
        f.write(text)
    os.replace(path + ".part", path)


def main(argv):
    if len(argv) < 6:
        print("usage: real.py PROGRAM FITS DATA PAGE REPORT [WORD...]", file=sys.stderr)
        return 2
    program, folder, data, target, report, words = argv[1], argv[2], argv[3], argv[4], argv[5], argv[6:]
    files = measured_files(data)
    if not files:
        print(f"real.py: {data} holds neither {' nor '.join(os.path.join(*s) for s in DATA_SETS)}", file=sys.stderr)
        return 1
    os.makedirs(folder, exist_ok=True)
    begin = time.monotonic()
    ndfs = formulas(program, folder)
    paints = [compare_file(program, folder, path, ndfs, words) for path in files]
    seconds = time.monotonic() - begin
    write(target, page(paints, program, words, seconds, os.path.relpath(report, os.path.dirname(target) or ".")))
    write(report, file_by_file(paints, program, words, seconds))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv))
