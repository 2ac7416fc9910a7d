#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Makes a folder of clouds, which `hybrid-import clouds` reads, of the clouds and the odometry of a ROS 2 bag in MCAP.

Clouds are a topic of sensor_msgs/PointCloud2. Each becomes a PCD file whose name is its time. Odometry is interpolated to these
times: odometry.txt has a pose for each cloud. A bag without odometry gives clouds alone, which hybrid-replay maps as well.
--base tells the frame of the robot, so that /tf and /tf_static say where the sensor is on it; without it the poses are taken
to be those of the sensor.

It needs python3-numpy.
"""

import math
import pathlib
import sys

from bag_results import staged, told
from bag_words import BagError, say
from mcap_bag import chosen_topic, files_of, messages_of, named, topics_of
from mcap_to_carmen import OUTSIDE, no_odometry, timed_odometry
from mcap_to_csv import FARTHEST, frame_of, parser_of, sensor_pose_option, tell_dropped

try:
    import numpy as np
except ImportError:
    sys.exit("mcap_to_clouds: this needs numpy: install python3-numpy")

CLOUD = "sensor_msgs/msg/PointCloud2"
NUMBERS = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 8: "f8"}  # datatypes of sensor_msgs/PointField
TIMES = ("t", "time", "timestamp", "offset_time")  # names of the field with the time of a point
LARGEST_TIME = 1e10  # numbers above are no seconds: milliseconds, and so on


# --- Points of a message.

def layout_of(message):
    """How a point is stored: x, y and z, and intensity and t where there are."""
    fields = {}
    for field in message["fields"]:
        fields.setdefault(field["name"], field)
    wanted = {name: fields.get(name) for name in ("x", "y", "z", "intensity")}
    wanted["t"] = next((fields[name] for name in TIMES if name in fields), None)
    layout = {"names": [], "formats": [], "offsets": [], "itemsize": message["point_step"]}
    for name, field in wanted.items():
        kind = NUMBERS.get(field["datatype"], "") if field else ""
        if name in "xyz" and kind not in ("f4", "f8"):
            raise BagError(f"{name} is no float32 or float64" if field else f"there is no field {name}")
        if not kind:
            continue
        if field["offset"] + int(kind[1]) > message["point_step"]:
            raise BagError(f"{name} ends behind point_step")
        layout["names"].append(name)
        layout["formats"].append((">" if message["is_bigendian"] else "<") + kind)
        layout["offsets"].append(field["offset"])
    if sum(int(kind[-1]) for kind in layout["formats"]) > message["point_step"]:
        raise BagError("fields overlap")
    return np.dtype(layout)


def points_in(message):
    """The points as they are stored, in an array."""
    height, width, step, data = (message[name] for name in ("height", "width", "point_step", "data"))
    if height == 0 or width == 0:
        return np.empty(0, [(name, "f4") for name in "xyz"])
    row = message["row_step"] if height > 1 else width * step
    if row < width * step:
        raise BagError("row_step is less than width times point_step")
    if (height - 1) * row + width * step > len(data):
        raise BagError("data is shorter than width, height and steps say")
    return np.ndarray((height, width), layout_of(message), data, strides=(row, step)).ravel()


def relative(times, stamp):
    """Seconds since the stamp: whole numbers are nanoseconds since then, doubles may be absolute."""
    if times.dtype.kind != "f":
        return 1e-9 * times
    seconds = times.astype("f8", copy=False)
    finite = seconds[np.isfinite(seconds)] if times.itemsize == 8 else []
    middle = float(np.median(finite, overwrite_input=True)) if len(finite) else 0.0
    del finite
    while middle >= LARGEST_TIME:
        seconds, middle = seconds / 1000, middle / 1000
    return seconds - stamp if abs(middle - stamp) < abs(middle) else seconds


def cloud_of(message, stamp, optical):
    """The points that have a place, as x, y, z, and intensity and t where there are; and how many have none."""
    found = points_in(message)
    x, y, z = (found[name] for name in "xyz")
    columns = dict(zip("xyz", (z, -x, -y) if optical else (x, y, z)))
    columns.update((name, found[name]) for name in ("intensity", "t") if name in found.dtype.names)
    have_place = np.logical_and.reduce([np.abs(columns[name]) <= FARTHEST for name in "xyz"])
    cloud = np.empty(np.count_nonzero(have_place), [
        (name, "<f8" if name in "xyz" and values.itemsize == 8 else "<f4") for name, values in columns.items()])
    for name, values in columns.items():
        cloud[name] = relative(values[have_place], stamp) if name == "t" else values[have_place]
    return cloud, len(found) - len(cloud)


def write_pcd(cloud, path):
    names = cloud.dtype.names
    sizes = " ".join(str(cloud.dtype[name].itemsize) for name in names)
    head = (f"# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS {' '.join(names)}\nSIZE {sizes}\n"
            f"TYPE{' F' * len(names)}\nCOUNT{' 1' * len(names)}\nWIDTH {len(cloud)}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\n"
            f"POINTS {len(cloud)}\nDATA binary\n")
    with open(path, "wb") as file:
        file.write(head.encode())
        file.write(cloud)


# --- Poses.

def between(first, second, share):
    """The pose between two, turning evenly from one to the other."""
    (p, q), (u, v) = first, second
    q, v = ([c / math.hypot(*r) for c in r] for r in (q, v))
    dot = sum(a * b for a, b in zip(q, v))
    angle = math.acos(min(1.0, abs(dot)))
    one, other = 1 - share, share
    if angle > 1e-6:
        one, other = math.sin(one * angle) / math.sin(angle), math.sin(other * angle) / math.sin(angle)
    rotation = [one * a + math.copysign(other, dot) * b for a, b in zip(q, v)]
    return [a + share * (b - a) for a, b in zip(p, u)], [c / math.hypot(*rotation) for c in rotation]


# --- What is written.

class Clouds:
    """Writes clouds to a folder, and counts what is left out."""

    def __init__(self, folder, topic, odometry, optical):
        self.folder, self.topic, self.odometry, self.optical = folder, topic, odometry, optical
        self.messages, self.count, self.points, self.no_place, self.empty = 0, 0, 0, 0, 0
        self.frame, self.rows, self.outside = None, [], []
        self.dropped = {}  # reason -> the number of its first message, and how many

    def drop(self, reason):
        """Counts a message that is no cloud."""
        self.messages += 1
        self.dropped.setdefault(reason, [self.messages, 0])[1] += 1

    def add(self, message):
        try:
            with named(self.topic), np.errstate(all="ignore"):
                reason = self.write(message)
        except BagError as error:
            reason = str(error)
        if reason:
            self.drop(reason)
        else:
            self.messages += 1

    def write(self, message):
        """Why there is no file of a message; None where there is one."""
        stamp, frame = message["header"]["stamp"], frame_of(message["header"]["frame_id"])
        if stamp["sec"] < 0 or stamp["nanosec"] >= 10**9:
            return "the stamp is no time"
        if self.frame not in (None, frame):
            return f"the frame is not that of the first cloud, {self.frame}"
        name, time = f"{stamp['sec']}.{stamp['nanosec']:09d}", stamp["sec"] + 1e-9 * stamp["nanosec"]
        path = self.folder / f"{name}.pcd"
        if path.exists():
            return "the stamp was there before"
        found, why_not = self.odometry.around(time) if self.odometry else (None, None)
        if why_not:
            self.outside += [time] if why_not == OUTSIDE else []
            return why_not
        cloud, no_place = cloud_of(message, time, self.optical)
        write_pcd(cloud, path)
        self.frame = frame
        self.count, self.points, self.no_place = self.count + 1, self.points + len(cloud), self.no_place + no_place
        self.empty += len(cloud) == 0
        if found:
            position, rotation = between(*found)
            self.rows.append((time, " ".join([name, *map(repr, position), *map(repr, rotation)]) + "\n"))
        return None

    def write_poses(self):
        """Writes those that clouds have, in the order of their times."""
        if self.count == 0 and self.outside:
            raise BagError(no_odometry(self.topic, "cloud", min(self.outside), max(self.outside), self.odometry.times))
        if self.count == 0:
            raise BagError(f"no cloud of {self.topic} can be read; the first: {next(iter(self.dropped))}" if self.dropped else
                           f"{self.topic} has no message")
        if self.odometry:
            (self.folder / "odometry.txt").write_text("".join(row for _, row in sorted(self.rows)), encoding="utf-8")

    def tell(self, output):
        for reason, (first, count) in self.dropped.items():
            tell_dropped(count, f"clouds dropped, the first is message {first}: {reason}")
        tell_dropped(self.no_place, "points dropped: their places are not finite")
        tell_dropped(self.empty, "clouds kept without points")
        if not self.odometry:
            say("the bag has no odometry: clouds alone")
        poses = " and odometry.txt" if self.odometry else ""
        say(f"wrote {output}: {self.count} clouds with {self.points} points{poses}")


def counted(messages):
    """The same, with their number on a terminal."""
    is_shown = sys.stderr.isatty()
    try:
        for number, message in enumerate(messages, 1):
            if is_shown:
                print(f"\rcloud {number}", end="", file=sys.stderr, flush=True)
            yield message
    finally:
        if is_shown:
            print("\r\x1b[K", end="", file=sys.stderr)


def convert(options):
    files = files_of(options.bag)
    with staged(options.output, pathlib.Path(options.output), "refused") as folder:
        topics = topics_of(files)
        topic = chosen_topic(topics, (CLOUD,), options.topic)
        clouds, place = Clouds(folder, topic, timed_odometry(files, topics, options), options.optical), None
        for message in counted(messages_of(files, topic, clouds.drop)):
            clouds.add(message)
            if options.base and clouds.frame is not None and place is None:
                place = sensor_pose_option(files, topics, options.base, clouds.frame, options.optical, topic)
        clouds.write_poses()
    clouds.tell(options.output)
    if place:
        say(place)
    elif clouds.odometry:
        say(f"poses are taken to be those of {clouds.frame}: --base tells where it is on the robot")


def main():
    parser = parser_of(__doc__, "prints where the sensor is on it")
    parser.add_argument("--topic", metavar="TOPIC", help="of sensor_msgs/PointCloud2; may be left out where there is one")
    parser.add_argument("--optical", action="store_true",
                        help="clouds are in the optical frame of a camera: z ahead, x to the right, y down")
    parser.add_argument("-o", "--output", required=True, metavar="FOLDER", help="for the clouds; empty or new")
    sys.exit(told("mcap_to_clouds", convert, parser.parse_args()))


if __name__ == "__main__":
    main()
