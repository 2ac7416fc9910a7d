# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Runs the examples, and the Python blocks of each page of docs, one after the other."""

import os
import pathlib
import re
import runpy

import pytest

ROOT = pathlib.Path(os.environ["HYBRID_SOURCE_DIR"])
EXAMPLES = sorted((ROOT / "python" / "examples").glob("*.py"))


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_example(path, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    runpy.run_path(str(path), run_name="__main__")
    assert capsys.readouterr().out


PAGES = sorted(path for path in (ROOT / "docs").glob("*.md") if "```python\n" in path.read_text(encoding="utf-8"))


@pytest.mark.parametrize("path", PAGES, ids=lambda path: path.stem)
def test_page(path, tmp_path, monkeypatch):
    blocks = re.findall(r"```python\n(.*?)```", path.read_text(encoding="utf-8"), re.DOTALL)
    if os.environ["HYBRID_WITH_MRPT"] != "ON":
        blocks = [block for block in blocks if "replay" not in block]
    for name in ("config", "rawlogs"):
        (tmp_path / name).symlink_to(ROOT / name)
    monkeypatch.chdir(tmp_path)
    exec(compile("\n".join(blocks), f"docs/{path.name}", "exec"), {})


def test_pages_with_code_are_found():
    assert {"python", "coming_from"} <= {path.stem for path in PAGES}
