# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""A replay as a function. The first call loads MRPT."""

import json
import os
import sys
from collections.abc import Callable, Sequence


def replay(
    config: str | os.PathLike = "",
    output: str | os.PathLike = "hybrid-replay-out",
    *,
    rawlog: str | os.PathLike = "",
    truth_path: str | os.PathLike = "",
    truth_map: str | os.PathLike = "",
    settings: dict[str, object] | None = None,
    plugins: Sequence[str] = (),
    pictures: bool = True,
    progress: Callable[[float, int, int, float], None] | None = None,
) -> dict:
    """Maps a rawlog as hybrid-replay does, and returns the content of summary.json.

    config: an INI file; output: the folder of the result, which is replaced as a whole or not at all; rawlog,
    truth_path, truth_map: override those of the INI; settings: override values of the INI, by "section.key"; plugins:
    libraries to load; progress: called after every keyframe with the share of the log, the numbers of keyframes and
    landmarks, and the objective. If it raises an exception, or on Ctrl-C, the replay ends and nothing is written. An
    Error names file, section or key.
    """
    from . import _mrpt

    text = _mrpt.replay(os.fspath(config), os.fspath(output), os.fspath(rawlog), os.fspath(truth_path),
                        os.fspath(truth_map), [f"{key}={value}" for key, value in (settings or {}).items()],
                        list(plugins), pictures, list(sys.orig_argv), progress)
    return json.loads(text)
