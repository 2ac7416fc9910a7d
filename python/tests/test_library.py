# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Each room of the library from Python: conversion of values, errors, and results of solvers."""

import copy
import math
import pickle

import hybrid as h
import numpy as np
import pytest


def test_keys():
    assert h.Key("x3") == h.Key("x", 3) != h.Key("x4")
    assert {h.Key("x3"): 1}[h.Key("x", 3)] == 1
    assert str(h.Key("l", 7)) == "l7"
    assert sorted([h.Key("x2"), h.Key("l9")])[0] == h.Key("l9")
    assert pickle.loads(pickle.dumps(h.Key("x3"))) == h.Key("x3")
    for text in ("", "x", "3", "x-1", "x1.5", "x1 "):
        with pytest.raises(h.Error, match="letter and a number"):
            h.Key(text)
    with pytest.raises(h.Error, match=r"below 2\^56"):
        h.Key("x72057594037927936")


@pytest.mark.parametrize("g, k", [
    (h.SO2(0.7), h.SO2(-2.0)),
    (h.SE2(1, 2, 0.7), h.SE2(-1, 0.5, 2.0)),
    (h.SO3.exp([0.1, 0.2, 0.3]), h.SO3.exp([0.3, -0.2, 0.1])),
    (h.SE3([1, 2, 3], h.SO3.exp([0.1, 0.2, 0.3])), h.SE3.exp([1, 0, 0, 0.5, 0.2, 0.1])),
])
def test_group_laws(g, k):
    close = lambda a, b: np.testing.assert_allclose(a, b, rtol=1e-12, atol=1e-12)  # noqa: E731
    group = type(g)
    close((g * k).matrix(), g.matrix() @ k.matrix())
    close((g * g.inverse()).matrix(), np.eye(len(g.matrix())))
    close(g.between(k).matrix(), (g.inverse() * k).matrix())
    close(group.exp(g.log()).matrix(), g.matrix())
    close(g.retract(g.local(k)).matrix(), k.matrix())
    v = 0.1 * np.arange(1, group.dim + 1)
    close((g * group.exp(v)).matrix(), (group.exp(g.adjoint() @ v) * g).matrix())
    points = np.arange(12.0).reshape(-1, 2 if group in (h.SO2, h.SE2) else 3)
    close((g * points)[1], g * points[1])
    close(pickle.loads(pickle.dumps(g)).storage, g.storage)
    assert g.log().shape == (group.dim,)


def test_constructors_of_groups():
    R = h.SO3.exp([0.3, 0.2, 0.1]).matrix()
    np.testing.assert_allclose(h.SO3.from_matrix(R).matrix(), R, atol=1e-15)
    np.testing.assert_allclose(h.SO3.from_quaternion([0, 0, 2, 2]).log(), [0, 0, math.pi / 2], atol=1e-15)
    T = h.SE3([1, 2, 3], h.SO3.from_matrix(R))
    np.testing.assert_allclose(h.SE3.from_matrix(T.matrix()).log(), T.log(), atol=1e-14)
    with pytest.raises(h.Error, match="4 numbers"):
        h.SE2.from_storage([1, 2, 3])


def test_values():
    values = h.Values({"x0": h.SE2(1, 2, 3), "l0": [4.0, 5.0]})
    values["x0"] = h.SE2(1, 1, 1)
    values.insert("x1", h.SE2())
    values["l0"] = np.array([6.0, 7.0])
    assert values["x0"].angle == 1 and list(values["l0"]) == [6, 7]
    assert [str(key) for key in values.keys("x")] == ["x0", "x1"] and len(values) == 3
    assert "l0" in values and "l1" not in values
    kept = copy.copy(values)
    del values["l0"]
    assert "l0" not in values and "l0" in kept
    with pytest.raises(h.Error, match="x0"):
        values.insert("x0", h.SE2())
    with pytest.raises(h.Error, match="SE2"):
        values["x0"] = [1.0, 2.0]
    with pytest.raises(h.Error, match="x9"):
        values["x9"]
    with pytest.raises(h.Error, match="finite"):
        values.insert("x9", h.SE2(math.nan, 0, 0))


def test_many_values_at_once():
    rows = np.random.default_rng(1).normal(size=(50, 7))
    rows[:, 3:] /= np.linalg.norm(rows[:, 3:], axis=1)[:, None]
    keys = [h.Key("x", i) for i in range(50)]
    values = h.Values()
    values.insert_stack(keys, h.SE3, rows)
    np.testing.assert_allclose(values.stack(keys), rows, rtol=1e-15)
    assert values.stack([]).shape == (0, 0)
    values.insert_stack(["l0"], 2, [[1.0, 2.0]])
    with pytest.raises(h.Error, match="50 x 4"):
        h.Values().insert_stack(keys, h.SE2, rows)
    with pytest.raises(h.Error, match="type"):
        values.stack(["x0", "l0"])


def test_noise_and_loss():
    covariance = np.array([[0.04, 0.01], [0.01, 0.09]])
    noise = h.Noise.from_covariance(covariance)
    np.testing.assert_allclose(noise.covariance, covariance, rtol=1e-14)
    np.testing.assert_allclose(h.Noise.from_information(np.linalg.inv(covariance)).covariance, covariance)
    assert noise.inflated(4.0).log_normalizer == pytest.approx(noise.log_normalizer + math.log(4))
    with pytest.raises(h.Error, match="positive"):
        h.Noise.isotropic(2, -1.0)
    with pytest.raises(h.Error):
        h.Noise.from_covariance([[1.0, 2.0], [2.0, 1.0]])
    assert h.Loss.huber(1.0).weight(4.0) == pytest.approx(0.5)


def test_settings_are_keywords():
    options = h.AlternatingOptions(max_iterations=3, continuous=h.SolverOptions(threads=1))
    assert options.continuous.threads == 1 and options.max_iterations == 3
    with pytest.raises(TypeError, match="SolverOptions has no field 'thread'"):
        h.SolverOptions(thread=1)
    with pytest.raises(TypeError):
        h.SolverOptions(threads="many")


def test_tables_are_arrays_without_a_copy():
    a, b = h.DiscreteKey("a0", 2), h.DiscreteKey("b0", 3)
    costs = np.arange(6.0).reshape(2, 3)
    table = h.Table([a, b], costs)
    np.testing.assert_array_equal(table.costs, costs)
    assert table.costs.base is not None and not table.costs.flags.writeable
    assert table.costs.ctypes.data == table.costs.ctypes.data
    assert table.cost({"a0": 1, "b0": 2}) == 5
    with pytest.raises(ValueError):
        table.costs[0, 0] = 1
    with pytest.raises(h.Error):
        h.Table([a], [1.0, 2.0, 3.0])


def test_discrete_inference_is_enumeration():
    rng = np.random.default_rng(3)
    a, b, c = (h.DiscreteKey(key, n) for key, n in (("a0", 2), ("b0", 3), ("c0", 4)))
    f, g = rng.random((2, 3)), rng.random((3, 4))
    tables = [h.potential_table([a, b], f), h.potential_table([b, c], g), h.prior_table(a, [0.3, 0.7])]
    joint = np.einsum("ab,bc,a->abc", f, g, [0.3, 0.7])
    best = np.unravel_index(joint.argmax(), joint.shape)
    solution = h.solve_discrete(tables)
    assert solution.exact and tuple(solution.assignment[key] for key in ("a0", "b0", "c0")) == best
    marginals = h.table_marginals(tables)
    np.testing.assert_allclose(marginals["b0"], joint.sum((0, 2)) / joint.sum(), rtol=1e-12)
    assert marginals.log_partition == pytest.approx(math.log(joint.sum()))


def test_exhaustive_and_alternation_agree():
    graph = h.HybridGraph()
    graph.add(h.Prior("x0", [0.0], h.Noise.isotropic(1, 1.0)))
    graph.add(h.Mixture([h.DiscreteKey("d0", 2)], [
        (h.Prior("x0", [5.0], h.Noise.isotropic(1, 0.5)), 0.0), (h.Prior("x0", [0.5], h.Noise.isotropic(1, 0.5)), 1.0)]))
    best = h.solve_exhaustive(graph, h.Values({"x0": [0.0]}))
    result = h.alternate(graph, h.Estimate({"x0": [0.0]}, {"d0": 0}))
    assert best.estimate.assignment["d0"] == result.estimate.assignment["d0"] == 1
    assert result.report.objective == pytest.approx(best.objective)
    assert [step.objective for step in result.report.half_steps] == sorted(
        (step.objective for step in result.report.half_steps), reverse=True)
    assert h.objective(graph, result.estimate.values, {"d0": 1}) == pytest.approx(best.objective)


def test_linear_factors_solve_normal_equations():
    rng = np.random.default_rng(5)
    A, B, b = rng.normal(size=(9, 4)), rng.normal(size=(9, 3)), rng.normal(size=9)
    graph = h.HybridGraph()
    graph.add(h.LinearFactor([("u0", A), ("v0", B)], b, h.Noise.unit(9)))
    result = h.dogleg(graph, h.Estimate({"u0": np.zeros(4), "v0": np.zeros(3)}))
    expected = np.linalg.lstsq(np.hstack([A, B]), b, rcond=None)[0]
    np.testing.assert_allclose(np.hstack([result.values["u0"], result.values["v0"]]), expected, rtol=1e-9)
    marginals = h.ContinuousMarginals(graph, h.Estimate(result.values))
    J = np.hstack([A, B])
    np.testing.assert_allclose(marginals.joint_covariance(["u0", "v0"]), np.linalg.inv(J.T @ J), rtol=1e-9)
    blocks = marginals.all()
    np.testing.assert_allclose(blocks["v0"], np.linalg.inv(J.T @ J)[4:, 4:], rtol=1e-9)
    assert len(blocks) == 2 and not blocks["v0"].flags.owndata


def test_what_is_not_determined_is_named():
    graph = h.HybridGraph()
    graph.add(h.Range("x0", "l0", 2.0, h.Noise.isotropic(1, 0.1), (h.SE2, 2)))
    estimate = h.Estimate({"x0": h.SE2(), "l0": [2.0, 0.0]})
    marginals = h.ContinuousMarginals(graph, estimate)
    assert not marginals.valid and set(marginals.under_constrained) == {h.Key("x0"), h.Key("l0")}
    with pytest.raises(h.Error, match="x0"):
        marginals.covariance("x0")
    assert {free.key for free in h.free_variables(graph, estimate)} == {h.Key("x0"), h.Key("l0")}


def test_smoothers_follow_a_walk():
    window = h.WindowSmoother(h.WindowOptions(mode=h.WindowMode.FIXED_LAG, lag=3))
    whole = h.IncrementalSmoother()
    noise = h.Noise.isotropic(3, 0.1)
    for i in range(10):
        delta = h.Delta()
        delta.add(h.Prior("x0", h.SE2(), noise) if i == 0 else
                  h.BetweenSE2(f"x{i - 1}", f"x{i}", h.SE2(1, 0, 0.1), noise))
        delta.values = h.Values({f"x{i}": h.SE2(i, 0, 0)})
        assert window.update(delta).ok and whole.update(delta).ok
    window.converge()
    whole.converge()
    assert len(whole) == 10 and len(window.smoother) < 10 and "x0" in window.past().values
    np.testing.assert_allclose(window.smoother["x9"].storage, whole["x9"].storage, rtol=1e-9)
    assert whole.settle().ok
    # What of x9 is known relative to x8 is the noise of one step, wherever they are.
    joint = whole.joint_covariance(["x8", "x9"])
    J = np.hstack([-h.SE2(1, 0, 0.1).inverse().adjoint(), np.eye(3)])
    np.testing.assert_allclose(whole.joint_covariance(["x8", "x9"], J), J @ joint @ J.T, atol=1e-9)
    np.testing.assert_allclose(whole.joint_covariance(["x8", "x9"], J), 0.01 * np.eye(3), atol=1e-9)
    duplicate = h.Delta()
    duplicate.values = h.Values({"x3": h.SE2()})
    with pytest.raises(h.Error, match="x3"):
        whole.update(duplicate)
    before, more = whole.objective(), h.Delta()
    more.add(h.Prior("x9", h.SE2(), noise))
    whole.begin()
    handles = whole.update(more).handles
    assert whole.objective() > before and len(whole.factors_of("x9")) == 2
    whole.roll_back()
    assert whole.objective() == before and len(whole.factors_of("x9")) == 1
    wrong = h.Delta()
    wrong.add(h.Prior("x9", h.SE2(50, 0, 0), noise))
    report = whole.propose(wrong, 3.0)
    assert not report.ok and "where 3 is allowed" in report.message
    assert whole.objective() == before and len(whole.factors_of("x9")) == 1
    right = h.Delta()
    right.add(h.Prior("x9", whole["x9"], noise))
    assert whole.propose(right, 3.0).ok and len(whole.factors_of("x9")) == 2
    removal = h.Delta()
    removal.remove, removal.remove_values = whole.factors_of("x9"), [h.Key("x9")]
    assert whole.update(removal).ok and "x9" not in whole
    removal.remove_values = []
    removal.remove = handles.all()
    with pytest.raises(h.Error, match="no longer"):
        whole.update(removal)


def ring(tmp_path, poses=30):
    graph = h.PoseGraph()
    noise = h.Noise.isotropic(3, 0.05)
    step = h.SE2(1, 0, 2 * math.pi / poses)
    for i in range(poses):
        graph.add_edge(f"x{i}", f"x{i + 1}", step, noise)
    for i in range(0, poses, 5):
        graph.add_edge(f"x{i}", f"x{(i + 3)}", step * step * step, noise)
    graph.values = h.initialize_from_odometry(graph)
    path = str(tmp_path / "ring.g2o")
    h.write_g2o(path, graph)
    return h.read_graph(path)


def test_pose_graphs_and_false_closures(tmp_path):
    graph = ring(tmp_path)
    assert graph.edge_count == 36 and len(graph.poses2) == 36
    assert graph.poses2[0].measured.x == 1 and str(graph.poses2[0].to_key) == "x1"
    spoilt = h.add_false_closures(graph, 0.5, 7)
    problem = h.to_robust_problem(spoilt, graph.values)
    assert len(problem.closures) > len(graph.poses2) - 30
    trusting = h.to_robust_problem(spoilt, graph.values, lambda a, b: b.index < 40)
    assert len(trusting.closures) == 0
    for method in h.robust_methods():
        assert h.robust_methods()[method]
    with pytest.raises(h.Error, match="selection"):
        h.solve_robust(problem, "magic")
    with pytest.raises(ZeroDivisionError):
        h.to_robust_problem(spoilt, graph.values, lambda a, b: 1 / 0)
    with pytest.raises(h.Error, match=r"missing\.g2o"):
        h.read_graph(str(tmp_path / "missing.g2o"))


def test_starts_and_certificate(tmp_path):
    graph = ring(tmp_path)
    tree = h.initialize_from_tree(graph)
    assert len(tree) == 31
    factors = h.to_factors(graph, tree)
    problem = h.HybridGraph()
    for factor in factors:
        problem.add(factor)
    values = h.levenberg_marquardt(problem, h.Estimate(tree)).values
    certificate = h.certify(problem.continuous, values)
    assert certificate.verified and certificate.relative_gap <= 1e-6, certificate.message
    with pytest.raises(h.Error, match="nothing to certify"):
        h.certify([], values)


def test_staircase_unwinds_a_circle():
    graph, twice = h.PoseGraph(), h.Values()
    for i in range(12):
        graph.add_edge(f"x{i}", f"x{(i + 1) % 12}", h.SE2(1, 0, math.pi / 6), h.Noise.isotropic(3, 0.3))
        a = math.pi / 3 * i
        twice[f"x{i}"] = h.SE2(math.sin(a), -math.cos(a), a)
    factors = h.to_factors(graph, twice)
    assert not h.certify(factors, twice).verified
    climbed = h.climb_staircase(factors, twice)
    assert climbed.certificate.verified and climbed.levels >= 1
    assert climbed.cost < 1e-9 < climbed.cost_before


def test_objective_is_bounded(tmp_path):
    graph = ring(tmp_path)
    noise = h.Noise.isotropic(3, 0.05)
    graph.add_edge("x0", "x15", h.SE2(50, 0, 0), noise)
    problem = h.to_robust_problem(graph, graph.values)
    result = h.select_closures(problem)
    agreement = h.agreement_of_closures(problem, result.values, result.accepted)
    assert agreement.rivals == 0 and agreement.agreeing + agreement.alone <= len(result.accepted)
    assert agreement.agreeing == 0 or agreement.ratio == 1
    with pytest.raises(h.Error):
        h.agreement_of_closures(problem, result.values, result.accepted[1:])
    bound = h.bound_objective(problem, result.values, result.accepted)
    assert bound.gap == pytest.approx(result.objective - bound.bound, abs=1e-9) and bound.gap >= 0
    wrong = h.bound_objective(problem, result.values, ~result.accepted)
    assert wrong.bound <= result.objective and wrong.gap > bound.gap
    hasty = h.bound_objective(problem, result.values, result.accepted, budget=0)
    assert hasty.solves == 0 and not hasty.complete and hasty.bound <= bound.bound
    with pytest.raises(h.Error):
        h.bound_objective(problem, h.Values(), result.accepted)


def test_information_is_repaired_where_asked(tmp_path):
    path = tmp_path / "bad.g2o"
    path.write_text("EDGE_SE2 0 1 1 0 0 4 0 0 9 0 -1\n")
    with pytest.raises(h.Error, match="bad.g2o:1:1: information matrix is not positive definite"):
        h.read_graph(str(path))
    assert h.read_graph(str(path), repair_information=True).edge_count == 1


def test_closures_selected_online(tmp_path):
    graph = ring(tmp_path)
    selection = h.OnlineSelection()
    feed = h.PoseFeed(graph, graph.values)
    while not feed.done:
        delta = feed.next(selection.smoother)
        assert selection.update(delta, []).ok
    far = h.Between("x0", "x15", h.SE2(50, 0, 0), h.Noise.isotropic(3, 0.05))
    near = h.Between("x0", "x30", h.SE2(0, 0, 0), h.Noise.isotropic(3, 0.05))
    selection.update(h.Delta(), [far, near])
    selection.finish()
    assert [decision.accepted for decision in selection.decisions()] == [False, True]
    assert selection.status(1) == h.ClosureStatus.ACCEPTED


def test_of_alternatives_at_most_one_is_accepted(tmp_path):
    graph = ring(tmp_path)
    for alternatives, accepted in (([], 2), ([0, 0], 1)):
        selection = h.OnlineSelection()
        feed = h.PoseFeed(graph, graph.values)
        while not feed.done:
            selection.update(feed.next(selection.smoother))
        found = [h.Between("x0", "x30", h.SE2(x, 0, 0), h.Noise.isotropic(3, 0.05)) for x in (0, 0.3)]
        selection.update(h.Delta(), found, alternatives)
        selection.finish()
        decisions = selection.decisions()
        assert sum(decision.accepted for decision in decisions) == accepted
        if alternatives:
            assert sum(decision.inlier_probability for decision in decisions) <= 1 + 1e-9
    with pytest.raises(h.Error, match="comes later"):
        selection.update(h.Delta(), found, [1, 1])


def test_misuse_is_an_error_and_no_crash(tmp_path):
    graph = ring(tmp_path)
    feed = h.PoseFeed(graph, graph.values)
    smoother = h.IncrementalSmoother()
    while not feed.done:
        smoother.update(feed.next(smoother))
    for beyond in (lambda: feed.pose, lambda: feed.next(smoother)):
        with pytest.raises(h.Error, match="no pose is left"):
            beyond()
    with pytest.raises(h.Error, match="at least one value"):
        h.DiscreteKey("d0", -1)
    with pytest.raises(h.Error, match="1 to 4096 dimensions"):
        h.Noise.isotropic(-1, 0.1)


def test_clouds(tmp_path):
    with pytest.raises(h.Error, match="n x 3"):
        h.register_clouds(np.zeros((4, 2)), np.zeros((4, 3)))
    path = tmp_path / "cloud.xyz"
    cloud = np.random.default_rng(1).normal(size=(100, 3))
    np.savetxt(path, cloud)
    np.testing.assert_allclose(h.read_points(str(path)), cloud)
    strided = np.asfortranarray(cloud)
    options = h.RegistrationOptions(metric=h.MatchMetric.POINT)
    found = [h.register_clouds(source, cloud, options).T_target_source.storage for source in (cloud, strided)]
    np.testing.assert_array_equal(*found)
