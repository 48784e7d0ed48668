#!/usr/bin/env python3
"""hostile_test.py PROGRAM: whatever a name of a file or the value of a flag holds, nothing that is printed speaks to the terminal.

What commands and flags there are comes from --help, so that a new one is tested because it is there."""
import os
import re
import subprocess
import sys
import tempfile

program = os.path.abspath(sys.argv[1])
# red text, a forged line, CSI as one character, text from right to left, no UTF-8
HOSTILE = b"a\x1b[31m\nforged\r\x07\x7f\xc2\x9b\xe2\x80\xae\xff"
FORBIDDEN = re.compile("[\x00-\x09\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069]|^forged", re.M)
failures = runs = seen = 0


def check(*args):
    """The streams of a run, which has to end by itself. What the name became shows that it was printed at all."""
    global failures, runs, seen
    runs += 1
    p = subprocess.run([program.encode(), *args], stdin=subprocess.DEVNULL, capture_output=True, timeout=120)
    for stream, out in (("stdout", p.stdout), ("stderr", p.stderr)):
        text = out.decode("utf-8", "surrogateescape")
        wrong = FORBIDDEN.search(text) or re.search("[\udc80-\udcff]", text)
        seen += "\\x1b[31m\\x0aforged" in text or "\\u001b[31m\\nforged" in text
        if wrong:
            failures += 1
            print("failed: facetfit %s: %s has %r" % (args, stream, text[max(wrong.start() - 40, 0):wrong.end() + 20]))
    if p.returncode < 0 or p.returncode > 4:
        failures += 1
        print("failed: facetfit %s: status %d" % (args, p.returncode))
    return p


def flags_of(command):
    lines = subprocess.run([program, command, "--help"], capture_output=True, text=True, check=True).stdout
    return re.findall(r"^(?:      |  -\w, )--(\S+) (\S+)", lines, re.M)


def images(path):
    """What a list names is not what the reader of the message gave: nothing of it is told."""
    global failures
    with open("secret", "w") as f:
        f.write("root:x:0:0\n")
    with open(b"s" + HOSTILE + b".csv", "wb") as f:
        f.write(b"image,theta_i,phi_i,theta_o,phi_o\n%s,10,0,10,180\n%s,20,0,20,180\n" % (path, path))
    p = check(b"info", b"--format", b"images", b"s" + HOSTILE + b".csv")
    if b"root" in p.stderr + p.stdout or p.returncode not in (2, 3) or b"image '" not in p.stderr:
        failures += 1
        print("failed: an image list that names %r: status %d, %s" % (path, p.returncode, p.stderr))


with tempfile.TemporaryDirectory() as directory:
    os.chdir(directory)
    data = HOSTILE + b".csv"
    check(b"simulate", b"ggx+lambert", b"--set", b"alpha=0.3", b"--grid", b"goniometer:30", b"-o", data)
    subprocess.run([program, b"simulate", b"ggx", b"--set", b"f0=0.3:0.4", b"--grid", b"goniometer:30", b"-o", b"d.csv"], check=True)
    with open("d.csv", "rb") as f:  # names of channels that no reader refuses
        text = f.read().replace(b"c0", b"c\xc2\x9b\xe2\x80\xae\xff")
    with open(b"channels" + data, "wb") as f:
        f.write(text)
    for file in (data, b"channels" + data):
        for command in (b"info", b"fit --model ggx+lambert", b"fit --model lambert --free ks", b"fit --channels separate --model ggx",
                        b"fit --model ggx --table markdown", b"compare --ndf ggx", b"compare --ndf ggx,beckmann --table text", b"ndf"):
            check(*command.split(), file)
            check(*command.split(), file, b"--json", b"-")
        check(b"ndf", file, b"-o", b"-")
        for kind in (b"slice", b"residuals", b"forest"):
            check(b"plot", kind, file)
            check(b"plot", kind, file, b"--title", HOSTILE)
        check(b"resample", file, HOSTILE + b".2.csv")
        check(b"resample", file, HOSTILE)
        check(b"resample", file, HOSTILE + b".binary")
    check(HOSTILE)
    check(b"help", HOSTILE)
    for command in ("fit", "compare", "info", "ndf", "eval", "resample", "simulate", "furnace", "sample", "convert", "models", "formats", "plot", "man", "completion"):
        check(command.encode(), HOSTILE, HOSTILE)
        check(command.encode(), b"--" + HOSTILE)
        check(command.encode(), b"-" + HOSTILE)
        words = {"fit": [data], "compare": [data], "info": [data], "ndf": [data], "eval": [b"ggx", data], "resample": [data, b"o.csv"],
                 "simulate": [b"ggx", b"-o", b"o.csv"], "furnace": [b"ggx"], "sample": [b"ggx"], "plot": [b"slice", data]}.get(command, [])
        for flag, _ in flags_of(command):
            for value in (HOSTILE, b"alpha=" + HOSTILE, b"0.5" + HOSTILE):
                check(command.encode(), *words, b"--" + flag.encode(), value)
    with open(b"broken" + data, "wb") as f:
        f.write(b"theta_i,phi_i,theta_o,phi_o,f\n1,2,3,4,\x1b[31mforged\n")
    with open(b"unknown" + HOSTILE, "wb") as f:
        f.write(HOSTILE * 20)
    for file in (b"broken" + data, b"unknown" + HOSTILE, b"absent" + HOSTILE, b"."):
        check(b"info", file)
        check(b"fit", file)
    images(b"secret")
    images(b"/etc/passwd")
    os.chdir("/")
print("%d runs, the name in %d streams, %d failures" % (runs, seen, failures))
sys.exit(1 if failures or seen < runs / 2 else 0)
