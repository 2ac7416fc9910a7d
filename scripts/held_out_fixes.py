#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Compares a path with positions that the map did not use: held_out_fixes.py TRAJECTORY.tum FIXES.xyz X Y

X and Y are the place of the antenna on the robot [m]. The path is moved onto the positions by weights that fall with
distance, so that false ones hardly count. Prints the median of the distances [m], and the root mean square of those below
10 m.
"""

import sys

import numpy as np


def moved(path, fixes, weights):
    """The points of the path after the planar motion that fits best."""
    weights = weights / weights.sum()
    a, b = path - weights @ path, fixes - weights @ fixes
    h = (a * weights[:, None]).T @ b
    turn = np.arctan2(h[0, 1] - h[1, 0], h[0, 0] + h[1, 1])
    c, s = np.cos(turn), np.sin(turn)
    return a @ np.array([[c, s], [-s, c]]) + weights @ fixes


def main():
    if len(sys.argv) != 5:
        sys.exit(__doc__)
    poses = np.loadtxt(sys.argv[1])
    fixes = np.loadtxt(sys.argv[2], comments=["#", "%"])
    x, y = float(sys.argv[3]), float(sys.argv[4])
    times = poses[:, 0]
    fixes = fixes[(fixes[:, 0] >= times[0]) & (fixes[:, 0] <= times[-1])]
    yaw = np.unwrap(2 * np.arctan2(poses[:, 6], poses[:, 7]))
    at = [np.interp(fixes[:, 0], times, column) for column in (poses[:, 1], poses[:, 2], yaw)]
    path = np.c_[at[0] + x * np.cos(at[2]) - y * np.sin(at[2]), at[1] + x * np.sin(at[2]) + y * np.cos(at[2])]
    weights = np.ones(len(fixes))
    for _ in range(50):
        off = np.linalg.norm(moved(path, fixes[:, 1:3], weights) - fixes[:, 1:3], axis=1)
        weights = 1 / (1 + off**2)
    print(f"{len(off)} positions, median {np.median(off):.3f} m, rmse below 10 m {np.sqrt((off[off < 10] ** 2).mean()):.3f} m")


if __name__ == "__main__":
    main()
