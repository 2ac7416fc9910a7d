# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Builds a wheel by CMake (PEP 517), without packages of its own.

Debian 12 has no scikit-build-core. A wheel has the package and its extension modules, and, as files below the prefix, the
libraries in lib and the reader of rawlogs in libexec, which find each other by relative paths. What Debian's packages of
scripts/packages.txt provide stays outside: the wheel is for the machine that built it and others like it.

Settings (pip install . --config-settings NAME=VALUE):
  build-dir  a folder for CMake, which may have been built before; default build/wheel
  jobs       how many compilers at once; default: as CMake chooses
"""

import base64
import hashlib
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
            wheel.writestr(entry, data)
            records.append(f"{name},{digest(data)},{len(data)}")

        for name, file in sorted(found.items()):
            add(name, file.read_bytes(), 0o755 if os.access(file, os.X_OK) else 0o644)
        for name, text in information().items():
            add(f"{info}/{name}", text.encode(), 0o644)
        add(f"{info}/licenses/LICENSE", (ROOT / "LICENSE").read_bytes(), 0o644)
        wheel.writestr(f"{info}/RECORD", "\n".join([*records, f"{info}/RECORD,,"]) + "\n")


def prepare_metadata_for_build_wheel(metadata_directory, config_settings=None):  # pylint: disable=unused-argument
    """Tells what the wheel will be, without which pip builds all to know, and once more to install it."""
    info = pathlib.Path(metadata_directory) / f"{NAME}-{version()}.dist-info"
    info.mkdir()
    for name, text in information().items():
        (info / name).write_text(text, encoding="utf-8")
    return info.name


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):  # pylint: disable=unused-argument
    name = f"{NAME}-{version()}-{tag()}.whl"
    with tempfile.TemporaryDirectory() as stage:
        build_and_stage(config_settings or {}, pathlib.Path(stage))
        write_wheel(pathlib.Path(wheel_directory) / name, contents(pathlib.Path(stage)))
    return name


def build_sdist(sdist_directory, config_settings=None):  # pylint: disable=unused-argument
    """The files under version control."""
    folder = f"{NAME}-{version()}"
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, check=True, capture_output=True).stdout.decode()
    with tarfile.open(pathlib.Path(sdist_directory) / f"{folder}.tar.gz", "w:gz") as archive:
        for name in filter(None, listed.split("\0")):
            archive.add(ROOT / name, f"{folder}/{name}")
        with tempfile.NamedTemporaryFile("w") as info:
            info.write(metadata())
            info.flush()
            archive.add(info.name, f"{folder}/PKG-INFO")
    return f"{folder}.tar.gz"
