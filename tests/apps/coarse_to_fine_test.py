#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Where landmarks are not found again, or mapped twice, a log is mapped with its odometry calibrated, or with landmarks of an extent.

usage: coarse_to_fine_test.py BIN
"""

import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
import boards_world  # noqa: E402
from detector_world import World  # noqa: E402
from health_table import copies_of  # noqa: E402

IMPORT = ["--sigma-range", ".12", "--sigma-bearing", ".02", "--walk-rotation", ".06", "--walk-translation", ".06"]
SEED = 14


class CoarseToFine(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.at = pathlib.Path(folder.name)
        boards_world.make(self.at, SEED)
        self.run_program("hybrid-import", "csv", "--odometry", "odometry.csv", "--detections", "detections.csv", *IMPORT,
                         "-o", "boards.rawlog")

    def run_program(self, name, *words):
        ran = subprocess.run([BIN / name, *words], cwd=self.at, text=True, capture_output=True, check=False)
        self.assertEqual(ran.returncode, 0, ran.stdout + ran.stderr)

    def mapped(self, *settings):
        words = [word for setting in settings for word in ("--set", setting)]
        self.run_program("hybrid-replay", "boards.rawlog", "--no-pictures", "--truth-path", "truth.tum", "-o", "out", *words)
        return json.loads((self.at / "out/summary.json").read_text(encoding="utf-8"))

    @staticmethod
    def error(summary):
        return summary["truth"]["trajectory"]["aligned"]["rmse_m"]

    @staticmethod
    def verdict(summary, name):
        return next(e["verdict"] for e in summary["health"] if e["name"] == name)

    def lost(self, summary):
        return self.verdict(summary, "landmarks seen at one time only")

    def test_by_default(self):
        stated = self.mapped("sensor.noise=stated")
        self.assertEqual(self.lost(stated), "bad")
        self.assertEqual(stated["configuration"]["BearingRangeAssociation"]["extent"], "0")
        drawn = self.mapped()
        self.assertEqual(self.lost(drawn), "good")
        self.assertLess(self.error(drawn), 0.5 * self.error(stated))
        self.assertLessEqual(drawn["landmarks"], 15)
        taken = next(draw["settings"] for draw in drawn["draws"] if draw["taken"])
        self.assertEqual(taken, ["calibration.odometry=yes"])

    def test_of_an_extent(self):
        """One of those that are drawn where the odometry is not what is wrong."""
        stated = self.mapped("sensor.noise=stated")
        coarse = self.mapped("sensor.noise=stated", "BearingRangeAssociation.method=jcbb", "BearingRangeAssociation.extent=.1", "keyframes.tracklets=yes")
        self.assertEqual(self.lost(coarse), "good")
        self.assertLess(self.error(coarse), 0.5 * self.error(stated))
        self.assertLessEqual(coarse["landmarks"], 15)

    def test_of_twins(self):
        """Each thing beside one of its class: nearly as many landmarks as things, without an extent, since looks are counted."""
        World({"seed": 2, "twins": 0.3}).write(self.at)
        self.run_program("hybrid-import", "csv", "--odometry", "odometry.tum", "--detections", "detections.csv",
                         "--sigma-range", ".2", "-o", "boards.rawlog")
        stated = self.mapped("sensor.noise=stated")
        self.assertEqual(self.verdict(stated, "copies of landmarks"), "good")
        copies, things = copies_of(self.at / "out", self.at)
        self.assertGreater(things, 60)
        self.assertLess(copies, 0.05 * things)
        apart = self.mapped("sensor.noise=stated", "BearingRangeAssociation.merge=no")
        self.assertEqual(self.verdict(apart, "copies of landmarks"), "bad")

    def test_not_where_it_is_said_how_to_decide(self):
        for setting in "method=jcbb", "extent=.01":
            said = self.mapped(f"BearingRangeAssociation.{setting}")["configuration"]["BearingRangeAssociation"]
            self.assertEqual(float(said["extent"]), 0.01 if "extent" in setting else 0)


if __name__ == "__main__":
    BIN = pathlib.Path(sys.argv[1]).resolve()
    unittest.main(argv=sys.argv[:1])
