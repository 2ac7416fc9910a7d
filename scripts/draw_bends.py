#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Draws what one loop moves and what it bends, in a pose graph in the plane that is solved pose by pose.

usage: PYTHONPATH=build/release/python /usr/bin/python3 scripts/draw_bends.py GRAPH.g2o OUT.png

The update is that which moves most poses (by more than 5 cm), among those of poses 0, 10, 20, ... Steps between neighbours that have
changed by more than a millimetre or a thousandth of a radian are bent.
"""

import sys

import hybrid
import numpy as np
from matplotlib import pyplot

MOVED, BENT = 0.05, 1e-3  # m; m or rad
COLOURS = {"as they were": "#b0b0b0", "moved": "#1f5fa8", "bent": "#d1342f"}


def poses(smoother, count):
    """x, y, heading of the first poses."""
    values = smoother.values()
    return values.stack(values.keys()[:count])


def steps(rows):
    """Motions from each pose to the next."""
    heading = np.arctan2(rows[:, 3], rows[:, 2]) if rows.shape[1] == 4 else rows[:, 2]
    cos, sin = np.cos(heading[:-1]), np.sin(heading[:-1])
    x, y = np.diff(rows[:, 0]), np.diff(rows[:, 1])
    turn = np.angle(np.exp(1j * np.diff(heading)))
    return np.stack([cos * x + sin * y, cos * y - sin * x, turn], axis=1)


def most_moving(graph, initial):
    """The poses before and after the update that moves most of them."""
    smoother, feed, best = hybrid.IncrementalSmoother(), hybrid.PoseFeed(graph, initial), (0, None, None)
    for number in range(len(feed)):
        delta = feed.next(smoother)
        look = number % 10 == 0 and number > 0
        before = poses(smoother, number) if look else None
        smoother.update(delta)
        if not look:
            continue
        after = poses(smoother, number)
        moved = int((np.hypot(*(after - before)[:, :2].T) > MOVED).sum())
        if moved > best[0]:
            best = moved, before, after
    return best[1:]


def main(file, out):
    graph = hybrid.read_graph(file)
    before, after = most_moving(graph, hybrid.initialize_from_odometry(graph))
    moved = np.hypot(*(after - before)[:, :2].T) > MOVED
    bent = (np.abs(steps(after) - steps(before)) > BENT).any(axis=1)
    figure, ax = pyplot.subplots(figsize=(9, 6), layout="constrained")
    ax.plot(before[:, 0], before[:, 1], color="#e3e3e3", linewidth=1, label="before")
    for name, chosen in ("as they were", ~moved[:-1] & ~bent), ("moved", moved[:-1] & ~bent), ("bent", bent):
        at = np.flatnonzero(chosen)
        lines = np.stack([after[at, :2], after[at + 1, :2], np.full((len(at), 2), np.nan)], axis=1).reshape(-1, 2)
        ax.plot(*lines.T, color=COLOURS[name], linewidth=1.2 if name != "bent" else 2, label=f"{name}: {len(at)} steps")
    ax.set_aspect("equal", adjustable="datalim")
    ax.set(xlabel="x [m]", ylabel="y [m]", title=f"one update at {len(after):,} poses")
    ax.legend()
    figure.savefig(out, dpi=110)


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(*sys.argv[1:])
