# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Runs the examples, and the Python blocks of each page of docs, one after the other."""

import importlib.util
import math
import os
import pathlib
import re
import runpy

import hybrid
import pytest

os.environ.setdefault("MPLBACKEND", "Agg")

ROOT = pathlib.Path(os.environ["HYBRID_SOURCE_DIR"])
EXAMPLES = sorted((ROOT / "python" / "examples").glob("*.py"))


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_example(path, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    runpy.run_path(str(path), run_name="__main__")
    assert capsys.readouterr().out


def write_ring(path):
    """The pose graph that a reader has."""
    noise = hybrid.Noise.isotropic(3, 0.05)
    ring = hybrid.PoseGraph()
    for i in range(24):
        ring.add_edge(f"x{i}", f"x{(i + 1) % 24}", hybrid.SE2(1, 0.01 * (i % 3), math.pi / 12), noise)
    hybrid.write_g2o(str(path), ring)


PAGES = sorted(path for path in (ROOT / "docs").glob("*.md") if "```python\n" in path.read_text(encoding="utf-8"))


@pytest.mark.parametrize("path", PAGES, ids=lambda path: path.stem)
def test_page(path, tmp_path, monkeypatch):
    blocks = re.findall(r"```python\n(.*?)```", path.read_text(encoding="utf-8"), re.DOTALL)
    if os.environ["HYBRID_WITH_MRPT"] != "ON":
        blocks = [block for block in blocks if "replay" not in block]
    if importlib.util.find_spec("matplotlib") is None:
        blocks = [block for block in blocks if "plot" not in block]
    write_ring(tmp_path / "ring.g2o")
    for name in ("config", "rawlogs"):
        (tmp_path / name).symlink_to(ROOT / name)
    monkeypatch.chdir(tmp_path)
    exec(compile("\n".join(blocks), f"docs/{path.name}", "exec"), {})


def test_pages_with_code_are_found():
    assert {"python", "coming_from"} <= {path.stem for path in PAGES}
