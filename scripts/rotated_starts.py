#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Registers two clouds from many wrong starts: rotated_starts.py SOURCE TARGET [STARTS [DEGREES [SEED]]].

A start is the result from the identity, turned by DEGREES (40) about a random axis through the centre of the source. Prints
how many of STARTS (100) end within 0.5 degrees and 0.1 units of that result. Needs the Python package of this project."""

import sys

import numpy as np

import hybrid


def turned(result, centre, axis, degrees):
    """`result` after a turn of the source about an axis through `centre`."""
    rotation = hybrid.SE3.exp(np.concatenate([np.zeros(3), np.radians(degrees) * axis]))
    return result * hybrid.SE3(centre - rotation * centre, rotation.rotation)


def main():
    source, target = (hybrid.read_points(name) for name in sys.argv[1:3])
    starts, degrees, seed = (int(a) if a else b for a, b in zip((sys.argv[3:] + [""] * 3)[:3], (100, 40, 1)))
    right = hybrid.register_clouds(source, target).T_target_source
    random = np.random.default_rng(seed)
    found = 0
    for _ in range(starts):
        axis = random.normal(size=3)
        start = turned(right, source.mean(axis=0), axis / np.linalg.norm(axis), degrees)
        result = hybrid.register_clouds(source, target, hybrid.RegistrationOptions(start=start)).T_target_source
        error = result.between(right).log()
        found += np.degrees(np.linalg.norm(error[3:])) < 0.5 and np.linalg.norm(result.translation - right.translation) < 0.1
    print(f"{found} of {starts}")


if __name__ == "__main__":
    main()
