#!/usr/bin/env python3
"""Command lines that nobody means: every command with every flag and values that are empty, huge, no numbers, doubled, of other alphabets,
of a hundred thousand characters; words in the place of files; files that are none; random pairs of all of these.

  hostile.py PROGRAM [SEED] [--seconds S] [--all] [--only WORDS] [--markdown FILE]

Of each line must hold: it ends by itself within ten seconds, with one of the exit statuses of the manual and never 5 (internal error); a
failure says something on standard error, in printable characters, and no more than a screenful; inputs are what they were; no temporary
file stays; and where it fails no output stays either. Lines are drawn in an order of the seed (0) for S seconds (120), with --all every one.
With --markdown a table of kinds, lines and findings is written. Returns 1 when something was found.
"""
import argparse
import concurrent.futures
import datetime
import hashlib
import itertools
import os
import platform
import random
import re
import resource
import shutil
import subprocess
import sys
import tempfile
import time

LONG = 100000
DONE = {0, 1, 2, 3, 4}
LIMIT = 10.0
MOST_SAID = 8192

VALUES = {
    "empty": ["", " ", "\t", "\n"],
    "sign": ["-", "--", "+", "-0", "+1", "- 1"],
    "number": ["0", "1", "-1", "1e308", "-1e308", "1e-320", "1e999", "9" * 30, "0x10", "1,5", "1e", ".", "1_000", "18446744073709551616"],
    "no number": ["nan", "NaN", "-nan", "inf", "-inf", "infinity", "nan(1)"],
    "punctuation": [",", ",,,", "=", "a=", "=1", "a=b=c", ":", "1:", ":1", "1:2:3:4", "+-", "a+-b", "{", "}", "{1,2", "[", "a[", "a[b]=1", "/", "..", "*"],
    "format": ["%s%s%n", "%d", "%999999d", "$(id)", "`id`", "'\"", "\\", "\\x00"],
    "alphabet": ["αβγ", "\u202eabc", "é" * 40, "𝔣", "\ufeff1"],
    "bytes": [b"\xff\xfe", b"\x1b[31mred\x1b[0m", b"a\x07b", b"a\nb", b"\xc3", b"\x80" * 20],
    "long": ["A" * LONG, "1" * LONG, "," * LONG, "a=1," * (LONG // 4), "(" * LONG, "-" * LONG, "ggx+" * (LONG // 4), "/" * LONG],
}
WORDS = ["ggx", "beckmann+lambert", "alpha", "alpha=0.3", "alpha=0.1:0.9", "f0=0.04+-0.01", "lobe2.f0=f0", "kd[r]=1", "fit", "none", "all",
         "auto", "log", "huber", "huber:nan", "noise", "csv", "merl", "goniometer:30", "scattered:9", "scattered:9:2", "rgb", "srgb:e", "mean",
         "bands:x=1-2", "relative=0.1", "theta_i=a", "40", "0.5", "1e300", "3sigma"]
FILES = ["good.csv", "rgb.csv", "table.csv", "empty", "noise.bin", "folder", "missing", "dangling", "good.csv/x", "/dev/null", "/dev/full", "loop",
         "zeros.csv", "secret"]


def flags_of(program):
    """command -> [(flag, takes a value, is an output)], from the manual."""
    text = subprocess.run([program, "man", "--markdown"], stdout=subprocess.PIPE, check=True, text=True).stdout
    commands, command = {}, None
    for line in text.splitlines():
        heading = re.match(r"## (\S+)$", line)
        if heading:
            command = heading[1]
            commands[command] = []
        row = re.match(r"\| `(?:-\w, )?(-{1,2}[\w-]+)( [^`]*)?` \| ([^|]*) \|", line.replace("\\|", "/"))
        if row and command:
            commands[command].append((row[1], bool(row[2]), "output" in row[3]))
    return commands


# A line that works, for each command: what stands in the place of its words.
PLAIN = {"fit": ["good.csv"], "compare": ["good.csv", "--ndf", "ggx", "--masking", "smith-separable"], "ndf": ["good.csv", "-o", "out"], "info": ["good.csv"],
         "eval": ["ggx"], "simulate": ["ggx", "-o", "out", "--format", "csv", "--grid", "goniometer:30"], "furnace": ["ggx"], "resample": ["good.csv", "out"],
         "convert": ["--from", "beckmann", "--to", "phong", "m=0.25"], "sample": ["ggx", "--theta", "30", "-n", "5"], "models": [], "selftest": ["-q"], "formats": [], "man": [],
         "completion": ["bash"], "plot": ["slice", "good.csv", "-o", "out.svg"],
         "render": ["ggx", "--size", "8", "--samples", "4", "-o", "out.png"],
         "export": ["fit.json", "--to", "blender", "-o", "out.py"], "gather": ["fits", "--summary", "out.csv"], "diff": ["old.csv", "old.csv"]}


def lay_out(folder, program):
    """Inputs that are never to change."""
    at = lambda name: os.path.join(folder, name)
    grid = ["--grid", "goniometer:30", "--noise", "0.05"]
    for name, more in (("good.csv", []), ("rgb.csv", ["--channels", "3"])):
        made = subprocess.run([program, "simulate", "ggx+lambert", *grid, *more, "-o", name], cwd=folder, stderr=subprocess.PIPE)
        if made.returncode:
            shutil.copy(at("good.csv"), at(name))
    subprocess.run([program, "fit", "good.csv", "--json", "fit.json"], cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    subprocess.run([program, "fit", "good.csv", "rgb.csv", "-o", "fits", "--summary", "old.csv"], cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    with open(at("table.csv"), "w") as f:
        f.write("theta_deg,D\n0,1\n30,0.5\n60,0.1\n90,0\n")
    with open(at("zeros.csv"), "w") as f:
        f.write("theta_i,phi_i,theta_o,phi_o,f\n" + "".join(f"30,0,{o},180,0\n" for o in range(0, 80, 2)))
    open(at("empty"), "w").close()
    with open(at("noise.bin"), "wb") as f:
        f.write(random.Random(1).randbytes(4096))
    with open(at("secret"), "w") as f:
        f.write("root:x:0:0:password\n" * 20)
    os.mkdir(at("folder"))
    os.symlink("nowhere", at("dangling"))
    os.symlink("loop", at("loop"))


def lines(commands):
    """(kind, words) of every line."""
    every = [(kind, value) for kind, values in VALUES.items() for value in values]
    for command, flags in commands.items():
        plain = [command, *PLAIN.get(command, [])]
        for flag, takes, output in flags:
            if flag in ("--help", "-h"):
                continue
            for kind, value in every:
                yield kind, plain + [flag, value]
                if flag.startswith("--"):
                    yield kind, plain + [flag + "=" + value if isinstance(value, str) else flag.encode() + b"=" + value]
            for word in WORDS:
                yield "word", plain + [flag, word]
            for file in FILES:
                yield "file", plain + [flag, file]
            yield "no value", plain + [flag]
            yield "twice", plain + ([flag, "1"] if takes else [flag]) * 2
            yield "twice", plain + [flag, "x", flag, "y"]
            yield "before the command", [flag, "1", *plain]
        for kind, value in every:
            yield kind, [command, value]
            yield kind, plain + [value]
            for k in range(1, len(plain)):
                yield kind, plain[:k] + [value] + plain[k + 1:]
        for file in FILES:
            yield "file", [command, file]
            yield "file", [command, file, "out"]
            yield "file", plain + [file]
        yield "no value", [command]
        yield "long", plain + ["good.csv"] * 5000
    for kind, value in every:
        yield kind, [value]
    for flag in ("-v", "-x", "---", "--version=1", "--help=x", "--helpp", "-hh", "-V", "--"):
        yield "sign", [flag]
    yield "no value", []


def pairs(commands, seed, n):
    """Two or three flags at once."""
    draw = random.Random(seed)
    every = [value for values in VALUES.values() for value in values if len(value) < 1000] + WORDS + FILES
    names = sorted(commands)
    for _ in range(n):
        command = draw.choice(names)
        words = [command, *PLAIN.get(command, [])]
        if draw.random() < 0.2:
            words = [command, draw.choice(every)]
        for _ in range(draw.randint(2, 4)):
            if not commands[command]:
                break
            flag, takes, output = draw.choice(commands[command])
            words += [flag] if not takes and draw.random() < 0.9 else [flag, draw.choice(every)]
        yield "together", words


def fingerprint(folder):
    """What is there: of files their content; of links where they lead."""
    found = {}
    for root, dirs, files in os.walk(folder):
        for name in dirs + files:
            path = os.path.join(root, name)
            key = os.path.relpath(path, folder)
            if os.path.islink(path):
                found[key] = "link to " + os.readlink(path)
            elif os.path.isdir(path):
                found[key] = "folder"
            else:
                with open(path, "rb") as f:
                    found[key] = hashlib.sha1(f.read()).hexdigest()
    return found


def bounded():
    resource.setrlimit(resource.RLIMIT_AS, (4 << 30, 4 << 30))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    resource.setrlimit(resource.RLIMIT_FSIZE, (1 << 28, 1 << 28))


def shown(words):
    return " ".join(repr(w if len(w) < 60 else w[:40] + (b"..." if isinstance(w, bytes) else "...")) for w in words)


class Bench:
    """A folder of its own for each worker, put back after every line."""

    def __init__(self, program, model):
        self.program = program
        self.model = model
        self.folder = tempfile.mkdtemp(prefix="hostile-")
        self.put_back()

    def put_back(self):
        shutil.rmtree(self.folder)
        shutil.copytree(self.model, self.folder, symlinks=True)
        self.before = fingerprint(self.folder)

    def run(self, words):
        """What is wrong, [] when nothing is."""
        begin, wrong = time.time(), []
        with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
            try:
                p = subprocess.run([self.program, *words], cwd=self.folder, stdin=subprocess.DEVNULL, stdout=out, stderr=err, timeout=LIMIT,
                                   preexec_fn=bounded, env={"PATH": os.environ["PATH"], "LC_ALL": "C.UTF-8"})
                code = p.returncode
            except subprocess.TimeoutExpired:
                return [f"still running after {LIMIT:.0f} s"]
            except (OSError, ValueError):
                return []  # the system itself takes no such line
            err.seek(0)
            said = err.read(10 * MOST_SAID)
            size = out.seek(0, 2)
        if code not in DONE:
            wrong.append(f"ends with {code}")
        if code >= 2 and not said.strip():
            wrong.append(f"ends with {code} and says nothing")
        if re.search(rb"[\x00-\x08\x0b-\x0c\x0e-\x1f\x7f]", said.replace(b"\r\x1b[K", b"")):
            wrong.append("prints control characters")
        try:
            said.decode()
        except UnicodeDecodeError:
            wrong.append("prints what is not UTF-8")
        if len(said) > MOST_SAID:
            wrong.append(f"says {len(said)} bytes and more")
        if b"root:x:0:0" in said and b"secret" not in b" ".join(w if isinstance(w, bytes) else w.encode() for w in words):
            wrong.append("quotes a file that was not named")
        after = fingerprint(self.folder)
        if after != self.before:
            changed = sorted(k for k in self.before if after.get(k) != self.before[k])
            new = sorted(k for k in after if k not in self.before)
            if changed:
                wrong.append("changes " + ", ".join(changed))
            if any(".part-" in k for k in new):
                wrong.append("leaves " + ", ".join(new))
            if new and code >= 2:
                wrong.append(f"fails and leaves {', '.join(new)}")
            self.put_back()
        return wrong

    def close(self):
        shutil.rmtree(self.folder, ignore_errors=True)


def is_named_output(words, finding):
    """A file that the line itself names as an output may be replaced, as `-o table.csv`."""
    named = {w.split("=", 1)[-1] if isinstance(w, str) else "" for w in words}
    return finding.startswith("changes ") and set(finding[8:].split(", ")) <= named


def machine():
    with open("/proc/cpuinfo", encoding="utf-8") as f:
        model = re.search(r"^model name\s*:\s*(.*)$", f.read(), re.M)
    return f"{platform.system()} {platform.release()} {platform.machine()}, {model[1] if model else platform.processor()}"


HEAD = """# Command lines that nobody means

Every command with every flag and hostile values, files and words, and several flags together: see the head of
`tests/hostile/hostile.py` for what must hold of each line. Made by

    {command}

with the seed {seed}, on {machine}, {date}.

| kind | lines | findings |
|---|---:|---:|
"""


def main():
    a = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    a.add_argument("program")
    a.add_argument("seed", nargs="?", type=int, default=0)
    a.add_argument("--seconds", type=float, default=120)
    a.add_argument("--all", action="store_true")
    a.add_argument("--only", default="", help="lines that have these words, joined by blanks")
    a.add_argument("--markdown", metavar="FILE")
    o = a.parse_args()
    program = os.path.abspath(o.program)
    commands = flags_of(program)
    missing = sorted(set(PLAIN) ^ set(commands))
    if missing or sum(map(len, commands.values())) < 100:
        print("the commands of the manual are not those that are known here:", ", ".join(missing))
        return 1
    todo = list(lines(commands)) + list(pairs(commands, o.seed, 4000))
    if o.only:
        todo = [(kind, words) for kind, words in todo if o.only in shown(words).replace("'", "")]
    if not o.all:
        random.Random(o.seed).shuffle(todo)
    model = tempfile.mkdtemp(prefix="hostile-")
    lay_out(model, program)
    workers = os.cpu_count() or 1
    benches = [Bench(program, model) for _ in range(workers)]
    begin, count, found = time.time(), {}, []
    position = itertools.count()

    def work(bench):
        for k in position:
            if k >= len(todo) or (not o.all and time.time() - begin > o.seconds):
                return
            kind, words = todo[k]
            wrong = [w for w in bench.run(words) if not is_named_output(words, w)]
            tally = count.setdefault(kind, [0, 0])
            tally[0] += 1
            if wrong:
                tally[1] += 1
                found.append((kind, words, wrong))
                if len(found) <= 40:
                    print(f"{kind}: facetfit {shown(words)}\n    {'; '.join(wrong)}", flush=True)

    try:
        with concurrent.futures.ThreadPoolExecutor(workers) as pool:
            list(pool.map(work, benches))
    finally:
        for bench in benches:
            bench.close()
        shutil.rmtree(model, ignore_errors=True)
    done = sum(n for n, _ in count.values())
    print(f"{done} of {len(todo)} lines, seed {o.seed}, {time.time() - begin:.0f} s; {len(found)} findings")
    if o.markdown:
        with open(o.markdown, "w", encoding="utf-8") as f:
            f.write(HEAD.format(command=f"python3 tests/hostile/hostile.py PROGRAM {o.seed}{' --all' if o.all else ''} --markdown reports/hostile.md",
                                seed=o.seed, machine=machine(), date=datetime.date.today()))
            for kind in sorted(count):
                f.write(f"| {kind} | {count[kind][0]} | {count[kind][1]} |\n")
            f.write(f"| all | {done} | {len(found)} |\n")
    return 1 if found or done < 100 else 0


if __name__ == "__main__":
    sys.exit(main())
