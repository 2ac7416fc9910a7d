# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""What a careful reader could tell of a file without knowing the undamaged one: an independent,
simple check of the forms of rows. Only what is certainly wrong counts; "" means nothing is."""

import math
import re
import zlib

NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")

# Forms of rows: n a number, i a whole number from 0, w any word. A form with a tag begins with it.
FORMS = {
    "graph": ["VERTEX_SE2 i nnn", "VERTEX2 i nnn", "VERTEX_SE3:QUAT i nnnnnnn", "VERTEX3 i nnnnnn",
              "VERTEX_XY i nn", "VERTEX_TRACKXYZ i nnn", "EDGE_SE2 ii nnn nnnnnn",
              "EDGE2 ii nnn nnnnnn", "EDGE2 iiiii nnn", "EDGE2 iiiii nnn nnn", "FIX i",
              "EDGE_SE3:QUAT ii nnnnnnn " + "n" * 21, "EDGE3 ii nnnnnn " + "n" * 21,
              "EDGE_SE2_XY ii nn nnn"],
    "planar": ["nnn", "nnnnnn", "i nnn"], "pairs": ["ii", "iii"], "matrix": None,
    "cloud": ["nnn"], "tum": ["nnnnnnnn"], "series": ["nnnnn"],
    "ranges": ["range2 nnnnnnn", "odom2diff nnnnnnnn"], "points": ["point2 nnn"],
    "path": ["nnnnnn"], "landmarks": ["nnnnnni", "nnnnnniw"],
    "csv/odometry.csv": ["nnnn"], "csv/detections.csv": None,
    "kitti-2d/odometry.g2o": ["EDGE_SE2 ii nnn nnnnnn"], "kitti-2d/boxes.txt": ["innnnnn"],
    "kitti-2d/poses.txt": ["n" * 12], "kitti-3d/poses.txt": ["n" * 12],
    "kitti-3d/odometry.txt": ["n" * 12], "kitti-3d/boxes.txt": ["innnnnn"],
    "kitti-3d/covariances.txt": ["n" * 21], "kitti-tracking/poses.txt": ["n" * 12],
    "kitti-tracking/labels.txt": ["iiw" + "n" * 14],
    "mrclam/Barcodes.dat": ["ii"], "mrclam/Landmark_Groundtruth.dat": ["innnn", "inn"],
    "mrclam/Robot1_Odometry.dat": ["nnn"], "mrclam/Robot1_Groundtruth.dat": ["nnnn"],
    "mrclam/Robot1_Measurement.dat": ["ninn"],
    "stata/frames.txt": ["ii" + "n" * 12], "stata/detections.txt": ["iin" + "n" * 8],
    "carmen/a.clf": None, "mot/odometry.csv": ["nnnn"], "mot/det.txt": ["iinnnnn" + "n" * k for k in range(9)],
    "coco/odometry.csv": ["nnnn"], "coco/a.json": None, "yolo/odometry.csv": ["nnnn"],
    "fixes/odometry.csv": ["nnnn"], "fixes/fixes.csv": None,
    "yolo/classes.txt": None, **{f"yolo/image_{i}.txt": ["innnn", "innnnn", "innnnni"] for i in range(10)},
    "victoria-park/odometry.txt": ["nnn"], "victoria-park/scan_times.txt": ["n"],
    "victoria-park/tree_detections.txt": ["nnnn"], "victoria-park/gps.txt": ["nnn"],
    "victoria-park/victoria_park_known_assoc_gtsam.txt": ["ODOMETRY ii nnn nnnnnn",
                                                          "LANDMARK ii nn nnn"],
}
PLAZA = ["Variable www nn", "Variable www nnn", "Factor www nn", "Factor www nnn w " + "n" * 9,
         "Factor " + "w" * 7 + " nn www n w n"]
FORMS.update({"plaza/graph.fg": PLAZA, "plaza/known.fg": PLAZA})
COMMAS = {"cloud", "csv/odometry.csv", "csv/detections.csv", "mot/odometry.csv", "mot/det.txt",
          "coco/odometry.csv", "yolo/odometry.csv", "fixes/odometry.csv", "fixes/fixes.csv"}


def is_number(word):
    return NUMBER.fullmatch(word) is not None and math.isfinite(float(word)) and (
        float(word) != 0 or not re.search(r"[1-9]", re.split("[eE]", word)[0]))


def fits(word, kind):
    if kind == "w":
        return True
    return is_number(word) and (kind == "n" or (float(word) >= 0 and float(word).is_integer()))


def matches(words, form):
    first = form.split()[0]
    if not set(first) <= set("niw"):
        if words[0] != first:
            return False
        words, form = words[1:], form[len(first):]
    kinds = form.replace(" ", "")
    return len(words) == len(kinds) and all(map(fits, words, kinds))


def cells(line, form):
    if form not in COMMAS or ("," not in line and ";" not in line):
        return line.split()
    separator = ";" if ";" in line else ","
    return [cell.strip(" \t\r") for cell in line.split(separator)]


def fault_of_rows(text, form):
    forms = FORMS.get(form)
    if not forms:
        return ""
    rows = 0
    for number, line in enumerate(text.split("\n"), 1):
        words = cells(re.split("[#%]" if form != "graph" else "#", line)[0].strip(" \t\r"), form)
        if not words or words == [""]:
            continue
        rows += 1
        header = form.endswith(("odometry.csv", "detections.csv")) and rows == 1
        if not header and not any(matches(words, f) for f in forms):
            return f"line {number} is not of its form"
    return ""


def fault_of_log(data):
    if data[:2] != b"\x1f\x8b":
        return ""
    inflate = zlib.decompressobj(31)
    try:
        inflate.decompress(data)
        inflate.flush()
    except zlib.error as error:
        return str(error)
    return "" if inflate.eof else "truncated gzip"


def fault(data, form):
    """Why a file is certainly damaged, or ""."""
    if form == "log":
        return fault_of_log(data)
    if form in ("binary", "map"):
        return ""
    if b"\x00" in data:
        return "a NUL byte"
    text = data.decode("utf-8", "surrogateescape").removeprefix("\ufeff")
    if form == "INI":
        return ""
    wrong = fault_of_rows(text, form)
    if not wrong and data and not data.endswith(b"\n"):
        return "the last line has no end"
    return wrong
