# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""The type stubs match the package."""

import ast
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
