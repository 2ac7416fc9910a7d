# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""A user-defined factor: the distance of a robot to a wall, first without derivatives, then with them."""

import hybrid
import numpy as np


class Wall(hybrid.Factor):
    """The distance [m] from a robot to the wall n' p = d."""

    def __init__(self, pose, normal, d, distance, sigma):
        super().__init__([pose], [hybrid.SE2], hybrid.Noise.isotropic(1, sigma))
        self.normal, self.d, self.distance = np.asarray(normal), d, distance

    def residual(self, pose):
        return [self.d - self.normal @ pose.translation - self.distance]


class DerivedWall(Wall):
    def jacobians(self, pose):
        by_translation = -self.normal @ pose.rotation.matrix()  # a tangent moves the robot in its own frame
        return [np.append(by_translation, 0.0)[None, :]]


for wall in (Wall, DerivedWall):
    graph = hybrid.HybridGraph()
    graph.add(hybrid.Prior("x0", hybrid.SE2(), hybrid.Noise.isotropic(3, 1.0)))
    graph.add(wall("x0", [1.0, 0.0], 5.0, 4.0, 0.01))
    result = hybrid.levenberg_marquardt(graph, hybrid.Estimate({"x0": hybrid.SE2(0.3, 0.1, 0.2)}))
    print(f"{wall.__name__}: x = {result.values['x0'].x:.4f} m after {result.report.iterations} iterations")
    assert abs(result.values["x0"].x - 1) < 0.01
