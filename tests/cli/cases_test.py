#!/usr/bin/env python3
"""cases_test.py PROGRAM FOLDER: small inputs of kinds that people have, made from formulas by another program, and the values behind
them. FOLDER lies beside the project; without it the test is skipped. What a case stands for is named beside it."""
import json
import os
import subprocess
import sys

program, folder = os.path.abspath(sys.argv[1]), sys.argv[2]
if not os.path.isdir(folder):
    print("%s is not there" % folder)
    sys.exit(77)
checks, failures = 0, 0


def check(holds, *words):
    global checks, failures
    checks += 1
    if not holds:
        failures += 1
        print("failed:", *words)


def run(command, name, *flags):
    p = subprocess.run([program, command, os.path.join(folder, name), *flags], capture_output=True, text=True)
    check(p.returncode in (0, 1), command, name, *flags, p.stderr)
    return p.stdout, p.stderr


def values(name, *flags):
    """Of the first fit: {parameter: [(value, error) of each channel]}, the codes of its warnings, the number of samples used."""
    out, said = run("fit", name, *flags, "--json", "-")
    if not out:
        return {}, set(), 0, said
    report = json.loads(out)
    fit = report["fits"][0]
    found = {}
    for key, p in fit["parameters"].items():
        v, e = p["value"], p["std_error"]
        found[key] = list(zip(v, e)) if isinstance(v, list) else [(v, e)]
    return found, {w["code"] for w in fit["warnings"]}, report["data"]["used"], said


def near(what, found, key, expected, errors=3.0, slack=0.0):
    """Each channel within so many of its errors, or the slack."""
    expected = expected if isinstance(expected, (list, tuple)) else [expected]
    check(len(found.get(key, [])) == len(expected), what, key, found.get(key))
    for (v, e), x in zip(found.get(key, []), expected):
        check(abs(v - x) <= max(errors * (e or 0), slack), what, key, "is", v, "+-", e, "expected", x)


# 5 % noise: alpha .25, F0 .3, kd .2, and the same again with standard deviations, copied four times, by wavelength, by numpy
n1, _, used, _ = values("n1.csv")
for name, slack in (("n1.csv", 0), ("c_std.csv", 0), ("n4.csv", 0), ("c_wl.csv", 0), ("savetxt_c.csv", 0)):
    found, codes, n, said = values(name)
    near(name, found, "alpha_x", 0.25)
    near(name, found, "f0", [0.3] * len(found.get("f0", [])))
    near(name, found, "kd", [0.2] * len(found.get("kd", [])))
    check(("copies" in codes) == (name == "n4.csv"), name, codes)
    if name in ("n4.csv", "savetxt_c.csv"):
        check(n == used and abs(found["alpha_x"][0][1] - n1["alpha_x"][0][1]) < 1e-9, name, n, found["alpha_x"])
check(len(values("c_std.csv")[0]["f0"]) == 1 and len(values("c_wl.csv")[0]["f0"]) == 2, "standard deviations are no channel")

# values of 1e-6: the same relative result in every unit
small = [values("mini.csv", "--model", "ggx/smith-height-correlated/none", "--free", "ks", "--scale", s)[0] for s in ("1", "1e6", "1e-6")]
near("mini.csv", small[0], "alpha_x", 0.139, 1)
near("mini.csv", small[0], "ks", 4.91e-6, 1)
for other, scale in ((small[1], 1e6), (small[2], 1e-6)):
    for key, unit in (("alpha_x", 1), ("ks", scale)):
        for k in range(2):
            a, b = small[0][key][0][k] * unit, other[key][0][k]
            check(abs(a - b) < 1e-3 * abs(a), "mini.csv in units of", scale, key, a, b)

# codes of what was not measured, and the errors of a spreadsheet: named and left out
found, codes, n, said = values("missing.csv")
check(n == 820 and "12 values are -9999" in said, "missing.csv", n, said)
near("hash_value.csv", values("hash_value.csv")[0], "alpha_x", 0.25, 0, 1e-5)
check("#DIV/0!" in values("hash_value.csv")[3] and values("hash_value.csv")[2] == 539, "hash_value.csv")
near("trailing_empty.csv", values("trailing_empty.csv")[0], "alpha_x", 0.25, 0, 1e-5)
check(len(values("um_head2.csv")[0]["f0"]) == 3, "um_head2.csv: three channels")

# azimuth 0 on the mirror side
check("brightest-elsewhere" in values("azflip.csv", "--as-is")[1], "azflip.csv", values("azflip.csv", "--as-is")[1])
found = values("azflip.csv", "--azimuth", "mirror")[0]
near("azflip.csv", found, "alpha_x", 0.25, 3, 1e-4)
for name in ("gonio_long", "gonio_wide"):
    near(name, values(name + ".csv")[0], "alpha_x", 0.15, 3, 0.02)
for name in ("semicolon_decimalcomma", "utf16", "rusin", "xyz", "pivot", "trailing_empty", "hash_value", "um_head2"):
    near(name, values(name + ".csv")[0], "alpha_x", 0.25, 3, 1e-3)
near("space_nohdr", values("space_nohdr.txt", "--columns", "theta_i=#1,phi_i=#2,theta_o=#3,phi_o=#4,f=#5")[0], "alpha_x", 0.25, 3, 1e-3)
check("on the side of the light" in run("info", "azflip.csv")[0], "info azflip.csv")

# a scan in the plane of incidence: exact, and no coverage
found = values("inplane_signed_phi.csv")[0]
for key, x in (("alpha_x", 0.25), ("f0", 0.3), ("kd", 0.2)):
    near("inplane_signed_phi.csv", found, key, x, 3, 1e-4)
out = run("info", "inplane_signed_phi.csv")[0]
check("beside it nothing was measured" in out and "not known, since nothing was measured beside" in out, out)

# a lobe as narrow as detectors are: alpha .02 seen by a disc of 1.5 degrees
found, codes, _, _ = values("aper02.csv")
check("narrow-lobe" in codes and found["alpha_x"][0][0] > 0.02, "aper02.csv", codes, found["alpha_x"])

# gold in 301 channels as sRGB, out of the gamut; counts times the cosine in any unit; a conductor whose metal is known
found = values("spec_nm.csv", "--reduce", "srgb")[0]
near("spec_nm.csv", found, "f0", [1.06, 0.78, 0.32], 0, 0.005)
near("spec_nm.csv", found, "alpha_x", 0.2, 0, 1e-5)
near("spec_nm.csv", found, "kd", [0, 0, 0], 0, 1e-4)
for scale in ("1", "1e-6"):
    found = values("cnt.csv", "--quantity", "brdf-cos", "--free", "ks", "--fix", "f0=0.3", "--scale", scale)[0]
    near("cnt.csv", found, "alpha_x", 0.25, 0, 1e-3)
found = values("gold_nk.csv", "--model", "ggx/smith-height-correlated/conductor", "--fix", "eta=.18:.42:1.45,k=3.4:2.4:1.9")[0]
check([v for v, _ in found.get("eta", [])] == [0.18, 0.42, 1.45], "gold_nk.csv", found.get("eta"))

# a cosine in the values: info sees it, and what it advises is taken
for name in ("z_brdfcos.bsdf", "f.fred"):
    check("--quantity brdf-cos" in run("info", name)[0], "info", name)
    check("--quantity brdf-cos" not in run("info", name, "--quantity", "brdf-cos")[0], "info", name, "as advised")
for name in ("fred_exclude.txt", "fred_num.txt"):
    check("samples    3" in run("info", name)[0], "info", name)

# A/(B + d^g) with 3 % noise over 8 decades
found = values("abg.csv", "--model", "abg", "--loss", "ln")[0]
for key, x in (("abg_a", 3e-7), ("abg_b", 1e-8), ("abg_g", 2.2)):
    near("abg.csv", found, key, x)

# v-cavity loses at 8 of 8 incidences; student-t contains ggx, which is the answer
out = run("compare", "power.csv", "--ndf", "ggx", "--masking", "v-cavity,smith-height-correlated")[0]
check("* best: ggx/smith-height-correlated" in out, "power.csv", out)
out = run("compare", "nested.csv", "--ndf", "ggx,student-t", "--masking", "smith-height-correlated")[0]
check("simplest that is not told apart from the best: ggx/" in out, "nested.csv", out)

print("%d checks, %d failures" % (checks, failures))
sys.exit(1 if failures else 0)
