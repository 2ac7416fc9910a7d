# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Several reports in one page."""

import base64
import gzip
import json
import os
import re
import subprocess
import sys

import pytest

needs_mrpt = pytest.mark.skipif(os.environ["HYBRID_WITH_MRPT"] != "ON", reason="built without MRPT")
DATA = re.compile(r'<script type="application/octet-stream" ([^>]*)>([^<]+)</script>')


def compare(*arguments):
    return subprocess.run([sys.executable, "-m", "hybrid", "compare", *map(str, arguments)], capture_output=True, text=True)


def packed(kind):
    return base64.b64encode(gzip.compress(json.dumps({"kind": kind}).encode())).decode()


def test_only_what_is_of_a_kind_is_compared(tmp_path):
    for kind in ("map", "graph", "trials"):
        (tmp_path / f"{kind}.html").write_text(f'<script type="application/octet-stream" id="data">{packed(kind)}</script>')
    for a, b, code in (("map", "map", 0), ("graph", "graph", 0), ("map", "graph", 1), ("trials", "trials", 1)):
        done = compare(tmp_path / f"{a}.html", tmp_path / f"{b}.html", "-o", tmp_path / f"{a}_{b}.html")
        assert done.returncode == code and (tmp_path / f"{a}_{b}.html").exists() == (code == 0)
        assert code == 0 or "cannot be compared" in done.stderr


@needs_mrpt
def test_the_page_of_the_first_run_holds_the_data_of_the_others(source, tmp_path):
    program = os.path.join(os.path.dirname(os.environ["HYBRID_REFERENCE"]), "hybrid-replay")
    runs = {tmp_path / "as it is": [], tmp_path / "a<b": ["--set", "sensor.sigma_range=0.5"]}
    for folder, settings in runs.items():
        subprocess.run([program, "-c", source / "config" / "classed_demo.ini", "-o", folder, "--no-pictures", "--report", *settings],
                       check=True, capture_output=True)
    folders = list(runs)
    assert compare(folders[0], folders[1] / "report.html", folders[0], "-o", tmp_path / "both.html").returncode == 0
    alone = [(folder / "report.html").read_text() for folder in folders]
    data = [DATA.findall(page)[0][1] for page in alone]
    assert data[0] != data[1]
    both = (tmp_path / "both.html").read_text()
    assert [text for _, text in DATA.findall(both)] == [data[0], data[1], data[0]]
    places = [place for place, _ in DATA.findall(both)]
    assert places[0] == f'id="data" data-name="{folders[0]}"'
    assert places[1] == f'class="other" data-name="{tmp_path}/a&lt;b/report.html"'
    assert DATA.sub("", both).replace("\n", "") == DATA.sub("", alone[0]).replace("\n", "")


def test_what_is_no_report_is_named(tmp_path):
    (tmp_path / "page.html").write_text("<html></html>")
    for run, message in ((tmp_path, "--report writes it"), (tmp_path / "page.html", "is no report of hybrid-replay")):
        done = compare(run, run, "-o", tmp_path / "out.html")
        assert done.returncode == 1 and message in done.stderr and str(run) in done.stderr
    assert not (tmp_path / "out.html").exists()
