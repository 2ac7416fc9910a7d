# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Undamaged inputs of laser scans, clouds, boxes in images and map files."""

import json
import math
import struct
import subprocess
import zlib

ODOMETRY = "time,x,y,yaw\n" + "".join(f"{i},{0.5 * i},0,0\n" for i in range(12))
CAMERA = ["--focal", "500", "--image-width", "640", "--image-height", "480", "--period", "1"]


def carmen():
    """A laser of 91 rays that moves along a room of 8 m by 4 m."""
    rows = ""
    for k in range(30):
        x, ranges = 1 + 0.2 * k, []
        for i in range(91):
            a = math.radians(2 * i - 90)
            sides = [(8 - x) / math.cos(a) if math.cos(a) > 1e-9 else 99,
                     2 / abs(math.sin(a)) if abs(math.sin(a)) > 1e-9 else 99]
            ranges.append(f"{min(sides):.2f}")
        rows += f"ODOM {x:.3f} 0 0 0.5 0 0 {k} host {k}\n"
        rows += f"FLASER 91 {' '.join(ranges)} {x:.3f} 0 0 {x:.3f} 0 0 {k} host {k}\n"
    return rows


def box(i):
    """Left, top, width and height of a thing that comes nearer."""
    return 300 + 5 * i, 200, 20 + 2 * i, 40 + 4 * i


def mot():
    return "".join("{},1,{},{},{},{},0.9\n".format(i, *box(i)) for i in range(1, 11))


def coco():
    return json.dumps([{"image_id": i, "category_id": 3, "bbox": list(box(i)), "score": 0.8} for i in range(10)]) + "\n"


def yolo():
    files = {"classes.txt": "car\ntree\n"}
    for i in range(10):
        left, top, width, height = box(i)
        files[f"image_{i}.txt"] = (f"{i % 2} {(left + width / 2) / 640:.6f} {(top + height / 2) / 480:.6f} "
                                   f"{width / 640:.6f} {height / 480:.6f} 0.9\n")
    return files


def fixes():
    return "time,x,y,z,sigma,quality\n" + "".join(f"{i}.5,{0.5 * i},0.2,1,{'0.02' if i % 2 else ''},4\n" for i in range(9))


def import_sets():
    """As those of material.py, with the forms of files beside them."""
    table = ["csv", "--odometry", "{odometry.csv}", "--detections"]
    odometry = {"odometry.csv": ODOMETRY}
    return {
        "carmen": (["carmen", "{a.clf}"], {"a.clf": carmen()}),
        "mot": ([*table, "{det.txt}", *CAMERA], {**odometry, "det.txt": mot()}),
        "coco": ([*table, "{a.json}", *CAMERA], {**odometry, "a.json": coco()}),
        "yolo": ([*table, "{dir}", *CAMERA], {**odometry, **yolo()}),
        "fixes": (["csv", "--odometry", "{odometry.csv}", "--fixes", "{fixes.csv}", "--datum", "-33.885", "151.19", "40"],
                  {**odometry, "fixes.csv": fixes()}),
    }


def corner(shift):
    """Points of a floor and two walls, with times."""
    points = []
    for i in range(9):
        for j in range(9):
            u, v = 0.25 * i, 0.25 * j
            points += [(2 - shift, u - 1, v - 1), (2 - u - shift, 1, v - 1), (2 - u - shift, v - 1, -1)]
    return [(*p, 0.001 * k) for k, p in enumerate(points)]


def kitti_cloud(points):
    return b"".join(struct.pack("<4f", *p) for p in points)


def timed_pcd(points, binary):
    count = len(points)
    head = (f"VERSION 0.7\nFIELDS x y z t\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1\nWIDTH {count}\nHEIGHT 1\n"
            f"POINTS {count}\nDATA {'binary' if binary else 'ascii'}\n").encode()
    return head + (kitti_cloud(points) if binary else "".join("%f %f %f %f\n" % p for p in points).encode())


def timed_ply(points):
    head = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(points)}\n"
    return head.encode() + b"property float x\nproperty float y\nproperty float z\nproperty float time\nend_header\n" + kitti_cloud(points)


def depth_png(shift):
    """A wall that leans, 24 rows of 32 pixels of 16 bits."""
    rows = b"".join(b"\0" + struct.pack(">32H", *(2000 - int(1000 * shift) + 20 * u + 30 * v for u in range(32))) for v in range(24))

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    head = struct.pack(">IIBBBBB", 32, 24, 16, 0, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")


def add_clouds(add):
    """Folders of three clouds of each form; the one in the middle is damaged."""
    kinds = {"bin": kitti_cloud, "pcd": lambda points: timed_pcd(points, True), "txt.pcd": lambda points: timed_pcd(points, False), "ply": timed_ply}
    sets = {name: [encoded(corner(0.1 * i)) for i in range(3)] for name, encoded in kinds.items()}
    sets["png"] = [depth_png(0.1 * i) for i in range(3)]
    for name, clouds in sets.items():
        end = name.split(".")[-1]
        files = {f"{i}.{end}": data for i, data in enumerate(clouds)}
        odometry = "".join(f"1 0 0 {0.1 * i:.1f} 0 1 0 0 0 0 1 0\n" for i in range(3))
        add(f"import clouds {name}", "hybrid-import",
            ["clouds", "{dir}", "--odometry", "{poses.txt}", *(["--focal", "30"] if end == "png" else []), "-o", "{out}.rawlog"],
            {**files, "poses.txt": odometry}, {f"1.{end}": "binary"}, "file")


def rooms(binaries, folder, config):
    """A log of scans of a corridor and one of its rooms."""
    log, scenario = folder / "rooms.rawlog", folder / "rooms.ini"
    text = (config / "simulate_rooms.ini").read_text()
    scenario.write_text(text.replace("laps = 2", "laps = 1").replace(
        "waypoints = 7 0  7 3.5  5.5 4.5  7 3.5  7 0  21 0  21 3.5  19.5 4.5  21 3.5  21 0  29 0  0 0",
        "waypoints = 7 0  7 3.5  5.5 4.5  7 3.5  7 0  1 0"))
    subprocess.run([binaries / "hybrid-simulate", "-c", scenario, "-o", log], check=True,
                   stdout=subprocess.DEVNULL)
    return log.read_bytes()


def map_of(binaries, folder, log, name):
    """A map file of a log."""
    (folder / f"{name}.rawlog").write_bytes(log)
    made = folder / f"{name}.hmap"
    subprocess.run([binaries / "hybrid-replay", folder / f"{name}.rawlog", "--no-pictures", "--map", made,
                    "-o", folder / f"{name}_out"], check=True, stdout=subprocess.DEVNULL)
    return made.read_bytes()


def add_inputs(add, binaries, folder, root):
    """Calls `add` of material.py for each input but those of hybrid-import that are tables."""
    add_clouds(add)
    scans = rooms(binaries, folder, root / "config")
    landmarks = (root / "rawlogs" / "classed_demo.rawlog").read_bytes()
    replay = ["{log.rawlog}", "--no-pictures", "-o", "{out}"]
    add("replay scans", "hybrid-replay", replay, {"log.rawlog": scans}, {"log.rawlog": "log"})
    for name, log in (("scans", scans), ("landmarks", landmarks)):
        made = map_of(binaries, folder, log, name)
        add(f"map {name} export", "hybrid-map", ["export", "{a.hmap}", "-o", "{out}"], {"a.hmap": made},
            {"a.hmap": "map"})
        add(f"map {name} localise", "hybrid-replay",
            [*replay, "--map", "{a.hmap}", "--map-mode", "localize"], {"log.rawlog": log, "a.hmap": made},
            {"log.rawlog": "log", "a.hmap": "map"})
