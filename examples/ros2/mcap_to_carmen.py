#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Makes a CARMEN log, which `hybrid-import carmen` reads, of the laser scans and the odometry of a ROS 2 bag in MCAP.

Scans are a topic of sensor_msgs/LaserScan. Odometry is interpolated to their times; a bag without any gives scans alone,
which hybrid-replay maps as well. --base tells the frame of the robot, so that /tf and /tf_static say where the laser is on
it; without it the laser is taken to be in the middle of the robot.
"""

import bisect
import math
import sys
import tempfile

from mcap_bag import BagError, Decoder, chosen_topic, files_of, messages_of, told, topics_of, written
from mcap_to_csv import POSES, angles_of, odometry_of, parser_of, sensor_pose, tell_dropped, time_of

SCAN = "sensor_msgs/msg/LaserScan"
LEVEL = math.radians(5)  # a laser that is tilted more does not see the plane
LARGEST = 1e6  # a laser that reaches farther [m] is said to have no limit


def planar(pose):
    return pose[0][0], pose[0][1], angles_of(pose[1])[0]


def wrapped(angle):
    return math.atan2(math.sin(angle), math.cos(angle))


def around(times, poses, time):
    """The poses before and after a time, and which share of the time between them has passed; None before the first or after
    the last pose."""
    if not times[0] <= time <= times[-1]:
        return None
    k = bisect.bisect_left(times, time)
    if times[k] == time:
        return poses[k], poses[k], 0.0
    return poses[k - 1], poses[k], (time - times[k - 1]) / (times[k] - times[k - 1])


def interpolated(before, after, share):
    """x, y and yaw between two poses."""
    (x, y, yaw), (u, v, turned) = planar(before), planar(after)
    return x + share * (u - x), y + share * (v - y), yaw + share * wrapped(turned - yaw)


def mount_of(files, topics, base, frame, topic):
    """x, y and yaw of the laser on the robot, and whether it hangs upside down."""
    if base is None:
        return (0.0, 0.0, 0.0), False
    position, rotation = sensor_pose(files, topics, base, frame, False, topic)
    yaw, pitch, roll = angles_of(rotation)
    hangs = abs(wrapped(roll - math.pi)) < LEVEL
    if abs(pitch) > LEVEL or (abs(roll) > LEVEL and not hangs):
        raise BagError(f"the laser {frame} is tilted: pitch {math.degrees(pitch):.0f}, roll {math.degrees(roll):.0f} degrees")
    return (position[0], position[1], yaw), hangs


def line_of(scan, robot, mount, hangs):
    """A line ROBOTLASER1, or RAWLASER1 where the robot is None. What sees nothing is as far as the laser reaches, or 0 where
    that has no limit."""
    most = scan["range_max"] if 0 < scan["range_max"] < LARGEST else 0.0
    seen = [math.isfinite(r) and max(scan["range_min"], 0) <= r < (most or LARGEST) for r in scan["ranges"]]
    ranges = [r if is_seen else most for r, is_seen in zip(scan["ranges"], seen)]
    step, first = scan["angle_increment"], scan["angle_min"]
    if hangs != (step < 0):  # so that the rays turn to the left
        first += step * (len(ranges) - 1)
        ranges.reverse()
    if hangs:
        first = -first
    step = abs(step)
    poses = []
    if robot is not None:
        x, y, yaw = robot
        poses = [x + math.cos(yaw) * mount[0] - math.sin(yaw) * mount[1], y + math.sin(yaw) * mount[0] + math.cos(yaw) * mount[1],
                 wrapped(yaw + mount[2]), x, y, wrapped(yaw), 0, 0, 0, 0, 0]
    time = time_of(scan["header"])
    words = ["ROBOTLASER1" if poses else "RAWLASER1", 0, first, step * (len(ranges) - 1), step, most, 0, 0, len(ranges),
             *(f"{r:.4f}" for r in ranges), 0, *poses, f"{time:.6f}", "ros", f"{time:.6f}"]
    return " ".join(f"{w:.9g}" if isinstance(w, float) else str(w) for w in words) + "\n"


def is_whole(scan):
    return all(math.isfinite(scan[name]) for name in ("angle_min", "angle_increment", "range_min"))


class SortedLines:
    """Lines with a time each, written to a file in the order of their times."""

    def __init__(self, unsorted):
        self.unsorted, self.places = unsorted, []

    def add(self, time, line):
        self.places.append((time, self.unsorted.tell(), len(line)))
        self.unsorted.write(line.encode())

    def write(self, log):
        for _, at, size in sorted(self.places):
            self.unsorted.seek(at)
            log.write(self.unsorted.read(size).decode())


def has_odometry(topics, options):
    kinds = [Decoder.short(kind) for kind in POSES]
    return options.odometry or options.odometry_tf or any(Decoder.short(kind) in kinds for kind in topics.values())


def timed_odometry(files, topics, options):
    """Times and poses of the robot; None of a bag without odometry."""
    if not has_odometry(topics, options):
        return None
    found = odometry_of(files, topics, options)
    if not found:
        raise BagError("the topic of the odometry has no message")
    return [time for time, _ in found], [pose for _, pose in found]


def spans(topic, what, first, last, times):
    """Of which times scans or clouds, and odometry are."""
    return (f"{topic} has no {what} with odometry around it: {what}s are of {first:.3f} to {last:.3f} s, odometry of "
            f"{times[0]:.3f} to {times[-1]:.3f} s; both need one clock")


def convert(options):
    files = list(files_of(options.bag))
    if not files:
        raise BagError("no MCAP file is there")
    topics = topics_of(files)
    topic = chosen_topic(topics, (SCAN,), options.scans)
    odometry = timed_odometry(files, topics, options)
    count, outside, damaged, mount, first, last = 0, 0, 0, None, math.inf, -math.inf
    with tempfile.TemporaryFile() as unsorted, written(options.output) as log:
        lines = SortedLines(unsorted)
        for scan in messages_of(files, topic):
            if mount is None:
                mount = mount_of(files, topics, options.base, scan["header"]["frame_id"], topic)
            time = time_of(scan["header"])
            first, last = min(first, time), max(last, time)
            found = around(*odometry, time) if odometry else None
            if odometry and found is None:
                outside += 1
            elif not is_whole(scan):
                damaged += 1
            else:
                lines.add(time, line_of(scan, interpolated(*found) if found else None, *mount))
                count += 1
        if first > last:
            raise BagError(f"{topic} has no message")
        if count == 0:
            raise BagError(spans(topic, "scan", first, last, odometry[0]) if outside else
                           f"{topic} has no scan whose angles and least range are numbers")
        if not odometry and mount[0][0] != 0:
            log.write(f"PARAM robot_frontlaser_offset {mount[0][0]:.9g}\n")
        lines.write(log)
    tell_dropped(outside, "scans dropped: no odometry before or after them")
    tell_dropped(damaged, "scans dropped: their angles or their least range are no numbers")
    if not odometry:
        beside = any(abs(x) > 1e-3 for x in mount[0][1:])
        print("the bag has no odometry: scans alone" + (", and the path will be that of the laser" if beside else ""))
    print(f"wrote {options.output}: {count} scans")


def main():
    parser = parser_of(__doc__, "tells where the laser is on it")
    parser.add_argument("--scans", metavar="TOPIC", help="of sensor_msgs/LaserScan; may be left out where there is one")
    parser.add_argument("-o", "--output", required=True, metavar="F.clf")
    options = parser.parse_args()
    sys.exit(told("mcap_to_carmen", convert, options))


if __name__ == "__main__":
    main()
