"""Builds the Python package through CMake: `pip install .`. See pyproject.toml."""

import os
import re
import subprocess
import sys
from pathlib import Path

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext

TOP = Path(__file__).resolve().parent


def version():
    """As the headers say it, which is the only place that does."""
    text = (TOP / "base" / "ff_version.h").read_text()
    return ".".join(re.search(rf"#define FF_VERSION_{part} (\d+)", text)[1] for part in ("MAJOR", "MINOR", "PATCH"))


class BuildThroughCMake(build_ext):
    """The extension, and the module that reads images beside it, made by the project's own build."""

    def run(self):
        build = Path(self.build_temp).resolve() / "cmake"
        package = (TOP / "python" if self.inplace else Path(self.build_lib).resolve()) / "facetfit"
        build.mkdir(parents=True, exist_ok=True)
        package.mkdir(parents=True, exist_ok=True)
        asked = ["-DFACETFIT_PYTHON=ON", "-DFACETFIT_TESTS=OFF", "-DFACETFIT_BENCH=OFF", f"-DPython3_EXECUTABLE={sys.executable}"]
        try:
            import pybind11

            asked.append(f"-Dpybind11_DIR={pybind11.get_cmake_dir()}")
        except ImportError:
            pass  # CMake finds that of the system
        asked += os.environ.get("FACETFIT_CMAKE_ARGS", "").split()
        jobs = os.environ.get("CMAKE_BUILD_PARALLEL_LEVEL", str(os.cpu_count() or 1))
        subprocess.run(["cmake", "-S", str(TOP), "-B", str(build), *asked], check=True)
        subprocess.run(["cmake", "--build", str(build), "--parallel", jobs, "--target", "facetfit_python"], check=True)
        made = [*(build / "python" / "facetfit").glob("_core.*.so"), *(build / "bin").glob("facetfit_images.so")]
        for file in made:
            self.copy_file(str(file), str(package / file.name))

    def get_outputs(self):
        return [str(file) for file in (Path(self.build_lib) / "facetfit").glob("*.so")]


setup(
    version=version(),
    ext_modules=[Extension("facetfit._core", [])],
    cmdclass={"build_ext": BuildThroughCMake},
)
