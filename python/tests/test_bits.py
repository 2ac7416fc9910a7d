# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""The problems of reference.cpp, stated in Python: all results are equal bit by bit."""

import os
import subprocess

import hybrid as h
import numpy as np
import pytest


def numbers(text):
    name, *values = text.split()
    return name, [float.fromhex(value) for value in values]


@pytest.fixture(scope="module")
def reference():
    out = subprocess.run([os.environ["HYBRID_REFERENCE"]], capture_output=True, text=True, check=True).stdout
    return [numbers(line) for line in out.splitlines()]


def storage(value):
    return list(value.storage if hasattr(value, "storage") else value)


def rows_of(values):
    return [(str(key), storage(values[key])) for key in values.keys()]


def world():
    motion = h.Noise.diagonal([0.05, 0.04, 0.01])
    polar = h.Noise.diagonal([0.1, 0.02])
    graph, initial = h.HybridGraph(), h.Estimate()
    graph.add(h.Prior("x0", h.SE2(), h.Noise.isotropic(3, 0.001)))
    pose = h.SE2()
    initial.values["x0"] = pose
    for i in range(8):
        step = h.SE2(1.0 + 0.01 * i, 0.02 * i, 0.0 if i % 2 == 0 else 1.55)
        graph.add(h.BetweenSE2(f"x{i}", f"x{i + 1}", step, motion))
        pose = pose * step * h.SE2(0.05, -0.03, 0.04)
        initial.values[f"x{i + 1}"] = pose
    for k in range(3):
        kind = h.DiscreteKey(f"s{k}", 2)
        initial.values[f"l{k}"] = [1.0 + k, 2.0]
        initial.assignment[kind.key] = 0
        for i in range(k, 9, 2):
            z = [2.0 + 0.1 * i, 0.5 - 0.2 * k]
            graph.add(h.SemanticBearingRange(f"x{i}", f"l{k}", kind, z, polar, [0.3 + 0.1 * k, 0.4]))
    initial.assignment["d0"] = 0
    loop = h.Between("x0", "x8", h.SE2(0.1, 0.2, 0.05), motion)
    graph.add(h.OutlierMixture(h.DiscreteKey("d0", 2), loop, h.Inflated(loop, 1e7), 0.9, 0.1))
    return graph, initial


def batch(graph, initial):
    result = h.alternate(graph, initial)
    estimate = result.estimate
    return [
        *rows_of(estimate.values),
        ("objective", [result.report.objective, result.report.cost]),
        ("covariance", list(h.ContinuousMarginals(graph, estimate).covariance("x8").flatten("F"))),
        ("evidence", [h.log_evidence(graph, estimate).log]),
        ("posterior", list(h.posterior(graph, estimate, ["d0"])["d0"].p)),
        ("classes", list(h.discrete_marginals(graph, estimate.values)["s2"])),
    ]


def online(graph, initial):
    smoother, delta = h.IncrementalSmoother(), h.Delta()
    for factor in graph.continuous + graph.hybrid:
        delta.add(factor)
    delta.values = initial.values
    assert smoother.update(delta).ok
    rows = rows_of(smoother.values())
    smoother.converge()
    joint = smoother.joint_covariance(["x3", "l1"])
    return [*rows, *rows_of(smoother.values()), ("joint", list(joint.flatten("F")))]


def robust():
    graph, noise = h.PoseGraph(), h.Noise.isotropic(6, 0.02)
    for i in range(12):
        step = h.SE3([1.0, 0.01 * i, 0.0], h.SO3.exp([0.01, 0.02, 0.5]))
        graph.add_edge(f"x{i}", f"x{i + 1}", step, noise)
    start = h.initialize_from_odometry(graph)
    across = start["x1"].between(start["x11"]) * h.SE3([0.01, 0.0, 0.02], h.SO3())
    graph.add_edge("x1", "x11", across, noise)
    graph.add_edge("x0", "x6", h.SE3([9.0, 9.0, 9.0], h.SO3()), noise)
    problem = h.to_robust_problem(graph, start)
    rows = []
    for result in (h.select_closures(problem), h.solve_robust(problem, "gnc")):
        rows += rows_of(result.values)
        rows.append(("robust", [result.objective, result.cost, *result.accepted.astype(float)]))
        bound = h.bound_objective(problem, result.values, result.accepted, h.MixtureOptions(), 20)
        rows.append(("bound", [bound.bound, bound.gap, bound.solves, bound.complete]))
        found = h.certify(problem.trusted + problem.closures[:1], result.values)
        rows.append(("certificate", [found.min_eigenvalue, found.relative_gap, found.cost, found.verified]))
    return rows


def clouds():
    T = h.SE3([0.05, -0.02, 0.03], h.SO3.exp([0.02, 0.01, -0.03]))
    i, j = np.meshgrid(range(30), range(30), indexing="ij")
    x, y = 0.1 * i.ravel(), 0.1 * j.ravel()
    source = np.column_stack([x, y, 0.125 * (x * x - y) + 0.25 * x * y * y])
    result = h.register_clouds(source, T * source)
    return [("T", storage(result.T_target_source)), ("rms", [result.rms])]


def test_results_are_those_of_the_library_to_the_last_bit(reference):
    graph, initial = world()
    found = [*batch(graph, initial), *online(graph, initial), *robust(), *clouds()]
    assert len(found) == len(reference)
    for ours, theirs in zip(found, reference):
        assert ours[0] == theirs[0]
        assert [x.hex() for x in map(float, ours[1])] == [x.hex() for x in theirs[1]], ours[0]
