#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Directions without ranges and ids become a map; boxes in images become directions and ranges.

usage: directions_test.py BIN
"""

import csv
import json
import math
import pathlib
import random
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
from detector_world import World  # noqa: E402

FOCAL, WIDTH, HEIGHT, POLE = 400.0, 640, 480, 2.0  # of a camera [pixels], of poles [m]
POLES = [(5.0, 3.0), (9.0, -3.0), (13.0, 3.5), (17.0, -2.5), (21.0, 3.0)]


class Room(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.at = pathlib.Path(folder.name)

    def run_program(self, name, *words, rc=0):
        ran = subprocess.run([BIN / name, *map(str, words)], cwd=self.at, text=True, capture_output=True, check=False)
        self.assertEqual(ran.returncode, rc, ran.stdout + ran.stderr)
        return ran.stdout + ran.stderr

    def summary(self, folder="out"):
        return json.loads((self.at / folder / "summary.json").read_text())

    def landmarks(self, folder="out"):
        return json.loads((self.at / folder / "landmarks.json").read_text())["landmarks"]


class Directions(Room):
    def directions(self, seed):
        """The tables of a world, detections without ranges and ids."""
        World({"seed": seed, "seconds": 180}).write(str(self.at))
        with open(self.at / "detections.csv", encoding="utf-8") as table:
            rows = list(csv.DictReader(table))
        with open(self.at / "seen.csv", "w", encoding="utf-8") as table:
            table.write("time,bearing,label,confidence\n")
            table.writelines(f"{r['time']},{r['yaw']},{r['class']},{r['score']}\n" for r in rows)
        return len(rows)

    def test_a_detector_without_ranges_makes_a_map(self):
        count = self.directions(1)
        told = self.run_program("hybrid-import", "csv", "--odometry", "odometry.tum", "--detections", "seen.csv",
                                "--sigma-bearing", 0.01, "-o", "a.rawlog")
        self.assertRegex(told, f"{count} directions without ranges and ids: a thing gets its place once")
        self.run_program("hybrid-replay", "a.rawlog", "--truth-path", "truth.tum", "--no-pictures", "-o", "out")
        summary = self.summary()
        truth = summary["truth"]
        self.assertLess(truth["trajectory"]["aligned"]["rmse_m"], 0.3 * truth["dead_reckoning"]["rmse_m"])
        things = [tuple(map(float, line.split()[:2])) for line in (self.at / "things.txt").read_text().splitlines()]
        off = sorted(min(math.dist(l["position"][:2], thing) for thing in things) for l in self.landmarks())
        self.assertGreaterEqual(len(off), 12)
        self.assertLess(off[len(off) // 2], 1.0)
        statistics = summary["plugins"]
        self.assertEqual(statistics["directions"], count)
        (entry,) = [e for e in summary["health"] if e["name"] == "directions without a range"]
        self.assertNotIn("landmarks seen when in view", {e["name"] for e in summary["health"]})  # most keyframes show no range
        self.assertAlmostEqual(entry["value"], 1 - statistics["directions_with_range"] / count)

    def test_directions_of_what_is_not_passed_map_nothing_and_say_so(self):
        with open(self.at / "odometry.csv", "w", encoding="utf-8") as table:
            table.write("time,x,y,yaw\n" + "".join(f"{t},{0.1 * t},0,0\n" for t in range(40)))
        with open(self.at / "seen.csv", "w", encoding="utf-8") as table:
            table.write("time,yaw\n" + "".join(f"{t},0.0\n" for t in range(40)))
        self.run_program("hybrid-import", "csv", "--odometry", "odometry.csv", "--detections", "seen.csv", "-o", "a.rawlog")
        told = self.run_program("hybrid-replay", "a.rawlog", "--no-pictures", "-o", "out", rc=2)
        self.assertIn("Directions without ranges place only what the robot passes", told)


    def straight_at_things(self, seed):
        """The tables of a robot that drives straight at three things and past ten; the things."""
        noise = random.Random(seed)
        things = [(20 + 10 * k + noise.uniform(-1, 1), noise.gauss(0, 0.02)) for k in range(3)]
        things += [(noise.uniform(0, 40), noise.choice((-1, 1)) * noise.uniform(3, 8)) for _ in range(10)]
        x, y, yaw = 0.0, 0.0, 0.0  # by odometry
        odometry, seen = ["time,x,y,yaw\n"], ["time,yaw,id\n"]
        for k in range(200):
            odometry.append(f"{0.25 * k},{x:.6f},{y:.6f},{yaw:.6f}\n")
            for i, (px, py) in enumerate(things):
                bearing = math.atan2(py, px - 0.12 * k)
                if abs(bearing) < 1.6 and math.hypot(px - 0.12 * k, py) < 45 and noise.random() > 0.15:
                    seen.append(f"{0.25 * k},{bearing + noise.gauss(0, 0.01):.6f},{i}\n")
            dx, dy, turn = 0.12 + noise.gauss(0, 0.007), noise.gauss(0, 0.007), noise.gauss(0, 0.0014)
            x, y, yaw = x + dx * math.cos(yaw) - dy * math.sin(yaw), y + dx * math.sin(yaw) + dy * math.cos(yaw), yaw + turn
        (self.at / "odometry.csv").write_text("".join(odometry), encoding="utf-8")
        (self.at / "seen.csv").write_text("".join(seen), encoding="utf-8")
        return things

    def test_things_straight_ahead_stay_within_the_world(self):
        for seed in (7, 8):
            things = self.straight_at_things(seed)
            self.run_program("hybrid-import", "csv", "--odometry", "odometry.csv", "--detections", "seen.csv", "--sigma-bearing", 0.01,
                             "--walk-translation", 0.02, "--walk-rotation", 0.004, "-o", "a.rawlog")
            self.run_program("hybrid-replay", "a.rawlog", "--no-pictures", "-o", "out")
            self.assertGreaterEqual(len(self.landmarks()), 10)
            for landmark in self.landmarks():
                self.assertLess(math.dist(landmark["position"][:2], things[landmark["id"]]), 10_000)


class Boxes(Room):
    def setUp(self):
        super().setUp()
        noise = random.Random(3)
        self.boxes = []  # (image, left, top, width, height, whether the pole is to the left)
        odometry = ["time,x,y,yaw\n"]
        for k in range(1, 181):
            x = 0.1 * k
            odometry.append(f"{0.1 * k:.2f},{x:.3f},0,0\n")
            for px, py in POLES:
                if not 1.5 < px - x < 12:
                    continue
                u, high, wide = 320 - FOCAL * py / (px - x), FOCAL * POLE / (px - x), FOCAL * 0.3 / (px - x)
                high, u = high + noise.gauss(0, 1), u + noise.gauss(0, 1)
                if u - wide / 2 > 2 and u + wide / 2 < WIDTH - 2:
                    self.boxes.append((k, u - wide / 2, 240 - high / 2, wide, high, int(py > 0)))
        (self.at / "odometry.csv").write_text("".join(odometry), encoding="utf-8")
        (self.at / "det.txt").write_text("".join(f"{k},-1,{l:.2f},{t:.2f},{w:.2f},{h:.2f},0.9,-1,-1,-1\n" for k, l, t, w, h, _ in self.boxes),
                                         encoding="utf-8")
        (self.at / "labels").mkdir()
        (self.at / "labels/classes.txt").write_text("post \r\npole\r\n", encoding="utf-8")
        for image in range(1, 181):
            rows = [f"{kind} {(l + w / 2) / WIDTH:.6f} {(t + h / 2) / HEIGHT:.6f} {w / WIDTH:.6f} {h / HEIGHT:.6f} 0.9\n"
                    for k, l, t, w, h, kind in self.boxes if k == image]
            (self.at / f"labels/left_{image:06}.txt").write_text("".join(rows), encoding="utf-8")
        (self.at / "results.json").write_text(json.dumps(
            [{"image_id": k, "category_id": 7 + kind, "bbox": [l, t, w, h], "score": 0.9} for k, l, t, w, h, kind in self.boxes]), encoding="utf-8")

    CAMERA = ("--focal", FOCAL, "--image-width", WIDTH, "--image-height", HEIGHT, "--period", 0.1, "--sigma-bearing", 0.004,
              "--walk-rotation", 0.005, "--walk-translation", 0.02)

    def imported(self, detections, *options, rc=0):
        return self.run_program("hybrid-import", "csv", "--odometry", "odometry.csv", "--detections", detections, *self.CAMERA,
                                *options, "-o", "a.rawlog", rc=rc)

    def check_map(self, most):
        self.run_program("hybrid-replay", "a.rawlog", "--no-pictures", "-o", "out")
        found = self.landmarks()
        for pole in POLES[1:4]:  # the first is passed too early, the last not at all
            off = min(math.dist(l["position"][:2], pole) for l in found)
            self.assertLess(off, most, pole)
        return found

    def test_heights_of_classes_tell_ranges(self):
        both = ("--class-height", f"pole={POLE}", "--class-height", f"post={POLE}")
        for detections, options in (("labels", both), ("results.json", ("--class-name", "7=post", "--class-name", "8=pole", *both))):
            told = self.imported(detections, *options, "--sigma-height", 0.02)
            self.assertIn("observations with", told)
            for landmark in self.check_map(0.4):
                self.assertEqual(landmark["class"], "pole" if landmark["position"][1] > 0 else "post")

    def test_without_heights_they_are_directions(self):
        for detections in ("det.txt", "labels", "results.json"):
            told = self.imported(detections)
            self.assertIn(f"{len(self.boxes)} directions without ranges and ids", told)
        self.check_map(0.8)

    def test_odometry_that_is_better_than_stated_is_named(self):
        self.run_program("hybrid-import", "csv", "--odometry", "odometry.csv", "--detections", "det.txt", *self.CAMERA[:10],
                         "--walk-rotation", 0.5, "--walk-translation", 1, "-o", "a.rawlog")
        told = self.run_program("hybrid-replay", "a.rawlog", "--no-pictures", "-o", "out", rc=2)
        self.assertIn("noise of the odometry, if it is better than stated: smaller ([reader] odometry_sigma_factor", told)

    def test_boxes_cut_by_the_border_are_dropped(self):
        (self.at / "det.txt").write_text("5,-1,0,100,50,200,1\n5,-1,100,100,50,200,1\n6,-1,620,100,19.5,200,1\n"
                                         "7,-1,50,100,0,200,1\n8,-1,50,100,10,200,0.2\n", encoding="utf-8")
        told = self.imported("det.txt", "--min-score", 0.5)
        self.assertIn("cut by the left or right border of the image: 2", told)
        self.assertIn("without width or height: 1", told)
        self.assertIn("score too low: 1", told)

    def test_frame_times_are_taken_from_a_table(self):
        (self.at / "times.csv").write_text("frame,time\n" + "".join(f"{k},{0.1 * k}\n" for k in range(1, 181) if k != 20), encoding="utf-8")
        lost = sum(box[0] == 20 for box in self.boxes)
        told = self.imported("det.txt", "--frame-times", "times.csv")
        self.assertIn(f"--frame-times has not its image: {lost}", told)

    def test_what_is_missing_or_wrong_is_told(self):
        def fails(message, detections, *options):
            told = self.run_program("hybrid-import", "csv", "--odometry", "odometry.csv", "--detections", detections, *options,
                                    "-o", "b.rawlog", rc=1)
            self.assertIn(message, told)
            self.assertFalse((self.at / "b.rawlog").exists())

        size = ("--image-width", 640, "--image-height", 480)
        fails("--focal is its focal length in pixels", "det.txt", "--period", 0.1)
        fails("--period tells the seconds between images", "det.txt", "--focal", 600, *size)
        fails("--image-width must be given", "det.txt", "--focal", 600, "--period", 0.1)
        fails("--image-width and --image-height tell its size", "labels", "--focal", 600, "--period", 0.1)
        fails("no box is of that class; classes are: pole post", "labels", "--focal", 600, "--period", 0.1, *size, "--class-height", "pol=2")
        fails("expected NAME=METRES", "labels", "--focal", 600, "--period", 0.1, *size, "--class-height", "pole=two")
        fails("--start is the time of image 0", "det.txt", "--focal", 600, "--period", 0.1, *size, "--start", 500)
        fails("--start is at most", "det.txt", "--focal", 600, "--period", 0.1, *size, "--start", "nan")
        fails("--period at most", "det.txt", "--focal", 600, "--period", 1e300, *size)
        camera = ("--focal", 600, "--period", 0.1, *size)
        for text, message in (('{"images": []}', "not the results of COCO"), ("[1", "not the results of COCO"),
                              ('[{"image_id": -1}]', "entry 1: image_id is no number"),
                              ('[{"image_id": "a_7", "category_id": 1, "bbox": [1, 2, 3], "score": 1}]', "entry 1: bbox has not four numbers"),
                              ('[{"image_id": 7, "category_id": 1, "bbox": [1, 2, 3, 4], "score": 3}]', "which is no probability")):
            (self.at / "bad.json").write_text(text, encoding="utf-8")
            fails(message, "bad.json", *camera)
        (self.at / "bad.txt").write_text("1,-1,3\n", encoding="utf-8")
        fails("bad.txt:1", "bad.txt", *camera)
        (self.at / "labels/right_000005.txt").write_text("", encoding="utf-8")
        fails("are both of image 5", "labels", *camera)
        (self.at / "labels/right_000005.txt").rename(self.at / "labels/notes.txt")
        fails("has no number of an image", "labels", *camera)


class Noise(Room):
    def test_sigmas_grow_with_the_range_and_across_near_by(self):
        (self.at / "odometry.csv").write_text("time,x,y,yaw\n0,0,0,0\n9,1,0,0\n", encoding="utf-8")
        (self.at / "seen.csv").write_text("time,range,yaw,sigma_range\n1,2,0.1,\n2,8,0.1,\n3,8,0.1,0.7\n", encoding="utf-8")
        common = ("csv", "--odometry", "odometry.csv", "--detections", "seen.csv", "-o", "a.rawlog", "--sigma-range", 0.3)
        self.run_program("hybrid-import", *common, "--sigma-range-share", 0.05, "--sigma-bearing", 0.03, "--sigma-across", 0.08)
        self.run_program("hybrid-replay", "a.rawlog", "--no-pictures", "-o", "out", "--set", "BearingRangeAssociation.confirm=1", "--events")
        # The covariance of a landmark that is seen once is that of its sighting, and of the pose.
        self.assertIn("--sigma-across", self.run_program("hybrid-import", "csv", "--help"))
        near, far, stated = (self.spread(k) for k in range(3))
        self.assertAlmostEqual(near[0], math.hypot(0.3, 0.1), delta=0.01)
        self.assertAlmostEqual(far[0], math.hypot(0.3, 0.4), delta=0.01)
        self.assertAlmostEqual(stated[0], 0.7, delta=0.01)
        self.assertAlmostEqual(near[1], math.hypot(0.03, 0.04), delta=0.002)
        self.assertAlmostEqual(far[1], math.hypot(0.03, 0.01), delta=0.002)

    def spread(self, step):
        """Sigmas of range and bearing of the only detection of a step, as a map of it alone has them."""
        (self.at / "one.csv").write_text(
            "".join((self.at / "seen.csv").read_text().splitlines(keepends=True)[i] for i in (0, step + 1)), encoding="utf-8")
        self.run_program("hybrid-import", "csv", "--odometry", "odometry.csv", "--detections", "one.csv", "-o", "b.rawlog",
                         "--sigma-range", 0.3, "--sigma-range-share", 0.05, "--sigma-bearing", 0.03, "--sigma-across", 0.08)
        self.run_program("hybrid-replay", "b.rawlog", "--no-pictures", "-o", "one", "--set", "BearingRangeAssociation.confirm=1")
        (landmark,) = self.landmarks("one")
        (x, y), ((xx, xy), (_, yy)) = landmark["position"], landmark["covariance"]
        r = math.hypot(x, y)
        along = (x * x * xx + 2 * x * y * xy + y * y * yy) / r**2
        across = (y * y * xx - 2 * x * y * xy + x * x * yy) / r**2
        return math.sqrt(along), math.sqrt(across) / r


if __name__ == "__main__":
    BIN = pathlib.Path(sys.argv.pop(1)).resolve()
    unittest.main()
