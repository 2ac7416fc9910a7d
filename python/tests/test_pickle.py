# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Factors and graphs in pickles."""

import copy
import pickle

import hybrid as h
import numpy as np
import pytest

RNG = np.random.default_rng(7)
HUBER = h.Loss.huber(1.2)
T2, T3 = h.SE2(0.1, -0.2, 0.3), h.SE3([0.1, 0.2, 0.3], h.SO3.exp([0.3, -0.1, 0.2]))


def noise(n):
    """Noise with correlations."""
    A = RNG.normal(size=(n, n))
    return h.Noise.from_covariance(A @ A.T + 0.1 * np.eye(n))



FACTORS = [
    h.Prior("x0", h.SO2.exp([0.3]), noise(1)), h.Prior("x0", T2, noise(3), HUBER), h.Prior("x0", h.SO3.exp([0.1, 0.2, 0.3]), noise(3)),
    h.Prior("x0", T3, noise(6)), *[h.Prior("v0", RNG.normal(size=n), noise(n)) for n in (1, 2, 3, 4, 5, 6, 8)],
    h.Between("x0", "x1", h.SO2.exp([0.3]), noise(1)), h.Between("x0", "x1", T2, noise(3), h.Loss.cauchy()),
    h.Between("x0", "x1", h.SO3.exp([0.1, 0.2, 0.3]), noise(3)), h.Between("x0", "x1", T3, noise(6)),
    *[h.Between("v0", "v1", RNG.normal(size=n), noise(n)) for n in (1, 2, 3, 5)],
    h.BetweenSE2("x0", "x1", T2, noise(3)),
    h.BearingRange("x0", "l0", [3.0, 0.2], noise(2), T2, HUBER), h.BearingRange("x0", "l0", [3.0, 0.2, 0.1], noise(3), T3),
    h.Bearing("x0", "l0", [0.2], noise(1), T2), h.Bearing("x0", "l0", [0.2, 0.1], noise(2), T3),
    h.Position("x0", [1.0, 2.0], noise(2), [0.3, 0.4]), h.Position("x0", [1.0, 2.0, 3.0], noise(3), [0.3, 0.4, 0.5]),
    *[h.Range("x0", "l0", 3.0, noise(1), types, HUBER)
      for types in ((h.SE2, 2), (h.SE2, h.SE2), (2, 2), (h.SE3, 3), (h.SE3, h.SE3), (3, 3))],
    h.LinearFactor([("v0", RNG.normal(size=(3, 2))), ("v1", RNG.normal(size=(3, 4)))], RNG.normal(size=3), noise(3)),
    h.Projection("x0", "l0", "c0", [320.0, 240.0], noise(2)),
    h.Inflated(h.Between("x0", "x1", T2, noise(3)), 1e4),
    h.SteadyMotion("x0", "x1", "x2", noise(2)), h.SteadyMotion("x0", "x1", "x2", noise(3)),
    h.SoftMixture([(h.Prior("v0", [1.0, 2.0], noise(2)), 0.3), (h.Prior("v0", [3.0, 2.0], noise(2)), 0.7)], 0.5),
]


def value(type_):
    if isinstance(type_, int):
        return RNG.normal(size=type_) + 2.0
    return type_.exp(0.4 * RNG.normal(size=len(type_().log())))


def again(thing):
    return pickle.loads(pickle.dumps(thing))


@pytest.mark.parametrize("factor", FACTORS, ids=lambda factor: repr(factor))
def test_a_factor_comes_back(factor):
    made = again(factor)
    assert made.keys == factor.keys and made.types == factor.types and made.name == factor.name
    assert made.log_normalizer == pytest.approx(factor.log_normalizer, rel=1e-12, abs=1e-12)
    for _ in range(3):
        values = h.Values({key: value(type_) for key, type_ in zip(factor.keys, factor.types)})
        assert made.cost(values) == pytest.approx(factor.cost(values), rel=1e-11)
        for a, b in zip(made.linearize(values), factor.linearize(values)):
            np.testing.assert_allclose(a, b, rtol=1e-10, atol=1e-10 * abs(b).max())
    assert copy.deepcopy(factor) is factor


class Wall(h.Factor):
    """A factor in Python with a rule of its own for pickle."""

    def __init__(self, pose, distance):
        super().__init__([pose], [h.SE2], h.Noise.isotropic(1, 0.1))
        self.distance = distance

    def residual(self, pose):
        return [5.0 - pose.x - self.distance]

    def __reduce__(self):
        return Wall, (self.keys[0], self.distance)


class Plain(h.Factor):
    def residual(self, pose):
        return [pose.x]


def world():
    key, switch = h.DiscreteKey("c0", 3), h.DiscreteKey("d0", 2)
    chain = [h.Prior("x0", h.SE2(), noise(3)), h.Between("x0", "x1", T2, noise(3)), Wall("x1", 4.5)]
    return h.HybridGraph([
        *chain, h.Prior("l0", [2.0, 1.0], noise(2)),
        h.prior_table(switch, [0.9, 0.1]), h.conditional_table(key, [switch], RNG.dirichlet([1, 1, 1], size=2)),
        h.OutlierMixture(switch, h.Between("x0", "x1", h.SE2(3, 0, 0), noise(3)), h.Inflated(chain[1], 1e7)),
        h.Mixture([switch], [(Wall("x1", 4.0), 0.5), (None, 3.0)]),
        h.SemanticBearingRange("x1", "l0", key, [2.0, 0.3], noise(2), [0.2, 0.5, 0.3]),
    ])


def test_a_graph_comes_back_with_the_same_solution():
    graph = world()
    made = again(graph)
    assert repr(made) == repr(graph)
    initial = h.Estimate({"x0": h.SE2(), "x1": h.SE2(0.5, 0, 0), "l0": [2.0, 1.0]}, {"c0": 0, "d0": 0})
    a, b = (h.alternate(g, initial) for g in (graph, made))
    assert a.estimate.assignment == b.estimate.assignment
    for key, expected in a.estimate.values.items():
        np.testing.assert_allclose(getattr(b.estimate.values[key], "storage", b.estimate.values[key]),
                                   getattr(expected, "storage", expected), rtol=0, atol=1e-9)
    for assignment in ({"c0": c, "d0": d} for c in range(3) for d in range(2)):
        assert h.objective(made, a.estimate.values, assignment) == pytest.approx(h.objective(graph, a.estimate.values, assignment), rel=1e-11)
    walls = [factor for factor in made.continuous if isinstance(factor, Wall)]
    assert [wall.distance for wall in walls] == [4.5]


def test_impossible_values_stay_impossible():
    table = again(h.potential_table([h.DiscreteKey("a1", 2), h.DiscreteKey("b1", 2)], [[1.0, 0.0], [0.5, 0.5]]))
    assert table.costs.tolist() == [[0.0, np.inf], [-np.log(0.5), -np.log(0.5)]]
    assert again(h.DiscreteKey("a1", 4)) == h.DiscreteKey("a1", 4)


def test_a_factor_that_cannot_be_kept_is_named():
    factor = Plain(["x3"], [h.SE2], h.Noise.isotropic(1, 0.1))
    for thing in (factor, h.HybridGraph([h.Prior("x3", h.SE2(), noise(3)), factor]), h.Inflated(factor, 2.0)):
        with pytest.raises(TypeError, match=r"<Plain (of|on|over)?.*x3.*> cannot be pickled: define __reduce__ in the class, such as `return Plain, "):
            pickle.dumps(thing)
    assert copy.deepcopy(h.HybridGraph([factor])).continuous[0] is factor


def test_marginals_are_factorised_again():
    graph = h.HybridGraph([h.Prior("x0", T2, noise(3)), h.Between("x0", "x1", T2, noise(3)), h.Between("x5", "x6", T2, noise(3))])
    marginals = h.ContinuousMarginals(graph, {"x0": T2, "x1": T2 * T2, "x5": T2, "x6": T2}, threads=1)
    made = again(marginals)
    np.testing.assert_allclose(made.joint_covariance(["x1", "x0"]), marginals.joint_covariance(["x1", "x0"]), rtol=1e-11)
    assert made.under_constrained == marginals.under_constrained == [h.Key("x5"), h.Key("x6")]
    assert copy.copy(marginals) is copy.deepcopy(marginals) is marginals


def test_a_pose_graph_comes_back(tmp_path):
    lines = ["VERTEX_SE2 0 0 0 0", "VERTEX_SE2 1 1 0 0.1", "VERTEX_XY 7 2 1", "FIX 0",
             "EDGE_SE2 0 1 1 0 0.1 100 3 0 100 0 400", "EDGE_SE2_XY 0 7 2 1 10 1 10"]
    (tmp_path / "a.g2o").write_text("\n".join(lines) + "\n")
    graph = h.read_graph(str(tmp_path / "a.g2o"))
    for i, made in enumerate((again(graph), copy.copy(graph), copy.deepcopy(graph))):
        h.write_g2o(str(tmp_path / f"{i}.g2o"), made)
        h.write_g2o(str(tmp_path / "as_it_is.g2o"), graph)
        a, b = ((tmp_path / name).read_text().split() for name in (f"{i}.g2o", "as_it_is.g2o"))
        assert len(a) == len(b)
        for x, y in zip(a, b):
            assert x == y or float(x) == pytest.approx(float(y), rel=1e-12)
    made = copy.deepcopy(graph)
    made.add_edge("x1", "x2", h.SE2(1, 0, 0), h.Noise.isotropic(3, 0.1))
    assert (made.edge_count, graph.edge_count) == (3, 2)
