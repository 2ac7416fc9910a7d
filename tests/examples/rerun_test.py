#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""The stream of a map in Rerun, with a module in its place that writes down its calls.

usage: rerun_test.py BIN
"""

import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

from foxglove_test import BIN, LINES, ROOT

SCRIPT = ROOT / "examples/ros2/stream_to_rerun.py"
# As Rerun 0.23: only these functions, with these parameters.
STAND_IN = '''
import json, os

def note(*entry):
    with open(os.environ["RERUN_CALLS"], "a") as file:
        file.write(json.dumps(entry) + "\\n")

def init(application_id, *, spawn=False):
    note("init", application_id, spawn)

def save(path):
    note("save", path)

def set_time(timeline, *, sequence=None, duration=None, timestamp=None):
    assert sum(x is not None for x in (sequence, duration, timestamp)) == 1
    note("time", timeline, sequence if timestamp is None else timestamp)

def log(entity_path, entity):
    note("log", entity_path, *entity)

def Points3D(positions, *, radii=None, colors=None, labels=None):
    return "points", positions, labels

def LineStrips3D(strips, *, radii=None, colors=None, labels=None):
    return "lines", strips

def Arrows3D(*, vectors, origins=None):
    return "arrows", origins, vectors

def Clear(*, recursive):
    return "clear", recursive
'''


class Rerun(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.at = pathlib.Path(folder.name)
        (self.at / "rerun.py").write_text(STAND_IN)
        self.calls = self.at / "calls"

    def shown(self, text, *options, path=True):
        environment = {**os.environ, "RERUN_CALLS": str(self.calls), "PYTHONPATH": str(self.at) if path else ""}
        ran = subprocess.run([sys.executable, "-B", SCRIPT, *options], input=text, text=True, capture_output=True, env=environment,
                             check=False)
        calls = [json.loads(line) for line in self.calls.read_text().splitlines()] if self.calls.exists() else []
        return ran, calls

    def test_what_a_step_shows(self):
        ran, calls = self.shown("".join(json.dumps(line) + "\n" for line in LINES))
        self.assertEqual((ran.returncode, ran.stderr), (0, ""))
        self.assertEqual(calls[:6], [
            ["init", "hybrid", True], ["time", "keyframe", 0], ["time", "time", 0.0],
            ["log", "map/path/0", "lines", [[[0, 0, 0.0]]]], ["log", "map/robot", "arrows", [[0, 0, 0.0]], [[1.0, 0.0, -0.0]]],
            ["log", "map/landmarks/3", "points", [[5.1, 1.9, 0.0]], ["3 tree"]]])
        second = calls[6:12]
        self.assertEqual(second[2], ["log", "map/landmarks/3", "clear", False])
        self.assertEqual(second[3], ["log", "map/path/0", "lines", [[[0, 0, 0.0], [1, 2, 0.0]]]])
        self.assertEqual(second[5], ["log", "map/landmarks/4", "points", [[1, 2, 3]], ["4"]])
        (x, y, z) = calls[-1][4][0]
        self.assertEqual(calls[-1][3], [[1, 2, 3]])
        self.assertAlmostEqual(z, -0.198669, delta=1e-6)  # pitch .2, positive down
        self.assertAlmostEqual(y / x, 0.100335, delta=1e-6)  # yaw .1

    def test_a_long_path_is_logged_in_pieces(self):
        lines = [{**LINES[0], "pose": [k, 0, 0], "changed": []} for k in range(250)]
        _, calls = self.shown("".join(json.dumps(line) + "\n" for line in lines))
        pieces = {call[1]: [p[0] for p in call[3][0]] for call in calls if call[1].startswith("map/path")}
        self.assertEqual(pieces, {"map/path/0": [*range(100)], "map/path/1": [*range(99, 200)], "map/path/2": [*range(199, 250)]})

    def test_a_file_and_mistakes(self):
        ran, calls = self.shown(json.dumps(LINES[0]) + "\n", "-o", "a.rrd")
        self.assertEqual((ran.returncode, calls[:2]), (0, [["init", "hybrid", False], ["save", "a.rrd"]]))
        for bad in ("12 keyframes", json.dumps({**LINES[0], "pose": [1]}), json.dumps({**LINES[0], "changed": ["tree"]})):
            ran, _ = self.shown(bad + "\n")
            self.assertEqual(len(ran.stderr.splitlines()), 1, ran.stderr)
            self.assertIn("standard input is what hybrid-replay --stream writes", ran.stderr)
        (self.at / "rerun.py").write_text("raise ImportError")
        ran, _ = self.shown("")
        self.assertEqual(ran.returncode, 1)
        self.assertIn("pip install rerun-sdk", ran.stderr)

    def test_a_replay_is_shown(self):
        if BIN is None:
            self.skipTest("skipped: no programs")
        log = ROOT / "rawlogs/classed_demo.rawlog"
        streamed = subprocess.run([BIN / "hybrid-replay", log, "--no-pictures", "-o", self.at / "out", "--stream"], text=True,
                                  capture_output=True, check=True).stdout
        ran, calls = self.shown(streamed)
        self.assertEqual(ran.returncode, 0, ran.stderr)
        self.assertEqual(sum(call[1] == "map/robot" for call in calls), len(streamed.splitlines()))


if __name__ == "__main__":
    unittest.main()
