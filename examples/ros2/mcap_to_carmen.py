#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Makes a CARMEN log, which `hybrid-import carmen` reads, of the laser scans and the odometry of a ROS 2 bag in MCAP.

Scans are a topic of sensor_msgs/LaserScan. Odometry is interpolated to their times; a bag without any gives scans alone,
which hybrid-replay maps as well. --base tells the frame of the robot, so that /tf and /tf_static say where the laser is on
it; without it the laser is taken to be in the middle of the robot.
"""

import bisect
import collections
import math
import pathlib
import sys
import tempfile

from bag_results import staged, told
from bag_words import BagError, say
from mcap_bag import Decoder, chosen_topic, files_of, messages_of, topics_of
from mcap_to_csv import POSES, odometry_of, parser_of, sensor_pose, tell_dropped, time_of
from rotations import angles_of, product

SCAN = "sensor_msgs/msg/LaserScan"
LEVEL = math.radians(5)  # a laser that is tilted more does not see the plane
LARGEST = 1e6  # a laser that reaches farther [m] is said to have no limit
WIDEST = 4 * math.pi  # angles beyond [rad] are none
LONG = 10  # times as far apart as usual, poses are missing; what is usual is known after as many
OUTSIDE, MISSING = "no odometry before or after them", "odometry is missing there for over ten times its usual period"


def planar(pose):
    return pose[0][0], pose[0][1], angles_of(pose[1])[0]


def wrapped(angle):
    return math.atan2(math.sin(angle), math.cos(angle))


def motion_between(first, second):
    """Way and turn between two poses."""
    (p, (x, y, z, w)), (t, r) = first, second
    *axis, half = product((-x, -y, -z, w), r)
    return math.dist(p, t), 2 * math.atan2(math.hypot(*axis), abs(half))


def gaps_in(times, poses):
    """Before which poses others are missing while the robot moved, as hybrid-replay tells it (odometry_gap.h)."""
    gaps, count, sums = set(), 0, [0.0] * 4
    for k in range(1, len(times)):
        time, (way, turn) = times[k] - times[k - 1], motion_between(poses[k - 1], poses[k])
        usual = LONG * sums[1] / sums[0] if count >= LONG else math.inf
        if time > usual and (way * sums[0] > usual * sums[2] or turn * sums[0] > usual * sums[3]):
            gaps.add(k)
        else:
            count, sums = count + 1, [a + b for a, b in zip(sums, (time, time * time, way, turn))]
    return gaps


class Odometry:
    """Poses of the robot at times that rise."""

    def __init__(self, timed_poses):
        self.times, self.poses = zip(*timed_poses)
        self.gaps = gaps_in(self.times, self.poses)

    def around(self, time):
        """The poses before and after a time and which share of the time between them has passed, or None; and why there
        are none."""
        if not self.times[0] <= time <= self.times[-1]:
            return None, OUTSIDE
        k = bisect.bisect_left(self.times, time)
        if self.times[k] == time:
            return (self.poses[k], self.poses[k], 0.0), None
        if k in self.gaps:
            return None, MISSING
        share = (time - self.times[k - 1]) / (self.times[k] - self.times[k - 1])
        return (self.poses[k - 1], self.poses[k], share), None


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


def fault_of(scan):
    """Why there is no line of a scan."""
    rays, first, step = len(scan["ranges"]), scan["angle_min"], scan["angle_increment"]
    if rays == 0:
        return "they have no rays"
    if not (abs(first) <= WIDEST and abs(step) * (rays - 1) <= WIDEST and math.isfinite(scan["range_min"])):
        return "their angles or their least range are no numbers, or absurd"
    return None


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
    """The odometry; None of a bag without any."""
    return Odometry(odometry_of(files, topics, options)) if has_odometry(topics, options) else None


def no_odometry(topic, what, first, last, times):
    """Of which times scans or clouds, and odometry are."""
    return (f"{topic} has no {what} with odometry around it: {what}s are of {first:.3f} to {last:.3f} s, odometry of "
            f"{times[0]:.3f} to {times[-1]:.3f} s; both need one clock")


def lines_of(scans, lines, odometry, mount_in):
    """Adds the lines of scans. Returns where the laser is, times of scans outside the odometry, and how many are left
    out, by reason."""
    mount, outside, dropped = None, [], collections.Counter()
    for scan in scans:
        mount, time = mount or mount_in(scan["header"]["frame_id"]), time_of(scan["header"])
        found, reason = odometry.around(time) if odometry else (None, None)
        reason = reason or fault_of(scan)
        if reason:
            dropped[reason] += 1
            outside += [time] if reason == OUTSIDE else []
        else:
            lines.add(time, line_of(scan, interpolated(*found) if found else None, *mount))
    return mount, outside, dropped


def convert(options):
    files, path = files_of(options.bag), pathlib.Path(options.output)
    place = staged(options.output, path.parent, "replaced", [path.name], files)
    with tempfile.TemporaryFile() as unsorted, place as part:
        topics = topics_of(files)
        topic = chosen_topic(topics, (SCAN,), options.scans)
        odometry, lines = timed_odometry(files, topics, options), SortedLines(unsorted)
        mount, outside, dropped = lines_of(messages_of(files, topic), lines, odometry,
                                           lambda frame: mount_of(files, topics, options.base, frame, topic))
        if not lines.places:
            raise BagError(no_odometry(topic, "scan", min(outside), max(outside), odometry.times) if outside else
                           f"{topic} has no scan that serves: {next(iter(dropped))}" if dropped else
                           f"{topic} has no message")
        with open(part / path.name, "w", encoding="utf-8") as log:
            if not odometry and mount[0][0] != 0:
                log.write(f"PARAM robot_frontlaser_offset {mount[0][0]:.9g}\n")
            lines.write(log)
    for reason, count in dropped.items():
        tell_dropped(count, f"scans dropped: {reason}")
    if not odometry:
        beside = any(abs(x) > 1e-3 for x in mount[0][1:])
        say("the bag has no odometry: scans alone" + (", and the path will be that of the laser" if beside else ""))
    say(f"wrote {options.output}: {len(lines.places)} scans")


def main():
    parser = parser_of(__doc__, "tells where the laser is on it")
    parser.add_argument("--scans", metavar="TOPIC", help="of sensor_msgs/LaserScan; may be left out where there is one")
    parser.add_argument("-o", "--output", required=True, metavar="F.clf")
    options = parser.parse_args()
    sys.exit(told("mcap_to_carmen", convert, options))


if __name__ == "__main__":
    main()
