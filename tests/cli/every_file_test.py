#!/usr/bin/env python3
"""every_file_test.py PROGRAM DATA: every file is described by `info` and fitted by the default command: one of each format that is made by
tests/made/make_files.py, one of each format that the program writes, and the measured ones at DATA where there are any.

What cannot be read as it is must be refused with an explanation, and read with what the explanation asks for. Prints a table of what
came out; skipped (77) when there are no measured files and numpy is not there to make others.
"""
import json
import os
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "made"))
try:
    import make_files
except ImportError:
    make_files = None

# Not measurements: descriptions, licences, published parameters, weights of networks.
NO_DATA = {"README.md", "README.txt", "rgl_reference_values.txt", "LICENSE", "LICENSE.ua-loft", "MERL_sha256_from_lfs_pointers.txt",
           "nbrdf_weights.npz", "valid_mask.bits", "material_brdf_schema.json"}
NO_FOLDERS = {"tables", "svbrdf"}
# Of formats without a reader: refused, with the formats that there are.
NO_READER = {"unknown.coated"}
# Refused without these flags; words of the explanation.
NEEDS = {"golden_paper_partial.txt": (["--scale", "1e-3"], ["uA", "--scale"])}
# All of it lies beyond the angle that fits look at.
BEYOND = {"asphalt_lidar_brdf.xompt": "--max-theta 90"}
# Words that the notes or warnings of info must have.
SAYS = {"retro-gray-tape.dat": ["no #PARAM_OUT", "is a cosine counted in the values?"], "C9_Gold.astm": ["VARS names 6 columns, the rows have 7"]}


def run(program, *words):
    p = subprocess.run([program, *words], capture_output=True, text=True, check=False, timeout=120)
    return p.returncode, p.stdout, p.stderr


def files(data):
    for folder in sorted(os.listdir(data)):
        path = os.path.join(data, folder)
        if not os.path.isdir(path) or folder in NO_FOLDERS:
            continue
        for name in sorted(os.listdir(path)):
            if name not in NO_DATA:
                yield os.path.join(path, name)


def check(program, path, failures):
    name, flags = os.path.basename(path), []
    if name in NEEDS:
        flags, words = NEEDS[name]
        status, _, said = run(program, "fit", path)
        if status not in (2, 3) or not all(w in said for w in words):
            failures.append(f"{name}: without {flags} exit status {status}: {said}")
    status, out, said = run(program, "info", path, *flags)
    if name in NO_READER:
        if status != 3 or "no format recognises it" not in said or "expected one of merl" not in said:
            failures.append(f"{name}: a format without a reader: exit status {status}: {said}")
        return
    if status != 0:
        failures.append(f"{name}: info: exit status {status}: {said}")
        return
    if "cosine counted" in out or "cosine divided" in out:
        if name != "retro-gray-tape.dat":
            failures.append(f"{name}: info suspects a cosine")
    for words in SAYS.get(name, []):
        if words not in out:
            failures.append(f"{name}: info does not say '{words}'")
    if name in BEYOND:
        said = run(program, "fit", path)[2]
        if BEYOND[name] not in said:
            failures.append(f"{name}: a fit without {BEYOND[name]} does not say it: {said}")
        flags = [*flags, *BEYOND[name].split()]
    status, out, said = run(program, "fit", path, "--json", "-", *flags)
    if status not in (0, 1):
        failures.append(f"{name}: fit: exit status {status}: {said}")
        return
    document = json.loads(out)
    fit, data = document["fits"][0], document["data"]
    if fit["outcome"] != "converged":
        failures.append(f"{name}: fit: {fit['outcome']}")
    if data["used"] < 0.3 * data["samples"]:
        failures.append(f"{name}: only {data['used']} of {data['samples']} samples used")
    alpha = fit["parameters"]["alpha_x"]["value"]
    print(f"{name:44} {data['format']:10} {data['samples']:8} {data['used']:8}  alpha_x {alpha:.4f}  log rmse {fit['residual']['log_rmse']:.4g}")


def write_pgii_current(path):
    """A file that says that it holds currents: refused without a scale, and read with one."""
    with open(path, encoding="ascii") as f:
        text = f.read()
    with open(os.path.join(os.path.dirname(path), "golden_paper_partial.txt"), "w", encoding="ascii") as f:
        f.write(text.replace("[DSF]", "[uA]").replace("theta phi DSF", "theta phi [uA]"))


def make(program, folder, failures):
    """Files of every format into folder/made and folder/written; their number."""
    made, written = os.path.join(folder, "made"), os.path.join(folder, "written")
    os.mkdir(made)
    os.mkdir(written)
    paths = make_files.make(made)
    write_pgii_current(paths["pgii"])
    with open(os.path.join(made, "unknown.coated"), "w", encoding="ascii") as f:
        f.write("OPTIS - coated surface file v3.0\n1\n")
    formats = json.loads(run(program, "formats", "--json", "-")[1])["formats"]
    with open(paths["images"], encoding="ascii") as f:
        lines = f.read()
    if "images" in [f["name"] for f in formats]:
        with open(paths["images"], "w", encoding="ascii") as f:
            f.write(lines.replace("made-", "../made-"))
    else:
        os.remove(paths["images"])
    for name in os.listdir(made):
        if name.endswith(".pfm"):  # parts of the list
            os.rename(os.path.join(made, name), os.path.join(folder, name))
    for f in formats:
        if not f["writes"] or f["name"] == "merl":
            continue
        path = os.path.join(written, "written." + f["extensions"].split()[0].lstrip("."))
        one = ["--reduce", "mean"] if f["name"] in ("zemax", "fred", "anisotropicbsdf", "openmaterial", "lighttools") else []  # these have one channel
        status, _, said = run(program, "resample", paths["mbsdf"], path, "--to", f["name"], *one)
        if status != 0:
            failures.append(f"resample to {f['name']}: exit status {status}: {said}")
    return len(os.listdir(made)) + len(os.listdir(written))


def check_all(program, data, least, failures):
    n = 0
    for path in files(data):
        check(program, path, failures)
        n += 1
    print(f"{n} files of {data}")
    if n < least:
        failures.append(f"only {n} files of {data}")


def main(argv):
    program, data = os.path.abspath(argv[1]), os.environ.get("FACETFIT_DATA", argv[2])
    if not os.path.isdir(data) and not make_files:
        print(f"no measured data at {data}, and no numpy to make files")
        return 77
    failures = []
    if make_files:
        with tempfile.TemporaryDirectory() as folder:
            check_all(program, folder, make(program, folder, failures), failures)
    if os.path.isdir(data):
        check_all(program, data, 30, failures)
    else:
        print(f"no measured files at {data}")
    print(f"{len(failures)} failures")
    for f in failures:
        print(f)
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv))
