#!/usr/bin/env python3
"""again_test.py PROGRAM: what follows "Next:" and "Look:" is the person's own command line with what it changes. Each is pasted into a
shell, and the same data were read in the same way: as many samples, the same loss, the same fit where the same model is fitted."""
import json
import math
import os
import re
import shlex
import subprocess
import sys
import tempfile

PROGRAM = os.path.abspath(sys.argv[1])
CHECKS = [0, 0]
WRITES = {"--json", "--html", "--residuals", "--summary", "-o", "--output", "--table"}


def check(held, what):
    CHECKS[0] += 1
    if not held:
        CHECKS[1] += 1
        print("failed:", what)


def run(words):
    return subprocess.run([PROGRAM, *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE, check=False)


def report(words):
    done = run([words[0], "--json", "-", *words[1:]])
    try:
        return json.loads(done.stdout)
    except ValueError:
        check(False, "%s: status %d, %s" % (words, done.returncode, done.stderr.decode()))
        return None


def suggested(document):
    """code: words of the command line, as a shell takes them apart; a comment is none"""
    said = {}
    for v in document["verdict"]:
        if v["code"] in ("next", "look") and ": facetfit " in v["text"]:
            said[v["code"]] = shlex.split(v["text"].split(": facetfit ", 1)[1], comments=True)
    return said


# ---- files -----------------------------------------------------------------------------------------------------------------------


def rows_of(name):
    with open(name, encoding="utf-8") as file:
        lines = [line for line in file if line[0] != "#"]
    return [[float(x) for x in line.split(",")] for line in lines[1:]]


def write(name, header, rows, separator=",", decimal="."):
    with open(name, "w", encoding="utf-8") as out:
        out.write(header + "\n")
        for row in rows:
            out.write(separator.join(("%.17g" % x).replace(".", decimal) for x in row) + "\n")


def files():
    two = "ggx+ggx+lambert --set alpha=0.08,f0=%s,lobe2.alpha=0.6,lobe2.f0=0.3,kd=0.05 --grid goniometer:15 --noise 0.01 --seed 1 -o %s"
    for f0, name in (("0.5", "two.csv"), ("0.5:0.3:0.2", "rgb.csv")):
        check(run(["simulate", *(two % (f0, name)).split()]).returncode == 0, name)
    rows = rows_of("two.csv")
    names = "theta_i,phi_i,theta_o,phi_o,f"
    cosine = lambda row: math.cos(math.radians(row[2]))
    write("cos.csv", names, [row[:4] + [row[4] * cosine(row)] for row in rows])
    write("own.csv", "q,p,z,y,x", [row[::-1] for row in rows])
    write("de.csv", "theta_i;phi_i;theta_o;phi_o;f", rows, ";", ",")
    write("rad.csv", names, [[math.radians(x) for x in row[:4]] + row[4:] for row in rows])
    write("mirror.csv", names, [row[:3] + [(row[3] + 180) % 360] + row[4:] for row in rows])
    write("clockwise.csv", names, [row[:3] + [-row[3]] + row[4:] for row in rows])
    write("double.csv", names, [row[:4] + [2 * row[4]] for row in rows])
    write("waves.csv", "theta_i,phi_i,theta_o,phi_o,wavelength,f", [row[:4] + [w, row[4] * w / 500] for row in rows for w in (500, 600)])
    write("half 'a'.csv", names, [row for row in rows if row[0] < 35])
    write("-b.csv", names, [row for row in rows if row[0] >= 35])


# Command lines; with --json what they say is read. Each is poor or fair, so that both lines are said.
B = "--model beckmann+lambert "
LINES = [
    "fit cos.csv --quantity brdf-cos " + B,
    "fit cos.csv --quantity brdf-cos --loss log --max-theta 70 " + B,
    "compare cos.csv --quantity brdf-cos --loss log --max-theta 70 --ndf beckmann,gaussian --masking v-cavity",
    "fit own.csv --columns 'theta_i=x,phi_i=y,theta_o=z,phi_o=p,f=q' " + B,
    "fit de.csv --dialect separator=semicolon,decimal=comma " + B,
    "fit rad.csv --angles radians " + B,
    "fit mirror.csv --azimuth mirror " + B,
    "fit clockwise.csv --phi clockwise-out " + B,
    "fit double.csv --scale 0.5 " + B,
    "fit rgb.csv --reduce channels:g " + B,
    "fit rgb.csv --channels mean --shape axis " + B,
    "fit two.csv --channels each " + B,
    "fit waves.csv --part 600nm " + B,
    "fit two.csv --format csv --as-is --weight sample --errors residuals " + B,
    "fit two.csv --loss auto " + B,
    "fit two.csv --robust huber " + B,
    "fit two.csv --fix f0=0.4 --bound alpha=0.05:0.5 --prior kd=0.05+-0.01 --max-iterations 60 --threads 2 " + B,
    "fit two.csv --fix f0=1.5 --bound f0=0:2 " + B,
    "fit rgb.csv --tie f0 --free ks --fix kd=0.05:0.06:0.07 --model beckmann/smith-separable/schlick+lambert",
    "fit two.csv --model beckmann/smith-separable/conductor+oren-nayar",
    "fit two.csv --aperture 1:square --source 0.5 --saturation 100 --noise-floor 0.001 --negative drop " + B,
    "fit two.csv --weight noise --bootstrap 20 --seed 3 --reach 75 --cut-off 60 --no-progress " + B,
    "fit two.csv --html p.html --residuals r.csv --no-times --wide " + B,
    "compare two.csv --ndf gtr,beckmann --masking v-cavity --fix gamma=2 --cross-validate 3 --rows 3",
    "compare rgb.csv --ndf beckmann --masking v-cavity --fresnel schlick --diffuse lambert,oren-nayar --bound 'kd[r]=0:0.5'",
    "fit two.csv --for blender",
    "fit two.csv --for blender:dielectric --loss log",
    "compare two.csv --for blender,unreal --max-theta 70",
    "fit 'half '\\''a'\\''.csv' ./-b.csv " + B,
    "fit " + B + "-- -b.csv",
]


def flags_of(words):
    """Flags of a command line with what follows each."""
    return [tuple(words[k:k + 2]) if k + 1 < len(words) and not re.match("-[-a-z]", words[k + 1]) else (words[k],)
            for k in range(len(words)) if re.match("-[-a-z]", words[k]) and words[k] != "--" and not words[k].endswith(".csv")]


def same_reading(a, b, what):
    for key in ("format", "samples", "used", "rejected", "negative", "channels", "saturated_values", "values_below_noise"):
        check(a["data"][key] == b["data"][key], "%s: %s: %s and %s" % (what, key, a["data"][key], b["data"][key]))


def same_fit(a, b, what):
    close = lambda x, y: x == y or (x is not None and y is not None and abs(x - y) <= 1e-5 * max(abs(x), abs(y), 1e-3))
    for name, p in a["parameters"].items():
        x, y = p["value"], b["parameters"][name]["value"]
        pairs = zip(x, y) if isinstance(x, list) else [(x, y)]
        check(all(close(u, v) for u, v in pairs), "%s: %s is %s and %s" % (what, name, x, y))


def pasted(document, code, words, what):
    """What comes of a line in a shell. A figure is drawn; then its flags are those of the fit that it shows."""
    text = [v["text"] for v in document["verdict"] if v["code"] == code][0].split(": facetfit ", 1)[1]
    if code == "next":
        text = text.replace(" ", " --json - ", 1)
    done = subprocess.run(["sh", "-c", "'%s' %s" % (PROGRAM, text)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, check=False)
    check(done.returncode in (0, 1), "%s: status %d, %s" % (what, done.returncode, done.stderr.decode()))
    if code == "next":
        return json.loads(done.stdout) if done.returncode in (0, 1) else None
    at = words.index("-o")
    check(os.path.exists(words[at + 1]), "%s: %s is not there" % (what, words[at + 1]))
    return report(["fit"] + words[2:at] + words[at + 2:])


def look_at(line):
    words = shlex.split(line)
    document = report(words)
    if not document:
        return
    said = suggested(document)
    joins, for_renderer = words[0] != "plot" and len([w for w in words if w.endswith(".csv")]) > 2, "--for" in words
    check("next" in said or "look" in said, "%s: nothing is suggested" % line)
    check("look" not in said if joins or for_renderer else True, "%s: %s" % (line, said.get("look")))
    for code, other in said.items():
        what = "%s\n    %s: %s" % (line, code, " ".join(other))
        check(not {w for w in other if w in WRITES and code == "next"}, "%s: it writes what the first one wrote" % what)
        own = {f[0] for f in flags_of(other)}
        lost = [f for f in flags_of(words) if f[0] not in own and f[0] not in WRITES | {"--model", "--ndf", "--masking", "--fresnel", "--diffuse", "--for", "--no-times", "--wide", "--rows", "--no-progress", "--threads"}]
        questions = {"--bootstrap", "--seed", "--cut-off", "--cross-validate", "--reach"}
        asked = {f[0] for f in lost} - questions - ({"--channels"} if "each" in words else set())
        asked -= {"--fix"} if "gamma=2" in words and not any(w.startswith("gtr/") for w in other) else set()
        check(not asked or (code == "look" and asked <= questions), "%s: %s are lost" % (what, asked))
        again = pasted(document, code, other, what)
        if not again:
            continue
        same_reading(document, again, what)
        check(document["loss"]["name"] == again["loss"]["name"] or "--weight noise" in what, "%s: the loss is %s and %s" % (what, document["loss"], again["loss"]))
        check(document["loss"]["max_theta_deg"] == again["loss"]["max_theta_deg"], what)
        by_model = {f["model"]: f for f in again["fits"]}
        common = [f for f in document["fits"] if f["model"] in by_model and (not f.get("target") or f["target"] == by_model[f["model"]].get("target"))]
        check(common or code == "next", "%s: the figure is of another model" % what)
        of_all = code == "next" and {"--robust", "--weight"} & own and "sample" not in words  # one scale, and one noise, of all models that are compared
        if not of_all:
            for f in common[:1]:
                same_fit(f, by_model[f["model"]], what)


def batch():
    """What a batch writes of a file is of that file alone."""
    done = run(["fit", "two.csv", "rgb.csv", *B.split(), "--loss", "log", "-o", "fits", "--summary", "all.csv", "-j", "1"])
    check(done.returncode == 0, done.stderr.decode())
    for name in ("two.csv", "rgb.csv"):
        with open("fits/%s.json" % name, encoding="utf-8") as file:
            said = suggested(json.load(file))
        check(said.get("next") == ["compare", name, "--loss", "log"], "a batch: %s" % said)


def long_lines():
    """What has no room is not said in half."""
    for k in range(60):
        write("file number %03d of many that are one measurement.csv" % k, "theta_i,phi_i,theta_o,phi_o,f", rows_of("two.csv")[k::60])
    document = report(["fit", *sorted(f for f in os.listdir(".") if f.startswith("file number")), *B.split()])
    check(document and not suggested(document), "60 files: %s" % (document and suggested(document)))


def main():
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        files()
        for line in LINES:
            look_at(line)
        batch()
        long_lines()
        os.chdir("/")
    print("%d checks, %d failures" % tuple(CHECKS))
    return CHECKS[1] > 0


if __name__ == "__main__":
    sys.exit(main())
