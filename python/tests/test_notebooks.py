# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Runs the code cells of the notebooks, one after the other, without Jupyter."""

import importlib.util
import json
import os
import pathlib

import pytest

os.environ.setdefault("MPLBACKEND", "Agg")
NOTEBOOKS = sorted((pathlib.Path(os.environ["HYBRID_SOURCE_DIR"]) / "python" / "notebooks").glob("*.ipynb"))


def cells_of(path):
    notebook = json.loads(path.read_text(encoding="utf-8"))
    assert notebook["nbformat"] == 4
    return notebook["cells"]


def test_they_are_there():
    assert len(NOTEBOOKS) == 4


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_its_cells_run(path, tmp_path, monkeypatch):
    code = ["".join(cell["source"]) for cell in cells_of(path) if cell["cell_type"] == "code"]
    if importlib.util.find_spec("matplotlib") is None:
        code = [cell for cell in code if "plot" not in cell]
    if any("hybrid.replay" in cell for cell in code) and os.environ["HYBRID_WITH_MRPT"] != "ON":
        pytest.skip("built without MRPT")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PATH", f"{pathlib.Path(os.environ['HYBRID_REFERENCE']).parent}:{os.environ['PATH']}")
    names = {}
    for number, cell in enumerate(code):
        exec(compile(cell, f"{path.name}, code cell {number}", "exec"), names)


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_it_has_no_results_of_a_former_run(path):
    for cell in cells_of(path):
        if cell["cell_type"] == "code":
            assert not cell["outputs"] and cell["execution_count"] is None
