# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""The type stubs match the package."""

import ast
import importlib.util
import os
import subprocess
import sys

import hybrid
import pytest


def made(source):
    return subprocess.run([sys.executable, "-B", source / "python" / "make_stubs.py"], capture_output=True, text=True,
                          check=True).stdout


@pytest.mark.skipif(os.environ.get("HYBRID_WITH_MRPT") != "ON", reason="built without MRPT, which the stubs know")
def test_stubs_are_those_of_the_package(source):
    committed = (source / "python" / "hybrid" / "__init__.pyi").read_text()
    assert made(source) == committed, "run python/make_stubs.py > python/hybrid/__init__.pyi"


def test_stubs_are_python_and_name_everything(source):
    text = made(source)
    names = {node.name for node in ast.parse(text).body if hasattr(node, "name")}
    assert names == set(hybrid.__all__)
    for foreign in ("_core", "hybrid::", "std::", "<", "0x"):
        assert foreign not in text


def test_everything_is_documented():
    for name in hybrid.__all__:
        thing = getattr(hybrid, name)
        assert thing.__doc__, name
        if not isinstance(thing, type):
            assert len(thing.__doc__.strip().splitlines()) > 1, name


def mypy(tmp_path, *files):
    return subprocess.run([sys.executable, "-m", "mypy", "--strict", "--allow-untyped-defs", "--allow-untyped-calls", "--check-untyped-defs",
                           "--cache-dir", tmp_path / "cache", *files], capture_output=True, text=True, check=False)


@pytest.mark.skipif(importlib.util.find_spec("mypy") is None, reason="mypy is not installed")
def test_a_checker_of_types_accepts_stubs_and_examples_and_finds_a_mistake(source, tmp_path):
    done = mypy(tmp_path, source / "python" / "hybrid" / "__init__.pyi")
    assert done.returncode == 0, done.stdout
    done = mypy(tmp_path, *sorted((source / "python" / "examples").glob("*.py")))
    assert done.returncode == 0, done.stdout
    wrong = tmp_path / "wrong.py"
    wrong.write_text('import hybrid\nhybrid.Prior(1, hybrid.SE2(0, 0, 0), hybrid.Noise.isotropic(3, 0.1))\nhybrid.Values().stack("x0").no_such\n')
    done = mypy(tmp_path, wrong)
    assert "wrong.py:2: error" in done.stdout and "wrong.py:3: error" in done.stdout
