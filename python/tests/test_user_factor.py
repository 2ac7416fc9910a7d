# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Factors written in Python."""

import gc
import threading
import warnings
import weakref

import hybrid as h
import numpy as np
import pytest

UNIT = h.Noise.isotropic(1, 1.0)


class Wall(h.Factor):
    """The distance of a robot from the wall x = 5 m."""

    def __init__(self, pose, distance, sigma=0.01, loss=h.Loss.none()):
        super().__init__([pose], [h.SE2], h.Noise.isotropic(1, sigma), loss)
        self.distance = distance

    def residual(self, pose):
        return [5.0 - pose.x - self.distance]


class FastWall(Wall):
    def jacobians(self, pose):
        return [[[-np.cos(pose.angle), np.sin(pose.angle), 0.0]]]


class Same(h.Factor):
    """Between written in Python, for any group."""

    def __init__(self, a, b, measured, noise):
        super().__init__([a, b], [type(measured)] * 2, noise)
        self.measured = measured

    def residual(self, a, b):
        return self.measured.between(a.between(b)).log()


def solve(factor, *others):
    graph = h.HybridGraph()
    graph.add(h.Prior("x0", h.SE2(), h.Noise.isotropic(3, 1.0)))
    for each in (factor, *others):
        graph.add(each)
    return h.levenberg_marquardt(graph, h.Estimate({"x0": h.SE2(0.3, 0.1, 0.2)}))


@pytest.mark.parametrize("wall", [Wall, FastWall])
def test_a_factor_of_ones_own_is_solved(wall):
    result = solve(wall("x0", 4.0))
    assert result.report.status == h.SolverStatus.CONVERGED
    assert result.values["x0"].x == pytest.approx(1.0, abs=1e-3)


def test_jacobians_by_differences_are_those_given():
    values = h.Values({"x0": h.SE2(0.3, -0.2, 0.7)})
    numeric, given = (wall("x0", 4.0, 0.1, h.Loss.huber(1.0)).linearize(values) for wall in (Wall, FastWall))
    np.testing.assert_allclose(numeric[0], given[0], rtol=0, atol=0)
    np.testing.assert_allclose(numeric[1], given[1], rtol=1e-8, atol=1e-8)


@pytest.mark.parametrize("a, b, z", [
    (h.SO2(0.3), h.SO2(1.0), h.SO2(0.5)),
    (h.SE2(1, 2, 3), h.SE2(2, 2, 2), h.SE2(0.5, 0.4, -0.8)),
    (h.SO3.exp([0.1, 0.2, 0.3]), h.SO3.exp([0.3, 0.1, -0.3]), h.SO3.exp([0.1, -0.2, -0.3])),
    (h.SE3([1, 2, 3], h.SO3()), h.SE3([3, 2, 1], h.SO3.exp([0.1, 0.2, 0.3])), h.SE3([1, 1, -1], h.SO3())),
])
def test_it_is_the_factor_of_the_library(a, b, z):
    noise = h.Noise.diagonal(0.1 + 0.05 * np.arange(type(z).dim))
    values = h.Values({"x0": a, "x1": b})
    ours, theirs = Same("x0", "x1", z, noise), h.Between("x0", "x1", z, noise)
    assert ours.cost(values) == pytest.approx(theirs.cost(values), rel=1e-12)
    assert ours.log_normalizer == theirs.log_normalizer
    np.testing.assert_allclose(ours.linearize(values)[1], theirs.linearize(values)[1], rtol=1e-6, atol=1e-6)


def test_many_threads_find_the_same():
    noise = h.Noise.isotropic(3, 0.1)
    found = []
    for threads in (1, 2, 4):
        graph, start = h.HybridGraph(), h.Values()
        graph.add(h.Prior("x0", h.SE2(), noise))
        for i in range(200):
            graph.add(Same(f"x{i}", f"x{i + 1}", h.SE2(1, 0.1, 0.1), noise))
        graph.add(Same("x0", "x200", h.SE2(3, 1, 0.5), noise))
        for i in range(201):
            start[f"x{i}"] = h.SE2(0.9 * i, 0, 0.1 * i)
        options = h.SolverOptions(threads=threads, max_iterations=4)
        found.append(h.levenberg_marquardt(graph, h.Estimate(start), options).values.stack(start.keys()))
    np.testing.assert_array_equal(found[0], found[1])
    np.testing.assert_array_equal(found[0], found[2])


class Custom(Exception):
    pass


@pytest.mark.parametrize("solver", [
    lambda graph, estimate: h.alternate(graph, estimate),
    lambda graph, estimate: h.cost(graph, estimate.values),
    lambda graph, estimate: h.ContinuousMarginals(graph, estimate),
])
def test_what_it_raises_reaches_the_caller(solver):
    class Broken(Wall):
        def residual(self, pose):
            raise Custom("sensor", 7)

    graph = h.HybridGraph()
    graph.add(h.Prior("x0", h.SE2(), h.Noise.isotropic(3, 1.0)))
    graph.add(Broken("x0", 4.0))
    with pytest.raises(Custom) as caught:
        solver(graph, h.Estimate({"x0": h.SE2()}))
    assert caught.value.args == ("sensor", 7)


def test_a_smoother_is_as_it_was_where_a_factor_raises():
    class Broken(Wall):
        def residual(self, pose):
            raise Custom()

    smoother, delta = h.IncrementalSmoother(), h.Delta()
    delta.add(h.Prior("x0", h.SE2(1, 2, 0), h.Noise.isotropic(3, 1.0)))
    delta.values = h.Values({"x0": h.SE2()})
    smoother.update(delta)
    before, more = smoother.objective(), h.Delta()
    more.add(Broken("x0", 4.0))
    with pytest.raises(Custom):
        smoother.update(more)
    assert smoother.objective() == before
    assert len(smoother.graph()) == 1


@pytest.mark.parametrize("result, message", [
    ([1.0, 2.0], r"residual returned an array of shape \(2,\) instead of \(1,\)"),
    ("far", "residual returned no array of numbers"),
    (None, "residual returned"),
])
def test_a_wrong_residual_names_the_factor(result, message):
    class Odd(Wall):
        def residual(self, pose):
            return result

    with pytest.raises(h.Error, match="Odd factor on x0.*" + message):
        solve(Odd("x0", 4.0))


@pytest.mark.parametrize("result, message", [
    ([], "one for each variable"),
    ([[[1.0, 2.0]]], r"shape \(1, 2\) instead of \(1, 3\)"),
])
def test_wrong_jacobians_name_the_factor(result, message):
    class Odd(Wall):
        def jacobians(self, pose):
            return result

    with pytest.raises(h.Error, match="Odd factor on x0.*" + message):
        solve(Odd("x0", 4.0))


def test_a_class_without_residual_says_so():
    with pytest.raises(h.Error, match="has no method 'residual'"):
        solve(h.Factor(["x0"], [h.SE2], UNIT))


def test_a_residual_that_is_no_number_is_a_status():
    class Nan(Wall):
        def residual(self, pose):
            return [float("nan")]

    assert solve(Nan("x0", 4.0)).report.status == h.SolverStatus.NOT_FINITE


def test_keys_and_types_must_fit():
    for keys, types in ((["x0"], []), ([], []), (["x0"], ["SE2"]), (["x0"], [0])):
        with pytest.raises(h.Error, match="type"):
            h.Factor(keys, types, UNIT)


def test_the_graph_keeps_the_object_and_lets_it_go():
    graph = h.HybridGraph()
    wall = Wall("x0", 4.0)
    gone = weakref.ref(wall)
    handle = graph.add(wall)
    del wall
    gc.collect()
    assert gone() is not None
    assert graph.continuous == [gone()]
    graph.add(h.Prior("x0", h.SE2(), h.Noise.isotropic(3, 1.0)))
    assert h.alternate(graph, h.Estimate({"x0": h.SE2()})).estimate.values["x0"].x == pytest.approx(1, abs=1e-3)
    graph.remove(handle)
    gc.collect()
    assert gone() is None


def test_it_may_be_a_component_of_a_mixture():
    near, far = Wall("x0", 4.0, 0.5), Wall("x0", 1.0, 0.5)
    graph = h.HybridGraph()
    graph.add(h.Prior("x0", h.SE2(), h.Noise.isotropic(3, 0.5)))
    graph.add(h.Mixture([h.DiscreteKey("d0", 3)], [(near, 0.0), (far, 0.0), (None, 100.0)]))
    del near, far
    gc.collect()
    start = h.Estimate({"x0": h.SE2()}, {"d0": 1})
    assert h.alternate(graph, start).estimate.assignment["d0"] == 0


def test_a_factor_is_called_from_another_thread_of_python():
    """A Python thread runs a solver while the main thread waits for it."""
    found = []
    other = threading.Thread(target=lambda: found.append(solve(Wall("x0", 4.0)).values["x0"].x))
    other.start()
    other.join()
    assert found == [solve(Wall("x0", 4.0)).values["x0"].x]


class WrongSign(h.Factor):
    """Its derivative has the other sign."""

    def __init__(self, key="x0"):
        super().__init__([key], [h.SE2], h.Noise.isotropic(1, 0.1))

    def residual(self, pose):
        return [pose.x]

    def jacobians(self, pose):
        return [np.array([[-1.0, 0.0, 0.0]])]


class Jump(WrongSign):
    """Not smooth where it is asked."""

    def residual(self, pose):
        return [1.0 if pose.x > 1 else 0.0]


def test_derivatives_that_are_not_those_of_the_residual_are_told_of_once():
    values = h.Values({"x0": h.SE2(1, 0, 0)})
    with pytest.warns(RuntimeWarning, match=r"WrongSign.*jacobians has -1.* in row 0, column 0, where differences of residual give 1"):
        WrongSign().linearize(values)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        WrongSign().linearize(values)
        Jump().linearize(values)
