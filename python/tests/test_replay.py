# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""A replay as a function has the same result as the program."""

import json
import os
import subprocess
import sys

import hybrid
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
