# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""The wheel of this build, unpacked as pip does, is a package that finds its libraries."""

import csv
import importlib.util
import io
import os
import pathlib
import stat
import subprocess
import sys
import zipfile

import pytest

BUILD = pathlib.Path(os.environ["HYBRID_REFERENCE"]).parents[1]


@pytest.fixture
def backend(source, monkeypatch):
    """The backend, which takes this build as it is."""
    spec = importlib.util.spec_from_file_location("hybrid_build", source / "python/build_backend/hybrid_build.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    run = module.run
    monkeypatch.setattr(module, "run", lambda *command: None if "--build" in command else run(*command))
    return module


def unpack(wheel, prefix):
    """Returns where the package is."""
    purelib = prefix / f"lib/python{sys.version_info.major}.{sys.version_info.minor}/site-packages"
    for entry in wheel.infolist():
        _, data, name = entry.filename.partition(".data/data/")
        file = prefix / name if data else purelib / entry.filename
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_bytes(wheel.read(entry))
        file.chmod(stat.S_IMODE(entry.external_attr >> 16))
    return purelib


def test_it_runs_where_it_is_unpacked(backend, source, tmp_path):
    name = backend.build_wheel(tmp_path, {"build-dir": str(BUILD)})
    assert name.endswith(".whl") and backend.version() in name
    with zipfile.ZipFile(tmp_path / name) as wheel:
        purelib = unpack(wheel, tmp_path / "prefix")
    program = ("import hybrid; print(hybrid.__file__); print(hybrid.SE2(1, 2, 0).x); "
               "print([line.split()[-1] for line in open('/proc/self/maps') if 'libhybrid' in line][0])")
    ran = subprocess.run([sys.executable, "-c", program], env={**os.environ, "PYTHONPATH": str(purelib)}, capture_output=True,
                         text=True)
    file, x, library = ran.stdout.split()
    assert x == "1.0" and file.startswith(str(purelib)) and library.startswith(str(tmp_path)), ran.stderr
    if os.environ["HYBRID_WITH_MRPT"] == "ON":
        log = source / "rawlogs/classed_demo.rawlog"
        ran = subprocess.run([sys.executable, "-m", "hybrid", "replay", log, "-o", tmp_path / "out", "--no-pictures"],
                             env={**os.environ, "PYTHONPATH": str(purelib)}, capture_output=True, text=True)
        assert ran.returncode == 0, ran.stderr
        assert os.access(tmp_path / "prefix/libexec/hybrid/hybrid-rawlog-reader", os.X_OK)


def test_its_record_lists_every_file(backend, tmp_path):
    with zipfile.ZipFile(tmp_path / backend.build_wheel(tmp_path, {"build-dir": str(BUILD)})) as wheel:
        record = next(name for name in wheel.namelist() if name.endswith("RECORD"))
        rows = {row[0]: row[1:] for row in csv.reader(io.StringIO(wheel.read(record).decode()))}
        assert set(rows) == set(wheel.namelist())
        for name in wheel.namelist():
            if name != record:
                assert rows[name] == [backend.digest(wheel.read(name)), str(len(wheel.read(name)))]


def test_what_it_will_be_is_known_before_it_is_built(backend, tmp_path, monkeypatch):
    with monkeypatch.context() as patch:
        patch.setattr(backend, "run", lambda *command: pytest.fail("built"))
        info = backend.prepare_metadata_for_build_wheel(tmp_path)
    with zipfile.ZipFile(tmp_path / backend.build_wheel(tmp_path, {"build-dir": str(BUILD)})) as wheel:
        for file in (tmp_path / info).iterdir():
            assert wheel.read(f"{info}/{file.name}").decode() == file.read_text(encoding="utf-8")


def test_the_version_is_that_of_the_package(backend):
    import hybrid

    assert backend.version() == hybrid.__version__
