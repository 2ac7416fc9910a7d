# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""A replay as a function has the same result as the program."""

import json
import os
import subprocess
import sys

import hybrid
import numpy as np
import pytest

MRPT = os.environ["HYBRID_WITH_MRPT"] == "ON"
needs_mrpt = pytest.mark.skipif(not MRPT, reason="built without MRPT")


def test_it_is_there_exactly_with_mrpt():
    assert hasattr(hybrid, "replay") == MRPT


@needs_mrpt
def test_it_writes_what_the_program_writes(source, tmp_path):
    config = source / "config" / "classed_demo.ini"
    seen = []
    summary = hybrid.replay(config, tmp_path / "python", pictures=False, progress=lambda *so_far: seen.append(so_far))
    program = os.path.join(os.path.dirname(os.environ["HYBRID_REFERENCE"]), "hybrid-replay")
    subprocess.run([program, "-c", config, "-o", tmp_path / "program", "--no-pictures"], check=True,
                   capture_output=True)
    assert summary["status"] == "ok" and summary["keyframes"] == len(seen)
    written = json.loads((tmp_path / "python" / "summary.json").read_text())
    assert {**summary, "files": written["files"]} == written
    for name in ("trajectory.tum", "landmarks.csv", "landmarks.json", "graph.g2o"):
        assert (tmp_path / "python" / name).read_bytes() == (tmp_path / "program" / name).read_bytes(), name


@needs_mrpt
def test_the_result_has_arrays(source, tmp_path, monkeypatch):
    log = str(source / "rawlogs" / "classed_demo")
    result = hybrid.replay(rawlog=f"{log}.rawlog", truth_path=f"{log}_ground_truth_robot_path.txt", output=tmp_path / "out",
                           pictures=False)
    n, landmarks = result["keyframes"], result["landmarks"]
    assert result.path.shape == result.dead_reckoning.shape == result.true_path.shape == (n, 8)
    assert result.positions.shape == (landmarks, 2) and result.covariances.shape == (landmarks, 2, 2)
    assert result.extents.shape == result.things.shape == (landmarks,)
    assert (result.extents == 0).all() and (result.things == 1).all()
    error = np.linalg.norm(result.path[:, 1:4] - result.true_path[:, 1:4], axis=1)
    assert np.sqrt(np.mean(error**2)) == pytest.approx(result["truth"]["trajectory"]["rmse_m"], rel=1e-6)
    assert f"{n} keyframes, {landmarks} landmarks" in repr(result)
    coarse = hybrid.replay(rawlog=f"{log}.rawlog", output=tmp_path / "coarse", pictures=False,
                           settings={"sensor.ids": "none", "BearingRangeAssociation.extent": 0.25})
    assert len(coarse.extents) > 0 and (coarse.extents == 0.25).all() and (coarse.things >= 1).all()
    monkeypatch.chdir(tmp_path)
    again = hybrid.ReplayResult.read("out")
    monkeypatch.chdir(source)  # files are read when they are asked for
    assert again["keyframes"] == n and (again.path == result.path).all()
    assert all(landmark["class"] for landmark in again.landmarks)
    with pytest.raises(hybrid.Error, match="is no result of hybrid-replay"):
        hybrid.ReplayResult.read(tmp_path)


@needs_mrpt
def test_the_package_is_a_program(source, tmp_path):
    def run(*arguments):
        return subprocess.run([sys.executable, "-m", "hybrid", *arguments], cwd=tmp_path, capture_output=True, text=True)

    log = str(source / "rawlogs" / "classed_demo.rawlog")
    ran = run("replay", log, "-o", "out", "--no-pictures", "--set", "solver.mode=batch")
    assert ran.returncode == 0 and ran.stdout.startswith("189 keyframes, 20 landmarks"), ran.stderr
    assert json.loads((tmp_path / "out" / "summary.json").read_text())["status"] == "ok"
    bad = run("replay", "missing.rawlog")
    assert bad.returncode == 1 and bad.stderr == "python -m hybrid: missing.rawlog: no such file\n"
    assert "is no SECTION.KEY=VALUE" in run("replay", log, "--set", "solver").stderr
    assert run("--version").stdout == f"hybrid {hybrid.__version__}\n"


@needs_mrpt
def test_settings_and_errors(source, tmp_path):
    config = source / "config" / "classed_demo.ini"
    with pytest.raises(hybrid.Error, match="no_such_key"):
        hybrid.replay(config, tmp_path / "out", settings={"log.no_such_key": 1})
    with pytest.raises(hybrid.Error, match="missing.ini"):
        hybrid.replay("missing.ini", tmp_path / "out")
    assert not (tmp_path / "out").exists()


@needs_mrpt
def test_what_progress_raises_ends_it_with_nothing_written(source, tmp_path):
    def stop(share, keyframes, landmarks, objective):
        if keyframes == 3:
            raise StopIteration("enough")

    with pytest.raises(StopIteration, match="enough"):
        hybrid.replay(source / "config" / "classed_demo.ini", tmp_path / "out", pictures=False, progress=stop)
    assert not (tmp_path / "out").exists()


@needs_mrpt
def test_ctrl_c_ends_it(source, tmp_path):
    program = f"""
import hybrid, os, signal
def stop(share, keyframes, landmarks, objective):
    if keyframes == 3: os.kill(os.getpid(), signal.SIGINT)
try:
    hybrid.replay({str(source / "config" / "classed_demo.ini")!r}, "out", pictures=False, progress=stop)
except KeyboardInterrupt:
    print("stopped")
"""
    run = subprocess.run([sys.executable, "-c", program], cwd=tmp_path, capture_output=True, text=True)
    assert run.stdout == "stopped\n", run.stderr
    assert not (tmp_path / "out").exists()
