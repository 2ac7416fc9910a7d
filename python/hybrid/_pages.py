# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Several reports in one page."""

import base64
import gzip
import html
import json
import os
import pathlib
import re
from collections.abc import Sequence

from . import _core

_DATA = re.compile(r'<script type="application/octet-stream" id="data"[^>]*>([^<]*)</script>')


def _read(run):
    """The page of a run, by its file or folder, and where its data stands."""
    file = pathlib.Path(run)
    file = file / "report.html" if file.is_dir() else file
    try:
        page = file.read_text(encoding="utf-8")
    except (OSError, ValueError) as error:
        raise _core.Error(f"{file}: {error}; --report writes it") from None
    found = _DATA.search(page)
    if not found:
        raise _core.Error(f"{file}: is no report of hybrid-replay or hybrid-pgo")
    return page, found


def _kind(found):
    return json.loads(gzip.decompress(base64.b64decode(found[1])))["kind"]


def _script(run, found, place):
    name = html.escape(os.path.normpath(run), quote=True)
    return f'<script type="application/octet-stream" {place} data-name="{name}">{found[1]}</script>'


def compare(runs: Sequence[str | os.PathLike], page: str | os.PathLike) -> None:
    """Writes the report of the first run as a page that holds the others too and compares them, in its tab Compare.

    runs: folders of hybrid-replay --report or hybrid-pgo --report, or files report.html.
    """
    first, own = _read(runs[0])
    scripts = [_script(runs[0], own, 'id="data"')]
    for run in runs[1:]:
        _, other = _read(run)
        if _kind(other) != _kind(own) or _kind(own) == "trials":
            raise _core.Error(f"{os.fspath(runs[0])} and {os.fspath(run)} cannot be compared: not two replays, or two pose graphs")
        scripts.append(_script(run, other, 'class="other"'))
    pathlib.Path(page).write_text(first[: own.start()] + "\n".join(scripts) + first[own.end() :], encoding="utf-8")
