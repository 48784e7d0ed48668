#!/usr/bin/env python3
"""threads_test.py PROGRAM [--little]: every command with four threads writes what it writes with one, to the last digit, and under
ThreadSanitizer nothing is reported (its exit status is 66).

What commands there are, and which have --threads, comes from --help: one that is not in LINES fails the test. --little takes small data,
for a sanitizer."""
import os
import re
import subprocess
import sys
import tempfile

program = os.path.abspath(sys.argv[1])
little = "--little" in sys.argv
SAMPLES = 600 if little else 20000 if os.environ.get("FF_TEST_THOROUGH") else 4000
DATA = "simulate ggx+lambert --set alpha=0.3,f0=0.5:0.4:0.3,kd=0.2 --noise 0.03 --seed 3 -o data.csv --grid scattered:%d" % SAMPLES
KINDS = {"slice": "data.csv", "polar": "data.csv", "profile": "data.csv", "image": "data.csv", "residuals": "data.csv", "coverage": "data.csv", "ndf": "ggx beckmann",
         "masking": "ggx beckmann", "fresnel": "ggx", "albedo": "ggx+lambert", "forest": "data.csv", "correlation": "data.csv", "likelihood": "data.csv",
         "bootstrap": "data.csv --bootstrap 20", "sweep": "data.csv"}
LINES = {
    "fit": ["fit data.csv --residuals r.csv --json j.json", "fit data.csv --profile --json j.json", "fit data.csv --channels each --loss cosine --json j.json", "fit data.csv --bootstrap 30 --seed 5 --json j.json",
            "fit data.csv --weight noise --reach 5 --json j.json", "fit data.csv --robust cauchy --cut-off 40 --json j.json"],
    "compare": ["compare data.csv --ndf ggx,beckmann,student-t --masking smith-separable,v-cavity --fresnel schlick --diffuse lambert --cross-validate 4 --json j.json"],
    "gather": ["gather fits --summary s.csv --html i.html"], "diff": ["diff old.csv old.csv"],
    "ndf": ["ndf data.csv -o t.csv --json j.json"],
    "resample": ["resample data.csv out.exr --json j.json", "resample data.csv out.utia --to utia"],
    "plot": ["plot %s %s -o p.csv" % kind for kind in KINDS.items()] + ["plot slice data.csv -o p.svg", "plot slice data.csv -o p.pdf"],
    "convert": ["convert --list"], "eval": ["eval ggx+lambert directions.csv --json j.json"],
    "simulate": ["simulate ggx+lambert --grid goniometer:15 --noise 0.1 -o out.csv", "simulate ggx+lambert --grid merl -o out.binary"],
    "furnace": ["furnace ggx --mu 0.2,0.7", "furnace student-t --set alpha_x=0.1,alpha_y=1,r_xy=0.8 --weak --mu 0.5"], "sample": ["sample ggx -n 2000"],
    "info": ["info data.csv --json j.json"],
    "render": ["render data.csv --size 24 -o r.exr", "render ggx+lambert --environment sky --samples 16 --size 24 -o r.png --json j.json"],
    "export": ["export fit.json --to gltf -o e.gltf"], "models": ["models", "models --markdown"], "selftest": ["selftest"], "formats": ["formats"], "man": ["man fit"], "completion": ["completion bash"],
}
STABLE = re.compile(rb'"time_s": [^,}\n]*|"threads": [^,}\n]*|--threads[",= ]*[14]|/CreationDate[^\n]*|[0-9][0-9.e+]* m?s(?=[,;\n])')
failures = runs = 0


def fail(text):
    global failures
    failures += 1
    print("failed: " + text)


def outputs(before):
    """Standard output comes beside it: what the files hold that were not there."""
    found = {}
    for name in sorted(set(os.listdir(".")) - before):
        with open(name, "rb") as f:
            found[name] = STABLE.sub(b"", f.read())
        os.remove(name)
    return found


def run(words):
    global runs
    runs += 1
    before = set(os.listdir("."))
    p = subprocess.run([program, *words], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, check=False, timeout=1500)
    if p.returncode not in (0, 1):
        fail("%s: ends with %d: %s" % (" ".join(words), p.returncode, p.stderr.decode(errors="replace")[-3000:]))
    return p.returncode, STABLE.sub(b"", p.stdout), outputs(before)


def first_difference(a, b):
    for one, other in zip(a.splitlines(), b.splitlines()):
        if one != other:
            return "%s | %s" % (one[:200], other[:200])
    return "one is longer"


def try_line(line, has_threads):
    words = line.split()
    if not has_threads:
        run(words)
        return
    four, one = run(words + ["--threads", "4"]), run(words + ["--threads", "1"])
    if four[0] != one[0] or four[1] != one[1]:
        fail("%s: four threads print something else than one: %s" % (line, first_difference(four[1], one[1])))
    for name in set(four[2]) | set(one[2]):
        if four[2].get(name) != one[2].get(name):
            fail("%s: four threads write another %s than one" % (line, name))


def main():
    subprocess.run([program, *DATA.split()], check=True)
    with open("directions.csv", "w", encoding="ascii") as f:
        f.write("theta_i,phi_i,theta_o,phi_o\n" + "".join("%d,0,30,180\n" % i for i in range(90)))
    subprocess.run([program, "fit", "data.csv", "--json", "fit.json"], check=True, stdout=subprocess.DEVNULL)
    subprocess.run([program, "fit", "data.csv", "-o", "fits", "--summary", "old.csv"], check=True, stderr=subprocess.DEVNULL)
    kinds = re.findall(r"^ {28}([a-z]+) *", run(["plot", "--help"])[1].decode().partition("What KIND can be:")[2].partition("\n\n")[0], re.M)
    if {k for k in kinds if k} - set(KINDS) - {"correlationcorrelations"}:
        fail("kinds of figures that are not tried: %s" % (set(kinds) - set(KINDS)))
    for command in re.findall(r"^  (\w+) ", run(["--help"])[1].decode(), re.M):
        has_threads = b"--threads" in run([command, "--help"])[1]
        if command not in LINES:
            fail("%s is not tried" % command)
        for line in LINES.get(command, []):
            try_line(line, has_threads)
    print("%d runs, %d failures" % (runs, failures))
    return 1 if failures or runs < 60 else 0


with tempfile.TemporaryDirectory() as folder:
    os.chdir(folder)
    status = main()
    os.chdir("/")
sys.exit(status)
