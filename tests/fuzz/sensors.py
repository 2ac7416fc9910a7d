# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Undamaged inputs of laser scans, boxes in images and map files."""

import json
import math
import subprocess

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
    """Calls `add` of material.py for each input but those of hybrid-import."""
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
