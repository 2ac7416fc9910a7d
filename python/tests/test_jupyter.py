# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Runs the notebooks in Jupyter. Where Jupyter is not installed, test_notebooks.py runs their cells without it."""

import importlib.util
import json
import os
import pathlib
import shutil
import subprocess
import sys

import pytest

NOTEBOOKS = sorted((pathlib.Path(os.environ["HYBRID_SOURCE_DIR"]) / "python" / "notebooks").glob("*.ipynb"))
MISSING = [name for name in ("nbconvert", "ipykernel", "matplotlib") if importlib.util.find_spec(name) is None]

if MISSING:  # no test is left: ctest says that python.jupyter is skipped
    pytest.skip(f"{', '.join(MISSING)} not installed: see scripts/setup --optional", allow_module_level=True)
if os.environ["HYBRID_WITH_MRPT"] != "ON":
    pytest.skip("built without MRPT", allow_module_level=True)


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_jupyter_runs_it(path, tmp_path):
    # A kernel of the interpreter that runs this test: it has the package.
    kernel = tmp_path / "kernels" / "tested"
    kernel.mkdir(parents=True)
    (kernel / "kernel.json").write_text(json.dumps(
        {"argv": [sys.executable, "-m", "ipykernel_launcher", "-f", "{connection_file}"], "display_name": "tested", "language": "python"}))
    copy = tmp_path / path.name
    shutil.copy(path, copy)
    programs = pathlib.Path(os.environ["HYBRID_REFERENCE"]).parent
    environment = {**os.environ, "JUPYTER_PATH": str(tmp_path), "HOME": str(tmp_path), "PATH": f"{programs}:{os.environ['PATH']}"}
    ran = subprocess.run([sys.executable, "-m", "nbconvert", "--execute", "--to", "notebook", "--inplace",
                          "--ExecutePreprocessor.kernel_name=tested", copy], capture_output=True, text=True, check=False, env=environment, cwd=tmp_path)
    assert ran.returncode == 0, ran.stderr[-3000:]
    code = [cell for cell in json.loads(copy.read_text(encoding="utf-8"))["cells"] if cell["cell_type"] == "code"]
    assert [cell["execution_count"] for cell in code] == list(range(1, len(code) + 1))
    if any("plot." in "".join(cell["source"]) for cell in code):
        assert any("image/png" in output.get("data", {}) for cell in code for output in cell["outputs"])
