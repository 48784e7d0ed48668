#!/usr/bin/env python3
"""extremes_test.py PROGRAM: numbers near the ends of the doubles are bad data with their place, or fitted; never an error of ours."""
import math
import os
import subprocess
import sys
import tempfile

program = os.path.abspath(sys.argv[1])
failures = runs = refused = 0
COMMANDS = [c.split() for c in ("info", "fit --model ggx+lambert", "fit --model ggx --loss log", "fit --model ggx --weight noise",
                                "fit --model ggx --channels mean", "compare --ndf ggx", "ndf")]


def write(name, factor=1.0, value=None, sigma=None, only=None):
    """`only`: the row that has the value; the others are ordinary."""
    with open(name, "w") as f:
        f.write("theta_i,phi_i,theta_o,phi_o,f" + (",sigma" if sigma else "") + "\n")
        for row in range(24):
            i, o = 10 + 20 * (row // 8), 10 * (row % 8)
            ordinary = 0.1 + math.exp(-((i - o) / 10) ** 2) * (1 + 0.1 * math.sin(7 * o + i))
            here = value if value is not None and only in (None, row) else factor * ordinary
            f.write("%d,0,%d,180,%r%s\n" % (i, o, here, ",%s" % sigma if sigma else ""))


def check(label, name, *more, place=None):
    global failures, runs, refused
    for command in COMMANDS:
        runs += 1
        p = subprocess.run([program, *command, name, *more], capture_output=True, text=True, timeout=120)
        refused += p.returncode == 3
        wrong = p.returncode not in (0, 1, 3) or "internal" in p.stderr
        if place is not None and p.returncode == 3 and "cannot be summed" in p.stderr:
            wrong |= place not in p.stderr or name not in p.stderr
        if wrong:
            failures += 1
            print("failed: %s, %s: status %d, %s" % (label, " ".join(command), p.returncode, p.stderr[-300:]))


with tempfile.TemporaryDirectory() as directory:
    os.chdir(directory)
    for value in (1e140, 1e153, 1e155, 1e200, 1e300, 1.7e308, 1e-155, 1e-300, 5e-324, -1e300):
        write("v.csv", value=value)
        check("values of %g" % value, "v.csv", place="sample 0")
        write("v.csv", value=value, only=10)
        check("one value of %g" % value, "v.csv", place="sample 10, theta_i = 30 and theta_o = 20 degrees")
    for sigma in ("1e-100", "1e-150", "1e-155", "1e-300", "1e-320", "1e150", "1e300", "1.7e308"):
        write("s.csv", sigma=sigma)
        check("sigma of " + sigma, "s.csv", place="sample ")
    write("a.csv")
    for scale in ("1e-320", "1e-300", "1e-160", "1e160", "1e300", "1e308"):
        check("--scale " + scale, "a.csv", "--scale", scale, place="sample ")
    for factor in (1e-139, 1e139):
        write("f.csv", factor=factor)
        check("values times %g" % factor, "f.csv")
    os.chdir("/")
print("%d runs, %d refused, %d failures" % (runs, refused, failures))
sys.exit(1 if failures or refused < runs / 4 else 0)
