# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Rotations are quaternions (x, y, z, w), and poses are (position, rotation)."""

import math


def quaternion_of(q):
    """Of length 1, or 0."""
    q = q["x"], q["y"], q["z"], q["w"]
    return tuple(x / (math.hypot(*q) or 1.0) for x in q)


def angles_of(q):
    """Yaw, pitch and roll [rad]."""
    x, y, z, w = q
    pitch = math.asin(max(-1.0, min(1.0, 2 * (w * y - z * x))))
    return (math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)), pitch,
            math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y)))


def product(p, q):
    (a, b, c, w), (x, y, z, v) = p, q
    return (w * x + a * v + b * z - c * y, w * y - a * z + b * v + c * x, w * z + a * y - b * x + c * v,
            w * v - a * x - b * y - c * z)


def rotated(q, p):
    inverse = (-q[0], -q[1], -q[2], q[3])
    return product(product(q, (*p, 0.0)), inverse)[:3]


def composed(first, second):
    """Poses (position, rotation): that of c in a, of b in a and c in b."""
    (p, q), (t, r) = first, second
    return tuple(a + b for a, b in zip(p, rotated(q, t))), product(q, r)
