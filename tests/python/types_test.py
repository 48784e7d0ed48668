#!/usr/bin/env python3
"""types_test.py FOLDER: the package in FOLDER is typed: mypy --strict has nothing to say, the stubs of the extension are what it has,
and a program that uses it wrongly is told so."""
import os
import subprocess
import sys
import tempfile

try:
    import numpy
    import mypy
except ImportError as missing:
    print(f"skipped: {missing}; ./setup packages would install it")
    sys.exit(0)

RIGHT = """import numpy as np
import facetfit

fit = facetfit.fit(facetfit.simulate("ggx+lambert"), "ggx+lambert", shape="isotropic")
error: float = fit.parameters[0].std_error
f = facetfit.Model("ggx", alpha=0.3)(np.ones((4, 3)), [0.0, 0.0, 1.0])
print(f.shape, error, fit.covariance.names[0].upper())
"""
WRONG = [
    ("fit.parameters[0].std_error", "fit.parameters[0].error"),
    ('"ggx+lambert", shape', "3, shape"),
    ("fit.covariance", "fit.covariances"),
]
# pybind11 makes classes of its own kind, and one that Python cannot make has no __init__ of its own.
ALLOWED = r"""
facetfit\._core\.(Model|Noise|Profile|Retrieval|Study|Table)
facetfit\._core\.Table\.__init__
"""


def run(*words, **more):
    made = subprocess.run([sys.executable, "-m", *words], capture_output=True, text=True, **more)
    return made.returncode, made.stdout + made.stderr


def main():
    folder = os.path.abspath(sys.argv[1])
    failed = False
    with tempfile.TemporaryDirectory() as scratch:
        environment = {**os.environ, "MYPYPATH": folder, "PYTHONPATH": folder}
        strict = ["mypy", "--strict", "--cache-dir", scratch]
        status, said = run(*strict, "-p", "facetfit", env=environment, cwd=scratch)
        print(said.strip())
        failed |= status != 0
        path, allowed = os.path.join(scratch, "program.py"), os.path.join(scratch, "allowed")
        for old, new in [("", ""), *WRONG]:
            assert old in RIGHT
            with open(path, "w") as file:
                file.write(RIGHT.replace(old, new, 1) if old else RIGHT)
            status, said = run(*strict, path, env=environment, cwd=scratch)
            if (status != 0) != bool(old):
                print(f"{new or 'the right program'}: mypy says {said}")
                failed = True
        with open(allowed, "w") as file:
            file.write(ALLOWED.lstrip())
        status, said = run("mypy.stubtest", "facetfit._core", "--allowlist", allowed, env=environment, cwd=scratch)
        print(said.strip())
        failed |= status != 0
    return failed


if __name__ == "__main__":
    sys.exit(main())
