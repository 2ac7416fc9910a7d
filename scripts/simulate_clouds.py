#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Makes clouds of a 3-D lidar that is driven through a world of boxes, with odometry that drifts and the true path.

  storeys    two storeys that are equal, joined by a ramp: what is alike one above the other is not the same place
  warehouse  rows of shelves that are equal: aisles are alike
  street     house fronts, poles and parked cars along a loop around four blocks, which is driven twice

Written to DIR: 00000.bin and so on (x y z intensity, 32 bits each, in the frame of the sensor: x ahead, y to the left, z up), and
odometry.txt and truth.txt, poses of the sensor as rows of TUM (time x y z qx qy qz qw). The same options give the same files. With --sweep, the
lidar turns once around while it moves on: 00000.pcd and so on, with the time of each point after that of its pose. Import by

  hybrid-import clouds DIR --odometry DIR/odometry.txt --truth DIR/truth.txt -o DIR.rawlog
"""
import argparse
import math
import pathlib

import numpy as np

from cloud_worlds import WORLDS

PERIOD = 0.5  # s, between clouds
LOWEST, HIGHEST = math.radians(-25), math.radians(15)  # of the rays
DROPPED = 0.05  # share of rays without a return
CORNER = 2.0  # m, before and behind a corner of the path, where it is round
TURN = 1.5  # m, the way for which a turn by a radian counts, so that clouds are nearer to each other in turns


def round_corners(points):
    """The path as short pieces."""
    points = np.array(points, float)
    out = [points[0]]
    for before, at, after in zip(points, points[1:], points[2:]):
        a, b = before - at, after - at
        a, b = (v * min(CORNER, np.linalg.norm(v) / 2) / np.linalg.norm(v) for v in (a, b))
        out += [at + (1 - t) ** 2 * a + t ** 2 * b for t in np.linspace(0, 1, 9)]
    out = np.array([*out, points[-1]])
    return out[np.concatenate([[True], np.linalg.norm(np.diff(out, axis=0), axis=1) > 1e-9])]


def poses_along(world, count):
    """Positions and rotations, x ahead along the path, equally far from each other but for turns."""
    path = round_corners(world.path)
    pieces = np.diff(path, axis=0)
    lengths = np.linalg.norm(pieces, axis=1)
    cosines = np.sum(pieces[1:] * pieces[:-1], axis=1) / (lengths[1:] * lengths[:-1])
    lengths[1:] += TURN * np.arccos(np.clip(cosines, -1, 1))
    way = np.concatenate([[0], np.cumsum(lengths)])
    at = np.linspace(0.3, way[-1] - 0.3, count or int(way[-1] / world.spacing))

    def place(s):
        return np.stack([np.interp(s, way, path[:, axis]) for axis in range(3)], axis=1)

    ahead = place(at + 0.3) - place(at - 0.3)
    ahead /= np.linalg.norm(ahead, axis=1)[:, None]
    left = np.cross((0, 0, 1), ahead)
    left /= np.linalg.norm(left, axis=1)[:, None]
    return place(at) + (0, 0, world.height), np.stack([ahead, left, np.cross(ahead, left)], axis=2)


def cast(world, position, rays, most):
    """Distances along rays (3 rows) from a position, or one for each, to the nearest box; infinite beyond `most`."""
    position = np.reshape(position, (3, -1))
    nearest = np.full(rays.shape[1], np.inf)
    for middle, half, turn in zip(world.middles, world.halves, world.turns):
        from_middle, local = position - middle[:, None], rays
        if np.linalg.norm(np.maximum(np.abs(from_middle[:, 0]) - np.linalg.norm(half), 0)) > most:
            continue
        if turn is not None:
            from_middle, local = turn.T @ from_middle, turn.T @ rays
        with np.errstate(divide="ignore", invalid="ignore"):
            a = (-half[:, None] - from_middle) / local
            b = (half[:, None] - from_middle) / local
        enters, leaves = np.minimum(a, b).max(axis=0), np.maximum(a, b).min(axis=0)
        hit = (enters > 0) & (enters <= leaves)
        nearest[hit] = np.minimum(nearest[hit], enters[hit])
    nearest[nearest > most] = np.inf
    return nearest


def rotation(vector):
    """Rodrigues' formula."""
    angle = np.linalg.norm(vector)
    x, y, z = vector / max(angle, 1e-12)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + math.sin(angle) * cross + (1 - math.cos(angle)) * cross @ cross


def log(R):
    """The rotation vector of a rotation by less than half a turn."""
    sine = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]]) / 2
    length = np.linalg.norm(sine)
    return sine * (math.atan2(length, (np.trace(R) - 1) / 2) / max(length, 1e-12))


def swept(positions, rotations, i, own, shares):
    """Positions and directions of rays, of which each column is cast after a share of the way to the next pose."""
    a, b = max(min(i, len(positions) - 2), 0), max(min(i + 1, len(positions) - 1), 1)
    step, turn = positions[b] - positions[a], log(rotations[a].T @ rotations[b])
    R = np.stack([rotations[i] @ rotation(share * turn) for share in shares])
    columns = own.reshape(3, -1, len(shares))
    rays = np.einsum("cij,jrc->irc", R, columns).reshape(3, -1)
    at = positions[i][:, None] + step[:, None] * shares
    return np.broadcast_to(at[:, None, :], columns.shape).reshape(3, -1), rays


def write_pcd(path, points, times):
    header = (f"VERSION 0.7\nFIELDS x y z t\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1\nWIDTH {len(times)}\nHEIGHT 1\nPOINTS {len(times)}\n"
              "DATA binary\n")
    path.write_bytes(header.encode() + np.column_stack([points.T, times]).astype("<f4").tobytes())


def drifting(rng, positions, rotations, noise):
    """The path by odometry, whose error grows by so much [m, rad] per square root of a metre."""
    out = [(positions[0], rotations[0])]
    for i in range(1, len(positions)):
        step, turn = rotations[i - 1].T @ (positions[i] - positions[i - 1]), rotations[i - 1].T @ rotations[i]
        scale = math.sqrt(np.linalg.norm(step))
        step, turn = step + noise[0] * scale * rng.normal(size=3), turn @ rotation(noise[1] * scale * rng.normal(size=3))
        position, R = out[-1]
        out.append((position + R @ step, R @ turn))
    return out


def tum(time, position, R):
    d, s, trace = R - R.T, R + R.T, np.trace(R)
    K = np.array([[trace, d[2, 1], d[0, 2], d[1, 0]], [d[2, 1], s[0, 0] - trace, s[0, 1], s[0, 2]],
                  [d[0, 2], s[0, 1], s[1, 1] - trace, s[1, 2]], [d[1, 0], s[0, 2], s[1, 2], s[2, 2] - trace]])
    w, x, y, z = np.linalg.eigh(K)[1][:, -1]  # the quaternion, by Bar-Itzhack
    return " ".join(f"{value:.9f}" for value in (time, *position, x, y, z, w)) + "\n"


def make(folder, options):
    rng = [np.random.default_rng([options.seed, part]) for part in range(3)]  # of the world, the odometry and the clouds
    world = WORLDS[options.world](rng[0])
    positions, rotations = poses_along(world, options.clouds)
    odometry = drifting(rng[1], positions, rotations, options.odometry_noise)
    up, around = np.meshgrid(np.linspace(LOWEST, HIGHEST, options.rings), np.linspace(-math.pi, math.pi, options.columns, endpoint=False), indexing="ij")
    rays = np.stack([np.cos(up) * np.cos(around), np.cos(up) * np.sin(around), np.sin(up)]).reshape(3, -1)
    times = np.tile(np.arange(options.columns) * options.sweep / options.columns, options.rings)
    folder.mkdir(parents=True, exist_ok=True)
    count = 0
    for i, (position, R) in enumerate(zip(positions, rotations)):
        if options.sweep:
            position, directions = swept(positions, rotations, i, rays, times[:options.columns] / PERIOD)
        else:
            directions = R @ rays
        ranges = cast(world, position, directions, options.max_range)
        seen = np.isfinite(ranges) & (rng[2].random(len(ranges)) >= DROPPED)
        points = rays[:, seen] * (ranges[seen] + options.range_noise * rng[2].normal(size=np.count_nonzero(seen)))
        if options.sweep:
            write_pcd(folder / f"{i:05}.pcd", points, times[seen])
        else:
            np.column_stack([points.T, np.full(points.shape[1], 0.5)]).astype("<f4").tofile(folder / f"{i:05}.bin")
        count += points.shape[1]
    for name, poses in (("truth.txt", zip(positions, rotations)), ("odometry.txt", odometry)):
        (folder / name).write_text("".join(tum(PERIOD * i, *pose) for i, pose in enumerate(poses)), encoding="utf-8")
    way = np.linalg.norm(np.diff(positions, axis=0), axis=1).sum()
    off = np.linalg.norm(odometry[-1][0] - positions[-1])
    print(f"{options.world}: {len(positions)} clouds of {count / len(positions):.0f} points in the mean, {way:.0f} m of way; odometry ends {off:.2f} m off")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", metavar="DIR", type=pathlib.Path)
    parser.add_argument("--world", choices=WORLDS, required=True)
    parser.add_argument("--clouds", type=int, default=0, help="along the whole path; 0: one each 0.7 m, 1.5 m in a street")
    parser.add_argument("--rings", type=int, default=32, help="from 25 degrees down to 15 degrees up")
    parser.add_argument("--columns", type=int, default=600, help="of a ring")
    parser.add_argument("--sweep", type=float, default=0.0, metavar="S", help=f"time in which the lidar turns once, of {PERIOD} between clouds; 0: at once")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--range-noise", type=float, default=0.02, help="sigma [m]")
    parser.add_argument("--max-range", type=float, default=60.0, help="[m]")
    parser.add_argument("--odometry-noise", type=float, nargs=2, default=(0.03, 0.005), metavar=("M", "RAD"), help="per square root of a metre, each axis")
    options = parser.parse_args()
    make(options.folder, options)


if __name__ == "__main__":
    main()
