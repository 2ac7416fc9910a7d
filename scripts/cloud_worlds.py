#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""The worlds of simulate_clouds.py: boxes, and a path through them, made by a generator of random numbers."""
import math

import numpy as np


class World:
    """Boxes, by middle, half size and rotation."""

    def __init__(self, height, spacing):
        self.height, self.spacing = height, spacing  # of the sensor above the path, between clouds [m]
        self.middles, self.halves, self.turns = [], [], []
        self.path = []

    def add(self, low, high, turn=None):
        low, high = np.array(low, float), np.array(high, float)
        self.middles.append((low + high) / 2)
        self.halves.append((high - low) / 2)
        self.turns.append(turn)

    def add_hall(self, low, high, wall=0.2):
        """Floor, ceiling and walls around a space."""
        low, high = np.array(low, float), np.array(high, float)
        for axis in range(3):
            for side in (0, 1):
                a, b = low - wall, high + wall
                a[axis], b[axis] = (high[axis], high[axis] + wall) if side else (low[axis] - wall, low[axis])
                self.add(a, b)


def storeys(rng):
    """A way around a core on each storey of 30 by 20 m, and a ramp beside them."""
    world = World(1.0, 0.7)
    world.add_hall((0, 0, 0), (30, 24, 8))
    equal = [((10, 7, 0), (20, 13, 4)), ((0, 0, 3.8), (30, 20.2, 4)), ((3, 20, 0), (27, 20.2, 4))]  # core, ceiling, wall to the ramp
    for x in np.arange(1, 29, 3.0):
        for wall, side in ((0, 1), (7, -1), (13, 1)):
            width, depth, height = rng.uniform(0.4, 2.5), rng.uniform(0.2, 1.0), rng.uniform(0.4, 2.5)
            if wall == 0 or 10 <= x < 18:
                low, high = sorted((wall, wall + side * depth))
                equal.append(((x, low, 0), (x + width, high, height)))
    for y in np.arange(1, 14, 3.0):
        for wall, side in ((0, 1), (30, -1)):
            low, high = sorted((wall, wall + side * rng.uniform(0.2, 1.2)))
            equal.append(((low, y, 0), (high, y + rng.uniform(0.4, 2), rng.uniform(0.4, 2.5))))
    for floor in (0, 4):
        for low, high in equal:
            world.add(np.add(low, (0, 0, floor)), np.add(high, (0, 0, floor)))
    c, s, half = 24 / math.hypot(24, 4), 4 / math.hypot(24, 4), math.hypot(24, 4) / 2
    world.add((15 - half, 20.2, 1.9), (15 + half, 24, 2.0), np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]]))
    world.add((27, 20.2, 3.8), (30, 24, 4))  # where it ends
    up = [(1.5, 18, 0), (1.5, 22, 0), (3, 22, 0), (27, 22, 4), (28.5, 22, 4), (28.5, 18, 4)]
    lower = [(5, 16, 0), (5, 4, 0), (25, 4, 0), (25, 16, 0)]
    upper = [(x, y, 4) for x, y, _ in lower[::-1]]
    world.path = [*lower, *up, *upper, *up[::-1], *lower]
    return world


def warehouse(rng):
    """Six rows of 30 m, with the same goods on each."""
    world = World(1.0, 0.7)
    world.add_hall((0, 0, 0), (46, 36, 8))
    boards = (0.1, 1.5, 2.9)  # height [m]
    goods = [(8.4 + 3 * i, z + 0.1, rng.uniform(0.5, 2.2), rng.uniform(0.4, 1.0)) for i in range(10) for z in boards if rng.random() < 0.8]
    for y in 4 + 5.4 * np.arange(6):
        for x in 8 + 3 * np.arange(11):
            world.add((x, y, 0), (x + 0.1, y + 1.2, 4.4))
        for z in boards:
            world.add((8, y, z), (38.1, y + 1.2, z + 0.1))
        for x, z, width, height in goods:
            world.add((x, y + 0.1, z), (x + width, y + 1.1, z + height))
    for aisle, y in enumerate(1.9 + 5.4 * np.arange(7)):
        world.path += [(x, y, 0) for x in ((3, 43) if aisle % 2 == 0 else (43, 3))]
    world.path += [(43, 1.9, 0), (3, 1.9, 0), (3, 12.7, 0), (43, 12.7, 0)]
    return world


def street(rng):
    """Four blocks of 40 m, with streets of 12 m between and around them."""
    world = World(1.8, 1.5)
    world.add((-120, -120, -0.2), (220, 220, 0))

    def add(along_x, low, high):
        world.add(*((low, high) if along_x else ((low[1], low[0], low[2]), (high[1], high[0], high[2]))))

    for along_x in (True, False):
        for front, side, place, end in ((0, 1, 0, 40), (0, 1, 52, 92), (92, -1, 0, 40), (92, -1, 52, 92), (-12, -1, -30, 122), (104, 1, -30, 122)):
            while end - place > 4:
                width, back = min(rng.uniform(6, 14), end - place), rng.uniform(0, 1.5)
                low, high = sorted((front + side * back, front + side * (back + 8)))
                add(along_x, (place, low, 0), (place + width, high, rng.uniform(5, 12)))
                place += width + rng.choice((0, 0, 2.5))
        for kerb in (-11.8, -2.0, 92.2, 102.0):
            for place in np.arange(2, 86, 6.5):
                kind = rng.choice(("car", "pole", "nothing"), p=(0.45, 0.25, 0.3))
                if kind == "car":
                    add(along_x, (place, kerb, 0), (place + 4.3, kerb + 1.8, rng.uniform(1.4, 1.9)))
                elif kind == "pole":
                    add(along_x, (place, kerb + 0.8, 0), (place + 0.2, kerb + 1.0, 5))
    world.path = [(40, -6, 0)] + 2 * [(98, -6, 0), (98, 98, 0), (-6, 98, 0), (-6, -6, 0)] + [(80, -6, 0)]
    return world


WORLDS = {"storeys": storeys, "warehouse": warehouse, "street": street}
