#!/usr/bin/env python3
"""make_corpus_texts.py PROGRAM: writes the seeds of the fuzzers of texts that are no measurements into corpus/ beside this file: JSON,
results of fits (made by the program from what it simulates), expressions, command lines."""
import json
import os
import subprocess
import sys
import tempfile

here = os.path.join(os.path.dirname(os.path.abspath(__file__)), "corpus")
program = os.path.abspath(sys.argv[1])


def write(name, content):
    path = os.path.join(here, name)
    os.makedirs(os.path.dirname(path), exist_ok=True)
    with open(path, "wb") as f:
        f.write(content if isinstance(content, bytes) else content.encode())


def run(*words):
    subprocess.run([program, *words], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def document(name, *words):
    """Without what changes from run to run, and what is long and not read."""
    run(*words, "--json", "d.json")
    with open("d.json", encoding="utf-8") as f:
        d = json.load(f)
    for key in ("command", "verdict", "measure_next", "constraints", "groups"):
        d.pop(key, None)
    for i, fit in enumerate(d["fits"]):
        for key in ("time_s", "cut_off", "warnings", "ellipse", "explained", "aic", "bic", "condition") + ("residual_bands",) * (i > 0):
            fit.pop(key, None)
    write("fit_document/" + name, json.dumps(d, separators=(",", ":")) + "\n")


with tempfile.TemporaryDirectory() as folder:
    os.chdir(folder)
    run(*"simulate ggx+lambert --set alpha=0.3,f0=0.5:0.4:0.3,kd=0.2 --grid scattered:60 --noise 0.01 -o rgb.csv".split())
    run(*"simulate ggx+lambert --set alpha=0.3,f0=0.5,kd=0.2 --grid scattered:60 --noise 0.01 -o one.csv".split())
    document("one.json", "fit", "one.csv")
    document("rgb.json", "fit", "rgb.csv", "--model", "lambert")
    document("held.json", "fit", "one.csv", "--fix", "f0=0.5")
    document("two.json", "compare", "one.csv", "--ndf", "ggx,beckmann", "--masking", "smith-separable", "--fresnel", "schlick", "--diffuse", "lambert")

write("fit_document/short.json", '{"schema": "facetfit/fit", "fits": [{"model": "lambert", "channels": ["c0"], "parameters": {}}]}')
write("json/values.json", '{"a": [1, -0.5, 1e-3, 2E+5, true, false, null, ""], "b": {"c": {}, "d": []}, "a": 2}\n')
write("json/escapes.json", r'["\"\\\/\b\f\n\r\t", "\u00e9\u20ac", "\ud83d\ude00", "é€😀"]')
write("json/deep.json", "[" * 64 + "]" * 64)
write("json/too-deep.json", '{"a":' * 65 + "1" + "}" * 65)
write("json/numbers.json", "[0, -0, 1.7976931348623157e308, 5e-324, 123456789012345678901234567890, 0.1, 1e-400]")
write("json/cut.json", '{"a": "b')
write("json/bytes.json", b'["\xc3\x28", "\xed\xa0\x80"]')
for i, text in enumerate(("ggx+lambert\nalpha=0.3", "beckmann/smith-separable/schlick+lambert\nf0=0.04:0.05", "ggx/vcavity/shared+ggx+lambert\nlobe2.alpha=0.1",
                          "student-t/smith-height-correlated/conductor\ngamma=2", "lambert\nkd=0.5", "relative=0.02,floor=1e-4\n", "relative=0.1\n",
                          "merl\n", "goniometer:15\n", "scattered:100:0.5\n", "theta_i=1,phi_i=0,theta_o=2,phi_o=180,f=3\n",
                          "theta_i=a b,theta_o=-c,f=d\n")):
    write("expressions/%02d" % i, text)
for name, words in (("fit", "fit a.csv --model ggx+lambert --bound alpha=0.05:0.5 --fix f0=0.04:0.05:0.06 --prior kd=0.2+-0.01 --tie f0"),
                    ("names", "fit a.csv --bound f0[r]=0.1:0.2 --prior f0[g]=0.04±0.01 --fix kd[b]=0.1 --tie alpha=f0 --free ior"),
                    ("choices", "fit a.csv --loss auto --weight sigma --max-theta 80 --threads 2 --robust cauchy --errors sandwich --no-progress"),
                    ("compare", "compare a.csv --ndf ggx,beckmann --masking all --top 5 --table csv --json=b.json"),
                    ("ndf", "ndf a.csv -o t.csv --smooth 0.1 --nodes 30 --monotone yes"),
                    ("simulate", "simulate ggx --set alpha=0.3 --grid goniometer:5 -o x.exr --noise 0.1 --seed 7"),
                    ("plot", "plot slice a.csv --incidence 30 --log -o p.svg"), ("lines", "furnace ggx --mu 0.1,0.5,1 --weak"),
                    ("wrong", "fit --modle x --bound alpha=2:1 --json --table nothing -"), ("sample", "sample ggx -n 10 --theta 30 --phi=-5")):
    write("words/" + name, words.replace(" ", "\n"))
