#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""What verdicts about health are worth: how many wrong maps are called bad, and how many right ones.

usage: health_table.py BIN FOLDER SEEDS [CORRUPTION...]        SEEDS as 1-4 or 1,3,7

Makes worlds with detector_world.py, states their noise or settings wrongly, maps them, and compares with the truth. A map is wrong
where its path has more than twice the error of the right settings with the same seed, both aligned with the truth, or where there
are more copies than a fifth of the things. Prints a row for each corruption: runs, wrong maps, those of them that are called bad, right maps, those called bad;
and the error of the path to that with the right settings, and the copies to the things, in the median and at worst.
"""
import bisect
import csv
import json
import math
import os
import statistics
import subprocess
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from detector_world import World  # noqa: E402

RIGHT = {"--sigma-range": ".2"}
SURE = {"--walk-translation": ".005", "--walk-rotation": ".002"}
UNSURE = {"--walk-translation": ".5", "--walk-rotation": ".2"}
# name: settings of the world, options of the import
CORRUPTIONS = {
    "right settings": ({}, RIGHT),
    "no settings": ({}, {}),
    "noise of ranges x .15": ({}, {"--sigma-range": ".03"}),
    "noise of ranges x .25": ({}, {"--sigma-range": ".05"}),
    "noise of ranges x .5": ({}, {"--sigma-range": ".1"}),
    "noise of ranges x 2.5": ({}, {"--sigma-range": ".5"}),
    "noise of ranges x 5": ({}, {"--sigma-range": "1"}),
    "noise of odometry x .1": ({}, {**RIGHT, **SURE}),
    "noise of odometry x 10": ({}, {**RIGHT, **UNSURE}),
    "bearings of the other sign": ({"flip": 1}, RIGHT),
    "sensor turned by 90 degrees": ({"turn": 90}, RIGHT),
    "detections stamped .5 s late": ({"delay": 0.5}, RIGHT),
    "ids of a tracker": ({"tracker": 1}, RIGHT),
    "odometry x 1.2": ({"scale": 1.2}, RIGHT),
    "twins .3 m apart": ({"twins": 0.3}, RIGHT),
}


NEAR = 1.5  # m: a landmark farther from every thing is of nothing
TOGETHER = 0.5  # m: things nearer to each other are at one place, where any of them may be a landmark's


def places_of(things):
    """The number of the place of each thing."""
    places = list(range(len(things)))
    for a, one in enumerate(things):
        for b in range(a):
            if math.dist(one, things[b]) < TOGETHER:
                places = [places[b] if p == places[a] else p for p in places]
    return places


def positions(path):
    """Time in milliseconds to x, y of a TUM file."""
    rows = [line.split() for line in open(path) if line[0] != "#"]
    return {round(1000 * float(row[0])): complex(float(row[1]), float(row[2])) for row in rows}


def alignment(result, world):
    """Turns points of the map, as complex numbers, into the frame of the truth: rigid, of least squares of the path."""
    estimated, true = positions(f"{result}/trajectory.tum"), positions(f"{world}/truth.tum")
    times = sorted(true)
    pairs = [(at, true[times[min(bisect.bisect(times, time), len(times) - 1)]]) for time, at in estimated.items()]
    mean, true_mean = (sum(pair[i] for pair in pairs) / len(pairs) for i in (0, 1))
    turn = sum((b - true_mean) * (a - mean).conjugate() for a, b in pairs)
    turn = turn / abs(turn) if abs(turn) > 0 else 1
    return lambda at: true_mean + turn * (at - mean)


def copies_of(result, world):
    """Landmarks beyond the number of things at the place of the nearest, within NEAR, and the number of things mapped."""
    things = [tuple(map(float, line.split()[:2])) for line in open(f"{world}/things.txt")]
    places, landmarks, aligned = places_of(things), {}, alignment(result, world)
    for row in csv.DictReader(open(f"{result}/landmarks.csv")):
        at = aligned(complex(float(row["x"]), float(row["y"])))
        distance, thing = min((math.dist((at.real, at.imag), place), k) for k, place in enumerate(things))
        if distance < NEAR:
            landmarks[places[thing]] = landmarks.get(places[thing], 0) + 1
    mapped = sum(min(count, places.count(place)) for place, count in landmarks.items())
    return sum(landmarks.values()) - mapped, mapped


def run(binaries, folder, seed, name, seconds):
    """The judged summary of one run."""
    world, options = CORRUPTIONS[name]
    place = f"{folder}/{seed} {name}"
    result = f"{place}/out"
    if not os.path.exists(f"{result}/summary.json"):
        World({"seed": seed, "seconds": seconds, **world}).write(place)
        words = [word for pair in options.items() for word in pair]
        subprocess.run([f"{binaries}/hybrid-import", "csv", "--odometry", f"{place}/odometry.tum", "--detections",
                        f"{place}/detections.csv", *words, "-o", f"{place}/log.rawlog"], check=True, capture_output=True)
        try:
            subprocess.run([f"{binaries}/hybrid-replay", f"{place}/log.rawlog", "--truth-path", f"{place}/truth.tum",
                            "--no-pictures", "-o", result], capture_output=True, timeout=int(os.environ.get("TIMEOUT", 1200)))
        except subprocess.TimeoutExpired:
            return None
        if not os.path.exists(f"{result}/summary.json"):
            return None
    summary = json.load(open(f"{result}/summary.json"))
    copies, things = copies_of(result, place)
    bad = [e["name"] for e in summary["health"] if e["verdict"] == "bad"]
    return {"rmse": summary["truth"]["trajectory"]["aligned"]["rmse_m"], "copies": copies, "things": things, "bad": bad,
            "health": {e["name"]: e["value"] for e in summary["health"]}}


def seeds_of(text):
    if "-" in text:
        first, last = text.split("-")
        return list(range(int(first), int(last) + 1))
    return [int(word) for word in text.split(",")]


def spread(values):
    """Median and worst."""
    return f"{statistics.median(values):.2f}, {max(values):.2f}" if values else ""


def main():
    if len(sys.argv) < 4:
        print(__doc__)
        return
    binaries, folder, seeds, wanted = sys.argv[1], sys.argv[2], seeds_of(sys.argv[3]), sys.argv[4:] or list(CORRUPTIONS)
    seconds = float(os.environ.get("SECONDS_OF_WORLD", 120))
    right = {seed: run(binaries, folder, seed, "right settings", seconds) for seed in seeds}
    totals = [0, 0, 0, 0]
    print("| corruption | runs | wrong maps | called bad | right maps | called bad | checks that said so | path to right | copies to things |")
    print("|---|---|---|---|---|---|---|---|---|")
    for name in wanted:
        counts, said, paths, copies = [0, 0, 0, 0], {}, [], []
        for seed in seeds:
            one = run(binaries, folder, seed, name, seconds)
            if one is None or right[seed] is None:
                continue
            wrong = one["rmse"] > 2 * right[seed]["rmse"] or one["copies"] > one["things"] / 5
            counts[0 if wrong else 2] += 1
            counts[1 if wrong else 3] += bool(one["bad"])
            paths.append(one["rmse"] / right[seed]["rmse"])
            copies.append(one["copies"] / max(1, one["things"]))
            for check in one["bad"]:
                said[check] = said.get(check, 0) + 1
            print(f"  seed {seed} {name}: {'wrong' if wrong else 'right'}, {one}", file=sys.stderr)
        totals = [a + b for a, b in zip(totals, counts)]
        checks = ", ".join(f"{check} {count}" for check, count in sorted(said.items(), key=lambda s: -s[1]))
        print(f"| {name} | {counts[0] + counts[2]} | {counts[0]} | {counts[1]} | {counts[2]} | {counts[3]} | {checks} | {spread(paths)} | {spread(copies)} |", flush=True)
    print(f"| all | {totals[0] + totals[2]} | {totals[0]} | {totals[1]} | {totals[2]} | {totals[3]} | | | |")


if __name__ == "__main__":
    main()
