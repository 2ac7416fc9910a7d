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
import resource
import struct
import subprocess
import sys
import tempfile
import unittest
import unittest.mock

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


def detections(time, seen, old=False, frame="map"):
    """`seen` is (id, x, y, z, class) in the frame of the sensor."""
    out = Cdr().header(time, frame).put("I", len(seen))
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


def chunk(name, data, size):
    return record(6, struct.pack("<QQQI", 0, 0, size, 0) + text(name) + struct.pack("<Q", len(data)) + data)


def bag(topics, messages, pack=None, begin=b""):
    """`topics` is (name, definitions), `messages` are (topic's index, bytes); `pack` is (name, function). Records may
    come before."""
    body = begin
    for number, (name, definitions) in enumerate(topics, 1):
        (first, main), *_ = definitions.items()
        others = {**COMMON, **dict(list(definitions.items())[1:])}
        whole = main + "".join(f"{LINE}MSG: {kind}\n{lines}" for kind, lines in others.items())
        body += record(3, struct.pack("<H", number) + text(first.replace("/", "/msg/")) + text("ros2msg") + text(whole))
        body += record(4, struct.pack("<HH", number, number) + text(name) + text("cdr") + struct.pack("<I", 0))
    for index, data in messages:
        body += record(5, struct.pack("<HIQQ", index + 1, 0, 0, 0) + data)
    if pack:
        body = chunk(pack[0], pack[1](body), len(body))
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
DETECTED = "vision_msgs/Detection3DArray"


class McapToCsv(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.at = pathlib.Path(self.folder.name)

    def run_script(self, content, *options, output=None):
        (self.at / "a.mcap").write_bytes(content)
        return self.convert("a.mcap", *options, output=output)

    def convert(self, name, *options, output=None):
        """With little memory and time."""
        confine = lambda: resource.setrlimit(resource.RLIMIT_AS, (500 << 20, 500 << 20))
        command = [sys.executable, "-B", SCRIPT, self.at / name, "-o", output or self.at, *options]
        return subprocess.run(command, text=True, capture_output=True, check=False, timeout=300, preexec_fn=confine)

    def check_bag(self, messages, words, *options, topics=None, **more):
        self.check_refused(self.run_script(bag(topics or TOPICS, messages, **more), *options), words)

    def check_refused(self, ran, words):
        """In one line, and nothing else."""
        self.assertEqual((ran.returncode, ran.stderr.count("\n")), (1, 1), ran.stderr)
        self.assertTrue(ran.stderr.startswith("mcap_to_csv: "), ran.stderr)
        self.assertIn(words, ran.stderr)

    def names(self):
        return sorted(path.name for path in self.at.iterdir())

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

    def test_what_is_no_regular_file_is_not_waited_for(self):
        (self.at / "run").mkdir()
        os.mkfifo(self.at / "run/b.mcap")
        (self.at / "c.mcap").symlink_to(self.at / "run/b.mcap")
        for name in ("run", "run/b.mcap", "c.mcap"):
            self.check_refused(self.convert(name), "mcap: is a pipe, not a regular file")
        (self.at / "run/b.mcap").unlink()
        self.check_refused(self.convert("run"), f"{self.at}/run: no MCAP file is there")
        (self.at / "d.mcap").symlink_to("/dev/zero")
        (self.at / "odometry.csv").touch()
        self.check_refused(self.convert("none.mcap"), "none.mcap: No such file or directory")
        self.check_refused(self.convert("d.mcap"), "d.mcap: is a device, not a regular file")
        self.check_refused(self.convert("x" * 300), "File name too long")

    def test_values_without_bytes_are_limited(self):
        levels = {f"vision_msgs/A{i}": f"A{i + 1} a\nA{i + 1} b\n" for i in range(60)}
        doubling = {DETECTED: "std_msgs/Header header\nA0 a\n", **levels, "vision_msgs/A60": "uint8[0] x\n"}
        many = {DETECTED: "std_msgs/Header header\nA[100] a\n", "vision_msgs/A": "B[100] b\n",
                "vision_msgs/B": "C[100] c\n", "vision_msgs/C": "uint8[0] x\n"}
        for definitions in (doubling, many, {**many, DETECTED: "std_msgs/Header header\nA[] a\n"}):
            message = Cdr().header(0).put("I", 100).put("B", *[0] * 100).whole()
            ran = self.run_script(bag([TOPICS[0], ("/objects", definitions)], [*drive()[::2], (1, message)]))
            self.check_refused(ran, "a.mcap: vision_msgs/msg/Detection3DArray: a message has too many values")

    def test_sizes_are_limited(self):
        line_ends = record(3, struct.pack("<H", 9) + text("x/Y") + text("ros2msg") + text("\n" * (9 << 20)))
        self.check_bag(drive(), "a.mcap: a text of 9437184 bytes is longer than", begin=line_ends)
        self.check_bag([], "a.mcap: a text of 605 bytes is longer than", topics=[("/odom" + "m" * 600, ODOMETRY)])
        self.check_bag(drive(), "a.mcap: damaged: its chunks have more than 1000", begin=3 * chunk("", b"", 90 << 20))
        nested = chunk("", chunk("", chunk("", b"", 1 << 62), 0), 0)
        self.assertEqual(self.run_script(bag(TOPICS, drive(), begin=nested), "--plane").returncode, 0)

    def test_large_records(self):
        whole, size = bag(TOPICS, drive()), 1 << 40  # of a file with a hole
        for code in (5, 9):
            with open(self.at / "b.mcap", "wb") as file:
                file.write(whole[:8] + struct.pack("<BQ", code, size))
                file.seek(size, os.SEEK_CUR)
                file.write(whole[8:])
            ran = self.convert("b.mcap", "--plane")
            if code == 5:
                self.check_refused(ran, "b.mcap: damaged: a record or a chunk is said to have 1099511627776 bytes")
        self.assertEqual(ran.returncode, 0, ran.stderr)  # that of another kind is left out
        self.check_tables()

    def test_packed_definitions_are_limited(self):
        try:
            zstd = importlib.import_module("zstandard").ZstdCompressor()
        except ImportError:
            self.skipTest("skipped: python3-zstandard is not installed")
        for fill in ("\n", "\U0001f600"):
            definition = record(3, struct.pack("<H", 9) + text("x/Y") + text("ros2msg") + text(fill * (9 << 20)))
            self.check_bag(drive(), "is longer than", pack=("zstd", zstd.compress), begin=definition)

    def test_what_cannot_be_written_is_told(self):
        (self.at / "file").write_text("of before")
        (self.at / "link").symlink_to(self.at / "none")
        for output in ("file", "file/below", "link", "n" * 300, "/proc/x", "/dev/null"):
            ran = self.run_script(bag(TOPICS, drive()), output=self.at / output)
            self.check_refused(ran, f"cannot write {self.at / output}: ")
        self.assertEqual(self.names(), ["a.mcap", "file", "link"])
        ran = self.run_script(bag(TOPICS, drive()[:1]), output=self.at / "new/er")
        self.check_refused(ran, "there is no detection")
        self.assertFalse((self.at / "new").exists())

    def test_all_tables_are_written_or_none(self):
        self.check_bag(drive(), "no transforms lead from wheel to map", "--base", "wheel")
        self.assertEqual(self.names(), ["a.mcap"])
        (self.at / "detections.csv").mkdir()
        self.check_refused(self.run_script(bag(TOPICS, drive())), f"cannot write {self.at}/detections.csv: is a folder")
        self.assertEqual(self.names(), ["a.mcap", "detections.csv"])

    def test_a_move_that_fails_is_undone(self):
        bags, move = self.module("mcap_bag"), os.replace
        (self.at / "part").mkdir()
        for name in "ab":
            (self.at / name).write_text("old")
            (self.at / f"part/{name}").write_text("new")

        def fails(before, now):
            if before == self.at / "part/b":
                raise OSError
            move(before, now)

        with unittest.mock.patch("os.replace", fails), self.assertRaises(OSError):
            bags.publish(self.at / "part", self.at, True)
        self.assertEqual(self.names(), ["a", "b", "part"])
        self.assertEqual([path.read_text() for path in (self.at / "a", self.at / "b")], ["old"] * 2)
        self.assertEqual(len(list((self.at / "part").iterdir())), 2)

    def module(self, name):
        sys.path.insert(0, str(SCRIPT.parent))
        self.addCleanup(sys.path.remove, str(SCRIPT.parent))
        return importlib.import_module(name)

    def test_files_of_others_stay(self):
        for name in ("odometry.csv", "odometry.csv.part", "odometry.csv~"):
            (self.at / name).write_text(f"foreign {name}")
        ran = self.run_script(bag(TOPICS, drive()), "--plane")
        self.assertEqual(ran.returncode, 0, ran.stderr)
        self.assertIn(f"{self.at}/odometry.csv was there before; it is now {self.at}/odometry.csv~2\n", ran.stdout)
        self.check_tables()
        for name, now in (("odometry.csv", "odometry.csv~2"), ("odometry.csv.part",) * 2, ("odometry.csv~",) * 2):
            self.assertEqual((self.at / now).read_text(), f"foreign {name}")
        again = self.run_script(bag(TOPICS, drive()), "--plane")
        self.assertNotIn("before", again.stdout)  # the same tables
        self.assertEqual(len(self.names()), 6)

    def test_a_bag_is_not_replaced(self):
        (self.at / "odometry.csv").write_bytes(bag(TOPICS, drive()))
        ran = self.convert("odometry.csv")
        self.check_refused(ran, f"cannot write {self.at}/odometry.csv: is the bag that is read")
        self.assertEqual(self.names(), ["odometry.csv"])

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

    def test_an_output_that_is_full(self):
        (self.at / "a.mcap").write_bytes(bag(TOPICS, drive()))
        with open("/dev/full", "w", encoding="utf-8") as full:
            command = [sys.executable, "-B", SCRIPT, self.at / "a.mcap", "-o", self.at, "--plane"]
            ran = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True, check=False)
        self.assertEqual((ran.returncode, ran.stderr), (0, ""))
        self.check_tables()

    def test_a_signal_leaves_nothing(self):
        bags = self.module("mcap_bag")
        for error, code in ((KeyboardInterrupt(), 130), (SystemExit(143), None)):
            def convert(_, error=error):
                with bags.staged(self.at / "new", self.at / "new", "refused") as part:
                    (part / "a").write_text("new")
                    raise error
            options = type("Options", (), {"bag": ["a.mcap"]})
            if code:
                self.assertEqual(bags.told("x", convert, options), code)
            else:
                self.assertRaises(SystemExit, bags.told, "x", convert, options)
            self.assertEqual(self.names(), [])

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
