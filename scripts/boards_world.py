#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Makes a room with boards in twos and threes, which a wandering robot detects, as tables for hybrid-import csv, with the truth.

usage: boards_world.py OUT [seed=N] [seconds=S] [apart=M]

Six groups of boards stand around a room of 9 by 8 m, boards of one group `apart` metres from each other (.18). Which board of a
group is seen can be told only where the pose is known well. Written to OUT: odometry.csv, detections.csv and truth.tum. Odometry
turns 8 % too far, ranges have a sigma of 4 cm and 4 %, directions one of .5 degrees and 2 cm. Import it by

  hybrid-import csv --odometry OUT/odometry.csv --detections OUT/detections.csv --sigma-range .12 --sigma-bearing .02 \\
    --walk-rotation .06 --walk-translation .06 -o OUT/boards.rawlog
"""
import math
import pathlib
import random
import sys

from detector_world import wrapped

GROUPS = [(0, 4), (4.5, 1), (3, -3.5), (-2.5, -4), (-4.5, 0.5), (-2, 2.5)]  # m
STEP, LOOK = 0.1, 5  # s, steps from look to look
SPEED, MOST_TURN = 0.15, 0.5  # m/s, rad/s
REACH, HALF_VIEW, DETECTED = 5.0, 0.45, 0.4  # m, rad, probability


def moved(pose, speed, turn):
    """The pose one step later."""
    x, y, heading = pose
    return x + speed * STEP * math.cos(heading), y + speed * STEP * math.sin(heading), wrapped(heading + turn * STEP)


def boards(rng, apart):
    out = []
    for number, (x, y) in enumerate(GROUPS):
        row = rng.uniform(0, 2 * math.pi)
        for i in range(2 + number % 2):
            out.append((x + i * apart * math.cos(row), y + i * apart * math.sin(row)))
    return out


def look(rng, pose, things):
    """Ranges and directions of what is detected."""
    for x, y in things:
        distance = math.hypot(x - pose[0], y - pose[1])
        direction = wrapped(math.atan2(y - pose[1], x - pose[0]) - pose[2])
        if distance < REACH and abs(direction) < HALF_VIEW and rng.random() < DETECTED:
            yield (distance + rng.gauss(0, math.hypot(0.04, 0.04 * distance)),
                   direction + rng.gauss(0, math.hypot(0.009, 0.02 / distance)))


def make(folder, seed=1, seconds=500.0, apart=0.18):
    rng = random.Random(seed)
    things = boards(rng, apart)
    pose = odometry = (0.0, 0.0, 0.0)
    goal = pose[:2]
    way, detections, truth = [], [], []
    for step in range(1, int(seconds / STEP) + 1):
        if math.dist(goal, pose[:2]) < 0.3:
            goal = rng.uniform(-2.5, 2.5), rng.uniform(-2.5, 2.5)
        off = wrapped(math.atan2(goal[1] - pose[1], goal[0] - pose[0]) - pose[2])
        turn = max(-MOST_TURN, min(MOST_TURN, 1.5 * off))
        speed = SPEED if abs(turn) < 0.4 else 0.03
        pose = moved(pose, speed, turn)
        odometry = moved(odometry, speed * (1 + rng.gauss(0, 0.1)) + rng.gauss(0, 0.01),
                         1.08 * turn + rng.gauss(0, 0.05) * abs(turn) / math.sqrt(STEP))
        time = step * STEP
        way.append((time, *odometry))
        truth.append((time, *pose))
        if step % LOOK == 0:
            detections.extend((time, *seen) for seen in look(rng, pose, things))
    folder.mkdir(parents=True, exist_ok=True)
    table = "time,x,y,yaw\n" + "".join(f"{t:.3f},{x:.5f},{y:.5f},{h:.6f}\n" for t, x, y, h in way)
    (folder / "odometry.csv").write_text(table, encoding="utf-8")
    table = "time,range,yaw\n" + "".join(f"{t:.3f},{r:.4f},{a:.5f}\n" for t, r, a in detections)
    (folder / "detections.csv").write_text(table, encoding="utf-8")
    path = "".join(f"{t:.3f} {x:.5f} {y:.5f} 0 0 0 {math.sin(h / 2):.7f} {math.cos(h / 2):.7f}\n" for t, x, y, h in truth)
    (folder / "truth.tum").write_text(path, encoding="utf-8")


def main(words):
    if not words or words[0] in ("-h", "--help"):
        print(__doc__.strip())
        return 0 if words else 1
    named = dict(word.split("=", 1) for word in words[1:])
    unknown = set(named) - {"seed", "seconds", "apart"}
    if unknown:
        print(f"boards_world.py: there is no {sorted(unknown)[0]}; see --help", file=sys.stderr)
        return 1
    make(pathlib.Path(words[0]), int(named.get("seed", 1)), float(named.get("seconds", 500)), float(named.get("apart", 0.18)))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
