"""advice_test.py FACETFIT: every advice that `info`, `fit` and a refusal print is taken, and helps: the roughness comes out that the data were
made with. Files of one incidence each are one measurement."""
import json
import math
import pathlib
import re
import shlex
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from dialects import vector  # noqa: E402

program = sys.argv[1]
failures = []


def check(condition, text):
    if not condition:
        failures.append(text)


def run(*words):
    done = subprocess.run([program, *words], stdin=subprocess.DEVNULL, capture_output=True, check=False)
    return done.returncode, done.stdout.decode("utf-8", "replace"), done.stderr.decode("utf-8", "replace")


def surface(ti, pi, to, po, ratio=1.0):
    """A GGX lobe of alpha 0.3 on a diffuse base; ratio: that of alpha_x to alpha_y."""
    i, o = vector(ti, pi), vector(to, po)
    h = [a + b for a, b in zip(i, o)]
    n = math.sqrt(sum(x * x for x in h))
    x, y, z = (a / n for a in h)
    ax, ay = 0.3 * ratio, 0.3 / ratio
    d = 1 / (math.pi * ax * ay * ((x / ax) ** 2 + (y / ay) ** 2 + z * z) ** 2)

    def smith(w):
        return (math.sqrt(1 + ((ax * w[0]) ** 2 + (ay * w[1]) ** 2) / (w[2] * w[2])) - 1) / 2
    f = 0.4 + 0.6 * (1 - sum(a * b / n for a, b in zip(i, h))) ** 5
    return 0.05 / math.pi + d * f / (4 * i[2] * o[2] * (1 + smith(i) + smith(o)))


TI, TO = [10, 25, 40, 55, 70], list(range(2, 76, 6))
ROWS = [(ti, 0, to, po, surface(ti, 0, to, po)) for ti in TI for to in TO for po in range(0, 360, 30)]
TURNED = [(ti, pi, to, pi + po, surface(ti, pi, to, pi + po, 1.3)) for ti in TI for pi in range(0, 180, 30) for to in TO for po in range(0, 360, 45)]
PLANE = [(ti, 0, abs(to), 180 if to >= 0 else 0, surface(ti, 0, abs(to), 180 if to >= 0 else 0)) for ti in TI for to in range(-74, 75, 4)]


def write(name, rows, header="theta_i,phi_i,theta_o,phi_o,f"):
    text = header + "\n" + "".join(",".join("%.9g" % v for v in row) + "\n" for row in rows)
    pathlib.Path(name).write_text(text)
    return name


def flags_of(said):
    found = re.search(r"say (--[a-z-]+) ('[^']*'|[^\s;,]+)", said)
    return shlex.split("%s %s" % found.groups()) if found else []


def alpha_of(path, *flags):
    status, out, said = run("fit", path, *flags, "--json", "-")
    if not out:
        return status, None, said
    fit = json.loads(out)["fits"][0]
    return status, fit, said


def values(fit, name):
    return fit["parameters"][name]["value"]


def is_right(fit, ratio=1.0):
    return fit is not None and abs(values(fit, "alpha_x") / (0.3 * ratio) - 1) < 0.02 and abs(values(fit, "alpha_y") / (0.3 / ratio) - 1) < 0.02


def diagnose(label, path, ratio=1.0, stops=True, kind=None):
    """A fit stops, or says it, with a flag that mends it; so does info, in text and JSON; --as-is goes on."""
    status, fit, said = alpha_of(path)
    verdict = "" if fit is None else next((v["text"] for v in json.loads(run("fit", path, "--json", "-")[1])["verdict"] if v["code"] == "unit"), "")
    flags = flags_of("".join([line for line in said.splitlines() if "--as-is" in line] + [verdict]))
    check(flags, "%s: no advice in: %s" % (label, said))
    check(status == 3 and fit is None if stops else fit is not None, "%s: exit status %d: %s" % (label, status, said))
    informed = [flags_of(line) for line in run("info", path)[1].splitlines() if line.startswith("warning: ")]
    check(flags in informed, "%s: fit says %s, info %s" % (label, flags, informed))
    found = json.loads(run("info", path, "--json", "-")[1])["geometry"]
    check(found["open"] and any(f["kind"] == kind and ["--" + f["option"], f["value"]] == flags for f in found["findings"]), "%s: %s" % (label, found))
    if stops:
        check(alpha_of(path, "--as-is")[1] is not None, "%s: --as-is does not insist" % label)
    status, fit, said = alpha_of(path, *flags)
    check(status == 0 and is_right(fit, ratio), "%s: with %s exit status %d: %s %s" % (label, flags, status, said, fit and [values(fit, n) for n in ("alpha_x", "alpha_y")]))


def test_diagnoses():
    diagnose("mirror", write("mirror.csv", [(a, b, c, d + 180, f) for a, b, c, d, f in ROWS]), kind="turned")
    diagnose("elevation", write("up.csv", [(90 - a, b, 90 - c, d, f) for a, b, c, d, f in ROWS]), kind="elevation")
    diagnose("elevation of the light", write("up_i.csv", [(90 - a, b, c, d, f) for a, b, c, d, f in ROWS]), kind="elevation-in")
    diagnose("elevation of the detector", write("up_o.csv", [(a, b, 90 - c, d, f) for a, b, c, d, f in ROWS]), kind="elevation-out")
    diagnose("clockwise", write("clock.csv", [(a, b, c, -d, f) for a, b, c, d, f in TURNED]), ratio=1.3, kind="clockwise")
    diagnose("a scan the other way", write("scan.csv", [(a, c if d == 0 else -c, f) for a, b, c, d, f in PLANE], "theta_i,theta_o,brdf"), kind="unturned")
    cosine = lambda c: math.cos(math.radians(c))
    diagnose("times the cosine", write("cosine.csv", [(a, b, c, d, f * cosine(c)) for a, b, c, d, f in ROWS]), kind="cosine")
    diagnose("times the cosine, of one channel", write("cosines.csv", [(a, b, c, d, f * cosine(c), f * cosine(c)) for a, b, c, d, f in ROWS], "theta_i,phi_i,theta_o,phi_o,f_a,f_b"), kind="cosine")
    check(alpha_of("cosines.csv", "--reduce", "channels:a")[0] == 3, "a choice of channels leaves open what the values are, too")
    for label, path, flags in (("a file that says that it is the BRDF", write("named_brdf.csv", [(a, b, c, d, f * cosine(c)) for a, b, c, d, f in ROWS], "theta_i,phi_i,theta_o,phi_o,BRDF"), []),
                               ("a person who says it", "cosine.csv", ["--quantity", "brdf"]),
                               ("a comment that says it", write("said.csv", [(a, b, c, d, f * cosine(c)) for a, b, c, d, f in ROWS], "# quantity: brdf\ntheta_i,phi_i,theta_o,phi_o,f"), [])):
        status, fit, said = alpha_of(path, *flags)
        check(fit is not None and ["--quantity", "brdf-cos"] == flags_of(said), "%s is told, and goes on: %d: %s" % (label, status, said))
    diagnose("per cent", write("percent.csv", [(a, b, c, d, 100 * f) for a, b, c, d, f in ROWS]), stops=False, kind="percent")
    status, fit, said = alpha_of(write("right.csv", ROWS))
    check(status == 0 and is_right(fit) and "say --" not in said, "right data: %d: %s" % (status, said))
    status, fit, said = alpha_of(write("ours.csv", [(a, b, c, d + 180, f) for a, b, c, d, f in ROWS], "# facetfit-csv: 1\ntheta_i,phi_i,theta_o,phi_o,f"))
    check(status == 0 and fit is not None, "a file that says how its angles are counted is fitted: %d: %s" % (status, said))
    status, fit, said = alpha_of(write("beyond.csv", [r for r in ROWS if r[2] > 64]), "--max-theta", "60")
    check(status != 0, "all samples beyond --max-theta: %d" % status)
    found = re.search(r"say (--max-theta) (\S+)", run("info", write("grazing.csv", [(a, b, c / 10 + 82, d, f) for a, b, c, d, f in ROWS]))[1])
    check(found and alpha_of("grazing.csv", *found.groups())[1] is not None, "grazing: %s" % (found and found.groups(),))


def test_refusals():
    """Tables that are refused until their flag is said."""
    radians = [tuple(math.radians(v) for v in r[:4]) + (r[4],) for r in ROWS]
    plain = "theta_i,phi_i,theta_o,phi_o,f"
    cases = [("radians of ours", write("rad.csv", radians)), ("radians", write("rad2.csv", [r[:1] + r[2:] for r in radians], "AOI,Det,Azimuth,BRDF")),
             ("no names", write("bare.csv", [r[:1] + r[2:] for r in ROWS[1:]], "10,2,0,%.9g" % ROWS[0][4])),
             ("no azimuth of the detector", write("half.csv", [r[:3] + r[4:] for r in PLANE if r[3] == 180], "theta_i,phi_i,theta_o,f")),
             ("strangers", write("odd.csv", [r[:1] + r[2:] for r in ROWS], "AOI,gizmo,widget,thing"))]
    text = pathlib.Path(write("mixed.csv", ROWS, plain)).read_text().replace(",", ";").splitlines()
    text[3] = text[3].replace(".", ",")
    pathlib.Path("mixed.csv").write_text("\n".join([text[0]] + [re.sub(r"(\d)\.(\d)", r"\1,\2", line) if k % 2 else line for k, line in enumerate(text[1:3])] +
                                                    [line.replace(".", ",") for line in text[3:]]) + "\n")
    for label, path in cases:
        status, fit, said = alpha_of(path)
        flags = flags_of(said)
        check(status == 3 and fit is None and flags, "%s: exit status %d: %s" % (label, status, said))
        status, fit, said = alpha_of(path, *flags)
        check(status == 0 and is_right(fit), "%s: with %s exit status %d: %s" % (label, flags, status, said))
    status, fit, said = alpha_of("mixed.csv")
    check(status == 3 and "dialect" in " ".join(flags_of(said)), "two decimal marks: %d %s" % (status, said))


def test_notes():
    """The mapping that a note tells reads the same."""
    path = write("named.csv", [(a, c, d, f, 20) for a, b, c, d, f in ROWS], "Einfallswinkel [°],Ausfallswinkel [°],Azimut [°],BRDF [1/sr],Temperatur")
    said = run("resample", path, "named_1.csv")[2]
    flags = flags_of(said)
    check(flags and flags[0] == "--columns" and "Temperatur" in said, said)
    run("resample", path, "named_2.csv", *flags)
    check(pathlib.Path("named_1.csv").read_text() == pathlib.Path("named_2.csv").read_text(), "the mapping of the note reads otherwise")
    out = run("info", path, "--explain")[1]
    check("the first samples as they are understood" in out and "10,0,2,0," in out, out)


def test_joined():
    """One file for each incidence: its angle in the name, in a line, or in a column."""
    folder = pathlib.Path("scans")
    folder.mkdir()
    for ti in TI:
        rows = [(c, d, f) for a, b, c, d, f in ROWS if a == ti]
        write(str(folder / ("A3_%ddeg.csv" % ti)), rows, "theta_o,phi_o,f")
        write("line_%c.csv" % (65 + TI.index(ti)), rows, "# theta_i = %g\ntheta_o,phi_o,f" % ti)
        write("column_%d.csv" % ti, [r for r in ROWS if r[0] == ti])
    (folder / "README").write_text("not a measurement\n")
    for label, files in (("a folder", ["scans"]), ("lines", ["line_%c.csv" % (65 + k) for k in range(len(TI))]), ("columns", ["column_%d.csv" % t for t in TI])):
        status, fit, said = alpha_of(files[0], *files[1:])
        check(status == 0 and is_right(fit) and "5 files are joined" in said, "%s: exit status %d: %s" % (label, status, said))
    check("README" in run("info", "scans")[1], "what is passed over in a folder is not named")
    write("other.csv", [(10, 0, 10, 0, 1, 1)], "theta_i,phi_i,theta_o,phi_o,f_r,f_g")
    status, _, said = run("info", "column_10.csv", "other.csv")
    check(status == 3 and "other.csv" in said and "2 channels" in said, said)
    status, _, said = run("fit", "column_10.csv", "column_25.csv", "--json", "column_25.csv")
    check(status == 3 or status == 2, "an output over the second input: %d" % status)
    check(pathlib.Path("column_25.csv").read_text().startswith("theta_i"), "the second input was written over")


def main():
    with tempfile.TemporaryDirectory() as folder:
        import os
        os.chdir(folder)
        for test in (test_diagnoses, test_refusals, test_notes, test_joined):
            test()
        os.chdir("/")
    print("%d failures" % len(failures))
    return "\n".join(failures) if failures else 0


sys.exit(main())
