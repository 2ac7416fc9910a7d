#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Bags made here become the tables that are in them, and a map. HYBRID_BIN is the folder of the programs."""

import csv
import importlib
import json
import math
import os
import pathlib
import struct
import subprocess
import sys
import tempfile
import unittest

SCRIPT = pathlib.Path(__file__).parents[2] / "examples/ros2/mcap_to_csv.py"
LINE = "=" * 80 + "\n"
COMMON = {
    "std_msgs/Header": "builtin_interfaces/Time stamp\nstring frame_id\n",
    "builtin_interfaces/Time": "# of ROS\nint32 sec\nuint32 nanosec\n",
    "geometry_msgs/PoseWithCovariance": "Pose pose\nfloat64[36] covariance\n",
    "geometry_msgs/Pose": "Point position\nQuaternion orientation\n",
    "geometry_msgs/Point": "float64 x\nfloat64 y\nfloat64 z\n",
    "geometry_msgs/Quaternion": "float64 x 0\nfloat64 y 0\nfloat64 z 0\nfloat64 w 1\n",
    "geometry_msgs/Vector3": "float64 x\nfloat64 y\nfloat64 z\n",
    "geometry_msgs/TransformStamped": "std_msgs/Header header\nstring child_frame_id\nTransform transform\n",
    "geometry_msgs/Transform": "Vector3 translation\nQuaternion rotation\n",
}
TRANSFORMS = {"tf2_msgs/TFMessage": "geometry_msgs/TransformStamped[] transforms\n"}
ODOMETRY = {"nav_msgs/Odometry": "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/PoseWithCovariance pose\n"}
DETECTIONS = {
    "vision_msgs/Detection3DArray": "uint8 KIND=3\nstd_msgs/Header header\nvision_msgs/Detection3D[] detections\n",
    "vision_msgs/Detection3D":
        "std_msgs/Header header\nObjectHypothesisWithPose[] results\nBoundingBox3D bbox\nstring id\n",
    "vision_msgs/ObjectHypothesisWithPose": "ObjectHypothesis hypothesis\ngeometry_msgs/PoseWithCovariance pose\n",
    "vision_msgs/ObjectHypothesis": "string class_id\nfloat64 score\n",
    "vision_msgs/BoundingBox3D": "geometry_msgs/Pose center\ngeometry_msgs/Vector3 size\n",
}
# As ROS 2 Foxy has it.
OLD_DETECTIONS = {
    **DETECTIONS,
    "vision_msgs/Detection3D":
        "std_msgs/Header header\nObjectHypothesisWithPose[] results\nBoundingBox3D bbox\nbool is_tracking\n"
        "string tracking_id\n",
    "vision_msgs/ObjectHypothesisWithPose": "string id\nfloat64 score\ngeometry_msgs/PoseWithCovariance pose\n",
}
TAGS = {
    "apriltag_msgs/AprilTagDetectionArray": "std_msgs/Header header\nAprilTagDetection[] detections\n",
    "apriltag_msgs/AprilTagDetection":
        "string family\nint32 id\nint32 hamming\nfloat32 goodness\nfloat32 decision_margin\nPoint centre    # pixels\n"
        "Point[4] corners\nfloat64[9] homography\n",
    "apriltag_msgs/Point": "float64 x\nfloat64 y\n",
}
CAMERA = {"sensor_msgs/CameraInfo": "std_msgs/Header header\nuint32 height\nuint32 width\nfloat64[]  d\nfloat64[9]  k\nfloat64[12] p\n"}
POSE = {"geometry_msgs/PoseStamped": "std_msgs/Header header\nPose pose\n"}
FIX = {
    "sensor_msgs/NavSatFix": "std_msgs/Header header\nNavSatStatus status\nfloat64 latitude\nfloat64 longitude\nfloat64 altitude\n",
    "sensor_msgs/NavSatStatus": "int8 STATUS_NO_FIX = -1  # none\nint8 status\nuint16 service\n",
}
FOCAL, MIDDLE, EDGE = 600.0, (320.0, 240.0), 0.16  # of a camera [pixel] and of tags [m]
LANDMARKS = {"7": (4.0, 3.0, "tree"), "8": (8.0, -2.0, "post"), "9": (12.0, 4.0, "tree")}


def text(value):
    data = value.encode()
    return struct.pack("<I", len(data)) + data


class Cdr:
    """A message, little-endian."""

    def __init__(self):
        self.data = b""

    def put(self, code, *values):
        for value in values:
            size = struct.calcsize(code)
            self.data += b"\0" * (-len(self.data) % size) + struct.pack("<" + code, value)
        return self

    def string(self, value):
        self.put("I", len(value) + 1)
        self.data += value.encode() + b"\0"
        return self

    def header(self, time, frame="map"):
        return self.put("i", int(time)).put("I", round(1e9 * (time % 1))).string(frame)

    def pose(self, x, y, z=0.0, yaw=0.0):
        return self.put("d", x, y, z, 0, 0, math.sin(yaw / 2), math.cos(yaw / 2))

    def whole(self):
        return b"\0\1\0\0" + self.data


def odometry(time, x, y, yaw):
    return Cdr().header(time).string("base").pose(x, y, 0.0, yaw).put("d", *[0.0] * 36).whole()


def detections(time, seen, old=False):
    """`seen` is (id, x, y, z, class) in the frame of the sensor."""
    out = Cdr().header(time).put("I", len(seen))
    for name, x, y, z, class_name in seen:
        out.header(time).put("I", 2)
        for guess, score in (("rock", 0.2), (class_name, 0.8)):
            out.string(guess).put("d", score).pose(0, 0).put("d", *[0.0] * 36)
        out.pose(x, y, z).put("d", 1, 1, 1)
        if old:
            out.put("B", 1)
        out.string(name)
    return out.whole()


def transforms(time, seen):
    """`seen` is (parent, child, x, y, z)."""
    out = Cdr().put("I", len(seen))
    for parent, child, x, y, z in seen:
        out.header(time, parent).string(child).pose(x, y, z)
    return out.whole()


def homography(position, yaw):
    """Of a tag here in the optical frame, turned about its vertical axis, times an arbitrary factor."""
    columns = [(math.cos(yaw), 0.0, math.sin(yaw)), (0.0, 1.0, 0.0), [2 * x / EDGE for x in position]]
    pixels = [(FOCAL * x + MIDDLE[0] * z, FOCAL * y + MIDDLE[1] * z, z) for x, y, z in columns]
    return [-0.3 * column[row] for row in range(3) for column in pixels]


def tags(time, seen):
    """`seen` is (id, homography)."""
    out = Cdr().header(time, "camera_optical").put("I", len(seen))
    for number, h in seen:
        out.string("36h11").put("i", number, 0).put("f", 0.0, 50.0).put("d", *[0.0] * 10).put("d", *h)
    return out.whole()


def camera(time, focal=FOCAL):
    k = [focal, 0, MIDDLE[0], 0, focal, MIDDLE[1], 0, 0, 1]
    return Cdr().header(time).put("I", 480, 640).put("I", 0).put("d", *k).put("d", *[0.0] * 12).whole()


def record(code, content):
    return struct.pack("<BQ", code, len(content)) + content


def bag(topics, messages, pack=None):
    """`topics` is (name, definitions), `messages` are (topic's index, bytes); `pack` is (name, function)."""
    body = b""
    for number, (name, definitions) in enumerate(topics, 1):
        (first, main), *_ = definitions.items()
        others = {**COMMON, **dict(list(definitions.items())[1:])}
        whole = main + "".join(f"{LINE}MSG: {kind}\n{lines}" for kind, lines in others.items())
        body += record(3, struct.pack("<H", number) + text(first.replace("/", "/msg/")) + text("ros2msg") + text(whole))
        body += record(4, struct.pack("<HH", number, number) + text(name) + text("cdr") + struct.pack("<I", 0))
    for index, data in messages:
        body += record(5, struct.pack("<HIQQ", index + 1, 0, 0, 0) + data)
    if pack:
        packed = pack[1](body)
        body = record(6, struct.pack("<QQQI", 0, 0, len(body), 0) + text(pack[0]) + struct.pack("<Q", len(packed)) + packed)
    magic = b"\x89MCAP0\r\n"
    return magic + record(1, text("ros2") + text("test")) + body + record(15, b"\0" * 4) + record(2, b"\0" * 20) + magic


def drive(old=False):
    """A robot that drives 1 m/s along x and sees the landmarks ahead of it."""
    messages = []
    for k in range(11):
        messages.append((0, odometry(100 + k, k, 0.5, 0.1)))
        seen = []
        for name, (x, y, class_name) in LANDMARKS.items():
            dx, dy, c, s = x - k, y - 0.5, math.cos(0.1), math.sin(0.1)
            if dx > 0:
                seen.append((name, c * dx + s * dy, -s * dx + c * dy, 0.0, class_name))
        messages.append((1, detections(100 + k, seen, old)))
    return messages


TOPICS = [("/odom", ODOMETRY), ("/objects", DETECTIONS)]


class McapToCsv(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.at = pathlib.Path(self.folder.name)

    def run_script(self, content, *options):
        (self.at / "a.mcap").write_bytes(content)
        return subprocess.run([sys.executable, "-B", SCRIPT, self.at / "a.mcap", "-o", self.at, *options], text=True,
                              capture_output=True, check=False)

    def table(self, name):
        with open(self.at / name, encoding="utf-8") as file:
            return list(csv.DictReader(file))

    def check_tables(self):
        odometry_rows, seen = self.table("odometry.csv"), self.table("detections.csv")
        self.assertEqual([float(r["time"]) for r in odometry_rows], [100 + k for k in range(11)])
        self.assertAlmostEqual(float(odometry_rows[3]["x"]), 3)
        self.assertAlmostEqual(float(odometry_rows[3]["yaw"]), 0.1)
        first = [r for r in seen if r["time"] == "100.0"]
        self.assertEqual([(r["id"], r["class"], r["score"]) for r in first],
                         [("7", "tree", "0.8"), ("8", "post", "0.8"), ("9", "tree", "0.8")])
        self.assertAlmostEqual(float(first[0]["range"]), math.hypot(4, 2.5))
        self.assertAlmostEqual(float(first[0]["yaw"]), math.atan2(2.5, 4) - 0.1)

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
        self.assertIn("its time was there before, a number is not finite, or its rotation is 0: 1", ran.stdout)
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
        seen = Cdr().header(0, "lens").put("I", 0).whole()
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
        self.assertIn("a message ends early", self.run_script(bag(TOPICS, [(0, odometry(0, 0, 0, 0)[:-8])])).stderr)
        cut = self.run_script(whole[:len(whole) * 2 // 3], "--plane")
        self.assertEqual(cut.returncode, 0, cut.stderr)
        self.assertIn("ends early; what came before is used", cut.stdout)
        for size in range(0, len(whole), 997):
            self.assertNotIn("Traceback", self.run_script(whole[:size]).stderr)

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
