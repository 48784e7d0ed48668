#!/usr/bin/env python3
"""commands_test.py PROGRAM SOURCE_DIR [PAGE...]: the commands of the manual run, and print what the manual says.

Of README.md and docs/*.md every line of a block of code that begins with `facetfit` or `build/bin/facetfit` is run, page by page in a
folder of its own, in order. --times says how long a page takes a person's machine, up to the first answer and to its end. After `$ facetfit ...` what follows in the block is output: each line must be one of the program's, though
words of it may be left out; numbers may differ in their last digit, `...` stands for anything. Comments in the page say what is not so:

  <!-- not run: REASON -->     the next block has no commands that can be run
  <!-- file: NAME -->          the next block is a file
  <!-- exit status: N -->      the commands of the next block end with N
  <!-- with the module: NAME -->  the commands of the next block run where `facetfit --version --verbose` has that module
  <!-- a file for NAME: FILE -->  the commands of the next block run with FILE, made below, where the page says NAME
"""
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time

TIMES = "--times" in sys.argv
if TIMES:
    sys.argv.remove("--times")
PROGRAM, TOP = map(os.path.abspath, sys.argv[1:3])
# A file like a goniometer's, for examples about files that somebody has.
MEASURED = ("facetfit simulate ggx/v-cavity+lambert --set alpha=0.25,f0=0.6:0.5:0.3,kd=0.05:0.1:0.1 --grid goniometer:10 "
            "--noise 0.03 --seed 5 -o measured.astm")
# The flags page is written by the program; its examples are about such files.
GIVEN = {"README.md": [MEASURED], "docs/fitting.md": [MEASURED], "docs/flags.md": ["facetfit simulate ggx+lambert --set alpha=0.3,f0=0.05:0.06:0.04,kd=0.3:0.2:0.1 --noise 0.01 -o paint.csv",
                           "facetfit simulate ggx+lambert --set alpha=0.2,kd=0.2 --noise 0.01 --grid goniometer:15 -o grey.csv",
                           "facetfit fit paint.csv grey.csv -o fits --summary old.csv && cp old.csv new.csv",
                           "printf 'theta_i,phi_i,theta_o,phi_o\\n30,0,30,180\\n' > directions.csv"]}
COMMAND = re.compile(r"^(\$ )?(?:build/bin/)?(facetfit .*)$")
TOLERANCE = 0.006
failures = ran = 0
taken = []  # (page, command, seconds)
PREPARES = ("simulate", "info", "--version")  # what is done before there is an answer


def check(condition, text):
    global failures
    if not condition:
        failures += 1
        print("failed: " + text)


def blocks(text):
    """(line number, comments before it, lines) of every block of code."""
    comments, block, fenced, before = [], None, False, ""
    for number, line in enumerate(text.splitlines() + [""], 1):
        indented = line.startswith("    ") and (block is not None or not before.strip() or before.startswith("#"))
        if line.startswith("```"):
            fenced = not fenced
            if fenced:
                block = (number + 1, comments, [])
            else:
                yield block
                block, comments = None, []
        elif fenced:
            block[2].append(line)
        elif indented:
            block = block or (number, comments, [])
            block[2].append(line[4:])
        elif block is not None and not line.strip():
            block[2].append("")  # the block may go on
        else:
            if block is not None:
                yield block
                block, comments = None, []
            said = re.match(r"^<!-- (not run|file|exit status|with the module|a file for \S+): (.*) -->$", line)
            comments = comments + [said.groups()] if said else comments if not line.strip() else []
        before = line
    if block is not None:
        yield block


def same(a, b):
    if a == b or a == "...":
        return True
    x, y = (re.findall(r"[-+]?\d+\.?\d*(?:e[-+]?\d+)?", word) for word in (a, b))
    if not x or len(x) != len(y) or re.sub(r"[-+\d.e]+", "#", a) != re.sub(r"[-+\d.e]+", "#", b):
        return False
    return all(abs(float(p) - float(q)) <= TOLERANCE * max(abs(float(p)), abs(float(q))) for p, q in zip(x, y))


def is_in(said, line):
    """Are the words of `said` those of the line, in their order, but for some that are left out?"""
    words = iter(line.split())
    return all(word == "..." or any(same(word, other) for other in words) for word in said.split())


def run(command, folder):
    environment = dict(os.environ, PATH=os.path.dirname(PROGRAM) + os.pathsep + os.environ["PATH"], COLUMNS="80")
    return subprocess.run(["bash", "-o", "pipefail", "-c", command], cwd=folder, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                          stdin=subprocess.DEVNULL, text=True, check=False, timeout=600)


def check_block(page, number, comments, lines, folder):
    global ran
    said = dict(comments)
    if "not run" in said:
        check(len(said["not run"]) > 3, f"{page}:{number}: a block is not run, and there is no reason")
        return
    if "with the module" in said and not re.search(rf"^module {said['with the module']} +there:", run("facetfit --version --verbose", folder).stdout, re.M):
        print(f"{page}:{number}: not run, the module {said['with the module']} is not there")
        return
    if "file" in said:
        with open(os.path.join(folder, said["file"]), "w", encoding="utf-8") as f:
            f.write("\n".join(lines).rstrip("\n") + "\n")
        return
    output, at_line = [], 0
    for k, line in enumerate(lines):
        match = COMMAND.match(line)
        for key, file in said.items():
            if match and key.startswith("a file for "):
                match = COMMAND.match(re.sub(r"(?<!\S)" + re.escape(key.split()[-1]) + r"(?!\S)", file, line))
        if match and "| jq " in line and not shutil.which("jq"):
            print(f"{page}:{number + k}: not run, jq is not installed")
            output = None
        elif match:
            begin = time.monotonic()
            done = run(match[2], folder)
            taken.append((page, match[2], time.monotonic() - begin))
            ran += 1
            check(done.returncode == int(said.get("exit status", 0)), f"{page}:{number + k}: {match[2]}\n  ends with {done.returncode}: {done.stderr[-600:]}")
            output, at_line = ((done.stdout + done.stderr).splitlines() if match[1] else None), 0
        elif output is not None and output != [] and line.strip() and line.strip() != "...":
            found = next((i for i in range(at_line, len(output)) if is_in(line, output[i])), None)
            check(found is not None, f"{page}:{number + k}: the program does not say '{line}'")
            at_line = found + 1 if found is not None else at_line


def check_page(page):
    with open(os.path.join(TOP, page), encoding="utf-8") as f:
        text = f.read()
    with tempfile.TemporaryDirectory() as folder:
        for command in GIVEN.get(page, []):
            check(run(command, folder).returncode == 0, f"{page}: {command}")
        for number, comments, lines in blocks(text):
            check_block(page, number, comments, lines, folder)


def check_picture():
    """The picture of the README is what its script draws today."""
    with tempfile.TemporaryDirectory() as folder:
        drawn = os.path.join(folder, "lobes.svg")
        done = subprocess.run([sys.executable, os.path.join(TOP, "docs", "lobes.py"), PROGRAM, drawn], stderr=subprocess.PIPE, text=True, check=False)
        check(done.returncode == 0, f"docs/lobes.py: {done.stderr[-600:]}")
        if done.returncode == 0:
            with open(drawn, encoding="utf-8") as new, open(os.path.join(TOP, "docs", "lobes.svg"), encoding="utf-8") as kept:
                a, b = new.read().split(), kept.read().split()
            check(len(a) == len(b) and all(same(x, y) for x, y in zip(a, b)), "docs/lobes.svg is not what docs/lobes.py draws")


if not sys.argv[3:]:
    check_picture()
pages = sys.argv[3:] or ["README.md"] + sorted("docs/" + name for name in os.listdir(os.path.join(TOP, "docs")) if name.endswith(".md"))
for name in pages:
    check_page(name)
check(ran >= 20 or len(sys.argv) > 3, f"only {ran} commands")
for name in pages if TIMES else []:
    of = [(command, seconds) for page, command, seconds in taken if page == name]
    first = next((k for k, (command, _) in enumerate(of) if command.split()[1] not in PREPARES), None)
    if first is not None:
        print(f"{name}: {first + 1} commands and {sum(s for _, s in of[:first + 1]):.2f} s to the first answer ({of[first][0]}); "
              f"{len(of)} commands, {sum(s for _, s in of):.1f} s in all")
print(f"{len(pages)} pages, {ran} commands, {failures} failures")
sys.exit(1 if failures else 0)
