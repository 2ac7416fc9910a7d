# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Runs the examples, and the Python blocks of docs/python.md one after the other."""

import os
import pathlib
import re
import runpy

import pytest

EXAMPLES = sorted((pathlib.Path(os.environ["HYBRID_SOURCE_DIR"]) / "python" / "examples").glob("*.py"))


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_example(path, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    runpy.run_path(str(path), run_name="__main__")
    assert capsys.readouterr().out


def test_page(source, tmp_path, monkeypatch):
    page = (source / "docs" / "python.md").read_text()
    blocks = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    assert len(blocks) > 3
    if os.environ["HYBRID_WITH_MRPT"] != "ON":
        blocks = [block for block in blocks if "replay" not in block]
    (tmp_path / "config").symlink_to(source / "config")
    (tmp_path / "rawlogs").symlink_to(source / "rawlogs")
    monkeypatch.chdir(tmp_path)
    exec(compile("\n".join(blocks), "docs/python.md", "exec"), {})
