#!/usr/bin/env python3
"""contract_test.py PROGRAM: docs/contract.md, of every command that --help lists.

  done               stdout has the result; stderr has lines that begin with "facetfit: ", none of them an error, and no notes with -q
  --json -           is one document and nothing else
  a flag too many    status 2, a file that is not there 3, an output that cannot be written 4: stdout is empty, one line is an error,
                     it names what is wrong, and no line is said twice
"""
import json
import os
import re
import subprocess
import sys
import tempfile

program = os.path.abspath(sys.argv[1])
# What is done, with FILE for each input and OUT for an output; a command is tried with all that it has.
LINES = {
    "fit": "fit FILE", "compare": "compare FILE --ndf ggx,beckmann --masking v-cavity,smith-separable,none", "gather": "gather fits", "diff": "diff old.csv old.csv",
    "ndf": "ndf FILE -o OUT", "resample": "resample FILE OUT", "plot": "plot slice FILE -o OUT.svg", "convert": "convert --from phong --to alpha 60",
    "eval": "eval ggx FILE.directions", "simulate": "simulate ggx --grid goniometer:30 -o OUT", "furnace": "furnace ggx --mu 0.5", "sample": "sample ggx -n 10",
    "info": "info FILE", "render": "render FILE --size 16 -o OUT.png", "export": "export FILE.json --to gltf -o OUT.gltf", "models": "models",
    "selftest": "selftest", "formats": "formats", "man": "man fit", "completion": "completion bash",
}
failures = runs = 0


def check(condition, text):
    global failures
    if not condition:
        failures += 1
        print("failed: " + text)


def run(line):
    global runs
    runs += 1
    done = subprocess.run([program, *line.split()], stdin=subprocess.DEVNULL, capture_output=True, check=False, timeout=300)
    said = done.stderr.decode("utf-8", "replace").splitlines()
    for one in said:
        check(one.startswith("facetfit: "), f"{line}: says {one!r}")
    check(len(set(said)) == len(said), f"{line}: says something twice: {said}")
    return done.returncode, done.stdout, [one[len("facetfit: "):] for one in said]


def errors(said):
    return [one for one in said if one.startswith("error: ")]


def is_refused(line, status, word):
    ended, out, said = run(line)
    check(ended == status, f"{line}: ends with {ended}, not {status}: {said}")
    check(not out, f"{line}: is refused and prints {out[:80]!r}")
    check(len(errors(said)) == 1 and word in errors(said)[0], f"{line}: one error that names {word!r}: {said}")


def try_command(command):
    line = LINES[command].replace("FILE", "paint.csv").replace("OUT", "out.csv")
    _, help_text, _ = run(f"{command} --help")
    ended, out, said = run(line)
    check(ended == 0 and (out or "out.csv" in line) and not errors(said), f"{line}: ends with {ended}, prints {len(out)} bytes, says {said}")
    _, _, said = run(line + " -q")
    check(not [one for one in said if one.startswith("note: ")], f"{line} -q: {said}")
    if b"--json" in help_text:
        ended, out, _ = run(line + " --json -")
        try:
            check("schema" in json.loads(out), f"{line} --json -: is no document of ours")
        except ValueError as e:
            check(False, f"{line} --json -: {e}")
    is_refused(line + " --nonsense", 2, "--nonsense")
    if "paint.csv" in line:
        is_refused(line.replace("paint.csv", "nothing.csv"), 3, "nothing.csv")
    if "out.csv" in line:
        is_refused(line.replace("out.csv", "nowhere/out.csv"), 4, "nowhere/out.csv")


def check_maskings():
    """by_masking is what a person would make of the fits: of each masking the lowest objective, the best first."""
    said = json.loads(run(LINES["compare"].replace("FILE", "paint.csv") + " --json -")[1])
    best = {}
    for k, fit in enumerate(said["fits"]):
        if fit["masking"] not in best or fit["residual"]["objective"] < said["fits"][best[fit["masking"]]]["residual"]["objective"]:
            best[fit["masking"]] = k
    objective = {masking: said["fits"][k]["residual"]["objective"] for masking, k in best.items()}
    wanted = sorted(best, key=objective.get)
    check(len(wanted) == 3 and [m["masking"] for m in said["by_masking"]] == wanted, f"by_masking: {said['by_masking']}, expected {wanted}")
    for m in said["by_masking"]:
        check(m["fit"] == best[m["masking"]] and m["ndf"] == said["fits"][m["fit"]]["ndf"], f"by_masking: {m} is not the best of its masking")
        check(abs(m["ratio"] * objective[wanted[0]] - objective[m["masking"]]) <= 1e-12 * objective[m["masking"]], f"by_masking: the ratio of {m}")


def main():
    made = subprocess.run([program, "simulate", "ggx+lambert", "--set", "alpha=0.3,f0=0.5,kd=0.1", "--grid", "goniometer:15", "--noise", "0.02", "-o", "paint.csv"],
                          stdout=subprocess.DEVNULL, check=True)
    with open("paint.csv.directions", "w", encoding="ascii") as f:
        f.write("theta_i,phi_i,theta_o,phi_o\n30,0,30,180\n")
    for words in ("fit paint.csv --json paint.csv.json", "fit paint.csv -o fits --summary old.csv"):
        subprocess.run([program, *words.split()], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=True)
    commands = re.findall(r"^  (\w+) ", run("--help")[1].decode(), re.M)
    check(not set(commands) ^ set(LINES), f"commands and lines differ: {set(commands) ^ set(LINES)}")
    for command in commands:
        if command in LINES:
            try_command(command)
    is_refused("nonsense", 2, "nonsense")
    check_maskings()
    print("%d runs, %d failures" % (runs, failures))
    return 1 if failures or runs < 60 or made.returncode else 0


with tempfile.TemporaryDirectory() as folder:
    os.chdir(folder)
    status = main()
    os.chdir("/")
sys.exit(status)
