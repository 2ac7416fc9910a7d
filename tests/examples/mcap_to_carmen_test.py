#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Laser scans of a bag made here become a CARMEN log and a map of one. HYBRID_BIN is the folder of the programs."""

import json
import math
import os
import pathlib
import subprocess
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from bags import LINE, ODOMETRY, TRANSFORMS, BagTest, Cdr, bag, odometry  # noqa: E402

SCRIPT = pathlib.Path(__file__).parents[2] / "examples/ros2/mcap_to_carmen.py"
SCANS = {"sensor_msgs/LaserScan": "std_msgs/Header header\nfloat32 angle_min\nfloat32 angle_max\nfloat32 angle_increment\n"
                                  "float32 time_increment\nfloat32 scan_time\nfloat32 range_min\nfloat32 range_max\n"
                                  "float32[] ranges\nfloat32[] intensities\n"}
TOPICS = [("/odom", ODOMETRY), ("/scan", SCANS), ("/tf_static", TRANSFORMS)]
ROOM = (-4.0, 6.0, -3.0, 2.0)  # left, right, lower and upper wall [m]


def scan(time, first, step, ranges, most=30):
    out = Cdr().header(time, "laser").put("f", first, first + step * (len(ranges) - 1), step, 0, 0, 0.1, most)
    return out.put("I", len(ranges)).put("f", *ranges).put("I", 0).whole()


def mounted(roll, pitch=0.0):
    """The laser half a metre ahead of the robot."""
    q = (math.sin(roll / 2) * math.cos(pitch / 2), math.cos(roll / 2) * math.sin(pitch / 2),
         -math.sin(roll / 2) * math.sin(pitch / 2), math.cos(roll / 2) * math.cos(pitch / 2))
    return Cdr().put("I", 1).header(0, "base").string("laser").put("d", 0.5, 0, 0, *q).whole()


def wall(x, y, angle):
    """How far the room goes on from a point."""
    left, right, lower, upper = ROOM
    c, s = math.cos(angle), math.sin(angle)
    across = ((right if c > 0 else left) - x) / c if abs(c) > 1e-9 else math.inf
    along = ((upper if s > 0 else lower) - y) / s if abs(s) > 1e-9 else math.inf
    return min(across, along)


class McapToCarmen(BagTest):
    def run_script(self, messages, *options, topics=TOPICS):
        (self.at / "a.mcap").write_bytes(bag(topics, messages))
        return self.convert("a.mcap", *options)

    def convert(self, name, *options):
        return subprocess.run([sys.executable, "-B", SCRIPT, self.at / name, "-o", self.at / "a.clf", *options], text=True,
                              capture_output=True, check=False)

    def lines(self):
        return [line.split() for line in (self.at / "a.clf").read_text().splitlines()]

    def test_a_scan_is_a_line(self):
        messages = [(0, odometry(0, 0, 0, 0)), (0, odometry(2, 4, 0, 1)), (1, scan(1, -0.5, 0.5, [1, math.inf, 3])),
                    (1, scan(3, -0.5, 0.5, [1, 2, 3])), (2, mounted(0))]
        ran = self.run_script(messages, "--base", "base")
        self.assertEqual(ran.returncode, 0, ran.stderr)
        self.assertIn("no odometry before or after them: 1", ran.stdout)
        (words,) = self.lines()
        self.assertEqual([float(w) for w in words[2:9]], [-0.5, 1, 0.5, 30, 0, 0, 3])
        self.assertEqual([float(w) for w in words[9:12]], [1, 30, 3])  # what sees nothing is as far as the laser reaches
        x, y, yaw, *robot = map(float, words[13:19])
        self.assertEqual(robot, [2, 0, 0.5])
        self.assertAlmostEqual(x, 2 + 0.5 * math.cos(0.5), places=6)
        self.assertAlmostEqual(y, 0.5 * math.sin(0.5), places=6)
        self.assertEqual((yaw, float(words[-3])), (0.5, 1))

    def test_rays_turn_to_the_left(self):
        still = [(0, odometry(0, 0, 0, 0)), (0, odometry(2, 0, 0, 0))]
        for messages, options in (([(1, scan(1, 0.5, -0.25, [4, 3, 2]))], []),
                                  ([(1, scan(1, -0.5, 0.25, [4, 3, 2])), (2, mounted(math.pi))], ["--base", "base"])):
            ran = self.run_script([*still, *messages], *options)
            self.assertEqual(ran.returncode, 0, ran.stderr)
            (words,) = self.lines()
            self.assertEqual([float(words[2]), float(words[4])], [0, 0.25])
            self.assertEqual([float(w) for w in words[9:12]], [2, 3, 4])

    def test_what_cannot_be_read_is_told(self):
        still = [(0, odometry(0, 0, 0, 0)), (0, odometry(2, 0, 0, 0)), (1, scan(1, 0, 0.1, [1]))]
        self.assertIn("the laser laser is tilted", self.run_script([*still, (2, mounted(0.3))], "--base", "base").stderr)
        self.assertIn("no transforms lead from base to laser", self.run_script(still, "--base", "base").stderr)
        self.assertIn("/scan has no message", self.run_script(still[:2]).stderr)
        self.assertIn("/scan (sensor_msgs/msg/LaserScan)".replace("/msg/", "/"),
                      self.run_script(still, "--scans", "/scans").stderr.replace("/msg/", "/"))

    def test_names_of_a_damaged_bag_are_told_in_one_line(self):
        topics = [("/odom", ODOMETRY), ("/s\x1b[31m\ncan\x7f", SCANS), ("/tf_static", TRANSFORMS)]
        for options in (["--scans", "/scan"], []):
            ran = self.run_script([(0, odometry(0, 0, 0, 0))], *options, topics=topics)
            self.assertEqual((ran.returncode, ran.stderr.count("\n")), (1, 1))
            self.assertIn(r"/s\x1b[31m\ncan\x7f", ran.stderr)

    STILL = ((0, odometry(0, 0, 0, 0)), (0, odometry(20, 0, 0, 0)))

    def test_a_failure_leaves_what_was_there(self):
        (self.at / "a.clf").write_text("of before")
        for messages, words in (([*self.STILL, (1, scan(50, 0, 0.1, [1]))], "scans are of 50.000 to 50.000 s, odometry of 0.000 to 20.000 s"),
                                ([*self.STILL, (1, scan(1, 0, 0.1, [1])[:-9])], "ends early"),
                                ([*self.STILL], "/scan has no message"), ([(1, scan(1, 0, 0.1, [1]))], "odometry has no message"),
                                ([*self.STILL, (1, scan(1, math.nan, 0.1, [1]))], "no scan that serves: their angles")):
            ran = self.run_script(messages)
            self.assertEqual((ran.returncode, ran.stderr.count("\n")), (1, 1))
            self.assertIn(words, ran.stderr)
            self.assertEqual((self.at / "a.clf").read_text(), "of before")
            self.assertEqual(len(list(self.at.iterdir())), 2)

    def test_a_bag_in_many_files_and_in_any_order(self):
        run = self.at / "run"
        run.mkdir()
        order = [*range(11, 5, -1), *range(6)]  # stamps fall, and then rise
        for k, time in enumerate(order):
            (run / f"run_{k}.mcap").write_bytes(bag(TOPICS, [(0, odometry(time, time, 0, 0)), (1, scan(time, 0, 0.1, [time + 1]))]))
        ran = self.convert("run")
        self.assertEqual(ran.returncode, 0, ran.stderr)
        self.assertNotIn("dropped", ran.stdout)
        self.assertEqual([(float(w[9]), float(w[14])) for w in self.lines()], [(k + 1, k) for k in range(12)])

    def test_files_are_read_in_the_order_of_their_numbers(self):
        run = self.at / "run"
        run.mkdir()
        for k in (2, 10):
            (run / f"run_{k}.mcap").write_bytes(b"")
        self.assertIn("run_2.mcap: is not an MCAP file", self.convert("run").stderr)

    def test_no_limit_of_the_range(self):
        for most in (math.inf, 3.4e38, math.nan, 0):
            ran = self.run_script([*self.STILL, (1, scan(1, 0, 0.1, [1, math.inf, 99], most))])
            self.assertEqual(ran.returncode, 0, ran.stderr)
            (words,) = self.lines()
            self.assertEqual([float(w) for w in (words[5], *words[9:12])], [0, 1, 0, 99])

    def test_namespaces_and_frames_with_a_slash(self):
        topics = [("/robot1/odom", ODOMETRY), ("/robot1/scan", SCANS), ("/robot1/tf_static", TRANSFORMS), ("/robot2/tf_static", TRANSFORMS)]
        other = Cdr().put("I", 1).header(0, "base").string("laser").put("d", 7, 0, 0, 0, 0, 0, 1).whole()
        mount = Cdr().put("I", 1).header(0, "/base").string("/laser").put("d", 0.5, 0, 0, 0, 0, 0, 1).whole()
        ran = self.run_script([*self.STILL, (1, scan(1, 0, 0.1, [1])), (2, mount), (3, other)], "--base", "base", topics=topics)
        self.assertEqual(ran.returncode, 0, ran.stderr)
        (words,) = self.lines()
        self.assertEqual(float(words[11]), 0.5)

    def test_lines_that_end_as_on_windows(self):
        topics = [(name, {kind: lines.replace("\n", "\r\n") for kind, lines in definitions.items()}) for name, definitions in TOPICS]
        whole = bag(topics, [*self.STILL, (1, scan(1, 0, 0.1, [1]))]).replace(LINE.encode(), LINE[:-2].encode() + b"\r\n")
        (self.at / "a.mcap").write_bytes(whole)
        ran = self.convert("a.mcap")
        self.assertEqual(ran.returncode, 0, ran.stderr)

    def test_sizes_that_cannot_be(self):
        whole = bag(TOPICS, [*self.STILL, (1, scan(1, 0, 0.1, [1]))], ("zstd", bytes))
        for at in (9 + 8, whole.index(b"zstd") - 8):  # of the first record; of what is in the chunk
            (self.at / "a.mcap").write_bytes(whole[:at - 8] + b"\xff" * 7 + b"\x3f" + whole[at:])
            ran = self.convert("a.mcap")
            self.assertEqual(ran.returncode, 1)
            self.assertNotIn("Traceback", ran.stderr)
            self.assertIn("a.mcap", ran.stderr + ran.stdout)

    def test_scans_without_odometry(self):
        ran = self.run_script([(0, scan(k, 0, 0.1, [1, 2])) for k in range(3)], topics=TOPICS[1:2])
        self.assertEqual(ran.returncode, 0, ran.stderr)
        self.assertIn("no odometry: scans alone", ran.stdout)
        self.assertEqual([(w[0], float(w[-3])) for w in self.lines()], [("RAWLASER1", k) for k in range(3)])

    def test_the_bag_is_not_replaced(self):
        content = bag(TOPICS, [*self.STILL, (1, scan(1, 0, 0.1, [1]))])
        (self.at / "a.clf").write_bytes(content)
        (self.at / "a.mcap").symlink_to(self.at / "a.clf")
        for name in ("a.clf", "a.mcap"):
            ran = self.convert(name)
            self.assertEqual((ran.returncode, ran.stderr),
                             (1, f"mcap_to_carmen: cannot write {self.at}/a.clf: is the bag that is read\n"))
            self.assertEqual((self.at / "a.clf").read_bytes(), content)

    def test_what_is_written_replaces_regular_files_alone(self):
        (self.at / "a.clf.part").write_text("foreign")
        self.assertEqual(self.run_script([*self.STILL, (1, scan(1, 0, 0.1, [1]))]).returncode, 0)
        self.assertEqual((self.at / "a.clf.part").read_text(), "foreign")
        (self.at / "a.clf").unlink()
        os.mkfifo(self.at / "a.clf")
        self.assertIn("a.clf: is a pipe, not a regular file", self.convert("a.mcap").stderr)
        self.assertTrue((self.at / "a.clf").is_fifo())

    def test_scans_that_are_none_are_dropped(self):
        none = [(1, scan(1, -0.5, 0.1, []))]
        ran = self.run_script([*self.STILL, *none, *none, (1, scan(2, 1e30, 0.1, [1])), (1, scan(3, 0, 9, [1, 2, 3])),
                               (1, scan(4, 0, 0.1, [1]))])
        self.assertEqual((ran.returncode, ran.stderr), (0, ""))
        self.assertIn("scans dropped: they have no rays: 2\n", ran.stdout)
        self.assertIn("no numbers, or absurd: 2\n", ran.stdout)
        self.assertIn("a.clf: 1 scans\n", ran.stdout)
        ran = self.run_script([*self.STILL, *none])
        self.assertIn("a.mcap: /scan has no scan that serves: they have no rays\n", ran.stderr)
        self.assertEqual(ran.returncode, 1)

    def test_scans_where_odometry_is_missing_are_dropped(self):
        times = [k / 10 for k in (*range(101), *range(400, 421))]
        for speed, kept in ((0.5, [5.5, 10, 40, 41.5]), (0, [5.5, 10, 25, 40, 41.5])):  # one that stands says nothing
            driven = [(0, odometry(time, speed * time, 0, 0)) for time in times]
            ran = self.run_script([*driven, *[(1, scan(time, 0, 0.1, [1])) for time in (5.5, 10, 25, 40, 41.5)]])
            self.assertEqual((ran.returncode, ran.stderr), (0, ""))
            self.assertEqual([float(w[-3]) for w in self.lines()], kept)
            self.assertEqual("missing there for over ten times its usual period: 1\n" in ran.stdout, speed > 0)

    def test_a_scan_at_the_time_of_two_poses(self):
        messages = [(0, odometry(1, 4, 0, 1)), (0, odometry(1, 4, 0, 1)), (0, odometry(2, 5, 0, 1)),
                    *[(1, scan(time, -0.5, 0.5, [1, 2, 3])) for time in (1, 1.5, 2)]]
        done = self.run_script(messages)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual([line[0] for line in self.lines()].count("ROBOTLASER1"), 3)

    def test_scans_become_a_map(self):
        programs = os.environ.get("HYBRID_BIN")
        if not programs:
            self.skipTest("skipped: HYBRID_BIN is not set")
        messages, rays = [(2, mounted(0))], 360
        for k in range(20):  # odometry is 10 % long
            x, yaw = 0.15 * k, 0.02 * k
            messages.append((0, odometry(k, 1.1 * x, 0, yaw)))
            sensor = (x + 0.5 * math.cos(yaw), 0.5 * math.sin(yaw))
            angles = [-math.pi / 2 + math.pi * i / (rays - 1) for i in range(rays)]
            messages.append((1, scan(k, angles[0], math.pi / (rays - 1), [wall(*sensor, yaw + a) for a in angles])))
        ran = self.run_script(messages, "--base", "base")
        self.assertEqual(ran.returncode, 0, ran.stderr)
        for command in (["hybrid-import", "carmen", "a.clf", "-o", "a.rawlog"],
                        ["hybrid-replay", "a.rawlog", "--no-pictures", "-o", "out"]):
            ran = subprocess.run([f"{programs}/{command[0]}", *command[1:]], cwd=self.at, text=True, capture_output=True, check=False)
            self.assertEqual(ran.returncode, 0, ran.stderr)
        self.assertEqual(json.loads((self.at / "out/summary.json").read_text())["status"], "ok")
        last = (self.at / "out/trajectory.tum").read_text().splitlines()[-1].split()
        self.assertLess(abs(float(last[1]) - 0.15 * 19), 0.05)


if __name__ == "__main__":
    unittest.main()
