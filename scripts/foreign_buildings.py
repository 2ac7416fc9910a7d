#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Localises lasers in maps of their own and of foreign buildings: foreign_buildings.py -o OUT --seeds 1-10.

For each seed it draws a corridor, an L, a ring of corridors and a row of rooms, whose niches, doors and furniture are random, drives
through them (hybrid-simulate) and makes a map of each (hybrid-replay). Then it localises in this map: a drive the other way round, one
with another laser (270 degrees, 12 m), one after half of the furniture and niches have gone and new boxes stand in the way, and a drive
in a foreign building of a random kind. Prints each, and how many were right (within 1 m), wrong and not found."""

import argparse
import collections
import json
import math
import pathlib
import random
import subprocess

BIN = pathlib.Path(__file__).resolve().parent.parent / "build" / "release" / "bin"
DRIVES = ["back", "laser", "moved", "foreign"]
INI = """[simulation]
seed = {seed}
dimension = 2d
[world]
landmarks = 0
min_corner = 0 -0.7 0
max_corner = 30 0.7 0
[path]
shape = waypoints
start = {start} 0
waypoints = {waypoints}
laps = 1
step = 0.1
max_turn_deg = 5
period = 0.2
[odometry]
sigma_translation = .01
sigma_yaw_deg = .3
drift_deg_per_m = .2
[sensor]
ids = hidden
[laser]
rays = {rays}
fov_deg = {fov}
max_range = {reach}
sigma_range = 0.02
pose = 0.2 0 0
walls = {walls}
"""


def wall(rng, a, b):
    """A wall from a to b with niches to the right of it at random places."""
    length = math.dist(a, b)
    along = ((b[0] - a[0]) / length, (b[1] - a[1]) / length)

    def at(way, depth=0.0):
        return (a[0] + along[0] * way + along[1] * depth, a[1] + along[1] * way - along[0] * depth)

    corners, way = [a], rng.uniform(1, 4)
    while way < length - 3:
        width, depth = rng.uniform(0.6, 1.6), rng.uniform(0.15, 0.5)
        corners += [at(way), at(way, depth), at(way + width, depth), at(way + width)]
        way += width + rng.uniform(1.5, 6)
    corners.append(b)
    return list(zip(corners, corners[1:]))


def outline(rng, corners):
    """Walls from each corner to the next, and from the last to the first."""
    return [w for a, b in zip(corners, corners[1:] + corners[:1]) for w in wall(rng, a, b)]


def corridor(rng):
    """Walls and way."""
    length, half = rng.uniform(30, 45), rng.uniform(0.8, 1.2)
    return outline(rng, [(-2, -half), (length, -half), (length, half), (-2, half)]), [(0, 0), (length - 2, 0)]


def ell(rng):
    """Walls and way."""
    x, y, half = rng.uniform(15, 25), rng.uniform(15, 25), rng.uniform(0.8, 1.2)
    corners = [(-2, -half), (x + half, -half), (x + half, y), (x - half, y), (x - half, half), (-2, half)]
    return outline(rng, corners), [(0, 0), (x, 0), (x, y - 2)]


def ring(rng):
    """Walls and way."""
    x, y, half = rng.uniform(14, 22), rng.uniform(10, 16), rng.uniform(0.8, 1.2)
    outer = [(-half, -half), (x + half, -half), (x + half, y + half), (-half, y + half)]
    inner = [(half, half), (half, y - half), (x - half, y - half), (x - half, half)]
    return outline(rng, outer) + outline(rng, inner), [(0, 0), (x, 0), (x, y), (0, y), (0, 0.01)]


def box(x, y, width, height):
    """Four walls."""
    corners = [(x, y), (x + width, y), (x + width, y + height), (x, y + height)]
    return list(zip(corners, corners[1:] + corners[:1]))


def rooms(rng):
    """Walls and way."""
    walls, way, x = [((-1.5, -1), (1.5, -1)), ((-1.5, 1), (1.5, 1)), ((-1.5, -1), (-1.5, 1))], [(0, 0)], 1.5
    for _ in range(rng.randint(4, 6)):
        width, depth, side = rng.uniform(3.5, 6), rng.uniform(3.5, 6), rng.choice([-1, 1])
        door, end = x + rng.uniform(0.8, width - 1.8), x + width
        back = side * (1 + depth)
        walls += [((x, side), (x, back)), ((x, back), (end, back)), ((end, back), (end, side))]
        walls += [((x, side), (door, side)), ((door + 1, side), (end + 0.5, side)), ((x, -side), (end + 0.5, -side))]
        for _ in range(rng.randint(1, 3)):
            size = rng.uniform(0.4, 1)
            far = rng.uniform(2.8, depth - 0.2)
            walls += box(x + rng.uniform(0.2, width - 1.2), min(side * far, side * (far + size)), size, size)
        way += [(door + 0.5, 0), (door + 0.5, side * 2.2), (door + 0.5, 0)]
        x = end + 0.5
    return walls + [((x, -1), (x, 1))], way + [(x - 1, 0)]


KINDS = {"corridor": corridor, "ell": ell, "ring": ring, "rooms": rooms}


def building(kind, seed):
    """Walls and way of a building."""
    return KINDS[kind](random.Random(f"{kind} {seed}"))


def refurnish(walls, way, seed):
    """The same building later: half of the short walls have gone, and boxes stand beside the way."""
    rng = random.Random(seed)
    walls = [w for w in walls if math.dist(*w) > 1.7 or rng.random() > 0.5]
    for _ in range(10):
        k, t, aside = rng.randrange(len(way) - 1), rng.random(), rng.choice([-0.7, 0.7])
        (ax, ay), (bx, by) = way[k], way[k + 1]
        length = math.dist(way[k], way[k + 1]) or 1
        x, y = ax + t * (bx - ax) - aside * (by - ay) / length, ay + t * (by - ay) + aside * (bx - ax) / length
        walls = walls + box(x - 0.15, y - 0.15, 0.3, 0.3)
    return walls


def simulate(log, walls, way, seed, laser=(361, 180, 30)):
    """Writes a log, and returns the true poses: rows of x, y, z, yaw."""
    x, y = way[0]
    rays, fov, reach = laser
    text = INI.format(seed=seed, start=f"{x:.3f} {y:.3f}", rays=rays, fov=fov, reach=reach,
                      waypoints="  ".join(f"{a - x:.3f} {b - y:.3f}" for a, b in way[1:]),
                      walls="  ".join(f"{a[0]:.3f} {a[1]:.3f} {b[0]:.3f} {b[1]:.3f}" for a, b in walls))
    log.with_suffix(".ini").write_text(text)
    subprocess.run([BIN / "hybrid-simulate", "-c", log.with_suffix(".ini"), "-o", log], check=True, capture_output=True)
    return rows(log.with_name(log.stem + "_ground_truth_robot_path.txt"))


def rows(name):
    """Numbers of each line that is no comment."""
    return [[float(v) for v in line.split()] for line in open(name) if line.strip() and line[0] not in "#%"]


def replay(log, building_map, out, *more):
    """Summary of a replay."""
    subprocess.run([BIN / "hybrid-replay", "--no-pictures", log, "--map", building_map, *more, "-o", out], capture_output=True,
                   check=False)
    return json.loads((out / "summary.json").read_text())


def largest_error(origin, truth, path):
    """Of positions in the frame of the first pose of the map [m]."""
    worst = 0.0
    for p, q in zip(truth, path):
        dx, dy, c, s = p[0] - origin[0], p[1] - origin[1], math.cos(origin[3]), math.sin(origin[3])
        worst = max(worst, math.dist((c * dx + s * dy, c * dy - s * dx), q[1:3]))
    return worst


def drives(kind, seed):
    """Each drive with its walls, way and laser."""
    walls, way = building(kind, seed)
    there_and_back = way + way[-2::-1]
    foreign_kind = random.Random(f"foreign {kind} {seed}").choice(list(KINDS))
    foreign, foreign_way = building(foreign_kind, seed + 1000)
    yield "back", walls, way[::-1], (361, 180, 30)
    yield "laser", walls, there_and_back, (541, 270, 12)
    yield "moved", refurnish(walls, way, seed), there_and_back, (361, 180, 30)
    yield f"foreign {foreign_kind}", foreign, foreign_way + foreign_way[-2::-1], (361, 180, 30)


def main():
    """Prints a line a drive, and counts."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", "--output", type=pathlib.Path, required=True)
    parser.add_argument("--seeds", default="1-10", help="first-last")
    args = parser.parse_args()
    args.output.mkdir(parents=True, exist_ok=True)
    first, last = map(int, args.seeds.split("-"))
    counts = collections.Counter()
    for seed, kind in ((s, k) for s in range(first, last + 1) for k in KINDS):
        walls, way = building(kind, seed)
        building_map = args.output / "building.hmap"
        building_map.unlink(missing_ok=True)
        origin = simulate(args.output / "first.rawlog", walls, way + way[-2::-1], seed)[0]
        replay(args.output / "first.rawlog", building_map, args.output / "first")
        for name, its_walls, its_way, laser in drives(kind, seed):
            truth = simulate(args.output / "later.rawlog", its_walls, its_way, seed + 500, laser)
            summary = replay(args.output / "later.rawlog", building_map, args.output / "later", "--map-mode", "localize")
            is_found = summary.get("localized_at") is not None
            error = largest_error(origin, truth, rows(args.output / "later" / "trajectory.tum")) if is_found else math.nan
            verdict = "not found" if not is_found else "right" if error < 1 and "foreign" not in name else "WRONG"
            agreement = [(round(h["value"], 3), h["verdict"]) for h in summary["health"] if h["name"] == "agreement with the map"]
            counts[name.split()[0], verdict] += 1
            print(f"{seed} {kind}: {name}: {verdict}, largest error {error:.2f} m, agreement {agreement}", flush=True)
    for drive in DRIVES:
        print(drive, {verdict: n for (name, verdict), n in sorted(counts.items()) if name == drive})


if __name__ == "__main__":
    main()
