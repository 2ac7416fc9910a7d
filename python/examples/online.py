# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""A growing graph: poses, a landmark with an unreliably detected class, and a measurement that is removed again."""

import math

import hybrid

smoother = hybrid.IncrementalSmoother()
motion, polar = hybrid.Noise.diagonal([0.1, 0.1, 0.02]), hybrid.Noise.diagonal([0.1, 0.03])
kind = hybrid.DiscreteKey("s0", 2)  # tree or car
for i in range(10):
    delta = hybrid.Delta()
    delta.values = hybrid.Values({f"x{i}": hybrid.SE2(i, 0, 0)})
    if i == 0:
        delta.add(hybrid.Prior("x0", hybrid.SE2(), hybrid.Noise.isotropic(3, 0.01)))
        delta.values["l0"] = [5.0, 3.0]
    else:
        delta.add(hybrid.BetweenSE2(f"x{i - 1}", f"x{i}", hybrid.SE2(1, 0, 0), motion))
    seen = hybrid.SE2(i, 0, 0).inverse() * [5.0, 3.0]
    z = [math.hypot(*seen), math.atan2(seen[1], seen[0])]
    delta.add(hybrid.SemanticBearingRange(f"x{i}", "l0", kind, z, polar, [0.6, 0.4]))
    report = smoother.update(delta)
    assert report.ok, report.message

graph, estimate = smoother.graph(), smoother.estimate()
p = hybrid.discrete_marginals(graph, estimate.values)["s0"]
print(f"landmark at {smoother['l0']}, a tree with {p[0]:.3f}; objective {smoother.objective():.3f}")

undo = hybrid.Delta()
undo.remove = report.handles.hybrid  # the last sighting
smoother.update(undo)
print(f"without the last sighting: {len(smoother.graph())} factors")
assert p[0] > 0.95
