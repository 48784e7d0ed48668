#!/usr/bin/env python3
"""Pages of --html: what is in them, and what they do in a browser.

usage: pages_test.py FACETFIT SHARED contents|drive [--all]

contents: they are HTML that closes what it opens, JSON that reads, within their limits of size, and safe whatever files and channels are
called. drive: a browser works on a page of a fit (drive.mjs); with --all also on a comparison, a table, a MERL file, 31 channels, one
incidence, a surface with a direction, a model that is a table, a fit that failed, and on measured gold where SHARED has it."""
import hashlib
import html.parser
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile

program, shared, part = os.path.abspath(sys.argv[1]), sys.argv[2], sys.argv[3]
everything = "--all" in sys.argv
HERE = os.path.dirname(os.path.abspath(__file__))
FIT_MOST, COMPARISON_MOST = 1000000, 2000000
VOID = {"meta", "br", "img", "input", "hr", "link"}
failures = 0


def check(good, what):
    global failures
    if not good:
        failures += 1
        print("failed:", what)


def run(*args, statuses=(0,), cwd=None):
    done = subprocess.run([program, *args], capture_output=True, text=True, cwd=cwd or scratch, check=False)
    check(done.returncode in statuses, f"{' '.join(args)}: status {done.returncode}: {done.stderr[-500:]}")
    return done


class Reader(html.parser.HTMLParser):
    """Elements that are open, ids, and what would ask for something."""

    def __init__(self):
        super().__init__(convert_charrefs=True)
        self.open, self.ids, self.wrong, self.text = [], [], [], []

    def handle_starttag(self, tag, attributes):
        attributes = dict(attributes)
        if "id" in attributes:
            self.ids.append(attributes["id"])
        for name in ("src", "href", "xlink:href", "action", "data"):
            value = attributes.get(name)
            if value and not value.startswith(("#", "data:")):
                self.wrong.append(f"{tag} {name}={value[:60]}")
        for name in attributes:
            if name.startswith("on"):
                self.wrong.append(f"{tag} {name}")
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attributes):
        self.handle_starttag(tag, attributes)
        if tag not in VOID:
            self.open.pop()

    def handle_endtag(self, tag):
        if not self.open or self.open.pop() != tag:
            self.wrong.append(f"</{tag}> closes nothing")

    def handle_data(self, data):
        if self.open and self.open[-1] not in ("script", "style"):
            self.text.append(data)


def read(path, most, what):
    size = os.path.getsize(path)
    check(size < most, f"{what}: {size} bytes, at most {most}")
    with open(path, encoding="utf-8") as f:
        text = f.read()
    reader = Reader()
    reader.feed(text)
    reader.close()
    check(not reader.wrong, f"{what}: {reader.wrong[:5]}")
    check(not reader.open, f"{what}: open at the end: {reader.open}")
    check(len(set(reader.ids)) == len(reader.ids), f"{what}: ids twice: {sorted(i for i in set(reader.ids) if reader.ids.count(i) > 1)[:5]}")
    check(not re.search(r"(url\(|@import|fetch\(|XMLHttpRequest|https?://(?!www\.w3\.org))", re.sub(r"url\(#", "", text)), f"{what}: names a place elsewhere")
    parts = {}
    for name, body in re.findall(r'<script type="application/json" id="([^"]*)">(.*?)</script>', text, re.S):
        check(not re.search("[<>&\u2028\u2029]", body), f"{what}: {name} is not safe in a script element")
        parts[name] = json.loads(body)
    return "".join(reader.text), parts


def make_data():
    rgb = ["--set", "alpha=0.3,f0=0.5:0.4:0.3,kd=0.2"]
    run("simulate", "ggx/v-cavity+lambert", "--set", "alpha=0.45,f0=0.9:0.6:0.3,kd=0.1:0.05:0.02", "--grid", "goniometer", "--noise", "0.02", "-o", "demo.csv")
    run("simulate", "ggx+lambert", *rgb, "--grid", "goniometer:15", "--noise", "0.02", "-o", "small.csv")
    run("simulate", "ggx+lambert", "--set", "alpha_x=0.15,alpha_y=0.5,f0=0.9:0.6:0.3,kd=0.1", "--grid", "goniometer:5", "--noise", "0.02", "-o", "turned.csv")
    many = ":".join(f"{0.3 + 0.01 * k:.2f}" for k in range(31))
    run("simulate", "ggx+lambert", "--set", f"alpha=0.2,f0={many},kd=0.1", "--grid", "goniometer:5", "--noise", "0.01", "-o", "many.csv")
    with open(os.path.join(scratch, "small.csv"), encoding="utf-8") as f:
        lines = f.read().splitlines()
    head = next(k for k, line in enumerate(lines) if "theta_i" in line)
    column = lines[head].split(",").index("theta_i")
    one = [r for r in lines[head + 1:] if abs(float(r.split(",")[column]) - 45) < 0.1]
    with open(os.path.join(scratch, "one.csv"), "w", encoding="utf-8") as f:
        f.write("\n".join(lines[:head + 1] + one) + "\n")


def same_samples(parts, what):
    """The samples that the fit used, where the page has all."""
    page, result = parts["page"], parts["result"]
    s = page["samples"]
    check(s["step"] == 1 and s["of"] == result["data"]["samples"], f"{what}: not all samples are on the page")
    check(sum(1 for k in range(s["even"]) if s["why"][k] == 0) == result["data"]["used"], f"{what}: the used samples are others")
    for reason, number in (("grazing", 3), ("invalid", 1), ("below_horizon", 2)):
        check(sum(1 for k in range(s["even"]) if s["why"][k] == number) == result["data"]["rejected"][reason], f"{what}: {reason}")


def units(parts, what, ways):
    """The figure in renderers' units has what `convert` says. ways: label, convention, its name of the number, convention wanted, criterion."""
    panels = {p["x"]["label"]: p for p in parts["units-numbers"]["panels"]}
    check(sorted(panels) == sorted(w[0] for w in ways), f"{what}: units {sorted(panels)}")
    fit = parts["result"]["fits"][parts["page"]["shown"]]
    for label, convention, symbol, wanted, *by in ways:
        panel = panels.get(label, {"y": {"names": []}})
        check(panel["y"]["names"], f"{what}: {label}: no rows")
        for k, row in enumerate(panel["y"]["names"]):
            name, _, channel = row.partition("[")
            p, s = fit["parameters"][name], panel["series"][0]
            at = fit["channels"].index(channel.rstrip("]")) if channel else None
            given = [v if at is None else v[at] for v in (p["value"], p["interval"])]
            shown = [s["x"][k], *sorted((s["x_low"][k], s["x_high"][k]))]
            own = []
            for x in (given[0], *given[1]):
                words = run("convert", "--from", convention, "--to", wanted, *(["--by", by[0]] if by else []), f"{symbol}={x!r}").stdout.split()
                own.append(float(words[1]))
            own = [own[0], *sorted(own[1:])]
            check(all(abs(a - b) <= 6e-6 * abs(b) for a, b in zip(shown, own)), f"{what}: {label} of {row}: {shown}, not {own}")


# ---- contents ----------------------------------------------------------------------------------------------------------------------------


def contents():
    run("fit", "small.csv", "--html", "fit.html")
    text, parts = read(os.path.join(scratch, "fit.html"), FIT_MOST, "a fit")
    same_samples(parts, "a fit")
    with open(os.path.join(scratch, "small.csv"), "rb") as f:
        digest = hashlib.sha256(f.read()).hexdigest()
    for wanted in (digest, "fit small.csv --html fit.html", "@article{heitz2014", "alpha_x", "95 % interval", "Samples, and why some were left out"):
        check(wanted in text, f"a fit: '{wanted}' is not in its text")
    check({"result", "page"} <= set(parts), f"a fit: {sorted(parts)}")
    run("fit", "small.csv", "--max-theta", "50", "--html", "cut.html")
    _, parts = read(os.path.join(scratch, "cut.html"), FIT_MOST, "up to 50 degrees")
    check(parts["result"]["data"]["rejected"]["grazing"] > 20, "up to 50 degrees: hardly a sample is left out")
    same_samples(parts, "up to 50 degrees")
    ior = ("index of refraction", "f0", "f0", "eta")
    units(read(os.path.join(scratch, "fit.html"), FIT_MOST, "a fit")[1], "a fit", [("perceptual roughness", "ggx", "alpha", "roughness"), ("exponent of Phong", "ggx", "alpha", "phong", "peak"), ior])
    run("fit", "small.csv", "--model", "phong+lambert", "--html", "phong.html")
    units(read(os.path.join(scratch, "phong.html"), FIT_MOST, "phong")[1], "phong", [("perceptual roughness", "phong", "n", "roughness", "peak"), ("m of Beckmann", "phong", "n", "beckmann"), ior])
    run("fit", "small.csv", "--model", "gtr/smith-separable/dielectric+lambert", "--html", "gtr.html")
    units(read(os.path.join(scratch, "gtr.html"), FIT_MOST, "gtr")[1], "gtr", [("F0", "eta", "eta", "f0")])
    run("compare", "small.csv", "--ndf", "ggx,beckmann", "--html", "compare.html")
    text, parts = read(os.path.join(scratch, "compare.html"), COMPARISON_MOST, "a comparison")
    check("not told apart from the best" in text and len(parts["result"]["fits"]) > 10, "a comparison")
    run("info", "small.csv", "--html", "info.html")
    text, parts = read(os.path.join(scratch, "info.html"), FIT_MOST, "a table")
    check("reciprocity" in text and parts["table"]["schema"].startswith("facetfit.info/"), "a table")
    run("fit", "many.csv", "--html", "many.html")
    read(os.path.join(scratch, "many.html"), FIT_MOST, "31 channels")
    run("fit", "small.csv", "--channels", "each", "--html", "each.html")
    read(os.path.join(scratch, "each.html"), FIT_MOST, "each channel")
    run("fit", "small.csv", "--model", "ggx+kelemen-matte", "--html", "tabled.html")
    read(os.path.join(scratch, "tabled.html"), FIT_MOST, "a model that is tabled")
    run("fit", "small.csv", "--weight", "noise", "--html", "noise.html")
    read(os.path.join(scratch, "noise.html"), FIT_MOST, "weights by the noise")
    names_of_others()
    run("fit", "one.csv", "--html", "one.html", statuses=(0, 1))
    read(os.path.join(scratch, "one.html"), FIT_MOST, "one incidence")
    refusals()


def names_of_others():
    """Names that would end a script element, an attribute or a comment."""
    evil = "<!--</script><script>window.evil=1<\u2028\"'&amp;.csv"
    with open(os.path.join(scratch, "small.csv"), encoding="utf-8") as f:
        data = f.read().replace("f_r", '"f_</script><b>"', 1)
    with open(os.path.join(scratch, evil.replace("/", "\u2215")), "w", encoding="utf-8") as f:
        f.write(data)
    for command in ("fit", "info", "compare"):
        more = ["--ndf", "ggx", "--masking", "v-cavity,kelemen"] if command == "compare" else []
        done = run(command, evil.replace("/", "\u2215"), *more, "--html", "evil.html", statuses=(0, 1, 3))
        if done.returncode == 3:
            check(False, f"{command} of a file with such a name: {done.stderr}")
            continue
        with open(os.path.join(scratch, "evil.html"), encoding="utf-8") as f:
            text = f.read()
        check("<b>" not in text and "<script>window.evil" not in text, f"{command}: a name is not escaped")
        read(os.path.join(scratch, "evil.html"), COMPARISON_MOST, f"{command} of a name that is code")


def refusals():
    done = run("fit", "small.csv", "--html", "small.csv", statuses=(2,))
    check("--html" in done.stderr, done.stderr)
    done = run("fit", "small.csv", "--html", "nowhere/a.html", statuses=(4,))
    check("nowhere/a.html" in done.stderr, done.stderr)
    done = run("fit", "small.csv", "--html", "a.html", "--json", "a.html", statuses=(2,))
    run("fit", "small.csv", "--html", "/dev/full", statuses=(4,))
    left = [n for n in os.listdir(scratch) if ".part-" in n or n == "a.html"]
    check(not left, f"left behind: {left}")


# ---- in a browser ------------------------------------------------------------------------------------------------------------------------


def drive(kind, name, most):
    path = os.path.join(scratch, name)
    read(path, most, name)
    done = subprocess.run([shutil.which("node"), os.path.join(HERE, "drive.mjs"), kind, path], capture_output=True, text=True, check=False, timeout=600)
    print(f"{name}: {done.stdout.strip()}")
    if done.returncode == 77:
        sys.exit(77)
    check(done.returncode == 0, f"{name}: status {done.returncode}: {done.stderr[-800:]}")


def in_browser():
    if not shutil.which("node"):
        print("skipped: node is not there (./setup renderers)")
        sys.exit(77)
    run("fit", "demo.csv" if everything else "small.csv", "--html", "demo.html")
    drive("fit", "demo.html", FIT_MOST)
    if not everything:
        return
    run("compare", "demo.csv", "--ndf", "ggx,beckmann,gtr", "--html", "compare.html")
    drive("comparison", "compare.html", COMPARISON_MOST)
    run("info", "demo.csv", "--html", "info.html")
    drive("table", "info.html", FIT_MOST)
    run("simulate", "ggx+lambert", "--set", "alpha=0.12,f0=0.9:0.6:0.3,kd=0.1", "--grid", "merl", "--noise", "0.02", "-o", "made.binary")
    run("fit", "made.binary", "--html", "merl.html")
    drive("fit", "merl.html", FIT_MOST)
    run("compare", "made.binary", "--ndf", "ggx,beckmann,student-t", "--html", "merl-compare.html", statuses=(0, 1))
    drive("comparison", "merl-compare.html", COMPARISON_MOST)
    run("fit", "many.csv", "--html", "many.html")
    drive("fit", "many.html", FIT_MOST)
    run("fit", "turned.csv", "--html", "turned.html")
    drive("fit", "turned.html", FIT_MOST)
    run("compare", "turned.csv", "--ndf", "ggx,beckmann", "--masking", "smith-height-correlated,v-cavity,none", "--html", "turned-compare.html", statuses=(0, 1))
    drive("comparison", "turned-compare.html", COMPARISON_MOST)
    run("fit", "small.csv", "--model", "ggx+kelemen-matte", "--html", "tabled.html")
    drive("tabled", "tabled.html", FIT_MOST)
    run("fit", "one.csv", "--html", "one.html", statuses=(0, 1))
    drive("in-plane", "one.html", FIT_MOST)
    run("fit", "demo.csv", "--model", "student-t+lambert", "--max-iterations", "1", "--html", "failed.html", statuses=(1,))
    drive("failed", "failed.html", FIT_MOST)
    gold = os.path.join(shared, "data", "astm", "C9_Gold.astm")
    if os.path.exists(gold):
        run("fit", gold, "--html", "gold.html")
        drive("fit", "gold.html", FIT_MOST)
    else:
        print(f"{gold} is not there: left out")


with tempfile.TemporaryDirectory() as scratch:
    make_data()
    if part == "contents":
        contents()
    else:
        in_browser()
sys.exit(failures != 0)
