# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""A robot drives a square twice; half of its loop closures are false."""

import math

import hybrid
import numpy as np

rng = np.random.default_rng(1)
sigmas = np.array([0.05, 0.05, 0.01])
noise = hybrid.Noise.diagonal(sigmas)
side = 10
truth = [hybrid.SE2()]
for i in range(8 * side):
    truth.append(truth[-1] * hybrid.SE2(1, 0, math.pi / 2 if i % side == side - 1 else 0))

graph = hybrid.PoseGraph()
measure = lambda a, b: truth[a].between(truth[b]) * hybrid.SE2.exp(sigmas * rng.normal(size=3))  # noqa: E731
for i in range(8 * side):
    graph.add_edge(f"x{i}", f"x{i + 1}", measure(i, i + 1), noise)
for i in range(0, 4 * side, 2):  # the second round closes loops with the first
    graph.add_edge(f"x{i}", f"x{i + 4 * side}", measure(i, i + 4 * side), noise)
graph = hybrid.add_false_closures(graph, 0.5, seed=2)

start = hybrid.initialize_from_odometry(graph)
problem = hybrid.to_robust_problem(graph, start)
right = np.arange(len(problem.closures)) < 2 * side
for method in ("lm", "gnc", "selection"):
    result = hybrid.solve_robust(problem, method)
    error = np.mean([np.linalg.norm(result.values[f"x{i}"].translation - T.translation) for i, T in enumerate(truth)])
    wrong = np.sum(result.accepted != right)
    print(f"{method}: mean error {error:.3f} m, {wrong} of {len(right)} closures decided wrongly")
assert wrong == 0 and error < 0.5
