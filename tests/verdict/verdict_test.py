#!/usr/bin/env python3
"""verdict_test.py PROGRAM [DATA]: the sentences that open `fit` and `compare`: when each is said and when not, and that its numbers
are those of the report beneath. What a fit is said to explain is computed anew from its residuals. With DATA also on the eleven
paints of that folder."""
import csv
import glob
import json
import math
import os
import re
import statistics
import subprocess
import sys
import tempfile

PROGRAM = os.path.abspath(sys.argv[1])
DATA = sys.argv[2] if len(sys.argv) > 2 else ""
FAILURES = []
CHECKS = [0]

# name: call of `simulate`
FILES = {
    "good.csv": "ggx+lambert --set alpha=0.25,f0=0.5,kd=0.1 --grid goniometer:5 --noise 0.02 --seed 1",
    "coarse.csv": "ggx+lambert --set alpha=0.2,f0=0.5,kd=0.1 --grid goniometer:10 --noise 0.05 --seed 1",
    "two.csv": "ggx+ggx+lambert --set alpha=0.08,f0=0.5,lobe2.alpha=0.6,lobe2.f0=0.4,kd=0.05 --grid goniometer:5 --noise 0.01 --seed 1",
    "short.csv": "beckmann+lambert --set alpha=0.15,f0=0.5,kd=0.05 --grid goniometer:5 --noise 0.05 --seed 1",
    "long.csv": "ggx/smith-height-correlated+lambert --set alpha=0.3,f0=0.5,kd=0.05 --grid goniometer:5 --noise 0.02 --seed 1",
    "cavity.csv": "ggx/v-cavity+lambert --set alpha=0.3,f0=0.5,kd=0.05 --grid goniometer:5 --noise 0.02 --seed 1",
    "diffuse.csv": "lambert --set kd=0.5 --grid goniometer:10 --noise 0.02 --seed 1",
    "narrow.csv": "ggx+lambert --set alpha=0.01,f0=0.5,kd=0.1 --grid goniometer:10 --noise 0.05 --seed 1",
    "rgb.csv": "ggx+lambert --set alpha=0.25,f0=0.5:0.3:0.1,kd=0.1:0.2:0.3 --grid goniometer:10 --noise 0.02 --seed 1",
}


def check(held, what):
    CHECKS[0] += 1
    if not held:
        FAILURES.append(what)
        print("failed:", what)


def run(*words):
    done = subprocess.run([PROGRAM, *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE, check=False)
    return done.stdout.decode(), done.returncode


def report(*words):
    text, _ = run(*words, "--json", "-")
    return json.loads(text)


SAID, UNSAID = set(), set()


def verdict(document, problem=0):
    """code: text"""
    said = {v["code"]: v["text"] for v in document["verdict"] if v["problem"] == problem}
    SAID.update(said)
    UNSAID.update(codes() - set(said))
    return said


def codes():
    """All that a verdict can say, by the schema."""
    if not codes.known:
        text = run("fit", "--print-schema")[0]
        codes.known = set(re.search(r'"code": \{"enum": \[("not-converged".*?)\]', text).group(1).replace('"', "").split(", "))
    return codes.known


codes.known = set()


def quality(document):
    return [v["quality"] for v in document["verdict"] if v["code"] == "quality"][0]


def rewritten(name, to, change):
    """A copy of a CSV with every row changed."""
    with open(name, encoding="utf-8") as source, open(to, "w", encoding="utf-8") as out:
        for line in source:
            if line.startswith("#") or line.startswith("theta"):
                out.write(line)
            else:
                out.write(",".join("%.17g" % x for x in change([float(x) for x in line.split(",")])) + "\n")
    return to


# ---- when each is said ---------------------------------------------------------------------------------------------------------


def sentences_of_units():
    """Values in another unit: said first, once, with how many times too bright they are."""
    for times, flag in ((math.pi, "--quantity reflectance-factor"), (100, "--scale 0.01"), (1000, "--scale takes")):
        path = rewritten("good.csv", "bright.csv", lambda row: row[:4] + [times * row[4]])
        for words in (("fit",), ("compare", "--ndf", "ggx,beckmann", "--masking", "v-cavity")):
            document = report(words[0], path, *words[1:])
            first = document["verdict"][0]
            verdict(document)
            said = re.search(r"reflect at least ([\d.]+) times the light", first["text"])
            check(first["code"] == "unit" and said and flag in first["text"], "%s, %g times: %s" % (words[0], times, first))
            text = run(words[0], path, *words[1:])[0]
            check(text.count("times the light") == 1 and text.startswith("The values are not in 1/sr"), "%s, %g times: said %d times" % (words[0], times, text.count("times the light")))
        least = float(said.group(1)) / times
        check(0.1 < least < 0.6, "%g times: at least %s" % (times, least))
    check("unit" not in verdict(report("fit", path, "--free", "ks")), "a scale is fitted: %s" % verdict(report("fit", path, "--free", "ks")))
    peak = rewritten("good.csv", "peak.csv", lambda row: row)
    with open(peak, encoding="utf-8") as file:
        lines = [line for line in file if not line[0].isdigit() or abs(float(line.split(",")[2]) - float(line.split(",")[0])) < 12 and abs(float(line.split(",")[3]) - 180) < 20]
    with open(peak, "w", encoding="utf-8") as file:
        file.writelines(lines)
    rewritten(peak, "brighter.csv", lambda row: row[:4] + [20 * row[4]])
    check("unit" not in verdict(report("fit", "brighter.csv")), "a peak alone proves nothing: %s" % verdict(report("fit", "brighter.csv")))


def sentences_of_lost_samples():
    """Degrees that are read as radians lie below the horizon, most of them."""
    _, status = run("info", "good.csv")
    text = run("fit", "good.csv", "--angles", "radians", "--max-iterations", "5")[0]
    said = re.match(r"(?:The values .*\n)?(\d+) of (\d+) samples lie below the horizon", text)
    check(said and int(said.group(1)) > 0.5 * int(said.group(2)), "lost samples: %s" % text[:200])
    document = report("fit", "good.csv", "--angles", "radians", "--max-iterations", "5")
    check(said and int(said.group(1)) == document["data"]["rejected"]["below_horizon"] and "lost" in verdict(document), "beneath: %s" % document["data"])
    noted = subprocess.run([PROGRAM, "fit", "good.csv", "--angles", "radians", "--max-iterations", "1"], stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, check=False).stderr
    check(b"as asked, where the file says that they are in degrees" in noted, "the file says otherwise: %s" % noted)
    check("lost" not in verdict(report("fit", "good.csv")), "nothing is lost: %s" % verdict(report("fit", "good.csv")))


def sentences_of_fits():
    good = report("fit", "good.csv", "--weight", "noise")
    check(set(verdict(good)) == {"found", "quality"}, "a good fit: %s" % verdict(good))
    check(quality(good) == "good", "a good fit is called %s" % quality(good))
    check(abs(float(verdict(good)["found"].split()[1]) - 0.25) < 0.001, "found: %s" % verdict(good)["found"])
    two = report("fit", "two.csv", "--model", "beckmann+lambert")
    check(quality(two) == "poor" and " compare two.csv" in verdict(two)["next"], "one lobe for two: %s" % verdict(two))
    check("not-told" not in verdict(two), "one lobe for two: %s" % verdict(two))
    coarse = report("fit", "coarse.csv")
    check("--weight noise" in verdict(coarse).get("next", ""), "few carriers: %s" % verdict(coarse))
    by_noise = report("fit", "coarse.csv", "--weight", "noise")
    check("--weight noise" not in verdict(by_noise).get("next", ""), "few carriers, by the noise: %s" % verdict(by_noise))
    stopped = report("fit", "two.csv", "--max-iterations", "1", "--model", "vmf+lambert")
    check(set(verdict(stopped)) == {"not-converged", "next"}, "stopped: %s" % verdict(stopped))
    rewritten("good.csv", "dark.csv", lambda x: x[:-1] + [0])
    dark = report("fit", "dark.csv")
    check(set(verdict(dark)) == {"nothing-found", "next"}, "all values 0: %s" % verdict(dark))
    rewritten("good.csv", "turned.csv", lambda x: x[:3] + [(x[3] + 180) % 360] + x[4:])
    turned = report("fit", "turned.csv")
    check("angles of the file" in verdict(turned).get("next", ""), "turned by 180 degrees: %s" % verdict(turned))
    narrow = report("fit", "narrow.csv", "--loss", "cube-root")
    alpha = narrow["fits"][0]["parameters"]["alpha_x"]
    wide = alpha["interval"] is not None and alpha["interval"][1] > 9 * alpha["interval"][0]
    check(("alpha may be anything" in verdict(narrow).get("not-told", "")) == wide, "a narrow lobe: %s, %s" % (alpha, verdict(narrow)))
    known = report("fit", "good.csv", "--model", "ggx/smith-height-correlated/conductor+lambert", "--free", "ks")
    check("not-told" in verdict(known), "eta, k and ks: %s" % verdict(known))
    diffuse = report("fit", "diffuse.csv", "--model", "lambert")
    check(quality(diffuse) == "good", "a diffuse surface: %s" % verdict(diffuse))
    diffuse = report("fit", "diffuse.csv", "--model", "lambert", "--loss", "ln")
    check(abs(diffuse["fits"][0]["explained"]["share"]) < 0.1, "about the mean of logarithms a constant explains nothing: %s" % verdict(diffuse))
    each = report("fit", "rgb.csv", "--channels", "each")
    check([v["problem"] for v in each["verdict"] if v["code"] == "found"] == [0, 1, 2], "each channel has its own")


def sentences_of_comparisons():
    some = ("--ndf", "beckmann,ggx,student-t,gtr,gaussian", "--masking", "smith-separable,smith-height-correlated,v-cavity")
    for name, word in (("long.csv", "long"), ("short.csv", "short")):
        said = verdict(report("compare", name, *some))["preference"]
        check("prefer %s tails" % word in said, "%s: %s" % (name, said))
    only_long = verdict(report("compare", "long.csv", "--ndf", "ggx,student-t", "--masking", "smith-separable,v-cavity"))["preference"]
    check("tails" not in only_long, "no short tails to choose from: %s" % only_long)
    cavity = verdict(report("compare", "cavity.csv", *some))["preference"]
    check("with the masking v-cavity" in cavity and "Smith" not in cavity, "V-cavity: %s" % cavity)
    smith = verdict(report("compare", "long.csv", *some))["preference"]
    check("with the masking Smith" in smith and "v-cavity" not in smith, "Smith: %s" % smith)
    incidences("good.csv", "one.csv", (45,))
    one = verdict(report("compare", "one.csv", "--ndf", "ggx,beckmann", "--masking", "v-cavity,smith-separable"))
    check("no-test" in one and "preference" not in one, "one incidence: %s" % one)
    bases = verdict(report("compare", "good.csv", "--ndf", "ggx", "--masking", "smith-separable", "--diffuse", "lambert,oren-nayar,eon"))["preference"]
    check(re.match(r"These data do not tell apart [23] of 3 models with ggx/smith-separable; simplest", bases), "diffuse parts: %s" % bases)
    rough = verdict(report("compare", "long.csv", "--ndf", "ggx", "--masking", "smith-separable,smith-height-correlated,v-cavity"))["preference"]
    check(rough.startswith("These data prefer the masking Smith; simplest") or "forms of Smith's" in rough or "tell ggx/" in rough, "maskings of one distribution: %s" % rough)
    poor = verdict(report("compare", "two.csv", "--ndf", "beckmann,gaussian", "--masking", "v-cavity"))
    check("two lobes" in poor["next"], "two lobes: %s" % poor)
    check("no-test" not in poor and "preference" in poor, "six incidences: %s" % poor)
    fine = verdict(report("compare", "long.csv", *some))
    check(" fit long.csv --model ggx/" in fine["next"], "next after a good one: %s" % fine["next"])


def incidences(name, to, kept):
    """The samples of some incidences."""
    with open(name, encoding="utf-8") as source, open(to, "w", encoding="utf-8") as out:
        out.writelines(line for line in source if not line[0].isdigit() or float(line.split(",")[0]) in kept)
    return to


def sentences_of_what_to_measure():
    run("simulate", *"ggx/smith-height-correlated+lambert --set alpha=0.6,f0=0.5,kd=0.02 --grid goniometer:15 --noise 0.25 --seed 1 -o rough.csv".split())
    few = incidences("rough.csv", "few.csv", (0, 15, 30))
    models = ("--ndf", "ggx", "--masking", "smith-height-correlated,v-cavity", "--max-theta", "85")
    tells = report("compare", few, *models, "--reach", "80")
    said = verdict(tells).get("measure", "")
    check(said.startswith("To tell ggx/") and ", measure at theta_i " in said, "two maskings from three steep incidences: %s" % verdict(tells))
    proposal = tells["measure_next"][0]
    degrees = [float(x) for x in re.findall(r"[\d.]+", said.split("theta_i ")[1].split(" degrees")[0])]
    check(degrees == [round(i["theta_i_deg"], 3) for i in proposal["incidences"]], "%s, beneath %s" % (said, proposal))
    check(close(float(said.split("to be ")[1].split()[0]), proposal["then"], 0.06) and close(float(said.split("now ")[1]), proposal["now"], 0.06), "z: %s, beneath %s" % (said, proposal))
    check(verdict(tells)["preference"].startswith("These data do not tell apart Smith and v-cavity; simplest"), "one distribution: %s" % verdict(tells))
    run("simulate", *"ggx/smith-height-correlated+lambert --set alpha=0.6,f0=0.5,kd=0.02 --grid goniometer:15 --noise 0.5 --seed 1 -o noisy.csv".split())
    noisy = verdict(report("compare", incidences("noisy.csv", "few_noisy.csv", (0, 15, 30)), *models, "--reach", "80"))
    check(noisy.get("measure", "").startswith("No three incidences up to theta_i 80 degrees would tell ") and "--reach" in noisy["measure"], "nothing to tell them by: %s" % noisy)
    one = ("--model", "ggx/smith-height-correlated+lambert", "--weight", "noise", "--errors", "noise", "--max-theta", "85")
    alone = report("fit", few, *one, "--reach", "80")
    better = verdict(alone).get("measure", "")
    check(re.match(r"To know \w+ better, measure at theta_i [\d, and]+ degrees: its error would be [\d.]+ of what it is", better), "one model: %s" % verdict(alone))
    parameter = better.split()[2]
    check(parameter == alone["measure_next"][0]["parameter"], "%s, beneath %s" % (better, alone["measure_next"]))
    check(close(float(better.split("would be ")[1].split()[0]), alone["measure_next"][0]["then"] / alone["measure_next"][0]["now"], 0.06), "%s, beneath %s" % (better, alone["measure_next"]))
    check("measure" not in verdict(report("fit", "good.csv", "--weight", "noise")), "what is known well is to be measured again")


def sentences_of_figures():
    """Where the fit is fair or poor a figure of it; what it draws is in the file that it names."""
    for name, words, fair in (("two.csv", ("--model", "beckmann+lambert"), True), ("coarse.csv", ("--max-theta", "60"), None), ("good.csv", (), False),
                              ("two.csv", ("--model", "beckmann+lambert", "--loss", "log"), True), ("rgb.csv", ("--channels", "each", "--model", "vmf"), False),
                              ("two.csv", ("--max-iterations", "1", "--model", "vmf+lambert"), False)):
        document = report("fit", name, *words)
        said = verdict(document)
        called = [v.get("quality") for v in document["verdict"] if v["code"] == "quality"]
        expected = "--channels" not in words and called in (["fair"], ["poor"])
        check(("look" in said) == expected and (fair is None or expected == fair), "%s, %s: %s" % (name, called, said))
    two = report("fit", "two.csv", "--model", "beckmann+lambert", "--loss", "log", "--max-theta", "70")
    said = verdict(two)["look"]
    check("--loss log" in said and "--max-theta 70" in said and "--model beckmann/" in said, "the same fit: %s" % said)
    check((" plot profile " in said) == (two["fits"][0]["explained"]["worst"]["angle"] == "theta_h"), "the figure by the angle of the worst band: %s" % said)
    compared = report("compare", "two.csv", "--ndf", "beckmann,gaussian", "--masking", "v-cavity")
    check("look" in verdict(compared) and "/v-cavity/" in verdict(compared)["look"], "of a comparison: %s" % verdict(compared))
    with open("two.csv", "rb") as file:
        done = subprocess.run([PROGRAM, "fit", "-", "--model", "beckmann+lambert"], stdin=file, stdout=subprocess.PIPE, check=False)
    check(b"Look:" not in done.stdout and b"poor fit" in done.stdout, "standard input cannot be read again")


def pasted(said, folder):
    """Status and standard output of what follows "Next: " or "Look: ", in a shell."""
    command = re.sub("^[A-Z][a-z]+: facetfit", lambda _: "'%s'" % PROGRAM, said)
    done = subprocess.run(["sh", "-c", command], stdout=subprocess.PIPE, stderr=subprocess.PIPE, check=False, cwd=folder)
    return done.returncode, done.stdout, "%s: %s" % (command, done.stderr.decode())


def commands_that_can_be_run():
    """What is to be tried next, pasted into a shell, does something, whatever the file is called."""
    for name in ("it's $(two).csv", "two of them & more.csv", "-two.csv"):
        os.rename("two.csv", name)
        said = verdict(report("fit", "./" + name if name[0] == "-" else name, "--model", "beckmann+lambert"))
        status, out, what = pasted(said["next"], ".")
        check(status == 0 and out, what)
        status, out, what = pasted(said["look"], ".")
        figure = re.search(r"-o (\S+\.svg)", said["look"]).group(1)
        check(status == 0 and os.path.exists(figure), what)
        with open(figure, encoding="utf-8") as file:
            check("beckmann/smith-height-correlated/schlick+lambert" in file.read(), "the figure is of another model: %s" % said["look"])
        os.remove(figure)
        os.rename(name, "two.csv")


# ---- their numbers -------------------------------------------------------------------------------------------------------------


def bands(rows, angle):
    """band: (light, mean, scatter, count)"""
    sums = {}
    for row in rows:
        x = math.cos(math.radians(row["theta_i"]))
        s = sums.setdefault(min(int((row[angle] + 1e-3) / 10), 8), [0, 0, 0, 0])
        for f, y in row["values"]:
            s[0] += 1
            s[1] += (f - y) * x
            s[2] += ((f - y) * x) ** 2
            s[3] += abs(y) * x
    channels = len(rows[0]["values"])
    return {b: (s[3], s[1] / s[3], math.sqrt(s[2] * s[0] / (s[0] / channels)) / s[3], s[0] / channels) for b, s in sums.items() if s[3]}


def worst_of(rows):
    found = None
    for angle in ("theta_i", "theta_h"):
        by = bands(rows, angle)
        light = sum(s[0] for s in by.values())
        for b in sorted(by):
            own, mean, scatter, count = by[b]
            if count < max(5, 0.01 * len(rows)) or own < 0.01 * light or abs(mean) < 2 * scatter:
                continue
            if found is None or abs(mean) > abs(found[2]):
                found = (angle, 10 * b, mean)
    return found


def explained_by_hand(path):
    """By the loss cosine with equal weights, from the file of the residuals."""
    with open(path, encoding="utf-8") as file:
        lines = [line for line in file if not line.startswith("#")]
    rows = []
    for line in csv.DictReader(lines):
        names = [k[6:] for k in line if k.startswith("model_")]
        rows.append({"theta_i": float(line["theta_i"]), "theta_o": float(line["theta_o"]), "theta_h": float(line["theta_h"]),
                     "values": [(float(line["model_" + n]), float(line["f_" + n])) for n in names]})
    left = all_ = 0.0
    near = []
    for c in range(len(rows[0]["values"])):
        w = [math.cos(math.radians(r["theta_i"])) ** 2 for r in rows]
        y = [r["values"][c][1] for r in rows]
        left += sum(a * (r["values"][c][0] - b) ** 2 for a, b, r in zip(w, y, rows))
        all_ += sum(a * b ** 2 for a, b in zip(w, y))
        bright = [r["values"][c][0] * math.cos(math.radians(r["theta_i"])) * math.cos(math.radians(r["theta_o"])) for r in rows]
        near += [abs(r["values"][c][1] / r["values"][c][0] - 1) for r, b in zip(rows, bright) if b >= 0.1 * max(bright)]
    return 1 - left / all_, statistics.median_low(near), len(near), worst_of(rows)


def close(a, b, relative):
    return abs(a - b) <= relative * max(abs(a), abs(b))


def numbers_by_hand(name, *words):
    document = report("fit", name, *words, "--residuals", "residuals.csv")
    said = document["fits"][0]["explained"]
    share, error, count, worst = explained_by_hand("residuals.csv")
    check(close(1 - said["share"], 1 - share, 1e-6), "%s: explains %s, by hand %s" % (name, said["share"], share))
    check(close(said["bright_error"], error, 1e-6), "%s: bright %s, by hand %s" % (name, said["bright_error"], error))
    check(said["bright_values"] == count, "%s: %s bright values, by hand %s" % (name, said["bright_values"], count))
    got = said.get("worst")
    if worst is None or got is None:
        check((worst is None) == (got is None), "%s: worst %s, by hand %s" % (name, got, worst))
        return
    check((got["angle"], got["from_deg"]) == worst[:2] and close(got["mean"], worst[2], 1e-5), "%s: worst %s, by hand %s" % (name, got, worst))


def agrees_in_words(said, e, name):
    """The numbers of the sentence about the quality, each as many digits as it has."""
    share = re.search(r"explains (?:more than )?(all|nothing|[\d.]+)", said).group(1)
    digits = {"all": 100, "nothing": 0}.get(share) if share in ("all", "nothing") else float(share)
    check(abs(digits - 100 * max(e["share"], 0)) <= 0.5 * 10.0 ** -len(share.partition(".")[2]) + 1e-9 or "more than" in said and e["share"] > 0.9999, "%s: %s, beneath %s" % (name, said, e))
    bright = re.search(r"half of the values are within (less than )?([\d.]+) %", said)
    if bright:
        check(100 * e["bright_error"] < 0.05 if bright.group(1) else abs(float(bright.group(2)) - 100 * e["bright_error"]) <= 0.5 * 10.0 ** -len(bright.group(2).partition(".")[2]) + 1e-9,
              "%s: %s, beneath %s" % (name, said, e))
    worst = re.search(r"furthest off at (\w+) (\d+) to (\d+) degrees, too (bright|dark) by ([\d.]+) %", said)
    if worst:
        w = e["worst"]
        check((worst.group(1), int(worst.group(2)), worst.group(4)) == (w["angle"], w["from_deg"], "bright" if w["mean"] > 0 else "dark"), "%s: %s, beneath %s" % (name, said, w))
        check(abs(float(worst.group(5)) - 100 * abs(w["mean"])) <= 0.5 * 10.0 ** -len(worst.group(5).partition(".")[2]) + 1e-9, "%s: %s, beneath %s" % (name, said, w))
    else:
        check("worst" not in e or abs(e["worst"]["mean"]) < 0.005, "%s: the worst band is not said: %s, beneath %s" % (name, said, e))


def agrees(document, name):
    """The text of a verdict and the numbers of the report."""
    compared = len(document["fits"]) > 1
    v = verdict(document)
    if "found" not in v:
        return
    model = v["found"].rsplit(": ", 1)[1]
    fit = [f for f in document["fits"] if f["model"] == model][0]
    if not compared:
        check(fit is document["fits"][0], "%s: of another model" % name)
    alpha = fit["parameters"].get("alpha_x")
    if alpha:
        said = float(v["found"].split("alpha ", 1)[1].split()[0].rstrip(",:"))
        check(close(said, alpha["value"], 0.2) or abs(said - alpha["value"]) < 0.51 * (alpha["interval"][1] - alpha["interval"][0]),
              "%s: alpha %s, beneath %s" % (name, said, alpha["value"]))
    e = fit["explained"]
    good = lambda share, deviation: (e["share"] >= share and e["bright_error"] <= deviation
                                     and abs(e.get("worst", {"mean": 0})["mean"]) <= deviation)
    expected = "good" if good(0.98, 0.1) else "fair" if good(0.9, 0.3) else "poor"
    check(quality(document) == expected, "%s: %s, by its numbers %s" % (name, quality(document), expected))
    agrees_in_words(v["quality"], e, name)
    check(("look" in v) == (expected != "good"), "%s: a figure of a %s fit: %s" % (name, expected, v.get("look")))
    check("look" not in v or model in v["look"], "%s: a figure of another model: %s" % (name, v.get("look")))
    if compared and "preference" in v:
        leaders = [f for f in document["fits"] if f["versus_best"] is None or not f["versus_best"]["told_apart"]
                   or f is document["fits"][document["ranking"][0]]]
        check(model in [f["model"] for f in leaders], "%s: %s is not among those that are not told apart" % (name, model))
        for ndf in {f["ndf"] for f in document["fits"]}:
            leads = ndf in {f["ndf"] for f in leaders}
            words = v["preference"].split("; simplest")[0].replace("(", " ").replace(")", " ").replace(",", " ").replace(";", " ").split()
            if "distributions" not in words and len({f["ndf"] for f in leaders}) > 1:
                check((ndf in words) == leads, "%s: %s leads %s, but: %s" % (name, ndf, leads, v["preference"]))


def paints():
    for path in sorted(glob.glob(os.path.join(DATA, "astm", "*.astm"))):
        name = os.path.basename(path)
        agrees(report("fit", path), name)
        agrees(report("compare", path, "--ndf", "beckmann,ggx,student-t", "--masking", "smith-separable,v-cavity"), name + " compared")


def main():
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        for name, words in FILES.items():
            _, status = run("simulate", *words.split(), "-o", name)
            check(status == 0, "simulate %s" % words)
        sentences_of_units()
        sentences_of_lost_samples()
        sentences_of_fits()
        sentences_of_comparisons()
        sentences_of_what_to_measure()
        sentences_of_figures()
        commands_that_can_be_run()
        numbers_by_hand("coarse.csv")
        numbers_by_hand("two.csv", "--model", "beckmann+lambert")
        numbers_by_hand("rgb.csv")
        for name in FILES:
            agrees(report("fit", name), name)
        agrees(report("compare", "short.csv"), "short.csv compared")
        paints()
        check(SAID == codes(), "never said here: %s" % (codes() - SAID))
        check(UNSAID == codes(), "always said here: %s" % (codes() - UNSAID))
        os.chdir("/")
    print("%d checks, %d failures" % (CHECKS[0], len(FAILURES)))
    return bool(FAILURES)


if __name__ == "__main__":
    sys.exit(main())
