#!/usr/bin/env python3
"""help_test.py PROGRAM: what --help says: examples first, all of which run, then flags by group; never wider than 80 columns."""
import os
import re
import subprocess
import sys
import tempfile

program = os.path.abspath(sys.argv[1])
GROUPS = ["Data", "Model", "Weights", "Retrieval", "Trust", "Conversion", "View", "Noise", "Figure", "Output", "Many files", "Running"]
failures = []
environment = dict(os.environ, PATH=os.path.dirname(program) + os.pathsep + os.environ["PATH"], LC_ALL="C")


def says(*args):
    p = subprocess.run([program, *args], capture_output=True, text=True)
    if p.returncode != 0:
        failures.append(f"facetfit {' '.join(args)}: status {p.returncode}, {p.stderr}")
    return p.stdout


def check(condition, what):
    if not condition:
        failures.append(what)


def check_width(what, text):
    for line in text.splitlines():
        check(len(line) <= 80, f"{what}: {len(line)} columns: {line}")


def check_form(command, text):
    """The examples; every heading in its order, with flags under it."""
    examples = re.search(r"^Examples:\n((?:  .*\n)+)\n", text, re.M)
    if not examples:
        failures.append(f"{command}: no examples")
        return []
    headings = re.findall(r"^(\w+):$", text, re.M)
    check(headings[0] == "Examples", f"{command}: {headings[0]} comes before the examples")
    check(headings[1:] == [g for g in GROUPS if g in headings], f"{command}: groups {headings[1:]}, expected the order {GROUPS}")
    for body in re.split(r"^\w+:\n", text[examples.end():], flags=re.M)[1:]:
        check(re.match(r" +(-\w, )?--", body), f"{command}: a heading without flags")
    lines = [line.strip() for line in examples.group(1).splitlines()]
    check(2 <= len(lines) <= 4, f"{command}: {len(lines)} examples")
    check(all(line.startswith(f"facetfit {command} ") or line == f"facetfit {command}" for line in lines),
          f"{command}: an example of another command: {lines}")
    return lines


def prepare(directory):
    subprocess.run(["sh", "-ec", "facetfit simulate ggx+lambert --set alpha=0.3,f0=0.05:0.06:0.04,kd=0.3:0.2:0.1 --noise 0.01 -o paint.csv\n"
                    "printf 'theta_i,phi_i,theta_o,phi_o\\n30,0,30,180\\n45,0,20,90\\n' > directions.csv\n"
                    "facetfit simulate ggx+lambert --set alpha=0.2,kd=0.2 --noise 0.01 --grid goniometer:15 -o grey.csv\n"
                    "facetfit fit paint.csv --json fit.json\n"
                    "facetfit fit paint.csv grey.csv -o fits --summary old.csv\n"
                    "cp old.csv new.csv"],
                   cwd=directory, env=environment, check=True)


def run(line):
    with tempfile.TemporaryDirectory() as directory:
        prepare(directory)
        p = subprocess.run(["sh", "-c", line], cwd=directory, env=environment, stdin=subprocess.DEVNULL, capture_output=True, text=True)
        made = [word for word in re.findall(r"(?:-o|>|--json) (\S+)", line) if word != "-"]
        check(p.returncode == 0, f"{line}: status {p.returncode}, {p.stderr}")
        check(p.stdout or made, f"{line}: says nothing")
        for name in made:
            check(os.path.exists(os.path.join(directory, name)), f"{line}: {name} was not made")


overview = says("--help")
check_width("the overview", overview)
commands = re.findall(r"^  (\w+) ", overview, re.M)
examples = 0
for command in commands:
    text = says(command, "--help")
    check(text == says("help", command), f"help {command} is not {command} --help")
    check_width(command, text)
    for line in check_form(command, text):
        examples += 1
        run(line)
for failure in failures:
    print("failed:", failure)
print(f"{len(commands)} commands, {examples} examples, {len(failures)} failures")
sys.exit(1 if failures or len(commands) < 12 else 0)
