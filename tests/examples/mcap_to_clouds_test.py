#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Clouds of a bag made here become PCD files with poses, and a log. HYBRID_BIN is the folder of the programs."""

import math
import os
import pathlib
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from bags import ODOMETRY, TRANSFORMS, Cdr, bag, odometry  # noqa: E402

SCRIPT = pathlib.Path(__file__).parents[2] / "examples/ros2/mcap_to_clouds.py"
CLOUDS = {
    "sensor_msgs/PointCloud2": "std_msgs/Header header\nuint32 height\nuint32 width\nPointField[] fields\nbool is_bigendian\n"
                               "uint32 point_step\nuint32 row_step\nuint8[] data\nbool is_dense\n",
    "sensor_msgs/PointField": "uint8 INT8=1\nuint8 FLOAT32 = 7\nstring name\nuint32 offset\nuint8 datatype\nuint32 count\n",
}
TOPICS = [("/odom", ODOMETRY), ("/points", CLOUDS), ("/tf_static", TRANSFORMS)]
ALONE = TOPICS[1:2]
XYZ = (("x", 0, 7), ("y", 4, 7), ("z", 8, 7))  # name, offset and datatype of fields
POINT = struct.pack("<3f", 1, 2, 3)
STILL = ((0, odometry(0, 0, 0, 0)), (0, odometry(20, 0, 0, 0)))


def cloud(time, data=POINT, fields=XYZ, step=12, size=None, row=None, big=False, frame="lidar"):
    """A message; `size` is (height, width)."""
    height, width = size or (1, len(data) // step)
    out = Cdr().header(time, frame).put("I", height, width, len(fields))
    for name, offset, kind in fields:
        out.string(name).put("I", offset).put("B", kind).put("I", 1)
    out.put("B", big).put("I", step, width * step if row is None else row, len(data))
    out.data += data
    return out.put("B", 0).whole()


def pcd(path):
    """Names of the fields, bytes of each, and the points."""
    head, _, data = path.read_bytes().partition(b"DATA binary\n")
    lines = {line.split()[0]: line.split()[1:] for line in head.decode().splitlines()}
    assert set(lines["TYPE"]) == {"F"} and len(lines["COUNT"]) == len(lines["FIELDS"])
    points = list(struct.iter_unpack("<" + "".join({"4": "f", "8": "d"}[size] for size in lines["SIZE"]), data))
    assert lines["POINTS"] == lines["WIDTH"] == [str(len(points))] and lines["HEIGHT"] == ["1"]
    return lines["FIELDS"], lines["SIZE"], points


class McapToClouds(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.at = pathlib.Path(self.folder.name)
        self.out = self.at / "out"

    def run_script(self, messages, *options, topics=TOPICS):
        """Runs with a new folder for its output."""
        (self.at / "a.mcap").write_bytes(bag(topics, messages))
        shutil.rmtree(self.out, ignore_errors=True)
        return self.convert("a.mcap", *options)

    def convert(self, name, *options):
        return subprocess.run([sys.executable, "-B", SCRIPT, self.at / name, "-o", self.out, *options], text=True,
                              capture_output=True, check=False)

    def only(self, message, *options):
        """The one file of a bag with this message alone, read."""
        ran = self.run_script([*STILL, (1, message)], *options)
        self.assertEqual((ran.returncode, ran.stderr), (0, ""))
        (path,) = self.out.glob("*.pcd")
        return pcd(path)

    def poses(self):
        return [[float(x) for x in line.split()] for line in (self.out / "odometry.txt").read_text().splitlines()]

    def test_clouds_have_names_and_poses_of_their_times(self):
        messages = [(1, cloud(time)) for time in (1.5, 0.25, 3)] + [(0, odometry(0, 0, 0, 0)), (0, odometry(2, 4, 0, 1))]
        ran = self.run_script(messages)
        self.assertEqual(ran.returncode, 0, ran.stderr)
        self.assertIn("clouds dropped, the first is message 3: no odometry before or after them: 1\n", ran.stdout)
        self.assertIn("2 clouds with 2 points and odometry.txt\n", ran.stdout)
        self.assertIn("poses are taken to be those of lidar", ran.stdout)
        self.assertEqual(sorted(path.name for path in self.out.iterdir()), ["0.250000000.pcd", "1.500000000.pcd", "odometry.txt"])
        for pose, (time, x, yaw) in zip(self.poses(), [(0.25, 0.5, 0.125), (1.5, 3, 0.75)], strict=True):
            for a, b in zip(pose, [time, x, 0, 0, 0, 0, math.sin(yaw / 2), math.cos(yaw / 2)], strict=True):
                self.assertAlmostEqual(a, b, places=12)

    def test_poses_turn_the_short_way(self):
        whole = odometry(2, 0, 0, 1)
        at = len(whole) - 36 * 8 - 32  # of the rotation
        turned = struct.pack("<4d", *(-x for x in struct.unpack("<4d", whole[at:at + 32])))
        messages = [(0, odometry(0, 0, 0, 0)), (0, whole[:at] + turned + whole[at + 32:]), (1, cloud(1)),
                    (0, whole[:at] + bytes(32) + whole[at + 32:])]
        ran = self.run_script(messages)
        self.assertEqual(ran.returncode, 0, ran.stderr)
        self.assertIn("or its rotation is 0: 1", ran.stdout)
        self.assertAlmostEqual(self.poses()[0][6], math.sin(0.25), places=12)

    def test_values_are_those_of_the_message(self):
        places = [(1.5, -2.25, 3.125), (4, 5, 6), (-7, 8, 1e6)]
        for order, kind, code, size in (("<", 7, "f", "4"), (">", 7, "f", "4"), ("<", 8, "d", "8"), (">", 8, "d", "8")):
            step, wide = 8 * 5 + 3, int(size)
            fields = [("z", 1, kind), ("ring", 9, 4), ("x", 11, kind), ("y", 19, kind), ("intensity", 27, 2)]
            points = b""
            for x, y, z in places:
                point = bytearray(b"\xff" * step)
                for at, value in ((1, z), (11, x), (19, y)):
                    point[at:at + wide] = struct.pack(order + code, value)
                point[27] = 200
                points += point
            names, sizes, read = self.only(cloud(1, points, fields, step, big=order == ">"))
            self.assertEqual((names, sizes), (["x", "y", "z", "intensity"], [size] * 3 + ["4"]))
            self.assertEqual(read, [(*place, 200) for place in places])

    def test_rows_have_padding(self):
        rows = b"".join(struct.pack("<6f", *range(6 * k, 6 * k + 6)) + b"\xff" * 10 for k in range(3))
        for data in (rows, rows[:-10]):  # the last row may end with its points
            _, _, points = self.only(cloud(1, data, size=(3, 2), row=34))
            self.assertEqual(points, [tuple(range(k, k + 3)) for k in range(0, 18, 3)])

    def test_points_without_a_place_are_dropped(self):
        bad = [(math.nan, 0, 0), (0, math.inf, 0), (0, 0, -math.inf), (1e20, 0, 0)]
        data = b"".join(struct.pack("<3f", *p) for p in [(1, 2, 3), *bad, (4, 5, 6)])
        ran = self.run_script([(0, cloud(1, data)), (0, cloud(2, data[12:60])), (0, cloud(3, b"")), (0, cloud(4, b"", ()))], topics=ALONE)
        self.assertEqual((ran.returncode, ran.stderr), (0, ""))
        self.assertIn("points dropped: their places are not finite: 8\n", ran.stdout)
        self.assertIn("clouds kept without points: 3\n", ran.stdout)
        self.assertIn("the bag has no odometry: clouds alone\n", ran.stdout)
        read = [pcd(path)[2] for path in sorted(self.out.iterdir())]
        self.assertEqual(read, [[(1, 2, 3), (4, 5, 6)], [], [], []])

    def test_times_of_points(self):
        stamp = 1700000000.5
        for name, kind, code, values in (
                ("t", 6, "I", [0, 50_000_000]), ("offset_time", 6, "I", [0, 50_000_000]), ("time", 7, "f", [0, 0.05]),
                ("time", 8, "d", [0, 0.05]), ("timestamp", 8, "d", [stamp, stamp + 0.05]),
                ("timestamp", 8, "d", [1e9 * stamp, 1e9 * stamp + 5e7])):
            data = b"".join(POINT + struct.pack("<" + code, value).ljust(8, b"\xff") for value in values)
            ran = self.run_script([(0, cloud(stamp, data, (*XYZ, (name, 12, kind)), 20))], topics=ALONE)
            self.assertEqual((ran.returncode, ran.stderr), (0, ""))
            names, sizes, points = pcd(self.out / "1700000000.500000000.pcd")
            self.assertEqual((names, sizes), (["x", "y", "z", "t"], ["4"] * 4))
            for point, seconds in zip(points, (0, 0.05), strict=True):
                self.assertAlmostEqual(point[3], seconds, delta=1e-6)

    def test_clouds_where_odometry_is_missing_are_dropped(self):
        driven = [(0, odometry(k, k, 0, 0)) for k in (*range(12), 40)]
        ran = self.run_script([*driven, (1, cloud(5.5)), (1, cloud(20))])
        self.assertEqual((ran.returncode, ran.stderr), (0, ""))
        self.assertIn("message 2: odometry is missing there for over ten times its usual period: 1\n", ran.stdout)
        self.assertEqual([path.name for path in self.out.glob("*.pcd")], ["5.500000000.pcd"])

    def test_a_camera_looks_along_z(self):
        self.assertEqual(self.only(cloud(1), "--optical")[2], [(3, -1, -2)])

    def test_several_topics(self):
        topics = [*TOPICS, ("/depth", CLOUDS)]
        messages = [*STILL, (1, cloud(1)), (3, cloud(2, 2 * POINT))]
        ran = self.run_script(messages, topics=topics)
        self.assertEqual((ran.returncode, ran.stderr.count("\n"), self.out.exists()), (1, 1, False))
        for words in ("2 topics are sensor_msgs/msg/PointCloud2: name one", "/points (", "/depth ("):
            self.assertIn(words, ran.stderr)
        self.assertEqual(self.run_script(messages, "--topic", "/depth", topics=topics).returncode, 0)
        self.assertEqual(len(pcd(self.out / "2.000000000.pcd")[2]), 2)
        self.assertIn("/none is no topic of", self.run_script(messages, "--topic", "/none", topics=topics).stderr)
        self.assertIn("no topic is sensor_msgs/msg/PointCloud2", self.run_script(STILL, topics=TOPICS[:1]).stderr)

    DAMAGED = (
        (cloud(1)[:-8], "a message ends early"),
        (cloud(1)[:30], "a message ends early"),
        (b"", "not in plain CDR"),
        (cloud(1, 2 * POINT, size=(1, 3)), "data is shorter than width, height and steps say"),
        (cloud(1, size=(2**32 - 1, 2**32 - 1), row=2**32 - 1), "row_step is less than width times point_step"),
        (cloud(1, size=(2**32 - 1, 1), row=2**32 - 1), "data is shorter"),
        (cloud(1, step=2**32 - 1, size=(1, 2**32 - 1), row=0), "data is shorter"),
        (cloud(1, step=0, size=(2**32 - 1, 2**32 - 1)), "x ends behind point_step"),
        (cloud(1, size=(2, 1), row=6), "row_step is less"),
        (cloud(1, fields=XYZ[1:]), "there is no field x"),
        (cloud(1, fields=(*XYZ[1:], ("x", 0, 5))), "x is no float32 or float64"),
        (cloud(1, fields=(*XYZ[1:], ("x", 9, 7))), "x ends behind point_step"),
        (cloud(1, fields=(*XYZ, ("t", 2**32 - 1, 6))), "t ends behind point_step"),
        (cloud(-1), "the stamp is no time"),
        (cloud(1, fields=(("x", 0, 7), ("y", 0, 7), ("z", 0, 7)), step=4), "fields overlap"),
    )

    def test_damaged_messages_are_counted(self):
        for damaged, words in self.DAMAGED:
            with self.subTest(words):
                ran = self.run_script([(0, odometry(-9, 0, 0, 0)), *STILL, (1, cloud(2)), *[(1, damaged)] * 10, (1, cloud(3))])
                self.assertEqual((ran.returncode, ran.stderr), (0, ""))
                self.assertRegex(ran.stdout, f"clouds dropped, the first is message 2: .*{words}.*: 10\n")
                self.assertIn("2 clouds with 2 points", ran.stdout)
                ran = self.run_script([*STILL, (1, damaged)])
                self.assertEqual((ran.returncode, ran.stderr.count("\n"), self.out.exists()), (1, 1, False))
                self.assertRegex(ran.stderr, f": .*a.mcap: no cloud of /points can be read; the first: .*{words}")

    def test_clouds_that_are_no_others(self):
        messages = [*STILL, *[(1, cloud(1, frame="li\x1bdar"))] * 10, *[(1, cloud(2 + k, frame="other")) for k in range(3)]]
        ran = self.run_script(messages)
        self.assertEqual((ran.returncode, ran.stderr), (0, ""))
        self.assertIn("the first is message 2: the stamp was there before: 9\n", ran.stdout)
        self.assertIn(r"the first is message 11: the frame is not that of the first cloud, li\x1bdar: 3", ran.stdout)

    def test_a_definition_that_is_not_ros(self):
        topics = [TOPICS[0], ("/points", {**CLOUDS, "sensor_msgs/PointCloud2": "std_msgs/Header header\n"})]
        self.assertIn("KeyError 'height'", self.run_script([*STILL, (1, cloud(1))], topics=topics).stderr)
        topics = [TOPICS[0], ("/points", {"sensor_msgs/PointCloud2": CLOUDS["sensor_msgs/PointCloud2"]})]
        self.assertIn("does not define sensor_msgs/PointField", self.run_script([*STILL, (1, cloud(1))], topics=topics).stderr)

    def test_a_cut_bag(self):
        whole = bag(TOPICS, [*STILL, *[(1, cloud(k)) for k in range(9)]])
        for size in [*range(0, len(whole), 397), len(whole) - 300]:
            (self.at / "a.mcap").write_bytes(whole[:size])
            ran = self.convert("a.mcap")
            self.assertNotIn("Traceback", ran.stderr)
            self.assertEqual(self.out.exists(), ran.returncode == 0)
            shutil.rmtree(self.out, ignore_errors=True)
        self.assertIn("ends early; what came before is used", ran.stdout)

    def test_nothing_is_overwritten_and_a_failure_leaves_nothing(self):
        self.assertEqual(self.run_script([*STILL, (1, cloud(1))]).returncode, 0)
        before = sorted(self.out.iterdir())
        ran = self.convert("a.mcap")
        self.assertEqual((ran.returncode, ran.stderr.count("\n")), (1, 1))
        self.assertIn("out is not empty: name a folder that is empty or new", ran.stderr)
        self.assertEqual(sorted(self.out.iterdir()), before)
        for messages, words in (([*STILL, (1, cloud(50))], "clouds are of 50.000 to 50.000 s, odometry of 0.000 to 20.000 s"),
                                (STILL, "/points has no message"), ([(1, cloud(1))], "odometry has no message")):
            ran = self.run_script(messages)
            self.assertEqual((ran.returncode, ran.stderr.count("\n"), self.out.exists()), (1, 1, False))
            self.assertIn(words, ran.stderr)
            self.out.mkdir()
            self.assertEqual((self.convert("a.mcap").stderr, list(self.out.iterdir())), (ran.stderr, []))
        shutil.rmtree(self.out)
        self.out.write_text("a file")
        self.assertIn("cannot write", self.convert("a.mcap").stderr)

    def test_the_place_of_the_sensor_is_told(self):
        mount = Cdr().put("I", 1).header(0, "/base").string("lidar").put("d", 0.5, 0, 1.25, 0, 0, 0, 1).whole()
        ran = self.run_script([*STILL, (1, cloud(1)), (2, mount)], "--base", "base")
        self.assertEqual(ran.stdout.splitlines()[-1], "give hybrid-import: --sensor-pose 0.5 0 1.25 0 0 0")
        ran = self.run_script([*STILL, (1, cloud(1))], "--base", "base")
        self.assertIn("no transforms lead from base to lidar", ran.stderr)
        self.assertFalse(self.out.exists())

    def test_a_bag_in_many_files(self):
        run = self.at / "run"
        run.mkdir()
        for k in range(12):
            (run / f"run_{k}.mcap").write_bytes(bag(TOPICS, [(0, odometry(11 - k, k, 0, 0)), (1, cloud(11 - k))]))
        self.assertEqual(self.convert("run").returncode, 0)
        self.assertEqual([pose[:2] for pose in self.poses()], [[k, 11 - k] for k in range(12)])

    def test_clouds_become_a_log(self):
        programs = os.environ.get("HYBRID_BIN")
        if not programs:
            self.skipTest("skipped: HYBRID_BIN is not set")
        fields = (*XYZ, ("intensity", 12, 7), ("time", 16, 7))
        data = b"".join(struct.pack("<5f", k, 2 * k, 3, 9, 0.001 * k) for k in range(50))
        seen = [(0, cloud(0.5 + k, data if k else b"", fields, 20)) for k in range(4)]
        driven = [(1, odometry(k, 0.5 * k, 0, 0)) for k in range(5)]
        for messages, topics, options in ((seen, ALONE, []), (seen + driven, [*ALONE, *TOPICS[:1]], ["--odometry", "out/odometry.txt"])):
            ran = self.run_script(messages, topics=topics)
            self.assertEqual(ran.returncode, 0, ran.stderr)
            ran = subprocess.run([f"{programs}/hybrid-import", "clouds", "out", *options, "-o", "a.rawlog"], cwd=self.at, text=True,
                                 capture_output=True, check=False)
            self.assertEqual(ran.returncode, 0, ran.stderr)
            self.assertIn("4 clouds with 150 points, of which 150 are kept", ran.stdout + ran.stderr)


if __name__ == "__main__":
    unittest.main()
