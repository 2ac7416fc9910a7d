# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""An odometry step and a loop closure that may be wrong."""

import hybrid
import numpy as np

noise = hybrid.Noise.isotropic(3, 0.1)
trusted = hybrid.DiscreteKey("d0", 2)  # 0: the loop closure is right, 1: it is an outlier

graph = hybrid.HybridGraph()
graph.add(hybrid.Prior("x0", hybrid.SE2(0, 0, 0), noise))
graph.add(hybrid.BetweenSE2("x0", "x1", hybrid.SE2(1, 0, 0), noise))
loop = hybrid.BetweenSE2("x0", "x1", hybrid.SE2(5, 0, 0), noise)
graph.add(hybrid.OutlierMixture(trusted, loop, hybrid.Inflated(loop, 1e4), 0.9, 0.1))

initial = hybrid.Estimate({"x0": hybrid.SE2(), "x1": hybrid.SE2(4, 0, 0)}, {"d0": 0})
best = hybrid.alternate(graph, initial).estimate
sigma = np.sqrt(hybrid.ContinuousMarginals(graph, best).covariance("x1")[0, 0])
false = hybrid.posterior(graph, best, ["d0"])["d0"].p[1]
print(f"x1 is at x = {best.values['x1'].x:.4f} m, sigma {sigma:.4f} m")
print(f"the closure is false with probability {false:.4f}")
assert false > 0.99
