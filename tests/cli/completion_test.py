#!/usr/bin/env python3
"""completion_test.py PROGRAM: the scripts that complete command lines are ones their shells take, and bash is asked for completions."""
import os
import re
import shutil
import subprocess
import sys
import tempfile

program = os.path.abspath(sys.argv[1])
failures, asked = [], 0
ASK = r"""
source "$1"
shift
COMP_WORDS=("$@") COMP_CWORD=$(($# - 1))
compopt() { :; }
_facetfit
printf '%s\n' "${COMPREPLY[@]}"
"""


def says(*args):
    return subprocess.run([program, *args], stdout=subprocess.PIPE, check=True, text=True).stdout


def check_syntax(shell, directory):
    path = os.path.join(directory, f"facetfit.{shell}")
    with open(path, "w") as file:
        file.write(says("completion", shell))
    if not shutil.which(shell):
        print(f"left out: {shell} is not installed")
        return None
    p = subprocess.run([shell, "-n", path], capture_output=True, text=True)
    if p.returncode != 0 or p.stderr:
        failures.append(f"{shell} -n: {p.stderr}")
    return path


def ask(script, directory, *words):
    """What bash offers for the last word; '=' is a word of its own, as it is for readline."""
    global asked
    asked += 1
    p = subprocess.run(["bash", "-c", ASK, "ask", script, *words], cwd=directory, capture_output=True, text=True)
    if p.returncode != 0 or p.stderr:
        failures.append(f"{words}: status {p.returncode}, {p.stderr}")
    return p.stdout.split("\n")[:-1] if p.stdout.strip() else []


def expect(script, directory, words, expected):
    found = ask(script, directory, *words)
    if sorted(found) != sorted(expected):
        failures.append(f"{words}: found {found}, expected {expected}")


with tempfile.TemporaryDirectory() as directory:
    scripts = {shell: check_syntax(shell, directory) for shell in ("bash", "zsh", "fish")}
    if not scripts["bash"]:
        print("skipped: bash is not installed")
        sys.exit(77)
    for name in ("a b.csv", "paint.csv"):
        open(os.path.join(directory, name), "w").close()
    os.mkdir(os.path.join(directory, "folder"))
    bash = scripts["bash"]
    commands = re.findall(r"^  (\w+) ", says("--help"), re.M)
    refused = subprocess.run([program, "fit", "x.csv", "--loss", "?"], stderr=subprocess.PIPE, check=False).stderr.decode()
    losses = re.search(r"expected one of (.*)", refused).group(1).split(", ")
    in_c = [name for name in losses if name.startswith("c")]
    for words, expected in [
            (["facetfit", "co"], ["compare", "convert", "completion"]),
            (["facetfit", ""], commands + ["help", "--help", "--version"]),
            (["facetfit", "fit", "--los"], ["--loss"]),
            (["facetfit", "fit", "--no-"], ["--no-times", "--no-keep-going", "--no-progress"]),
            (["facetfit", "fit", "--loss", "c"], in_c),
            (["facetfit", "fit", "--loss", "=", "c"], in_c),
            (["facetfit", "fit", "--loss", "="], losses),
            (["facetfit", "compare", "--loss", "a"], []),
            (["facetfit", "compare", "x", "--ndf", "ggx,bec"], ["ggx,beckmann", "ggx,beckmann-walter"]),
            (["facetfit", "fit", "p"], ["paint.csv"]),
            (["facetfit", "fit", "a"], ["a b.csv"]),
            (["facetfit", "fit", "--loss", "log", "p"], ["paint.csv"]),
            (["facetfit", "fit", "--loss", "=", "log", "p"], ["paint.csv"]),
            (["facetfit", "fit", "--mean-slope", "p"], ["paint.csv"]),
            (["facetfit", "fit", "paint.csv", "p"], []),
            (["facetfit", "fit", "paint.csv", "--json", "fo"], ["folder"]),
            (["facetfit", "eval", "lamb"], ["lambert"]),
            (["facetfit", "eval", "ggx+lamb"], ["ggx+lambert"]),
            (["facetfit", "eval", "lambert", "pa"], ["paint.csv"]),
            (["facetfit", "fit", "--max-theta", "8"], []),
            (["facetfit", "sample", "ggx", "-n", ""], []),
            (["facetfit", "simulate", "ggx", "-o", "pa"], ["paint.csv"]),
            (["facetfit", "simulate", "ggx", "--format", "me"], ["merl"]),
            (["facetfit", "man", "fo"], ["formats"]),
            (["facetfit", "help", "fo"], ["formats"]),
            (["facetfit", "plot", "co"], ["coverage", "correlation"]),
            (["facetfit", "completion", ""], ["bash", "zsh", "fish"]),
    ]:
        expect(bash, directory, words, expected)
    for command in commands:  # every flag of --help, and nothing else
        flags = re.findall(r"^ +(?:-\w, +)?--(\[no-\])?([\w-]+)", says(command, "--help"), re.M)
        expect(bash, directory, ["facetfit", command, "--"], ["--" + name for _, name in flags] + ["--no-" + name for no, name in flags if no])
    for shell in ("zsh", "fish"):  # every flag of every command is in the script, installed or not
        with open(os.path.join(directory, f"facetfit.{shell}")) as file:
            script = file.read()
        for command in commands:
            flags = [name for _, name in re.findall(r"^ +(?:-\w, +)?--(\[no-\])?([\w-]+)", says(command, "--help"), re.M)]
            own = [line for line in script.splitlines() if f"__fish_seen_subcommand_from {command}'" in line] if shell == "fish" else \
                re.search(r"^ *%s\)\n(.*?);;" % command, script, re.M | re.S)
            text = "\n".join(own) if isinstance(own, list) else own[1] if own else ""
            for flag in flags:
                asked += 1
                if not re.search((r"-l %s\b" if shell == "fish" else r"--%s\b") % flag, text):
                    failures.append(f"{shell}: the completion of {command} lacks --{flag}")
for failure in failures:
    print("failed:", failure)
print(f"{asked} completions, {len(failures)} failures")
sys.exit(1 if failures else 0)
