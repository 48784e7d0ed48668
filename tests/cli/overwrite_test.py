#!/usr/bin/env python3
"""overwrite_test.py PROGRAM: wherever a command can name a file, it refuses to write to one that it names elsewhere; with --force, an
output takes the place of an input when the command has done its work, and of no other output.

What commands there are and where they name files comes from --help, so that a new flag is tested because it is there: whatever
is not in INPUTS counts as an output.
"""
import itertools
import os
import pathlib
import re
import subprocess
import sys
import tempfile

program = os.path.abspath(sys.argv[1])
FILE_WORDS = {"FILE", "FILE|-", "[FILE|-]", "IN", "OUT", "TABLE", "SOURCE", "FIT"}
INPUTS = {("fit", "FILE"), ("compare", "FILE"), ("ndf", "FILE"), ("info", "FILE"), ("eval", "FILE"), ("resample", "IN"),
          ("fit", "--ndf-table"), ("compare", "--ndf-table"), ("eval", "--ndf-table"), ("simulate", "--ndf-table"),
          ("furnace", "--ndf-table"), ("sample", "--ndf-table"), ("plot", "SOURCE"), ("plot", "--ndf-table"), ("plot", "--from"),
          ("eval", "--from"), ("simulate", "--from"), ("furnace", "--from"), ("sample", "--from"), ("render", "SOURCE"), ("render", "--ndf-table"),
          ("render", "--from"), ("export", "FIT"), ("export", "--ndf-table")}
OTHERS = {"EXPR": "lambert", "KIND": "slice"}
failures = pairs = 0
forced = [0, 0]  # refused or failed, replaced


def run(directory, *args, stdin=subprocess.DEVNULL):
    return subprocess.run([program, *args], cwd=directory, stdin=stdin, capture_output=True, text=True)


def fail(args, p, why):
    global failures
    failures += 1
    print("failed: facetfit %s: %s; status %d, %s" % (" ".join(args), why, p.returncode, p.stderr))


def places_of(command):
    """The positional words, and the places that name a file: words and flags."""
    lines = run(".", command, "--help").stdout.splitlines()
    words = [w.strip("[]") for w in lines[0].split()[2:-1] if w.strip("[]") != "..."] if command != "convert" else []
    flags = re.findall(r"^(?:      |  -\w, )(--\S+) (\S+)", "\n".join(lines), re.M)
    return words, [w for w in words if w in FILE_WORDS] + [flag for flag, argument in flags if argument in FILE_WORDS]


def try_pair(directory, command, words, one, other):
    """The same file in both places, with other files in the words that are left."""
    global pairs
    file = {one: "a.csv", other: "folder/a.csv"}
    left = [w for w in words if w != "EXPR" or "--from" not in (one, other)]  # a fit takes the place of the expression
    args = [command] + [file.get(w, OTHERS.get(w, "b.csv")) for w in left]
    for place in (one, other):
        if place.startswith("--"):
            args += [place, file[place]]
    pairs += 1
    before = (directory / "a.csv").read_bytes()
    p = run(directory, *args)
    if p.returncode != 2 or "file" not in p.stderr or one not in p.stderr or other not in p.stderr:
        fail(args, p, "expected a refusal that names %s and %s" % (one, other))
    if (directory / "a.csv").read_bytes() != before:
        fail(args, p, "a.csv is another now")
        (directory / "a.csv").write_bytes(before)
    replaces = ((command, one) in INPUTS) != ((command, other) in INPUTS)
    if replaces == ("--force" not in p.stderr):
        fail(args, p, "--force is named where it helps, and nowhere else")
    q = run(directory, *args, "--force")
    after = (directory / "a.csv").read_bytes()
    if not replaces and (q.returncode != 2 or after != before):
        fail(args + ["--force"], q, "expected a refusal: it is no input that would be replaced")
    if replaces and ("is the input" in q.stderr or (after != before) != (q.returncode == 0)):
        fail(args + ["--force"], q, "expected a.csv to be replaced by what is done, and by that alone")
    forced[q.returncode == 0 and replaces] += 1
    (directory / "a.csv").write_bytes(before)


def try_images(directory):
    """Files that an input names are inputs too."""
    if not os.path.exists(os.path.join(os.path.dirname(program), "facetfit_images.so")):
        print("image stacks are left out: this build has no module for them")
        return
    for name in ("image.pgm", "mask.pgm"):
        (directory / name).write_text("P2 2 2 255\n90 91 92 93\n")
    (directory / "stack.csv").write_text("image,theta_i,phi_i,theta_o,phi_o,mask\nimage.pgm,30,0,30,180,mask.pgm\n")
    for args in (["info", "stack.csv", "--json", "folder/image.pgm"], ["fit", "stack.csv", "--json", "mask.pgm"],
                 ["resample", "stack.csv", "image.pgm", "--to", "csv"], ["info", "-", "--format", "images", "--json", "image.pgm"]):
        with open(directory / "stack.csv") as stack:
            p = run(directory, *args, stdin=stack)
        if p.returncode != 2 or "would write" not in p.stderr or "--force" not in p.stderr or (directory / "image.pgm").stat().st_size != 23:
            fail(args, p, "expected a refusal")
    (directory / "stack.csv").write_text("image,theta_i,phi_i,theta_o,phi_o\nimage.pgm,30,0,30,180\n")
    p = run(directory, "info", "stack.csv", "--json", "folder/image.pgm", "--force")
    if p.returncode != 0 or not (directory / "image.pgm").read_text().startswith("{"):
        fail(["info"], p, "expected an image to be replaced")


with tempfile.TemporaryDirectory() as name:
    directory = pathlib.Path(name)
    (directory / "folder").symlink_to(".")
    for file in ("a.csv", "b.csv"):
        (directory / file).write_text("# quantity: brdf\ntheta_i,phi_i,theta_o,phi_o,f\n30,0,30,180,1.92\n30,0,35,180,1.61\n")
    for command in re.findall(r"^  (\w+) ", run(".", "--help").stdout, re.M):
        words, places = places_of(command)
        for one, other in itertools.combinations(places, 2):
            if not {(command, one), (command, other)} <= INPUTS:
                try_pair(directory, command, words, one, other)
    try_images(directory)
    if sorted(os.listdir(directory)) not in (["a.csv", "b.csv", "folder"],
                                             ["a.csv", "b.csv", "folder", "image.pgm", "mask.pgm", "stack.csv"]):
        failures += 1
        print("failed: left behind %s" % os.listdir(directory))
print("%d pairs of places, %d replaced by --force, %d failures" % (pairs, forced[1], failures))
sys.exit(1 if failures or pairs < 15 or forced[1] < 4 else 0)
