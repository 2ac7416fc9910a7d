#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Makes a CARMEN log, which `hybrid-import carmen` reads, of the laser scans and the odometry of a ROS 2 bag in MCAP.

Scans are a topic of sensor_msgs/LaserScan. Odometry is interpolated to their times. --base tells the frame of the robot,
so that /tf and /tf_static say where the laser is on it; without it the laser is taken to be in the middle of the robot.
"""

import bisect
import math
import sys

from mcap_bag import BagError, files_of, messages_of, topics_of
from mcap_to_csv import angles_of, chosen_topic, odometry_of, parser_of, sensor_pose, tell_dropped, time_of

SCAN = "sensor_msgs/msg/LaserScan"
LEVEL = math.radians(5)  # a laser that is tilted more does not see the plane


def planar(pose):
    return pose[0][0], pose[0][1], angles_of(pose[1])[0]


def wrapped(angle):
    return math.atan2(math.sin(angle), math.cos(angle))


def interpolated(times, poses, time):
    """x, y and yaw at a time; None before the first or after the last pose."""
    if not times or not times[0] <= time <= times[-1]:
        return None
    k = max(bisect.bisect_left(times, time), 1) if len(times) > 1 else 0
    if k == 0:
        return planar(poses[0])
    (x, y, yaw), (u, v, turned) = planar(poses[k - 1]), planar(poses[k])
    share = (time - times[k - 1]) / (times[k] - times[k - 1])
    return x + share * (u - x), y + share * (v - y), yaw + share * wrapped(turned - yaw)


def mount_of(files, topics, base, frame):
    """x, y and yaw of the laser on the robot, and whether it hangs upside down."""
    if base is None:
        return (0.0, 0.0, 0.0), False
    position, rotation = sensor_pose(files, topics, base, frame, False)
    yaw, pitch, roll = angles_of(rotation)
    hangs = abs(wrapped(roll - math.pi)) < LEVEL
    if abs(pitch) > LEVEL or (abs(roll) > LEVEL and not hangs):
        raise BagError(f"the laser {frame} is tilted: pitch {math.degrees(pitch):.0f}, roll {math.degrees(roll):.0f} degrees")
    return (position[0], position[1], yaw), hangs


def line_of(scan, robot, mount, hangs):
    """A line ROBOTLASER1. What sees nothing is as far as the laser reaches."""
    most = scan["range_max"]
    ranges = [r if math.isfinite(r) and scan["range_min"] <= r < most else most for r in scan["ranges"]]
    step, first = scan["angle_increment"], scan["angle_min"]
    if hangs != (step < 0):  # so that the rays turn to the left
        first += step * (len(ranges) - 1)
        ranges.reverse()
    if hangs:
        first = -first
    step = abs(step)
    x, y, yaw = robot
    laser = (x + math.cos(yaw) * mount[0] - math.sin(yaw) * mount[1], y + math.sin(yaw) * mount[0] + math.cos(yaw) * mount[1],
             wrapped(yaw + mount[2]))
    time = time_of(scan["header"])
    words = ["ROBOTLASER1", 0, first, step * (len(ranges) - 1), step, most, 0, 0, len(ranges), *(f"{r:.4f}" for r in ranges), 0,
             *laser, x, y, wrapped(yaw), 0, 0, 0, 0, 0, f"{time:.6f}", "ros", f"{time:.6f}"]
    return " ".join(f"{w:.9g}" if isinstance(w, float) else str(w) for w in words) + "\n"


def convert(options):
    files = list(files_of(options.bag))
    if not files:
        raise BagError("no MCAP file is there")
    topics = topics_of(files)
    topic = chosen_topic(topics, (SCAN,), options.scans)
    poses = odometry_of(files, topics, options)
    times, poses = [time for time, _ in poses], [pose for _, pose in poses]
    count, outside, mount = 0, 0, None
    with open(options.output, "w", encoding="ascii") as log:
        for scan in messages_of(files, topic):
            if mount is None:
                mount = mount_of(files, topics, options.base, scan["header"]["frame_id"])
            robot = interpolated(times, poses, time_of(scan["header"]))
            if robot is None:
                outside += 1
                continue
            log.write(line_of(scan, robot, *mount))
            count += 1
    tell_dropped(outside, "scans dropped: no odometry before or after them")
    if count == 0:
        raise BagError(f"{topic} has no scan with odometry around it")
    print(f"wrote {options.output}: {count} scans")


def main():
    parser = parser_of(__doc__, "tells where the laser is on it")
    parser.add_argument("--scans", metavar="TOPIC", help="of sensor_msgs/LaserScan; may be left out where there is one")
    parser.add_argument("-o", "--output", required=True, metavar="F.clf")
    options = parser.parse_args()
    try:
        convert(options)
    except BagError as error:
        sys.exit(f"mcap_to_carmen: {error}")


if __name__ == "__main__":
    main()
