# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Values, graphs and estimates as Python's containers; what reports show; mistakes told by name."""

import copy
import math
import pickle

import hybrid as h
import numpy as np
import pytest

NOISE = h.Noise.isotropic(3, 0.1)
VALUES = h.Values({"x0": h.SE2(1, 2, 3), "l0": [4.0, 5.0], "x1": h.SE3([1, 2, 3], h.SO3.exp([0.1, 0.2, 0.3]))})


def same(a, b):
    assert [str(key) for key in a] == [str(key) for key in b]
    for key, value in a.items():
        np.testing.assert_array_equal(getattr(value, "storage", value), getattr(b[key], "storage", b[key]))


def chain():
    graph = h.HybridGraph()
    graph.add([h.Prior("x0", h.SE2(), NOISE), h.Between("x0", "x1", h.SE2(1, 0, 0), NOISE)])
    return graph, h.Values({"x0": h.SE2(), "x1": h.SE2(2, 0, 0)})


def test_values_are_iterated_in_the_order_of_insertion():
    assert [str(key) for key in VALUES] == ["x0", "l0", "x1"]
    assert {str(key): type(value) for key, value in VALUES.items()} == {"x0": h.SE2, "l0": np.ndarray, "x1": h.SE3}
    assert [str(key) for key, _ in VALUES.items("x")] == ["x0", "x1"]
    same(h.Values(dict(VALUES.items())), VALUES)


def test_copies_and_pickles_are_equal_and_apart():
    for made in (copy.copy(VALUES), copy.deepcopy(VALUES), pickle.loads(pickle.dumps(VALUES))):
        same(made, VALUES)
        made["l0"] = [0.0, 0.0]
        assert list(VALUES["l0"]) == [4, 5]
    assignment = h.Assignment({"d1": 2, "c0": 1})
    assert [str(key) for key in assignment] == ["c0", "d1"]
    assert [(str(key), value) for key, value in assignment.items()] == [("c0", 1), ("d1", 2)]
    assert copy.deepcopy(assignment) == pickle.loads(pickle.dumps(assignment)) == assignment
    estimate = h.Estimate(VALUES, assignment)
    for made in (copy.deepcopy(estimate), pickle.loads(pickle.dumps(estimate))):
        same(made.values, VALUES)
        assert made.assignment == assignment
        made.values["l0"] = [0.0, 0.0]
        assert list(estimate.values["l0"]) == [4, 5]


def test_a_graph_takes_lists_and_is_iterated():
    graph = h.HybridGraph()
    factors = [h.Prior("x0", h.SE2(), NOISE), h.prior_table(h.DiscreteKey("d0", 2), [0.5, 0.5])]
    handles = graph.add(factors + [h.OutlierMixture(h.DiscreteKey("d0", 2), factors[0], h.Inflated(factors[0], 1e4))])
    assert len(handles) == 3 and all(handle in graph for handle in handles)
    assert [type(factor) for factor in graph] == [type(factors[0]), h.Table, h.HybridFactor]
    assert repr(graph) == "<HybridGraph of 1 continuous, 1 discrete and 1 hybrid factors>"
    assert repr(h.HybridGraph(factors)) == "<HybridGraph of 1 continuous, 1 discrete and 0 hybrid factors>"
    assert repr(h.HybridGraph(graph)) == repr(graph) and h.HybridGraph(graph).hybrid == graph.hybrid
    other = copy.deepcopy(graph)
    other.remove(handles[0])
    assert (len(graph), len(other)) == (3, 2)
    delta = h.Delta()
    delta.add(factors)
    delta.values = {"x0": h.SE2()}
    assert h.IncrementalSmoother().update(delta).ok


def test_solvers_take_values_alone():
    graph, values = chain()
    expected = h.levenberg_marquardt(graph, h.Estimate(values)).values
    for initial in (values, dict(values.items())):
        same(h.levenberg_marquardt(graph, initial).values, expected)
        same(h.alternate(graph, initial).estimate.values, expected)
    a, b = (h.ContinuousMarginals(graph, e).covariance("x1") for e in (expected, h.Estimate(expected)))
    np.testing.assert_array_equal(a, b)


def test_reports_show_their_fields():
    graph, values = chain()
    result = h.levenberg_marquardt(graph, values)
    assert repr(result.report).startswith("<SolverReport status=CONVERGED iterations=")
    assert "<SolverReport" in repr(result) and "<Values of 2 variables>" in repr(result)
    assert "relative_decrease=1e-" in repr(h.SolverOptions())
    assert "ok=True" in repr(h.IncrementalSmoother().update(h.Delta()))
    for name in h.__all__:
        cls = getattr(h, name)
        if isinstance(cls, type) and name.endswith(("Report", "Result", "Options", "Status")):
            assert cls.__repr__ is not object.__repr__, name


def add_edges(*edges, values=None):
    graph = h.PoseGraph()
    if values is not None:
        graph.values = values
    for start, end, measured in edges:
        size = len(measured) if isinstance(measured, list) else 3 if isinstance(measured, h.SE2) else 6
        graph.add_edge(start, end, measured, h.Noise.isotropic(size, 0.1))


@pytest.mark.parametrize("call, message", [
    (lambda: h.Prior("X", h.SE2(), NOISE), "a key is a letter and a number, such as 'x3'; got 'X'"),
    (lambda: h.Prior(1, h.SE2(), NOISE), "a key is a letter and a number, such as 'x3'; got 1"),
    (lambda: h.Between("x0", np.int64(7), h.SE2(), NOISE), "such as 'x3'; got 7"),
    (lambda: VALUES["pose"], "got 'pose'"),
    (lambda: "pose" in VALUES, "got 'pose'"),
    (lambda: h.DiscreteKey(0, 2), "got 0"),
    (lambda: h.Values({"x0": h.SE2(), "pose": h.SE2()}), "got 'pose'"),
    (lambda: h.Estimate({"x0": h.SE2(math.nan, 0, 0)}, {}), "initial value of x0 is not finite"),
    (lambda: h.levenberg_marquardt(h.HybridGraph(), {"x7": [math.inf]}), "initial value of x7 is not finite"),
    (lambda: h.Estimate({}, {"d": 1}), "got 'd'"),
    (lambda: h.Estimate({}, {"d0": 1.5}), "the value of discrete variable d0 is a whole number of at least 0; got 1.5"),
    (lambda: h.Estimate({}, {"d0": -1}), "the value of discrete variable d0 is a whole number of at least 0; got -1"),
    (lambda: h.Assignment({"d0": "a"}), "got 'a'"),
    (lambda: h.Key("landmark", 1), "such as Key('x', 3); its letter is 'landmark'"),
    (lambda: h.Key("x1", 2), "its letter is 'x1'"),
    (lambda: h.Key("x", 2**56), "the number of a key is below 2^56 = 72057594037927936; got 'x72057594037927936'"),
    (lambda: h.Key("x99999999999999999999999"), "the number of a key is below 2^56"),
    (lambda: add_edges(("x0", "x0", h.SE2())), "edge from x0 to x0: x0 is both its ends"),
    (lambda: add_edges(("x0", "x1", h.SE2()), ("x1", "x2", h.SE3())), "edge from x1 to x2: x1 is in the plane by other edges"),
    (lambda: add_edges(("x0", "l1", [1.0, 2.0, 3.0]), ("x4", "x5", h.SE2())), "edge from x4 to x5: the other edges are in space"),
    (lambda: add_edges(("x0", "x1", h.SE2()), values=VALUES), "edge from x0 to x1: x1 is SE3, not SE2"),
    (lambda: h.PoseGraph().add_edge("x0", "x1", h.SE3(), NOISE), "its noise has 3 dimensions, and its measurement 6"),
    (lambda: h.ContinuousMarginals(*chain()).joint_covariance(["x0", "y"]), "got 'y'"),
])
def test_a_mistake_is_told_by_name(call, message):
    with pytest.raises(h.Error) as raised:
        call()
    assert message in str(raised.value) and "overload" not in str(raised.value)


@pytest.mark.parametrize("value, message", [
    (h.SE2(math.nan, 0, 0), "its x is nan"), (h.SE2(0, math.inf, 0), "its y is infinite"), (h.SE2(0, 0, math.nan), "its angle is nan"),
    (h.SE3([1, 2, math.nan], h.SO3()), "its z is nan"), ([1.0, math.nan], "its number 2 of 2 is nan"),
])
def test_a_value_that_is_not_finite_is_refused_by_name(value, message):
    values = h.Values()
    with pytest.raises(h.Error, match=f"initial value of x0 is not finite: {message}"):
        values["x0"] = value
    with pytest.raises(h.Error, match=f"initial value of x0 is not finite: {message}"):
        values.insert("x0", value)
    good = [1.0, 2.0] if isinstance(value, list) else type(value)()
    values["x0"] = good
    with pytest.raises(h.Error, match=f"^value of x0 is not finite: {message}"):
        values["x0"] = value
    assert values == h.Values({"x0": good})


def test_values_are_like_a_dict():
    values = h.Values({"x0": h.SE2(1, 2, 3), "l0": [4.0, 5.0]})
    assert [type(value) for value in values.values()] == [h.SE2, np.ndarray] and list(values["l0"]) == [4, 5]
    assert values.get("x0").x == 1 and values.get("x7") is None and values.get("x7", 3) == 3
    with pytest.raises(h.Error, match="got 'pose'"):
        values.get("pose")
    other = h.Values({"l0": [4.0, 5.0], "x0": h.SE2(1, 2, 3)})
    assert values == other and not values != other and values != h.Values() and values != {"x0": 1} and values != 3
    other.update({"l0": [0.0, 1.0], "x1": h.SE2()})
    assert len(other) == 3 and list(other["l0"]) == [0, 1] and values != other
    assert h.Values({"x0": [1.0, 0.0]}) != h.Values({"x0": h.SO2()})


def test_a_graph_has_places_and_grows():
    graph, _ = chain()
    assert graph[0].name == "prior" and graph[-1] is graph[1] and len(graph[:]) == 2 and graph[1:][0] is graph[1]
    with pytest.raises(IndexError):
        graph[2]
    same_graph = graph
    graph += h.Between("x1", "x2", h.SE2(), NOISE)
    graph += [h.Between("x2", "x3", h.SE2(), NOISE), h.prior_table(h.DiscreteKey("d0", 2), [0.5, 0.5])]
    assert graph is same_graph and len(graph) == 5 and isinstance(graph[4], h.Table)
    with pytest.raises(TypeError, match="not a text"):
        graph.add("x0")
    with pytest.raises(TypeError, match="not a text"):
        h.Delta().add("x0")


def test_a_pose_graph_is_iterated():
    ring = h.PoseGraph()
    ring.add_edge("x0", "l1", [1.0, 2.0], h.Noise.isotropic(2, 0.1))
    ring.add_edge("x0", "x1", h.SE2(1, 0, 0), NOISE)
    assert len(ring) == 2 and [str(edge.to_key) for edge in ring] == ["x1", "l1"]
    assert repr(ring) == "<PoseGraph of 2 edges and 0 initial values>"


def test_a_graph_is_certified():
    graph, values = chain()
    estimate = h.levenberg_marquardt(graph, values).values
    assert h.certify(graph, estimate).cost == h.certify(graph.continuous, estimate).cost
    assert h.certify(graph, estimate).verified
    graph += h.prior_table(h.DiscreteKey("d0", 2), [0.5, 0.5])
    with pytest.raises(h.Error, match="of continuous factors"):
        h.certify(graph, estimate)


def test_what_holds_much_shows_little():
    graph, values = chain()
    assert repr(h.ContinuousMarginals(graph, values).all()) == "<Covariances of 2 variables>"
    smoother, change = h.IncrementalSmoother(), h.Delta()
    change.add(graph)
    change.values = values
    smoother.update(change)
    assert repr(smoother) == "<IncrementalSmoother of 2 variables and 2 factors>"


def test_comparing_a_key_with_other_things_is_no_mistake():
    key = h.Key("x1")
    assert key == "x1" and key != "X" and key != 1 and key != None and key not in [2, "y", h.Key("x2")]  # noqa: E711


def test_read_g2o_gives_what_a_solver_takes(tmp_path):
    ring = h.PoseGraph()
    for i in range(12):
        ring.add_edge(f"x{i}", f"x{(i + 1) % 12}", h.SE2(1, 0, np.pi / 6), NOISE)
    h.write_g2o(str(tmp_path / "ring.g2o"), ring)
    graph, initial = h.read_g2o(tmp_path / "ring.g2o")
    assert len(initial) == 12 and len(graph) == 13  # and a prior of the first pose
    result = h.levenberg_marquardt(graph, initial)
    assert result.report.status == h.SolverStatus.CONVERGED
    with pytest.raises(h.Error, match=r"none\.g2o"):
        h.read_g2o(tmp_path / "none.g2o")
