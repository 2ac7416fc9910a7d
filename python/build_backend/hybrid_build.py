# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Builds a wheel by CMake (PEP 517), without packages of its own.

Debian 12 has no scikit-build-core. A wheel has the package and its extension modules, and, as files below the prefix, the
libraries in lib and the reader of rawlogs in libexec, which find each other by relative paths. What Debian's packages of
scripts/packages.txt provide stays outside: the wheel is for the machine that built it and others like it.

Settings (pip install . --config-settings NAME=VALUE):
  build-dir  a folder for CMake, which may have been built before; default build/wheel
  jobs       how many compilers at once; default: as CMake chooses
The same sources and build give the same bytes. What is wrong is told in one line.
"""

import base64
import functools
import gzip
import hashlib
import io
import os
import pathlib
import re
import subprocess
import sys
import sysconfig
import tarfile
import tempfile
import zipfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
NAME = "hybrid_mapping"
PACKAGE_FILES = ("*.py", "*.pyi", "py.typed")
SETTINGS = ("build-dir", "jobs")


def told(hook):
    """A hook of which what is wrong is told in a line, without a trace of calls."""
    @functools.wraps(hook)
    def with_words(*arguments, **named):
        try:
            return hook(*arguments, **named)
        except subprocess.CalledProcessError as error:
            problem = f"'{' '.join(map(str, error.cmd))}' failed, with exit code {error.returncode}"
        except OSError as error:
            what = f"{error.filename} is not there" if isinstance(error, FileNotFoundError) else f"{error.filename}: {error.strerror}"
            problem = f"{what}; cmake, ninja, git and the packages of scripts/packages.txt are needed, and folders to write to"
        except RuntimeError as error:
            problem = str(error)
        raise SystemExit(f"error: {problem}")
    return with_words


def checked(settings):
    for name in settings or {}:
        if name not in SETTINGS:
            raise RuntimeError(f"there is no setting '{name}': --config-settings takes {' and '.join(SETTINGS)}")
    return settings or {}


def version():
    return re.search(r"project\(hybrid VERSION ([\d.]+)", (ROOT / "CMakeLists.txt").read_text(encoding="utf-8")).group(1)


def tag():
    """The interpreter and the machine, such as cp311-cp311-linux_x86_64."""
    python = f"cp{sys.version_info.major}{sys.version_info.minor}"
    return f"{python}-{python}-{re.sub(r'[-.]', '_', sysconfig.get_platform())}"


def metadata():
    summary = "Discrete-continuous smoothing and mapping: factor graphs with discrete and continuous unknowns"
    return (f"Metadata-Version: 2.1\nName: {NAME.replace('_', '-')}\nVersion: {version()}\nSummary: {summary}\n"
            "License: BSD-3-Clause\n"
            f"Requires-Python: =={sys.version_info.major}.{sys.version_info.minor}.*\nRequires-Dist: numpy\n"
            "Provides-Extra: plot\nRequires-Dist: matplotlib; extra == 'plot'\n")


def run(*command):
    """Runs CMake outside of the isolated environment of pip, which hides Debian's numpy from the interpreter."""
    env = {name: value for name, value in os.environ.items() if name not in ("PYTHONPATH", "PYTHONNOUSERSITE")}
    print("+", *command, flush=True)
    subprocess.run(list(map(str, command)), check=True, env=env)


def base_interpreter():
    """The interpreter that a virtual environment was made of."""
    return pathlib.Path(sys.base_prefix) / "bin" / f"python{sys.version_info.major}.{sys.version_info.minor}"


def targets_of(build):
    """What the wheel needs, as far as this build has it: without MRPT there are no rawlogs."""
    cache = (build / "CMakeCache.txt").read_text(encoding="utf-8")
    with_mrpt = re.search(r"^HYBRID_WITH_MRPT:BOOL=(ON|1|TRUE)$", cache, re.MULTILINE | re.IGNORECASE)
    return ["hybrid_python"] + (["hybrid_python_mrpt", "hybrid-rawlog-reader"] if with_mrpt else [])


def build_and_stage(settings, stage):
    build = pathlib.Path(settings.get("build-dir", ROOT / "build/wheel"))
    build = build if build.is_absolute() else ROOT / build
    if not (build / "CMakeCache.txt").exists():
        run("cmake", "-S", ROOT, "-B", build, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release", "-DCMAKE_UNITY_BUILD=ON",
            "-DHYBRID_PYTHON=ON", "-DHYBRID_BUILD_TESTS=OFF", "-DHYBRID_BUILD_BENCH=OFF", "-DHYBRID_MPI=OFF",
            f"-DPython_EXECUTABLE={base_interpreter()}")
    jobs = ["-j", settings["jobs"]] if "jobs" in settings else []
    run("cmake", "--build", build, *jobs, "--target", *targets_of(build))
    for component in ("python", "libhybrid0"):
        run("cmake", "--install", build, "--component", component, "--prefix", stage)


def contents(stage):
    """Name in the wheel -> file. Links become what they point to, under the name by which they are loaded."""
    found = {}
    for pattern in PACKAGE_FILES:
        found.update({f"hybrid/{file.name}": file for file in (ROOT / "python/hybrid").glob(pattern)})
    modules = [file for file in stage.rglob("*.so") if file.parent.name == "hybrid"]
    if not any(file.name.startswith("_core") for file in modules):
        raise RuntimeError("the build has no Python module: python3-dev, pybind11-dev and python3-numpy are needed")
    found.update({f"hybrid/{file.name}": file for file in modules})
    data = f"{NAME}-{version()}.data/data"
    for file in sorted(stage.glob("lib/lib*.so.*")):
        if file.is_symlink():
            found[f"{data}/lib/{file.name}"] = file.resolve()
    for file in stage.glob("libexec/hybrid/*"):
        found[f"{data}/libexec/hybrid/{file.name}"] = file
    return found


def digest(data):
    return "sha256=" + base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()


def information():
    """What the folder .dist-info tells of the wheel, by name of its file."""
    wheel = f"Wheel-Version: 1.0\nGenerator: hybrid_build\nRoot-Is-Purelib: false\nTag: {tag()}\n"
    return {"METADATA": metadata(), "WHEEL": wheel}


def write_wheel(path, found):
    info = f"{NAME}-{version()}.dist-info"
    records = []
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as wheel:

        def add(name, data, mode):
            entry = zipfile.ZipInfo(name, (2026, 1, 1, 0, 0, 0))
            entry.external_attr = (0o100000 | mode) << 16
            entry.compress_type = zipfile.ZIP_DEFLATED
            records.append(f"{name},{digest(data)},{len(data)}")
            wheel.writestr(entry, data)

        for name, file in sorted(found.items()):
            add(name, file.read_bytes(), 0o755 if os.access(file, os.X_OK) else 0o644)
        for name, text in information().items():
            add(f"{info}/{name}", text.encode(), 0o644)
        add(f"{info}/licenses/LICENSE", (ROOT / "LICENSE").read_bytes(), 0o644)
        add(f"{info}/RECORD", ("\n".join([*records, f"{info}/RECORD,,"]) + "\n").encode(), 0o644)


@told
def prepare_metadata_for_build_wheel(metadata_directory, config_settings=None):
    """Tells what the wheel will be, without which pip builds all to know, and once more to install it."""
    checked(config_settings)
    info = pathlib.Path(metadata_directory) / f"{NAME}-{version()}.dist-info"
    info.mkdir()
    for name, text in information().items():
        (info / name).write_text(text, encoding="utf-8")
    return info.name


@told
def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):  # pylint: disable=unused-argument
    name = f"{NAME}-{version()}-{tag()}.whl"
    with tempfile.TemporaryDirectory() as stage:
        build_and_stage(checked(config_settings), pathlib.Path(stage))
        write_wheel(pathlib.Path(wheel_directory) / name, contents(pathlib.Path(stage)))
    return name


@told
def build_editable(wheel_directory, config_settings=None, metadata_directory=None):
    raise RuntimeError("there are no editable installs: build the target hybrid_python and set PYTHONPATH to build/release/python")


def anyone(entry):
    """A file of the archive, of no user and no time."""
    entry.mtime, entry.uid, entry.gid, entry.uname, entry.gname = 1767225600, 0, 0, "", ""  # 2026
    entry.mode = 0o755 if entry.mode & 0o100 else 0o644
    return entry


@told
def build_sdist(sdist_directory, config_settings=None):
    """The files under version control."""
    checked(config_settings)
    folder = f"{NAME}-{version()}"
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, check=False, capture_output=True).stdout.decode().split("\0")
    if "CMakeLists.txt" not in listed:
        raise RuntimeError(f"{ROOT} is no clone: git tells which files belong to an sdist")
    path = pathlib.Path(sdist_directory) / f"{folder}.tar.gz"
    with gzip.GzipFile(path, "wb", mtime=0) as packed, tarfile.open(fileobj=packed, mode="w") as archive:
        for name in filter(None, listed):
            archive.add(ROOT / name, f"{folder}/{name}", filter=anyone)
        info = tarfile.TarInfo(f"{folder}/PKG-INFO")
        info.size = len(metadata().encode())
        archive.addfile(anyone(info), io.BytesIO(metadata().encode()))
    return path.name
