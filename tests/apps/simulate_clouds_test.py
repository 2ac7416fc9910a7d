#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Simulated clouds agree with their true path, are the same each time, and become a log.

usage: simulate_clouds_test.py BIN
"""

import pathlib
import subprocess
import sys
import tempfile
import unittest

import numpy as np

SCRIPT = pathlib.Path(__file__).parents[2] / "scripts/simulate_clouds.py"
CLOUDS = 200  # which are near enough to each other in all worlds


def rotation(quaternion):
    x, y, z, w = quaternion
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                     [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                     [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


class Simulated(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.at = pathlib.Path(folder.name)

    def make(self, name, world, *words):
        subprocess.run([sys.executable, "-B", SCRIPT, self.at / name, "--world", world, "--rings", "12", "--columns", "120",
                        "--clouds", str(CLOUDS), *words], check=True, capture_output=True)
        return self.at / name

    def test_clouds_lie_on_what_others_saw(self):
        for world, low, high in (("storeys", (0, 0, 0), (30, 24, 8)), ("warehouse", (0, 0, 0), (46, 36, 8)), ("street", (-120, -120, 0), (220, 220, 13))):
            with self.subTest(world):
                folder = self.make(world, world, "--range-noise", "0")
                truth = np.loadtxt(folder / "truth.txt")
                self.assertEqual(len(truth), CLOUDS)
                voxels, share = set(), []
                for i, row in enumerate(truth):
                    points = np.fromfile(folder / f"{i:05}.bin", "<f4").reshape(-1, 4)[:, :3] @ rotation(row[4:]).T + row[1:4]
                    self.assertGreater(len(points), 300)
                    self.assertTrue((points > np.subtract(low, 0.01)).all() and (points < np.add(high, 0.01)).all())
                    cells = {tuple(cell) for cell in np.floor(points[:400]).astype(int)}
                    share.append(len(cells & voxels) / len(cells))
                    voxels |= cells
                self.assertGreater(np.mean(share[CLOUDS // 2:]), 0.8)

    def test_the_same_seed_gives_the_same_files(self):
        folders = [self.make(name, "storeys", "--seed", seed) for name, seed in (("a", "3"), ("b", "3"), ("c", "4"))]
        texts = [[(folder / name).read_bytes() for name in ("00007.bin", "odometry.txt")] for folder in folders]
        self.assertEqual(texts[0], texts[1])
        self.assertNotEqual(texts[0][0], texts[2][0])
        self.assertNotEqual(texts[0][1], texts[2][1])

    def test_they_become_a_log(self):
        folder = self.make("a", "street", "--sweep", "0.2")
        ran = subprocess.run([BIN / "hybrid-import", "clouds", folder, "--odometry", folder / "odometry.txt", "--truth", folder / "truth.txt",
                              "-o", self.at / "a.rawlog"], capture_output=True, text=True, check=False)
        self.assertEqual(ran.returncode, 0, ran.stderr)
        self.assertIn(f"{CLOUDS} steps", ran.stdout)
        self.assertIn("points have times", ran.stdout)
        self.assertEqual(len((self.at / "a_ground_truth_robot_path.txt").read_text().splitlines()), CLOUDS + 1)


if __name__ == "__main__":
    BIN = pathlib.Path(sys.argv.pop(1)).resolve()
    unittest.main()
