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
import tarfile
import time
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


def test_the_same_build_gives_the_same_bytes(backend, tmp_path):
    wheels, archives = [], []
    for folder in (tmp_path / "a", tmp_path / "b"):
        folder.mkdir()
        wheels.append((folder / backend.build_wheel(folder, {"build-dir": str(BUILD)})).read_bytes())
        archives.append((folder / backend.build_sdist(folder)).read_bytes())
        time.sleep(2)  # a zip file has times in steps of 2 s
    assert wheels[0] == wheels[1]
    assert archives[0] == archives[1]


def test_a_source_archive_has_what_is_under_version_control(backend, source, tmp_path):
    name = backend.build_sdist(tmp_path)
    folder = name.removesuffix(".tar.gz")
    assert folder == f"hybrid_mapping-{backend.version()}"
    with tarfile.open(tmp_path / name) as archive:
        members = {member.name: member for member in archive.getmembers()}
        assert archive.extractfile(f"{folder}/PKG-INFO").read().decode() == backend.metadata()
    listed = subprocess.run(["git", "ls-files"], cwd=source, check=True, capture_output=True, text=True).stdout.split("\n")
    assert len(members) == len(listed)
    assert members[f"{folder}/scripts/test"].mode == 0o755 and members[f"{folder}/LICENSE"].mode == 0o644


def test_mistakes_are_told_in_a_line(backend, tmp_path, monkeypatch):
    def told(hook, *arguments):
        with pytest.raises(SystemExit) as ended:
            hook(*arguments)
        assert str(ended.value).startswith("error: ") and "\n" not in str(ended.value)
        return str(ended.value)

    for hook in (backend.build_wheel, backend.build_sdist, backend.prepare_metadata_for_build_wheel):
        assert "no setting 'job': --config-settings takes build-dir and jobs" in told(hook, tmp_path, {"job": "2"})
    assert "set PYTHONPATH" in told(backend.build_editable, tmp_path)
    (tmp_path / "file").touch()
    assert f"{tmp_path}/file" in told(backend.build_sdist, tmp_path / "file")
    assert f"{tmp_path}/none" in told(backend.build_sdist, tmp_path / "none")
    with monkeypatch.context() as patch:
        patch.setattr(backend, "run", lambda *command: subprocess.run(["false"], check=True))
        assert "'false' failed, with exit code 1" in told(backend.build_wheel, tmp_path, {"build-dir": str(BUILD)})
        patch.setenv("PATH", "/nonexistent")
        assert "git is not there" in told(backend.build_sdist, tmp_path)
    with monkeypatch.context() as patch:
        patch.setenv("PATH", "/nonexistent")
        assert "cmake is not there" in told(backend.build_wheel, tmp_path, {"build-dir": str(tmp_path / "new")})
    monkeypatch.setattr(backend, "ROOT", tmp_path)
    (tmp_path / "CMakeLists.txt").write_text("project(hybrid VERSION 0.1")
    assert f"{tmp_path} is no clone" in told(backend.build_sdist, tmp_path)
