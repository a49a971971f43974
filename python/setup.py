"""Builds the extension module and the program by the project's CMake build, for pip, wheels (cp311-abi3) and source
distributions.

The library is linked into both; the program is for tyndall.run(), view() and their like. What they need of the system
(docs/dependencies.md) stays shared. Environment: TYNDALL_CMAKE_ARGUMENTS: more arguments of cmake, such as
-DTYNDALL_KERNELS=native. TYNDALL_PYTHON_MODULE and TYNDALL: a module and a program that were built before, which are taken
in place of a build.
"""
import os
import pathlib
import re
import shlex
import shutil
import subprocess
import sys

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext
from setuptools.command.sdist import sdist

HERE = pathlib.Path(__file__).resolve().parent
# What a source distribution has of the project beside this folder.
PARTS = ["CMakeLists.txt", "LICENSE", "cmake", "include", "scenes", "src"]


def project() -> pathlib.Path:
    """The project's folder: beside this one in the repository, in it in a source distribution."""
    for folder in (HERE / "project", HERE.parent):
        if (folder / "include" / "tyndall" / "base.h").is_file():
            return folder
    raise SystemExit("setup.py: the project's sources are neither in ./project nor in the folder above")


def version() -> str:
    text = (project() / "include" / "tyndall" / "base.h").read_text(encoding="utf-8")
    return re.search(r'#define TY_VERSION "([^"]+)"', text)[1]


class CMakeBuild(build_ext):
    """cmake and one target."""

    def build_extension(self, ext: Extension) -> None:
        module, tool = os.environ.get("TYNDALL_PYTHON_MODULE"), os.environ.get("TYNDALL")
        if not module:
            build = self.run_cmake()
            module, tool = build / "python" / "tyndall" / "_core.abi3.so", build / "bin" / "tyndall"
        target = pathlib.Path(self.get_ext_fullpath(ext.name)).resolve()
        (target.parent / "bin").mkdir(parents=True, exist_ok=True)
        shutil.copy2(module, target)
        if tool:
            shutil.copy2(tool, target.parent / "bin" / "tyndall")

    def run_cmake(self) -> pathlib.Path:
        build = pathlib.Path(self.build_temp).resolve() / "cmake"
        jobs = self.parallel or os.cpu_count() or 1
        options = {"CMAKE_BUILD_TYPE": "Release", "TYNDALL_PYTHON": "ON", "TYNDALL_CLI": "ON", "TYNDALL_TOOLS": "OFF",
                   "TYNDALL_TESTS": "OFF", "TYNDALL_EXAMPLES": "OFF", "TYNDALL_PYTHON_EXECUTABLE": sys.executable,
                   "TYNDALL_PYTHON_SOURCES": str(HERE)}
        generator = ["-G", "Ninja"] if shutil.which("ninja") else []
        subprocess.run(["cmake", "-S", str(project()), "-B", str(build), *generator,
                        *(f"-D{key}={value}" for key, value in options.items()),
                        *shlex.split(os.environ.get("TYNDALL_CMAKE_ARGUMENTS", ""))], check=True)
        subprocess.run(["cmake", "--build", str(build), "--target", "tyndall_python", "tyndall_cli", "--parallel",
                        str(jobs)], check=True)
        return build


class SourceDistribution(sdist):
    """The package with the project's sources, so that it builds by itself."""

    def make_release_tree(self, base_dir: str, files: list) -> None:
        super().make_release_tree(base_dir, files)
        for part in PARTS:
            source, target = project() / part, pathlib.Path(base_dir) / "project" / part
            target.parent.mkdir(parents=True, exist_ok=True)
            if source.is_dir():
                shutil.copytree(source, target, dirs_exist_ok=True)
            else:
                shutil.copy2(source, target)


setup(
    version=version(),
    ext_modules=[Extension("tyndall._core", [], py_limited_api=True)],
    cmdclass={"build_ext": CMakeBuild, "sdist": SourceDistribution},
    options={"bdist_wheel": {"py_limited_api": "cp311"}},
)
