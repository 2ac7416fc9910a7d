#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Makes the tables that `hybrid-import csv` reads of a ROS 2 bag in MCAP: nav_msgs/Odometry, and vision_msgs/Detection3DArray or
the transforms from a camera to tags that apriltag_ros publishes.

Chunks that are compressed need python3-zstandard or python3-lz4; all else is Python's own. Messages are decoded by the
definitions that the bag itself holds, so that any version of vision_msgs serves. docs/importing.md has an example.
"""

import argparse
import csv
import math
import pathlib
import re
import struct
import sys

MAGIC = b"\x89MCAP0\r\n"
SCHEMA, CHANNEL, MESSAGE, CHUNK, DATA_END = 3, 4, 5, 6, 15
ODOMETRY, DETECTIONS = "nav_msgs/msg/Odometry", "vision_msgs/msg/Detection3DArray"
TRANSFORMS = "tf2_msgs/msg/TFMessage"


class BagError(Exception):
    """What is wrong with a bag, for the user."""


class Bytes:
    """A record, read from its start."""

    def __init__(self, data):
        self.data, self.at = memoryview(data), 0

    def take(self, count):
        if count > len(self.data) - self.at:
            raise BagError("a record ends early")
        self.at += count
        return self.data[self.at - count:self.at]

    def number(self, code):
        return struct.unpack("<" + code, self.take(struct.calcsize(code)))[0]

    def text(self):
        return bytes(self.take(self.number("I"))).decode("utf-8", "replace")


# --- Containers: records of a file, those inside of chunks included.

def unpacked(compression, data, size):
    """The bytes of a chunk."""
    if compression == "":
        return data
    packages = {"zstd": "zstandard", "lz4": "lz4.frame"}
    if compression not in packages:
        raise BagError(f"chunks are compressed with '{compression}', which is not known")
    try:
        module = __import__(packages[compression], fromlist=["x"])
    except ImportError:
        package = packages[compression].split(".", maxsplit=1)[0]
        raise BagError(f"chunks are compressed with {compression}: install python3-{package}") from None
    try:
        if compression == "zstd":
            return module.ZstdDecompressor().decompress(bytes(data), max_output_size=size)
        return module.decompress(bytes(data))
    except Exception as error:  # of either library's own kind
        raise BagError(f"a chunk is damaged: {error}") from None


def records_of(file):
    """(operation code, content) of each record of a file or of a chunk. Returns whether a file was whole."""
    while True:
        head = file.read(9)
        if len(head) < 9:
            return False
        code, size = struct.unpack("<BQ", head)
        content = file.read(size)
        if len(content) < size or code == DATA_END:
            return code == DATA_END
        if code == CHUNK:
            chunk = Bytes(content)
            chunk.take(16)
            size, _, compression = chunk.number("Q"), chunk.number("I"), chunk.text()
            yield from records_of(View(unpacked(compression, chunk.take(chunk.number("Q")), size)))
        else:
            yield code, content


class View:
    """Bytes as a file."""

    def __init__(self, data):
        self.data, self.at = memoryview(data), 0

    def read(self, count):
        self.at += count
        return self.data[self.at - count:self.at]


# --- Messages: what a definition in ROS's own form says, in CDR.

NUMBERS = {"bool": "?", "byte": "B", "char": "B", "int8": "b", "uint8": "B", "int16": "h", "uint16": "H", "int32": "i",
           "uint32": "I", "int64": "q", "uint64": "Q", "float32": "f", "float64": "d"}


def fields_of(definition):
    """(type, array, name) of each field; array is None, a fixed number, or "" for a sequence."""
    for line in definition.splitlines():
        words = line.split("#", maxsplit=1)[0].split()
        if len(words) < 2 or "=" in "".join(words[1:2]) or words[2:3] == ["="]:
            continue
        kind, _, array = words[0].partition("[")
        array = None if "[" not in words[0] else array.rstrip("]")
        fixed = int(array) if array and not array.startswith("<=") else None
        yield kind.partition("<=")[0], fixed if fixed is not None else ("" if array is not None else None), words[1]


class Decoder:
    """Reads messages of one schema."""

    def __init__(self, name, encoding, text):
        if encoding != "ros2msg":
            raise BagError(f"{name} is defined in '{encoding}', where ros2msg is read")
        main, *others = text.split("=" * 80 + "\n")
        self.name, self.types = name, {}
        self.types[self.short(name)] = list(fields_of(main))
        for other in others:
            head, _, body = other.partition("\n")
            self.types[self.short(head.replace("MSG:", "").strip())] = list(fields_of(body))

    @staticmethod
    def short(name):
        """pkg/msg/Type and pkg/Type -> pkg/Type"""
        return name.replace("/msg/", "/")

    def fields(self, kind, package):
        if "/" not in kind:
            kind = "std_msgs/Header" if kind == "Header" else f"{package}/{kind}"
        kind = self.short(kind)
        if kind not in self.types:
            raise BagError(f"{self.name}: the bag does not define {kind}")
        return kind, self.types[kind]

    def decode(self, data):
        if len(data) < 4 or data[1] not in (0, 1):
            raise BagError(f"{self.name}: a message is not in plain CDR")
        self.order, self.data, self.at = "<" if data[1] == 1 else ">", memoryview(data)[4:], 0
        return self.struct(self.short(self.name), "")

    def number(self, code):
        size = struct.calcsize("=" + code)
        self.at += -self.at % size
        if self.at + size > len(self.data):
            raise BagError(f"{self.name}: a message ends early")
        self.at += size
        return struct.unpack_from(self.order + code, self.data, self.at - size)[0]

    def string(self):
        size = self.number("I")
        if size > len(self.data) - self.at:
            raise BagError(f"{self.name}: a message ends early")
        self.at += size
        return bytes(self.data[self.at - size:self.at]).rstrip(b"\0").decode("utf-8", "replace")

    def value(self, kind, package):
        if kind in NUMBERS:
            return self.number(NUMBERS[kind])
        return self.string() if kind == "string" else self.struct(kind, package)

    def struct(self, kind, package):
        kind, fields = self.fields(kind, package)
        package = kind.split("/", maxsplit=1)[0]
        out = {}
        for field, array, name in fields:
            if array is None:
                out[name] = self.value(field, package)
                continue
            count = self.number("I") if array == "" else array
            if count > len(self.data):
                raise BagError(f"{self.name}: a message ends early")
            out[name] = [self.value(field, package) for _ in range(count)]
        if not fields:
            self.number("B")  # CDR has no empty structures
        return out


# --- Bags: the messages of the topics that are asked for.

def files_of(paths):
    for path in map(pathlib.Path, paths):
        yield from sorted(path.glob("*.mcap")) if path.is_dir() else [path]


def topics_of(files):
    """Topic -> type. Tells which files were cut off."""
    topics = {}
    for path in files:
        schemas = {}
        for code, content in bag_records(path, print):
            record = Bytes(content)
            if code == SCHEMA:
                number = record.number("H")
                schemas[number] = record.text()
            elif code == CHANNEL:
                record.take(2)
                schema = record.number("H")
                topics[record.text()] = schemas.get(schema, "")
    return topics


def bag_records(path, tell=lambda text: None):
    """The records of a bag; what is wrong names it."""
    try:
        with open(path, "rb") as file:
            if file.read(len(MAGIC)) != MAGIC:
                raise BagError("is not an MCAP file; `ros2 bag convert` makes one of other bags")
            if not (yield from records_of(file)):
                tell(f"{path}: ends early; what came before is used")
    except OSError as error:
        raise BagError(f"{path}: {error.strerror}") from None
    except BagError as error:
        raise BagError(f"{path}: {error}") from None


def messages_of(files, topic):
    """The messages of a topic, in the order of the files."""
    for path in files:
        schemas, channels = {}, {}
        for code, content in bag_records(path):
            record = Bytes(content)
            if code == SCHEMA:
                number, name, encoding = record.number("H"), record.text(), record.text()
                schemas[number] = (name, encoding, bytes(record.take(record.number("I"))).decode("utf-8", "replace"))
            elif code == CHANNEL:
                number, schema, name, encoding = record.number("H"), record.number("H"), record.text(), record.text()
                if name != topic:
                    continue
                if encoding != "cdr" or schema not in schemas:
                    raise BagError(f"{path}: {topic} is encoded as '{encoding}', where cdr with a definition is read")
                channels[number] = Decoder(*schemas[schema])
            elif code == MESSAGE:
                number = record.number("H")
                if number in channels:
                    record.take(20)
                    yield channels[number].decode(record.data[record.at:])


def chosen_topic(topics, kind, given):
    """The topic that is given, or the only one of its kind."""
    of_kind = [topic for topic, name in topics.items() if Decoder.short(name) == Decoder.short(kind)]
    if given in of_kind or (given is None and len(of_kind) == 1):
        return given or of_kind[0]
    listed = ", ".join(f"{topic} ({name})" for topic, name in sorted(topics.items())) or "none"
    wanted = f"{given} is no topic of {kind}" if given else f"{len(of_kind)} topics are {kind}: name one"
    raise BagError(f"{wanted}; the bag has {listed}")


# --- Tables.

def time_of(header):
    return header["stamp"]["sec"] + 1e-9 * header["stamp"]["nanosec"]


def angles_of(q):
    """Yaw, pitch and roll of a quaternion [rad]."""
    x, y, z, w = q["x"], q["y"], q["z"], q["w"]
    pitch = math.asin(max(-1.0, min(1.0, 2 * (w * y - z * x))))
    return (math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)), pitch,
            math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y)))


def odometry_rows(messages, plane):
    """Rows of a table whose times rise; how many did not."""
    rows, dropped = [], 0
    for message in messages:
        time, pose = time_of(message["header"]), message["pose"]["pose"]
        p, (yaw, pitch, roll) = pose["position"], angles_of(pose["orientation"])
        if rows and time <= rows[-1][0]:
            dropped += 1
        else:
            rows.append([time, p["x"], p["y"], yaw] if plane else [time, p["x"], p["y"], p["z"], yaw, pitch, roll])
    return rows, dropped


def best_class(results):
    """Name and score of the most probable class; ("", "") without any."""
    scored = [(r.get("hypothesis", r), r) for r in results]
    if not scored:
        return "", ""
    best = max((h for h, _ in scored), key=lambda h: h["score"])
    return str(best.get("class_id", best.get("id", ""))), best["score"]


def measured_of(p, plane, optical):
    """Range and yaw, in space also pitch, of a point in the frame of the sensor."""
    x, y, z = (p["z"], -p["x"], -p["y"]) if optical else (p["x"], p["y"], p["z"])
    flat = math.hypot(x, y)
    return [flat, math.atan2(y, x)] if plane else [math.hypot(flat, z), math.atan2(y, x), -math.atan2(z, flat)]


def tag_rows(messages, camera, plane):
    """Rows of the transforms from the optical frame of a camera to frames whose names end in the number of a tag."""
    rows, parents = [], set()
    for message in messages:
        for transform in message["transforms"]:
            number = re.search(r"[0-9]+$", transform["child_frame_id"])
            if number is None:
                continue
            parents.add(transform["header"]["frame_id"])
            if transform["header"]["frame_id"] == camera:
                measured = measured_of(transform["transform"]["translation"], plane, True)
                rows.append([time_of(transform["header"]), *measured, "", "", int(number.group())])
    if not rows:
        known = ", ".join(sorted(parents)) or "none"
        raise BagError(f"no transform leads from {camera} to a tag; frames that lead to numbered ones: {known}")
    return sorted(rows, key=lambda row: row[0])


def detection_rows(messages, plane, optical):
    rows, numbers = [], {}
    for message in messages:
        for detection in message["detections"]:
            p = detection["bbox"]["center"]["position"]
            name = detection.get("id", detection.get("tracking_id", ""))
            number = "" if name == "" else int(name) if name.isdigit() else numbers.setdefault(name, len(numbers))
            measured = measured_of(p, plane, optical)
            rows.append([time_of(message["header"]), *measured, *best_class(detection["results"]), number])
    if numbers and any(isinstance(row[-1], int) and row[-1] not in numbers.values() for row in rows):
        raise BagError("some ids of detections are numbers and some are names")
    return sorted(rows, key=lambda row: row[0])


def write_table(path, names, rows):
    """Without columns that are empty throughout."""
    used = [i for i in range(len(names)) if i < 3 or any(row[i] != "" for row in rows)]
    with open(path, "w", encoding="utf-8", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow([names[i] for i in used])
        table.writerows([[row[i] for i in used] for row in rows])
    print(f"wrote {path}: {len(rows)} rows")


def convert(options):
    files = list(files_of(options.bag))
    if not files:
        raise BagError("no MCAP file is there")
    topics = topics_of(files)
    odometry = chosen_topic(topics, ODOMETRY, options.odometry)
    kind = TRANSFORMS if options.tags else DETECTIONS
    detections = chosen_topic(topics, kind, options.detections or ("/tf" if options.tags else None))
    rows, dropped = odometry_rows(messages_of(files, odometry), options.plane)
    if dropped:
        print(f"odometry dropped: its time does not rise: {dropped}")
    out = pathlib.Path(options.output)
    out.mkdir(parents=True, exist_ok=True)
    pose = ["time", "x", "y", "yaw"] if options.plane else ["time", "x", "y", "z", "yaw", "pitch", "roll"]
    write_table(out / "odometry.csv", pose, rows)
    measured = ["time", "range", "yaw"] if options.plane else ["time", "range", "yaw", "pitch"]
    seen = messages_of(files, detections)
    write_table(out / "detections.csv", [*measured, "class", "score", "id"],
                tag_rows(seen, options.tags, options.plane) if options.tags else
                detection_rows(seen, options.plane, options.optical))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bag", nargs="+", help="F.mcap, or the folder of a bag")
    parser.add_argument("--odometry", metavar="TOPIC", help="of nav_msgs/Odometry; may be left out where there is one")
    parser.add_argument("--detections", metavar="TOPIC", help="of vision_msgs/Detection3DArray; likewise")
    parser.add_argument("--tags", metavar="FRAME",
                        help="detections are the transforms (of /tf, or --detections) from this optical frame of a camera to "
                             "frames whose names end in the number of a tag, as tag36h11:7")
    parser.add_argument("--plane", action="store_true", help="leave z, pitch and roll out")
    parser.add_argument("--optical", action="store_true",
                        help="detections are in the optical frame of a camera: z ahead, x to the right, y down")
    parser.add_argument("-o", "--output", default=".", metavar="FOLDER", help="for odometry.csv and detections.csv")
    try:
        convert(parser.parse_args())
    except BagError as error:
        sys.exit(f"mcap_to_csv: {error}")


if __name__ == "__main__":
    main()
