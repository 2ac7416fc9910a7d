# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Bags that are made here, and what mcap_to_csv makes of them."""

import csv
import math
import pathlib
import resource
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


class BagTest(unittest.TestCase):
    """Runs mcap_to_csv on bags that are made here."""

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
