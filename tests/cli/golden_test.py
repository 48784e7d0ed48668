#!/usr/bin/env python3
"""golden_test.py PROGRAM GOLDEN...: `eval --terms` against values that were computed from the definitions by quadrature. The first file is
the project's own; of the others those that are there are read.

1e-7 relative on D, Lambda, G, F and f, down to values of 1e-260. Lambda alone may also differ by 1e-20: that of student-t near normal
incidence is as small as 1e-22 beside 1, and there the file's quadrature has lost digits (direct integration of
(1/a) integral (t - a) P2(t) dt gives this program's 3.61495293e-20 where the file has 3.6161618e-20)."""
import csv
import itertools
import os
import subprocess
import sys

program, files = os.path.abspath(sys.argv[1]), sys.argv[2:]
SHAPE = ("alpha_x", "alpha_y", "r_xy", "slope_x", "slope_y", "gamma", "f0")
ANGLES = ("theta_i", "phi_i", "theta_o", "phi_o")
RESULTS = ("d", "lambda_i", "lambda_o", "g", "fresnel", "f")
TOLERANCE, ABSOLUTE = 1e-7, {"lambda_i": 1e-20, "lambda_o": 1e-20}
worst, compared, failures = {r: 0.0 for r in RESULTS}, 0, 0

rows = []
for golden in files:
    if golden != files[0] and not os.path.exists(golden):
        print("%s is not there" % golden)
        continue
    with open(golden, newline="", encoding="utf-8") as f:
        rows += csv.DictReader(f)


def group(row):
    return tuple(row[k] for k in ("ndf", "masking") + SHAPE)


for key, members in itertools.groupby(sorted(rows, key=group), group):
    members = list(members)
    assignments = ",".join("%s=%s" % (n, v) for n, v in zip(SHAPE, key[2:]) if v != "")
    text = ",".join(ANGLES) + "\n" + "".join(",".join(m[a] for a in ANGLES) + "\n" for m in members)
    for isa in ("best", "scalar"):
        p = subprocess.run([program, "eval", "%s/%s/schlick" % key[:2], "--set", assignments, "--terms", "--isa", isa], input=text,
                           capture_output=True, text=True)
        if p.returncode != 0:
            sys.exit("eval of %s failed: %s" % (key, p.stderr))
        for expected, found in zip(members, csv.DictReader(p.stdout.splitlines()), strict=True):
            for name in RESULTS:
                if expected[name] == "":  # a masking without Lambda
                    continue
                e, x = float(expected[name]), float(found[name])
                error = max(0.0, abs(x - e) - ABSOLUTE.get(name, 0.0)) / max(abs(e), 1e-300)
                compared += 1
                worst[name] = max(worst[name], error)
                if not error <= TOLERANCE:
                    failures += 1
                    print("%s %s %s: %s is %r, expected %r (%.2g)" % (isa, key, [expected[a] for a in ANGLES], name, x, e, error))

print("%d values of %d rows, worst relative error %s" % (compared, len(rows), ", ".join("%s %.1e" % i for i in worst.items())))
sys.exit(1 if failures or compared < 1000 else 0)
