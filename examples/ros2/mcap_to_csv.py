#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Makes the tables that `hybrid-import csv` reads of a ROS 2 bag in MCAP.

Odometry is a topic of nav_msgs/Odometry, geometry_msgs/PoseStamped or PoseWithCovarianceStamped, or a transform of /tf.
Detections are vision_msgs/Detection3DArray, apriltag_msgs/AprilTagDetectionArray, or the transforms from a camera to
tags that apriltag_ros publishes. What is true, for comparison, is a topic of poses or of sensor_msgs/NavSatFix.

It needs no ROS (see mcap_bag.py). docs/importing.md and docs/april_tags.md have examples.
"""

import argparse
import csv
import io
import math
import pathlib
import re
import sys

from bag_results import staged, told
from bag_words import BagError, say
from mcap_bag import Decoder, chosen_topic, files_of, messages_of, topics_of
from rotations import angles_of, composed, quaternion_of

POSES = ("nav_msgs/msg/Odometry", "geometry_msgs/msg/PoseStamped", "geometry_msgs/msg/PoseWithCovarianceStamped")
DETECTIONS, TAGS = "vision_msgs/msg/Detection3DArray", "apriltag_msgs/msg/AprilTagDetectionArray"
TRANSFORMS, CAMERA, FIX = "tf2_msgs/msg/TFMessage", "sensor_msgs/msg/CameraInfo", "sensor_msgs/msg/NavSatFix"
OPTICAL = (0.5, -0.5, 0.5, 0.5)  # the orientation, in an optical frame, of one with x ahead and z up
FARTHEST, LARGEST_ID, SIGMAS = 1e15, 2**31 - 1, (1e-9, 1e6)  # limits of hybrid-import: coordinates [m], ids, sigmas [m]
HIGHEST = 1e6  # [m] above the sea, or below
DROPPED = "dropped: its time was there before, a number is not finite or too large, or its rotation is 0"
EARTH_RADIUS, EARTH_ECCENTRICITY2 = 6378137.0, 6.69437999014e-3  # WGS 84 [m]


def time_of(header):
    return header["stamp"]["sec"] + 1e-9 * header["stamp"]["nanosec"]


# --- Rows of the tables.

def pose_of(message):
    """Position and rotation in a message of one of POSES."""
    pose = message["pose"].get("pose", message["pose"])
    p = pose["position"]
    return (p["x"], p["y"], p["z"]), quaternion_of(pose["orientation"])


def transform_of(transform):
    p = transform["transform"]["translation"]
    return (p["x"], p["y"], p["z"]), quaternion_of(transform["transform"]["rotation"])


def transforms_of(files, topics, *names, beside=None):
    """(time, parent, child, pose) of all transforms on the topics of these names, /tf also in namespaces. Of several
    namespaces, that of the topic `beside`, as /robot1/tf of /robot1/scan, and the global one."""
    found = [topic for topic, kind in topics.items() if Decoder.short(kind) == Decoder.short(TRANSFORMS)
             and any(topic == name or name in ("/tf", "/tf_static") and topic.endswith(name) for name in names)]
    near = [topic for topic in found if beside and beside.startswith(topic.rsplit("/", 1)[0] + "/")]
    for name in near or found:
        for message in messages_of(files, name):
            for transform in message["transforms"]:
                header = transform["header"]
                yield time_of(header), frame_of(header["frame_id"]), frame_of(transform["child_frame_id"]), transform_of(transform)


def frame_of(name):
    """The name of a frame, which ROS 1 began with a slash."""
    return name.lstrip("/")


def is_sound(pose):
    return all(abs(x) <= FARTHEST for part in pose for x in part) and any(pose[1])


def rising(timed_poses):
    """Poses in the order of their times, each time once, and how many are left out."""
    kept, dropped = [], 0
    for time, pose in sorted(timed_poses, key=lambda timed: timed[0]):
        if kept and time == kept[-1][0] or not is_sound(pose):
            dropped += 1
        else:
            kept.append((time, pose))
    return kept, dropped


def odometry_row(time, pose, plane):
    (x, y, z), (yaw, pitch, roll) = pose[0], angles_of(pose[1])
    return [time, x, y, yaw] if plane else [time, x, y, z, yaw, pitch, roll]


def best_class(results):
    """Name and score of the most probable class; ("", "") without any."""
    scored = [(r.get("hypothesis", r), r) for r in results]
    if not scored:
        return "", ""
    best = max((h for h, _ in scored), key=lambda h: h["score"])
    return str(best.get("class_id", best.get("id", ""))), best["score"]


def measured_of(p, plane, optical):
    """Range and yaw, in space also pitch, of a point in the frame of the sensor."""
    x, y, z = (p[2], -p[0], -p[1]) if optical else p
    flat = math.hypot(x, y)
    return [flat, math.atan2(y, x)] if plane else [math.hypot(flat, z), math.atan2(y, x), -math.atan2(z, flat)]


def transform_rows(transforms, camera, plane):
    """Rows of the transforms from the optical frame of a camera to frames whose names end in the number of a tag."""
    rows, parents = [], set()
    for time, parent, child, pose in transforms:
        number = re.search(r"[0-9]+$", child)
        if number is None:
            continue
        parents.add(parent)
        if parent == camera:
            rows.append([time, *measured_of(pose[0], plane, True), "", "", int(number.group())])
    if not rows:
        known = ", ".join(sorted(parents)) or "none"
        raise BagError(f"no transform leads from {camera} to a tag; frames that lead to numbered ones: {known}")
    return sorted(rows, key=lambda row: row[0])


def intrinsics_of(message):
    """fx, fy, cx, cy [pixel] of the rectified image, in which tags are detected."""
    p, k = message["p"], message["k"]
    found = (p[0], p[5], p[2], p[6]) if p[0] > 0 else (k[0], k[4], k[2], k[5])
    if not (found[0] > 0 and found[1] > 0):
        raise BagError("the camera is not calibrated: its focal length is 0")
    return found


def tag_position(h, intrinsics, size):
    """The middle of a tag of this edge [m] in the optical frame of the camera.

    The homography h (9 numbers, row by row) takes the corners (+-1, +-1) of the tag to pixels: its columns are those of
    K (r1, r2, t) up to scale, where r1 and r2 have length 1 and t is in halves of an edge.
    """
    fx, fy, cx, cy = intrinsics
    columns = [((h[i] - cx * h[6 + i]) / fx, (h[3 + i] - cy * h[6 + i]) / fy, h[6 + i]) for i in range(3)]
    lengths = [math.hypot(*column) for column in columns[:2]]
    if not all(math.isfinite(x) for column in columns for x in column) or min(lengths) <= 0:
        return None
    scale = size / (lengths[0] + lengths[1]) * (1 if columns[2][2] > 0 else -1)
    return tuple(scale * x for x in columns[2])


def tag_rows(messages, intrinsics, options):
    """Rows of apriltag_msgs, with the sigma of the range; how many have no position.

    A tag of an edge e [m] at z m is f e / z pixels wide: an error of s pixels changes the range by z^2 s / (f e).
    """
    rows, dropped = [], 0
    for message in messages:
        for tag in message["detections"]:
            position = tag_position(tag["homography"], intrinsics, options.tag_size)
            if position is None:
                dropped += 1
                continue
            sigma = position[2]**2 * options.pixel_sigma / (intrinsics[0] * options.tag_size)
            rows.append([time_of(message["header"]), *measured_of(position, options.plane, True), "", "", tag["id"], sigma])
    return sorted(rows, key=lambda row: row[0]), dropped


def detection_rows(messages, plane, optical):
    rows, numbers = [], {}
    for message in messages:
        for detection in message["detections"]:
            p = detection["bbox"]["center"]["position"]
            name = detection.get("id", detection.get("tracking_id", ""))
            is_number = re.fullmatch("[0-9]{1,99}", name)
            number = "" if name == "" else int(name) if is_number else numbers.setdefault(name, len(numbers))
            measured = measured_of((p["x"], p["y"], p["z"]), plane, optical)
            rows.append([time_of(message["header"]), *measured, *best_class(detection["results"]), number])
    if numbers and any(isinstance(row[-1], int) and row[-1] not in numbers.values() for row in rows):
        raise BagError("some ids of detections are numbers and some are names")
    return sorted(rows, key=lambda row: row[0])


def is_detection(row, angles):
    """Whether hybrid-import takes a row of a time, a range, so many angles, class, score, id and perhaps a sigma."""
    measured, (score, number, *sigma) = row[:2 + angles], row[3 + angles:]
    return (all(abs(x) <= FARTHEST for x in measured) and (score == "" or 0 <= score <= 1)
            and (number == "" or 0 <= number <= LARGEST_ID) and all(SIGMAS[0] <= x <= SIGMAS[1] for x in sigma))


def earth_fixed(latitude, longitude, altitude):
    """Position [m] in the frame of the Earth; degrees and metres in."""
    lat, lon = math.radians(latitude), math.radians(longitude)
    normal = EARTH_RADIUS / math.sqrt(1 - EARTH_ECCENTRICITY2 * math.sin(lat)**2)
    return ((normal + altitude) * math.cos(lat) * math.cos(lon), (normal + altitude) * math.cos(lat) * math.sin(lon),
            (normal * (1 - EARTH_ECCENTRICITY2) + altitude) * math.sin(lat))


def fix_rows(messages):
    """Rows of time and metres to the east, north and up of the first fix; how many were none; the first fix."""
    rows, dropped, origin = [], 0, None
    for message in messages:
        fix = [message[name] for name in ("latitude", "longitude", "altitude")]
        if message["status"]["status"] < 0 or not (abs(fix[0]) <= 90 and abs(fix[1]) <= 360) or abs(fix[2]) > HIGHEST:
            dropped += 1
            continue
        fix[2] = fix[2] if math.isfinite(fix[2]) else 0.0
        origin = origin or fix
        d = [a - b for a, b in zip(earth_fixed(*fix), earth_fixed(*origin))]
        lat, lon = math.radians(origin[0]), math.radians(origin[1])
        out = math.cos(lon) * d[0] + math.sin(lon) * d[1]
        rows.append([time_of(message["header"]), -math.sin(lon) * d[0] + math.cos(lon) * d[1],
                     math.cos(lat) * d[2] - math.sin(lat) * out, math.cos(lat) * out + math.sin(lat) * d[2]])
    return rows, dropped, origin


# --- What is written.

def table_of(names, rows):
    """The text of a table, without columns that are empty throughout, and the number of its rows."""
    names = names[:len(rows[0])]
    used = [i for i in range(len(names)) if i < 3 or any(row[i] != "" for row in rows)]
    file = io.StringIO()
    table = csv.writer(file, lineterminator="\n")
    table.writerow([names[i] for i in used])
    table.writerows([[row[i] for i in used] for row in rows])
    return file.getvalue(), len(rows)


def lines_of(rows):
    return "".join(" ".join(map(repr, row)) + "\n" for row in rows), len(rows)


def tell_dropped(count, reason):
    if count:
        say(f"{reason}: {count}")


def odometry_of(files, topics, options):
    """(time, pose) of the robot, times rising."""
    if options.odometry_tf:
        parent, child = map(frame_of, options.odometry_tf)
        found = ((time, pose) for time, a, b, pose in transforms_of(files, topics, "/tf") if (a, b) == (parent, child))
    else:
        topic = chosen_topic(topics, POSES, options.odometry)
        found = ((time_of(m["header"]), pose_of(m)) for m in messages_of(files, topic))
    poses, dropped = rising(found)
    if options.odometry_tf and not poses:
        raise BagError(f"/tf has no transform from {parent} to {child}")
    tell_dropped(dropped, f"odometry {DROPPED}")
    if not poses:
        raise BagError("the topic of the odometry has no " + ("pose that serves" if dropped else "message"))
    return poses


def odometry_table(files, topics, options):
    poses = odometry_of(files, topics, options)
    names = ["time", "x", "y", "yaw"] if options.plane else ["time", "x", "y", "z", "yaw", "pitch", "roll"]
    return table_of(names, [odometry_row(time, pose, options.plane) for time, pose in poses])


def detected(files, topics, options):
    """Rows of detections, whether their frame is an optical one, and its name."""
    if options.tags:
        found = transforms_of(files, topics, options.detections or "/tf")
        return transform_rows(found, frame_of(options.tags), options.plane), True, options.tags
    topic = chosen_topic(topics, (TAGS,) if options.tag_size else (DETECTIONS, TAGS), options.detections)
    frame = next((m["header"]["frame_id"] for m in messages_of(files, topic)), "")
    if Decoder.short(topics[topic]) != Decoder.short(TAGS):
        return detection_rows(messages_of(files, topic), options.plane, options.optical), options.optical, frame
    if not options.tag_size:
        raise BagError(f"{topic} tells where tags are in images: --tag-size is their edge in metres, "
                       "--tags FRAME takes the transforms of apriltag_ros instead")
    camera = chosen_topic(topics, (CAMERA,), options.camera)
    calibration = next(iter(messages_of(files, camera)), None)
    if calibration is None:
        raise BagError(f"{camera} has no message")
    rows, dropped = tag_rows(messages_of(files, topic), intrinsics_of(calibration), options)
    tell_dropped(dropped, "tags dropped: their homography tells no position")
    return rows, True, frame


def detections_of(files, topics, options):
    """The same, rows that hybrid-import takes alone."""
    found, optical, frame = detected(files, topics, options)
    rows = [row for row in found if is_detection(row, 1 if options.plane else 2)]
    tell_dropped(len(found) - len(rows),
                 "detections dropped: a number is not finite or too large, or a score not within 0 and 1")
    if not rows:
        raise BagError("no detection serves" if found else "there is no detection")
    return rows, optical, frame


def sensor_pose(files, topics, base, frame, optical, beside=None):
    """Where the sensor is on the robot: position and rotation. `beside` is the topic of what it saw."""
    base, frame = frame_of(base), frame_of(frame)
    parents = {child: (parent, pose)
               for _, parent, child, pose in transforms_of(files, topics, "/tf", "/tf_static", beside=beside)}
    at, pose = frame, ((0.0, 0.0, 0.0), OPTICAL if optical else (0.0, 0.0, 0.0, 1.0))
    for _ in range(len(parents) + 1):
        if at == base:
            break
        if at not in parents:
            raise BagError(f"no transforms lead from {base} to {frame}: they end at {at}")
        at, step = parents[at]
        pose = composed(step, pose)
    if not is_sound(pose):
        raise BagError(f"the transforms from {base} to {frame} are none: a number is not finite, or a rotation is 0")
    return pose


def sensor_pose_option(files, topics, base, frame, optical, beside):
    """The same as an option of hybrid-import."""
    position, rotation = sensor_pose(files, topics, base, frame, optical, beside)
    numbers = (*position, *angles_of(rotation))
    return "give hybrid-import: --sensor-pose " + " ".join(f"{x + 0.0:.6g}" for x in numbers)


def truth_of(files, topics, topic):
    """The name of the file of what is true, its text, and the number of its rows."""
    topic = chosen_topic(topics, (*POSES, FIX), topic)
    if Decoder.short(topics[topic]) != Decoder.short(FIX):
        poses, dropped = rising((time_of(m["header"]), pose_of(m)) for m in messages_of(files, topic))
        tell_dropped(dropped, f"truth {DROPPED}")
        found = "truth.tum", *lines_of([[time, *p, *q] for time, (p, q) in poses])
    else:
        rows, dropped, origin = fix_rows(messages_of(files, topic))
        tell_dropped(dropped, "satellite fixes dropped: they are none")
        if origin:
            say(f"east, north and up of latitude {origin[0]!r}, longitude {origin[1]!r}, altitude {origin[2]!r}")
        found = "truth.xyz", *lines_of(rows)
    if found[2] == 0:
        raise BagError(f"{topic} tells nothing that is true")
    return found


def convert(options):
    files, out = files_of(options.bag), pathlib.Path(options.output)
    names = ("odometry.csv", "detections.csv", "truth.tum", "truth.xyz")
    with staged(options.output, out, "kept", names, files) as part:
        topics = topics_of(files)
        rows, optical, frame = detections_of(files, topics, options)
        measured = ["time", "range", "yaw"] if options.plane else ["time", "range", "yaw", "pitch"]
        tables = [("odometry.csv", *odometry_table(files, topics, options)),
                  ("detections.csv", *table_of([*measured, "class", "score", "id", "sigma_range"], rows))]
        if options.truth:
            tables.append(truth_of(files, topics, options.truth))
        place = options.base and sensor_pose_option(files, topics, options.base, frame, optical, options.detections)
        for name, text, _ in tables:
            (part / name).write_text(text, encoding="utf-8")
    for name, _, count in tables:
        say(f"wrote {out / name}: {count} rows")
    if place:
        say(place)


def parser_of(doc, placed):
    """A parser with what every conversion asks for: bags, where the odometry is, and the robot that carries the sensor."""
    parser = argparse.ArgumentParser(description=doc, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bag", nargs="+", help="F.mcap, or the folder of a bag")
    parser.add_argument("--odometry", metavar="TOPIC", help="poses of the robot; may be left out where there is one")
    parser.add_argument("--odometry-tf", nargs=2, metavar=("PARENT", "CHILD"),
                        help="odometry is this transform of /tf, as odom base_link")
    parser.add_argument("--base", metavar="FRAME", help=f"the robot, as base_link: {placed}, by /tf and /tf_static")
    return parser


def main():
    parser = parser_of(__doc__, "prints where the sensor is on it")
    parser.add_argument("--detections", metavar="TOPIC", help="of vision_msgs or apriltag_msgs; likewise")
    parser.add_argument("--tags", metavar="FRAME",
                        help="detections are the transforms (of /tf, or --detections) from this optical frame of a camera to "
                             "frames whose names end in the number of a tag, as tag36h11:7")
    parser.add_argument("--tag-size", type=float, metavar="METRES",
                        help="detections are apriltag_msgs, of tags whose black edge is so long")
    parser.add_argument("--pixel-sigma", type=float, default=0.5, metavar="PIXELS",
                        help="error of the width of a tag in the image, of which the sigma of its range follows (default 0.5)")
    parser.add_argument("--camera", metavar="TOPIC", help="sensor_msgs/CameraInfo for --tag-size, where there are several")
    parser.add_argument("--truth", metavar="TOPIC",
                        help="poses or sensor_msgs/NavSatFix that are true: writes truth.tum or truth.xyz for hybrid-replay "
                             "--truth-path")
    parser.add_argument("--plane", action="store_true", help="leave z, pitch and roll out")
    parser.add_argument("--optical", action="store_true",
                        help="detections are in the optical frame of a camera: z ahead, x to the right, y down")
    parser.add_argument("-o", "--output", default=".", metavar="FOLDER", help="for odometry.csv and detections.csv")
    options = parser.parse_args()
    if options.tag_size is not None and not 0 < options.tag_size < 1000:
        parser.error("--tag-size is a length in metres")
    if not 0 < options.pixel_sigma < 1000:
        parser.error("--pixel-sigma is a number of pixels above 0")
    sys.exit(told("mcap_to_csv", convert, options))


if __name__ == "__main__":
    main()
