#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Bags made here become the tables that are in them, and a map. HYBRID_BIN is the folder of the programs."""

import importlib
import json
import math
import os
import subprocess
import unittest

from bags import BagTest, CAMERA, Cdr, DETECTIONS, EDGE, FIX, FOCAL, LANDMARKS, ODOMETRY, OLD_DETECTIONS, POSE, TAGS, TOPICS, TRANSFORMS, bag, camera, detections, drive, homography, odometry, tags, text, transforms


class McapToCsv(BagTest):
    def test_plain_and_old_messages(self):
        for definitions, old in ((DETECTIONS, False), (OLD_DETECTIONS, True)):
            ran = self.run_script(bag([("/odom", ODOMETRY), ("/objects", definitions)], drive(old)), "--plane")
            self.assertEqual(ran.returncode, 0, ran.stderr)
            self.check_tables()

    def test_compressed_chunks(self):
        for name, module in (("zstd", "zstandard"), ("lz4", "lz4.frame")):
            with self.subTest(name):
                try:
                    library = importlib.import_module(module)
                except ImportError:
                    self.skipTest(f"skipped: python3-{module.split('.')[0]} is not installed")
                pack = library.ZstdCompressor().compress if name == "zstd" else library.compress
                ran = self.run_script(bag(TOPICS, drive(), (name, pack)), "--plane")
                self.assertEqual(ran.returncode, 0, ran.stderr)
                self.check_tables()

    def test_in_space_and_in_an_optical_frame(self):
        messages = [(0, odometry(0, 0, 0, 0)), (1, detections(0, [("left", 3.0, 4.0, 0.0, "a"), ("low", 0.0, 2.0, 2.0, "a")]))]
        ran = self.run_script(bag(TOPICS, messages))
        self.assertEqual(ran.returncode, 0, ran.stderr)
        left, low = self.table("detections.csv")
        self.assertEqual(list(left), ["time", "range", "yaw", "pitch", "class", "score", "id"])
        self.assertEqual((float(left["range"]), left["id"], low["id"]), (5.0, "0", "1"))
        self.assertAlmostEqual(float(low["pitch"]), -math.pi / 4)  # above: positive is down
        ran = self.run_script(bag(TOPICS, messages), "--optical")
        self.assertEqual(ran.returncode, 0, ran.stderr)
        low = self.table("detections.csv")[1]  # 2 m ahead and 2 m down
        self.assertAlmostEqual(float(low["yaw"]), 0)
        self.assertAlmostEqual(float(low["pitch"]), math.pi / 4)

    def test_tags_are_transforms_from_the_camera(self):
        topics = [("/odom", ODOMETRY), ("/tf", TRANSFORMS)]
        seen = [("camera", "tag36h11:12", 0.5, 1.0, 2.0), ("odom", "base_2", 9, 9, 9), ("camera", "mount", 1, 1, 1)]
        messages = [(0, odometry(5, 0, 0, 0)), (1, transforms(5.25, seen))]
        ran = self.run_script(bag(topics, messages), "--tags", "camera", "--plane")
        self.assertEqual(ran.returncode, 0, ran.stderr)
        (tag,) = self.table("detections.csv")  # 2 m ahead and .5 m to the right
        self.assertEqual((tag["time"], tag["id"]), ("5.25", "12"))
        self.assertAlmostEqual(float(tag["range"]), math.hypot(2, 0.5))
        self.assertAlmostEqual(float(tag["yaw"]), math.atan2(-0.5, 2))
        ran = self.run_script(bag(topics, messages), "--tags", "lens")
        self.assertIn("no transform leads from lens to a tag; frames that lead to numbered ones: camera, odom", ran.stderr)

    def test_tags_in_images_are_placed_by_their_homography(self):
        topics = [("/odom", ODOMETRY), ("/tags", TAGS), ("/camera_info", CAMERA)]
        ahead, aside = (0.0, 0.0, 3.0), (0.5, -0.4, 2.0)
        messages = [(0, odometry(1, 0, 0, 0)), (2, camera(1)),
                    (1, tags(1.5, [(3, homography(ahead, 0.0)), (4, homography(aside, 0.6)), (5, [0.0] * 9)]))]
        ran = self.run_script(bag(topics, messages), "--tag-size", str(EDGE))
        self.assertEqual(ran.returncode, 0, ran.stderr)
        self.assertIn("their homography tells no position: 1", ran.stdout)
        three, four = self.table("detections.csv")
        self.assertEqual((three["time"], three["id"], four["id"]), ("1.5", "3", "4"))
        self.assertAlmostEqual(float(three["sigma_range"]), 9 * 0.5 / (FOCAL * EDGE))
        for row, (x, y, z) in ((three, ahead), (four, aside)):
            self.assertAlmostEqual(float(row["range"]), math.hypot(x, y, z))
            self.assertAlmostEqual(float(row["yaw"]), math.atan2(-x, z))
            self.assertAlmostEqual(float(row["pitch"]), math.atan2(y, math.hypot(x, z)))
        self.assertIn("--tag-size is their edge", self.run_script(bag(topics, messages)).stderr)
        flat = self.run_script(bag(topics, [(0, odometry(1, 0, 0, 0)), (2, camera(1, 0.0))]), "--tag-size", "0.1")
        self.assertIn("the camera is not calibrated", flat.stderr)
        self.assertIn("/camera_info has no message", self.run_script(bag(topics, messages[:1]), "--tag-size", "0.1").stderr)
        self.assertIn("is a length", self.run_script(bag(topics, messages), "--tag-size", "0").stderr)

    def test_poses_of_other_kinds_are_odometry(self):
        topics = [("/pose", POSE), ("/objects", DETECTIONS), ("/tf", TRANSFORMS)]
        seen = detections(0, [("7", 3.0, 4.0, 0.0, "a")])
        stamped = [Cdr().header(k).pose(2 * k, 1, 0, 0.25).whole() for k in range(3)]
        moved = [transforms(k, [("odom", "base", 3 * k, 1, 0), ("map", "odom", 9, 9, 9)]) for k in range(3)]
        messages = [(1, seen), *((0, m) for m in stamped), *((2, m) for m in moved), (2, moved[0])]
        ran = self.run_script(bag(topics, messages), "--plane")
        self.assertEqual(ran.returncode, 0, ran.stderr)
        last = self.table("odometry.csv")[-1]
        self.assertEqual((float(last["time"]), float(last["x"])), (2, 4))
        self.assertAlmostEqual(float(last["yaw"]), 0.25)
        ran = self.run_script(bag(topics, messages), "--odometry-tf", "odom", "base")
        self.assertEqual(ran.returncode, 0, ran.stderr)
        self.assertEqual([float(r["x"]) for r in self.table("odometry.csv")], [0, 3, 6])
        self.assertIn("its time was there before, a number is not finite or too large, or its rotation is 0: 1", ran.stdout)
        ran = self.run_script(bag(topics, messages), "--odometry-tf", "odom", "wheel")
        self.assertIn("/tf has no transform from odom to wheel", ran.stderr)

    def test_messages_out_of_order_are_sorted(self):
        shuffled = drive()
        shuffled = shuffled[12:] + shuffled[:12]
        ran = self.run_script(bag(TOPICS, shuffled), "--plane")
        self.assertEqual(ran.returncode, 0, ran.stderr)
        self.assertNotIn("dropped", ran.stdout)
        self.check_tables()

    def test_a_failure_leaves_what_was_there(self):
        self.run_script(bag(TOPICS, drive()), "--plane")
        ran = self.run_script(bag(TOPICS, drive()), "--plane", "--truth", "/none")
        self.assertEqual(ran.returncode, 1)
        self.check_tables()
        self.assertEqual(sorted(path.name for path in self.at.iterdir()), ["a.mcap", "detections.csv", "odometry.csv"])

    def test_what_a_definition_lacks_is_told_in_a_line(self):
        renamed = {**ODOMETRY, "std_msgs/Header": "builtin_interfaces/Time time\nstring frame_id\n"}
        broken = {"nav_msgs/Odometry": "std_msgs/Header header\nnav_msgs/Odometry again\n"}
        for definitions in (renamed, broken, {"nav_msgs/Odometry": "std_msgs/Header[x] header\n"}):
            ran = self.run_script(bag([("/odom", definitions), TOPICS[1]], drive()))
            self.assertEqual(ran.returncode, 1)
            self.assertRegex(ran.stderr, r"\Amcap_to_csv: .*a\.mcap.*\n\Z")

    def test_truth_is_poses_or_fixes(self):
        topics = [("/odom", ODOMETRY), ("/objects", DETECTIONS), ("/fix", FIX), ("/mocap", POSE)]
        fix = lambda k, status, lat, lon, alt: (2, Cdr().header(k).put("b", status).put("H", 1).put("d", lat, lon, alt).whole())
        messages = [*drive(), fix(100, -1, 0, 0, 0), fix(101, 0, 45.0, 8.0, 100.0), fix(102, 0, 45.0, 8.001, 101.0),
                    fix(103, 2, 45.001, 8.0, 100.0), fix(104, 0, math.nan, 8.0, 0.0), (3, Cdr().header(7).pose(1, 2, 3).whole())]
        ran = self.run_script(bag(topics, messages), "--truth", "/fix")
        self.assertEqual(ran.returncode, 0, ran.stderr)
        self.assertIn("they are none: 2", ran.stdout)
        self.assertIn("latitude 45.0, longitude 8.0, altitude 100.0", ran.stdout)
        rows = [[float(x) for x in line.split()] for line in (self.at / "truth.xyz").read_text().splitlines()]
        # A degree on WGS 84 at 45 degrees north: 78.847 km of longitude, 111.132 km of latitude.
        for row, expected in zip(rows, ([101, 0, 0, 0], [102, 78.847, 0, 1], [103, 0, 111.132, 0]), strict=True):
            for a, b in zip(row, expected, strict=True):
                self.assertAlmostEqual(a, b, delta=0.005)
        ran = self.run_script(bag(topics, messages), "--truth", "/mocap")
        self.assertEqual((self.at / "truth.tum").read_text(), "7.0 1.0 2.0 3.0 0.0 0.0 0.0 1.0\n")

    def test_the_place_of_the_sensor_is_told(self):
        topics = [("/odom", ODOMETRY), ("/objects", DETECTIONS), ("/tf_static", TRANSFORMS)]
        quarter = math.pi / 2
        mount = Cdr().put("I", 2)
        mount.header(0, "base").string("mast").put("d", 1, 0, 0.5, 0, 0, math.sin(quarter / 2), math.cos(quarter / 2))
        mount.header(0, "mast").string("lens").put("d", 0.25, 0, 0, -0.5, 0.5, -0.5, 0.5)
        seen = detections(0, [("7", 1.0, 2.0, 3.0, "a")], frame="lens")
        whole = bag(topics, [(0, odometry(0, 0, 0, 0)), (1, seen), (2, mount.whole())])
        self.assertIn("--sensor-pose 1 0.25 0.5 1.5708 0 0\n", self.run_script(whole, "--base", "base", "--optical").stdout)
        self.assertIn("no transforms lead from wheel to lens: they end at base", self.run_script(whole, "--base", "wheel").stderr)

    def test_tags_in_images_become_a_map(self):
        programs = os.environ.get("HYBRID_BIN")
        if not programs:
            self.skipTest("skipped: HYBRID_BIN is not set")
        messages = [(2, camera(0))]
        places = {1: (6.0, 2.0), 2: (9.0, -2.5), 3: (12.0, 1.0)}
        for k in range(20):
            messages.append((0, odometry(k, 0.25 * k, 0, 0)))
            seen = [(n, homography((-y, 0.2, x - 0.25 * k - 0.1), 0.3)) for n, (x, y) in places.items()]
            messages.append((1, tags(k, seen)))
        whole = bag([("/odom", ODOMETRY), ("/tags", TAGS), ("/camera_info", CAMERA)], messages)
        ran = self.run_script(whole, "--tag-size", str(EDGE), "--plane")
        self.assertEqual(ran.returncode, 0, ran.stderr)
        for command in (["hybrid-import", "csv", "--odometry", "odometry.csv", "--detections", "detections.csv",
                         "--sensor-pose", "0.1", "0", "0", "0", "0", "0", "-o", "a.rawlog"],
                        ["hybrid-replay", "a.rawlog", "--no-pictures", "-o", "out"]):
            ran = subprocess.run([f"{programs}/{command[0]}", *command[1:]], cwd=self.at, text=True, capture_output=True, check=False)
            self.assertEqual(ran.returncode, 0, ran.stderr)
        found = json.loads((self.at / "out/landmarks.json").read_text())["landmarks"]
        self.assertEqual({landmark["id"] for landmark in found}, set(places))
        for landmark in found:
            self.assertLess(math.dist(landmark["position"], places[landmark["id"]]), 0.01)

    def test_what_cannot_be_read_is_told(self):
        whole = bag(TOPICS, drive())
        self.assertIn("is not an MCAP file", self.run_script(b"SQLite format 3").stderr)
        self.assertIn("/objects (vision_msgs/msg/Detection3DArray)", self.run_script(whole, "--odometry", "/odometry").stderr)
        self.assertIn("no topic is vision_msgs/msg/Detection3DArray", self.run_script(bag(TOPICS[:1], [])).stderr)
        self.assertIn("compressed with 'xz'", self.run_script(bag(TOPICS, [], ("xz", bytes))).stderr)
        self.check_bag([*drive(), (0, odometry(0, 0, 0, 0)[:-8])], "a message ends early")
        cut = self.run_script(whole[:len(whole) * 2 // 3], "--plane")
        self.assertEqual(cut.returncode, 0, cut.stderr)
        self.assertIn("ends early; what came before is used", cut.stdout)
        for size in range(0, len(whole), 997):
            self.assertNotIn("Traceback", self.run_script(whole[:size]).stderr)

    def test_detections_that_are_none_are_dropped(self):
        bad = [("7", x, 1.0, 0.0, "a") for x in (math.nan, math.inf, 1e200, 2e15)]
        bad.append(("99999999999", 1.0, 1.0, 0.0, "a"))
        good = ("8", 3.0, 1.0, 0.0, "a")
        for options in ([], ["--plane"]):
            ran = self.run_script(bag(TOPICS, [*drive()[:1], (1, detections(0, [*bad, good]))]), *options)
            self.assertEqual(ran.returncode, 0, ran.stderr)
            self.assertIn("too large, or a score not within 0 and 1: 5\n", ran.stdout)
            self.assertEqual([row["id"] for row in self.table("detections.csv")], ["8"])
        self.check_bag([*drive()[:1], (1, detections(0, bad))], "a.mcap: no detection serves")
        self.check_bag([*drive()[:1], (1, detections(0, []))], "a.mcap: there is no detection")

    def test_tables_have_rows(self):
        seen = (1, detections(0, [("8", 3.0, 1.0, 0.0, "a")]))
        self.check_bag([seen], "a.mcap: the topic of the odometry has no message")
        absurd = (0, odometry(0, 1e200, 0, 0))
        self.check_bag([seen, absurd], "a.mcap: the topic of the odometry has no pose that serves")
        topics = [*TOPICS, ("/fix", FIX)]
        fixes = [(2, Cdr().header(k).put("b", 0).put("H", 1).put("d", *fix).whole())
                 for k, fix in enumerate(((1e200, 0, 0), (91, 0, 0), (0, 400, 0), (0, 0, 1e200)))]
        ran = self.run_script(bag(topics, [*drive(), *fixes]), "--truth", "/fix")
        self.check_refused(ran, "a.mcap: /fix tells nothing that is true")
        self.assertIn("they are none: 4\n", ran.stdout)

    def test_quaternions_of_any_length(self):
        for length in (1e-3, 2, 1e200):
            message = Cdr().header(0).put("d", 1, 2, 0, 0, 0, length * math.sin(0.5), length * math.cos(0.5)).whole()
            ran = self.run_script(bag([("/pose", POSE), TOPICS[1]], [(0, message), drive()[1]]), "--plane")
            self.assertEqual(ran.returncode, 0, ran.stderr)
            self.assertAlmostEqual(float(self.table("odometry.csv")[0]["yaw"]), 1.0)

    def test_transforms_that_are_none(self):
        topics = [*TOPICS, ("/tf_static", TRANSFORMS)]
        for q in ((0, 0, 0, 0), (0, 0, 0, math.nan)):
            mount = Cdr().put("I", 1).header(0, "base").string("map").put("d", 1, 0, 0.5, *q).whole()
            self.check_bag([*drive(), (2, mount)], "a.mcap: the transforms from base to map are none", "--base", "base",
                           topics=topics)

    def test_the_tables_become_a_map(self):
        programs = os.environ.get("HYBRID_BIN")
        if not programs:
            self.skipTest("skipped: HYBRID_BIN is not set")
        self.run_script(bag(TOPICS, drive()), "--plane")
        for command in (["hybrid-import", "csv", "--odometry", "odometry.csv", "--detections", "detections.csv", "-o", "a.rawlog"],
                        ["hybrid-replay", "a.rawlog", "--no-pictures", "-o", "out"]):
            ran = subprocess.run([f"{programs}/{command[0]}", *command[1:]], cwd=self.at, text=True, capture_output=True, check=False)
            self.assertEqual(ran.returncode, 0, ran.stderr)
        found = json.loads((self.at / "out/landmarks.json").read_text())["landmarks"]
        self.assertEqual({str(l["id"]): l["class"] for l in found}, {n: l[2] for n, l in LANDMARKS.items()})
        for landmark in found:  # in the frame of the first pose
            x, y, _ = LANDMARKS[str(landmark["id"])]
            c, s = math.cos(0.1), math.sin(0.1)
            expected = (c * x + s * (y - 0.5), -s * x + c * (y - 0.5))
            self.assertLess(math.dist(landmark["position"], expected), 0.05)


if __name__ == "__main__":
    unittest.main()
