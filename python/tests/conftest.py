# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
import os
import pathlib

import pytest


@pytest.fixture
def source():
    """The root of the repository."""
    return pathlib.Path(os.environ["HYBRID_SOURCE_DIR"])
