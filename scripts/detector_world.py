#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Makes a world of classed things and the log of a robot that detects them, as tables for hybrid-import csv, with the truth.

usage: detector_world.py OUT [NAME=VALUE]...

What goes wrong is chosen by name:
  flip=1      bearings are positive to the right
  turn=DEG    the sensor is mounted with this yaw
  delay=S     stamps of detections are this much too late
  tracker=1   detections carry ids, which change when a thing leaves the view for two seconds
  scale=F     odometry is F times as long
  twins=M     beside each thing stands another of its class, M metres away
The rest is the world and its noise: seed, things, seconds, range_share (of the range), bearing [rad], wrong (share of classes),
clutter (probability in a frame).

Written to OUT: odometry.tum, detections.csv, truth.tum and things.txt. Odometry is always 2 % long and drifts by 0.006 rad/s.
"""
import math
import os
import random
import sys

NAMES = ["tree", "bench", "lamp", "bin"]
STEP = 0.05  # s


def wrapped(angle):
    return (angle + math.pi) % (2 * math.pi) - math.pi


def path_at(time):
    a = time / 12
    return 10 + 12 * math.cos(a) + 2 * math.cos(3 * a), 8 + 9 * math.sin(a) + 1.5 * math.sin(2 * a)


def heading_at(time):
    (xa, ya), (xb, yb) = path_at(time - STEP), path_at(time + STEP)
    return math.atan2(yb - ya, xb - xa)


def tum(time, x, y, yaw):
    return f"{1718000000.123 + time:.6f} {x:.6f} {y:.6f} 0 0 0 {math.sin(yaw / 2):.9f} {math.cos(yaw / 2):.9f}\n"


class World:
    def __init__(self, settings):
        self.settings = settings
        self.random = random.Random(int(self.get("seed", 1)))
        self.things = [(self.random.uniform(-15, 35), self.random.uniform(-10, 30), self.random.randrange(4))
                       for _ in range(int(self.get("things", 60)))]
        if self.get("twins", 0):
            for x, y, kind in list(self.things):
                a = self.random.uniform(-math.pi, math.pi)
                self.things.append((x + self.get("twins", 0) * math.cos(a), y + self.get("twins", 0) * math.sin(a), kind))
        self.steps = int(self.get("seconds", 180) / STEP)
        self.origin = (*path_at(0), heading_at(0))  # of the map

    def get(self, name, default):
        return float(self.settings.get(name, default))

    def in_map(self, x, y):
        dx, dy, a = x - self.origin[0], y - self.origin[1], self.origin[2]
        return math.cos(a) * dx + math.sin(a) * dy, -math.sin(a) * dx + math.cos(a) * dy

    def write_paths(self, folder):
        noise, root, scale = self.random.gauss, math.sqrt(STEP), self.get("scale", 1)
        x = y = yaw = 0
        with open(f"{folder}/odometry.tum", "w") as odometry, open(f"{folder}/truth.tum", "w") as truth:
            for i in range(self.steps):
                t = i * STEP
                (px, py), heading = path_at(t), heading_at(t)
                if i:
                    (bx, by), before = path_at(t - STEP), heading_at(t - STEP)
                    dx, dy = px - bx, py - by
                    ahead = 1.02 * (math.cos(before) * dx + math.sin(before) * dy) + noise(0, 0.03 * root)
                    aside = 1.02 * (-math.sin(before) * dx + math.cos(before) * dy) + noise(0, 0.03 * root)
                    x += math.cos(yaw) * ahead - math.sin(yaw) * aside
                    y += math.sin(yaw) * ahead + math.cos(yaw) * aside
                    yaw += wrapped(heading - before) + 0.006 * STEP + noise(0, 0.01 * root)
                odometry.write(tum(t, scale * x, scale * y, yaw))
                truth.write(tum(t, *self.in_map(px, py), heading - self.origin[2]))

    def detections_at(self, i, last, ids):
        t, rows = i * STEP, []
        (px, py), heading = path_at(t), heading_at(t)
        for k, (x, y, kind) in enumerate(self.things):
            r, b = math.hypot(x - px, y - py), wrapped(math.atan2(y - py, x - px) - heading)
            if r >= 10 or abs(b) >= 0.9 or self.random.random() >= 0.8:
                continue
            named = kind if self.random.random() >= self.get("wrong", 0.15) else self.random.randrange(4)
            if k not in last or i - last[k] > 40:
                ids[k] = ids["next"] = ids.get("next", -1) + 1
            last[k] = i
            rows.append((r * (1 + self.random.gauss(0, self.get("range_share", 0.03))),
                         b + self.random.gauss(0, self.get("bearing", 0.01)), NAMES[named], self.random.uniform(0.6, 0.95), ids[k]))
        if self.random.random() < self.get("clutter", 0.15):
            ids["next"] = ids.get("next", -1) + 1
            rows.append((self.random.uniform(2, 10), self.random.uniform(-0.9, 0.9), self.random.choice(NAMES),
                         self.random.uniform(0.5, 0.7), ids["next"]))
        return rows

    def write_detections(self, folder):
        tracker, last, ids = self.get("tracker", 0), {}, {}
        with open(f"{folder}/detections.csv", "w") as table:
            table.write("time,range,yaw,class,score" + (",id" if tracker else "") + "\n")
            for i in range(0, self.steps, 4):
                time = 1718000000.123 + i * STEP + 0.013 + self.get("delay", 0)
                for r, b, name, score, number in self.detections_at(i, last, ids):
                    yaw = (-b if self.get("flip", 0) else b) + math.radians(self.get("turn", 0))
                    table.write(f"{time:.6f},{r:.3f},{yaw:.4f},{name},{score:.2f}" + (f",{number}" if tracker else "") + "\n")

    def write(self, folder):
        os.makedirs(folder, exist_ok=True)
        self.write_paths(folder)
        self.write_detections(folder)
        with open(f"{folder}/things.txt", "w") as things:
            for k, (x, y, kind) in enumerate(self.things):
                mx, my = self.in_map(x, y)
                things.write(f"{mx:.4f} {my:.4f} 0 5 0 0 {k} {NAMES[kind]}\n")


def main():
    if len(sys.argv) < 2 or sys.argv[1] in ("-h", "--help"):
        print(__doc__)
        return
    World(dict(word.split("=") for word in sys.argv[2:])).write(sys.argv[1])


if __name__ == "__main__":
    main()
