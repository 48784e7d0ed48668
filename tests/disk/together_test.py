#!/usr/bin/env python3
"""together_test.py PROGRAM SHIM [--all]: the outputs of a command are one, standard output among them: where one fails none changes.

Each command that writes something is run with all its outputs at once, and each of them in turn fails: as a full device, at every step
that a disk can fail at, with standard output full, closed or hung up, and with a signal at every step. Afterwards every file is what it
was, or all are new. Only where a rename fails after another one may they differ, and then the program says which are new.

What outputs there are comes from --help: one that is not in COMMANDS fails the test. Without --all each command has its first line, one
writer stands for all of them, and of the steps before the first rename the first, the last and one between are tried."""
import errno
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile

OLD = b"what was here before\n" * 50
OUTPUT_FLAGS = {"--json", "--output", "--residuals"}
SIMULATE = "simulate ggx+lambert --set alpha=0.3,f0=0.5,kd=0.2 --grid goniometer:30 -o in.csv"
# words; {KEY} is where an output goes, KEY what --help calls it; {x.csv} has a name that must end so
COMMANDS = {
    "fit": ["fit in.csv --model lambert --json {--json} --residuals {--residuals:.csv}", "fit in.csv --model lambert --table csv --json {--json}",
            "fit in.csv --model lambert --json {--json} --residuals {--residuals:.exr}"],
    "compare": ["compare in.csv --ndf ggx --masking smith-separable --diffuse lambert --json {--json} --residuals {--residuals:.csv}"],
    "ndf": ["ndf in.csv -o {--output:.csv} --json {--json}", "ndf in.csv --table csv -o {--output:.csv} --json {--json}",
            "ndf in.csv -o - --json {--json}"],
    "info": ["info in.csv --json {--json}"],
    "gather": ["gather fits --json {--json} --summary {--summary:.csv} --html {--html:.html}"],
    "formats": ["formats --json {--json}"],
    "models": ["models --json {--json}"],
    "convert": ["convert --list --json {--json}", "convert --from beckmann --to phong m=0.25 --json {--json}"],
    "furnace": ["furnace lambert --mu 0.5 --json {--json}"],
    "sample": ["sample ggx -n 10 --json {--json}"],
    "eval": ["eval ggx+lambert directions.csv --json {--json}"],
    "resample": ["resample in.csv {OUT} --to WRITER --json {--json}", "resample in.csv - --to csv --json {--json}"],
    "simulate": ["simulate ggx+lambert --grid goniometer:30 --format WRITER -o {--output}"],
    "plot": ["plot polar in.csv -o {--output:.svg}"],
    "render": ["render ggx --size 16 -o {--output:.png} --json {--json}", "render ggx --size 16 -o {--output:.exr} --json {--json}"],
    "export": ["export fit.json --to glsl -o {--output:.glsl} --json {--json}", "export fit.json --to gltf -o {--output:.gltf} --json {--json}",
               "export fit.json --to blender -o {--output:.py} --json {--json}"],
}
EVERY = "--all" in sys.argv
GRIDS = ["merl", "utia", "rgl", "zemax", "window", "speos", "anisotropicbsdf"]  # for samples where these formats have them
LARGE = ["merl"]  # a MERL file takes seconds, and is tried by disk_test
QUIET = {"simulate", "plot"}  # print nothing beside what they write
INPUTS = ["in.csv", "directions.csv", "fit.json"]

signal.signal(signal.SIGINT, signal.SIG_DFL)  # a shell lets what it starts in the background ignore it
program, shim = os.path.abspath(sys.argv[1]), os.path.abspath(sys.argv[2])
folder = tempfile.mkdtemp(prefix="together-")
os.chdir(folder)
wrong, runs, mixed = [], 0, 0


def run(words, stdout=subprocess.PIPE, **more):
    global runs
    runs += 1
    return subprocess.run([program, *words], stdin=subprocess.DEVNULL, stdout=stdout, stderr=subprocess.PIPE, timeout=60,
                          env={**os.environ, "LC_ALL": "C", **more})


def content(name):
    try:
        with open(name, "rb") as f:
            return f.read()
    except FileNotFoundError:
        return None


def put(name, data):
    if os.path.lexists(name):
        os.remove(name)
    if data is not None:
        with open(name, "wb") as f:
            f.write(data)


def check(good, what):
    if not good and what not in wrong:
        wrong.append(what)
        print("failed: " + what)


class Command:
    """One line of COMMANDS, with files that were there before, or (absent) were not."""

    def __init__(self, line, absent):
        self.old = None if absent else OLD
        self.places = re.findall(r"{([^}]*)}", line)
        self.files = ["%d%s" % (k, p.partition(":")[2]) for k, p in enumerate(self.places)]
        self.line = line

    def words(self, **instead):
        """The words, with the file of place k replaced by instead["k"]."""
        at = iter(range(len(self.places)))
        return re.sub(r"{[^}]*}", lambda m: (lambda k: instead.get("_%d" % k, self.files[k]))(next(at)), self.line).split()

    def restore(self):
        for name in self.files:
            put(name, self.old)

    def are_new(self):
        return [name for name in self.files if content(name) != self.old]

    def none_changed(self, p, where, status=4, spared=None):
        p_said = p.stderr.decode(errors="replace")
        new = [n for n in self.are_new() if n != spared]
        check(p.returncode == status, "%s: ends with %d, expected %s: %s" % (where, p.returncode, status, p_said[-200:]))
        check(not new, "%s: %s changed, which is one with what failed" % (where, new))
        self.no_parts(where)

    def no_parts(self, where):
        parts = [n for n in os.listdir(".") if ".part-" in n]
        check(not parts, "%s: leaves %s" % (where, parts))
        for part in parts:
            os.remove(part)


def before_computing(c, where):
    """What cannot be written is said before the data are looked at, which are not there either."""
    for k, name in enumerate(c.files):
        words = ["absent" + os.path.splitext(w)[1] if w in INPUTS else w for w in c.words(**{"_%d" % k: "missing/" + name})]
        p = run(words)
        said = p.stderr.decode(errors="replace")
        check(p.returncode == 4 and "missing/" in said and "absent" not in said, "%s: ends with %d, before %s was tried: %s" % (where, p.returncode, c.places[k], said[-200:]))


def full_devices(c, where):
    for k, name in enumerate(c.files):
        end = os.path.splitext(name)[1]
        link = "full" + end
        if not os.path.lexists(link):
            os.symlink("/dev/full", link)
        c.restore()
        c.none_changed(run(c.words(**{"_%d" % k: link})), "%s: %s full" % (where, c.places[k]), spared=name)


def bad_stdout(c, where):
    with open("/dev/full", "wb") as full:
        c.restore()
        c.none_changed(run(c.words(), stdout=full), where + ": standard output full")
    c.restore()
    p = subprocess.run(["sh", "-c", 'exec "$@" >&-', "sh", program, *c.words()], stdin=subprocess.DEVNULL, stderr=subprocess.PIPE, timeout=60)
    c.none_changed(p, where + ": standard output closed")
    c.restore()
    p = subprocess.run(["sh", "-c", 'exec "$@" >printed <&- 2>&-', "sh", program, *c.words()], timeout=60)
    place = where + ": standard input and error closed"
    check(p.returncode in (0, 1) and len(c.are_new()) == len(c.files), "%s: ends with %d, new are %s" % (place, p.returncode, c.are_new()))
    check(not any(b"facetfit: " in content(name) for name in [*c.files, "printed"]), place + ": a message is in an output")
    read, write = os.pipe()
    os.close(read)
    c.restore()
    p = run(c.words(), stdout=write)
    os.close(write)
    c.none_changed(p, where + ": nobody reads standard output", status=-signal.SIGPIPE)


def short(letters):
    return re.sub(r"(\w)\1{5,}", lambda m: "%s{%d}" % (m[1], len(m[0])), letters)


def steps(letters):
    """Which steps are tried, counted from 1: all from the last before a rename on, and of those before it the first and one between."""
    first = letters.index("r") if "r" in letters else len(letters)
    return [(n, letter) for n, letter in enumerate(letters, 1) if EVERY or n >= first or n in (1, first // 2)]


def failing_steps(c, where, letters):
    global mixed
    renames = [k for k, letter in enumerate(letters, 1) if letter == "r"]
    check(len(renames) == len(c.files), "%s: %d renames of %d files" % (where, len(renames), len(c.files)))
    check(all(letter == "r" or k < renames[0] or letter == "f" for k, letter in enumerate(letters, 1)), "%s: %s: not all is written before the first rename" % (where, letters))
    for n, letter in steps(letters):
        c.restore()
        p = run(c.words(), LD_PRELOAD=shim, DISK_FAIL="%d:%d" % (n, errno.EIO))
        said = p.stderr.decode(errors="replace")
        place = "%s: step %d of %s" % (where, n, short(letters))
        if letter == "f" and n > renames[0]:  # of a folder, which not every file system can
            check(p.returncode == 0 and len(c.are_new()) == len(c.files), "%s: ends with %d" % (place, p.returncode))
            continue
        if letter != "r" or n == renames[0]:
            c.none_changed(p, place)
            continue
        new = c.are_new()
        mixed += 1
        check(p.returncode == 4, "%s: ends with %d" % (place, p.returncode))
        check(len(new) == renames.index(n), "%s: %s are new" % (place, new))
        listed = said.partition("in place already: ")[2]
        check(all(re.search(r"(^|[/ ])%s(,|$)" % re.escape(name), listed.strip()) for name in new), "%s: %s are new, but it says: %s" % (place, new, said))
        c.no_parts(place)


def signals(c, where, letters):
    for n, _ in steps(letters):
        for number in (signal.SIGINT, signal.SIGTERM) if EVERY or n % 2 else (signal.SIGTERM,):
            c.restore()
            p = run(c.words(), LD_PRELOAD=shim, DISK_SIGNAL="%d:%d" % (n, number))
            place = "%s: %s at step %d of %s" % (where, number.name, n, short(letters))
            new = c.are_new()
            check(p.returncode == (130 if number == signal.SIGINT else -number), "%s: ends with %d" % (place, p.returncode))
            check(len(new) in (0, len(c.files)), "%s: of its outputs only %s is new" % (place, new))
            check(not new or n >= letters.index("r") + 1, "%s: new before it was given its name" % place)
            c.no_parts(place)


def try_line(name, line, absent):
    c = Command(line, absent)
    where = " ".join(c.words()) + (", new files" if absent else "")
    c.restore()
    p = run(c.words(), LD_PRELOAD=shim, DISK_COUNT="count")
    if p.returncode not in (0, 1) or len(c.are_new()) != len(c.files):
        check(False, "%s: ends with %d on a sound disk, new are %s: %s" % (where, p.returncode, c.are_new(), p.stderr.decode(errors="replace")[-200:]))
        return
    letters = content("count").decode().split()[1]
    before_computing(c, where)
    full_devices(c, where)
    if name not in QUIET:
        bad_stdout(c, where)
    failing_steps(c, where, letters)
    signals(c, where, letters)
    for file in c.files:
        put(file, None)


def outputs_of(command):
    text = run([command, "--help"]).stdout.decode()
    return set(re.findall(r"^(?:      |  -\w, )(--[a-z-]+)(?![a-z-]| DIR)", text, re.M)) & OUTPUT_FLAGS | {w for w in text.splitlines()[0].split() if w == "OUT"}


def main():
    subprocess.run([program, *SIMULATE.split()], check=True)
    run("fit in.csv --model ggx+lambert --json fit.json".split())
    run("fit in.csv --model ggx+lambert -o fits".split())
    with open("directions.csv", "w", encoding="ascii") as f:
        f.write("theta_i,phi_i,theta_o,phi_o\n30,0,30,180\n")
    formats = run(["formats", "--json", "-"]).stdout.decode()
    writers = re.findall(r'"name": "(\w+)"[^{}]*?"writes": true', formats)
    check(len(writers) >= 5, "no writers in the list of formats: %s" % writers)
    lines = 0
    for command in re.findall(r"^  (\w+) ", run(["--help"]).stdout.decode(), re.M):
        tried = {place.partition(":")[0] for line in COMMANDS.get(command, []) for place in re.findall(r"{([^}]*)}", line)}
        check(outputs_of(command) <= tried, "%s: outputs that are not tried: %s" % (command, outputs_of(command) - tried))
        for line in COMMANDS.get(command, [])[:None if EVERY else 1]:
            for writer in (writers if EVERY else ["csv"]) if "WRITER" in line else [""]:
                if writer in (GRIDS if command == "simulate" else LARGE):
                    continue
                try_line(command, line.replace("WRITER", writer), absent=lines % 2)
                lines += 1
    shutil.rmtree(folder, ignore_errors=True)
    print("%d lines, %d runs, %d of them with a rename that fails after another; %d failures" % (lines, runs, mixed, len(wrong)))
    return 1 if wrong or lines < (40 if EVERY else 12) or mixed < 4 else 0


sys.exit(main())
