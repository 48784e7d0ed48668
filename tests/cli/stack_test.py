#!/usr/bin/env python3
"""stack_test.py PROGRAM MADE: every command does its work where the limit of the stack (ulimit -s) is 192 KiB, less than the library
needs: on threads whose stacks have their own size. The files are made by make_files.py of the folder MADE."""
import os
import re
import resource
import subprocess
import sys
import tempfile

PROGRAM = os.path.abspath(sys.argv[1])
sys.path.insert(0, sys.argv[2])
try:
    import make_files
except ImportError:
    print("skipped: this needs python3-numpy")
    sys.exit(77)

LIMIT = 192 << 10
LINES = ["fit made.csv", "fit made.csv --robust huber", "fit made.csv --bootstrap 20 --threads 2", "fit made.csv --profile", "fit stack.csv --model ggx+lambert",
         "compare made.csv --ndf ggx,beckmann --masking smith-height-correlated,v-cavity", "ndf made.csv", "info made.csv", "info stack.csv",
         "info made.rgl.bsdf", "resample one.csv made.zemax.bsdf --grid rotation:90,incidence:20,azimuth:30,radial:0/2/5/10",
         "simulate ggx+lambert --set alpha=0.3 --grid goniometer:15 -o one.csv", "sample ggx+lambert", "eval ggx+lambert directions.csv",
         "furnace ggx/v-cavity", "plot slice made.csv -o a.svg", "plot profile made.csv -o a.pdf", "render ggx+lambert --environment sky --size 9 -o a.png", "render made.csv --size 9 -o a.exr", "plot bootstrap made.csv --bootstrap 20 -o b.csv", "convert --from beckmann --to phong m=0.3", "models", "models ggx", "formats", "selftest", "fit --help", "completion bash", "man fit",
         "fit made.csv --for blender --json fit.json", "export fit.json --to gltf -o made.gltf", "export fit.json --to c -o made.h",
         "fit made.csv one.csv -o fits --html index.html --summary old.csv", "gather fits", "diff old.csv old.csv"]
# The made one first: others read it.
LINES.sort(key=lambda line: not line.startswith("simulate"))
DIRECTIONS = "theta_i,phi_i,theta_o,phi_o\n30,0,30,180\n45,0,20,90\n"


def limited():
    resource.setrlimit(resource.RLIMIT_STACK, (LIMIT, LIMIT))


def run(folder, words):
    return subprocess.run([PROGRAM, *words], cwd=folder, stdin=subprocess.DEVNULL, capture_output=True, check=False, preexec_fn=limited,
                          timeout=600)


def main():
    failed = []
    with tempfile.TemporaryDirectory() as folder:
        for kind in ("csv", "images", "rgl"):
            name, make = make_files.FILES[kind]
            make(os.path.join(folder, name))
        with open(os.path.join(folder, "directions.csv"), "w", encoding="utf-8") as file:
            file.write(DIRECTIONS)
        has_images = os.path.exists(os.path.join(os.path.dirname(PROGRAM), "facetfit_images.so"))
        lines = [line for line in LINES if has_images or "stack.csv" not in line]
        for line in lines:
            done = run(folder, line.split())
            if done.returncode not in (0, 1):
                failed.append(f"facetfit {line}: {done.returncode} {done.stderr.decode('utf-8', 'replace')[:300]}")
        commands = re.findall(r"^  (\w+) ", run(folder, ["--help"]).stdout.decode(), re.M)
        failed += [f"the command {command} is not tried" for command in commands if not any(line.startswith(command) for line in LINES)]
    print(f"{len(lines)} lines of {len(commands)} commands by {LIMIT >> 10} KiB of stack, {len(failed)} failures")
    print("\n".join(failed), end="\n" if failed else "")
    return bool(failed)


if __name__ == "__main__":
    sys.exit(main())
