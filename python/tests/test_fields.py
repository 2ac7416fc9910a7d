# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Results, reports and settings in pickles, copies and processes."""

import copy
import multiprocessing
import pickle

import hybrid as h
import numpy as np
import pytest

NOISE = h.Noise.isotropic(3, 0.1)
SWITCH = h.DiscreteKey("d0", 2)


def problem():
    loop = h.Between("x0", "x2", h.SE2(9, 0, 0), NOISE)
    graph = h.HybridGraph([h.Prior("x0", h.SE2(), NOISE), *[h.Between(f"x{i}", f"x{i + 1}", h.SE2(1, 0, 0.1), NOISE) for i in range(2)],
                           h.OutlierMixture(SWITCH, loop, h.Inflated(loop, 1e4), 0.9, 0.1)])
    return graph, h.Estimate({f"x{i}": h.SE2(i, 0.1, 0) for i in range(3)}, {"d0": 0})


def delta():
    graph, initial = problem()
    change = h.Delta()
    change.add(list(graph))
    change.values, change.assignment = initial.values, initial.assignment
    return change


def robust():
    trusted = [h.Prior("x0", h.SE2(), NOISE), h.Between("x0", "x1", h.SE2(1, 0, 0), NOISE)]
    return h.RobustProblem(trusted, [h.Between("x0", "x1", h.SE2(8, 0, 0), NOISE)], {"x0": h.SE2(), "x1": h.SE2(1, 0, 0)})


def results():
    graph, initial = problem()
    best = h.alternate(graph, initial)
    smoother = h.IncrementalSmoother()
    relative = h.HybridGraph(list(graph.continuous))
    cloud = np.random.default_rng(1).normal(size=(60, 3))
    rounds = h.PoseGraph()
    rounds.add_edge("x0", "x1", h.SE2(1, 0, 0), NOISE)
    rounds.add_edge("x0", "l1", [1.0, 2.0], h.Noise.isotropic(2, 0.1))
    marginals = h.ContinuousMarginals(graph, best.estimate)
    online = h.OnlineSelection().update(delta())
    return [
        best, best.report, best.report.half_steps[0], h.levenberg_marquardt(graph, initial), h.solve_exhaustive(graph, initial.values),
        *h.free_variables(h.HybridGraph(list(relative)[1:]), initial)[:1], h.certify(list(relative), best.estimate.values),
        h.climb_staircase(list(relative), best.estimate.values), h.posterior(graph, best.estimate, ["d0"]), marginals.all(),
        h.posterior(graph, best.estimate, ["d0"])["d0"], h.log_evidence(graph, best.estimate), h.solve_discrete([h.prior_table(SWITCH, [0.3, 0.7])]),
        smoother.update(delta()), smoother.update(h.Delta()).handles, h.WindowSmoother().update(delta()), online, delta(), robust(),
        h.select_closures(robust()), h.select_closures(robust()).decisions[0], h.register_clouds(cloud, cloud), rounds.poses2[0], rounds.points2[0],
        h.Detection(range=3.0, id=7), h.DetectionFrame(class_names=["a"], T_robot_sensor=h.SE3([1, 2, 3], h.SO3()), detections=[h.Detection(yaw=0.1)]),
        h.AlternatingOptions(max_iterations=3, continuous=h.SolverOptions(threads=1)), h.ClosureSelectionOptions(margin=2.5),
        h.WindowOptions(mode=h.WindowMode.FIXED_LAG, lag=4), h.RegistrationOptions(start=h.SE3([1, 0, 0], h.SO3()), metric=h.MatchMetric.POINT),
    ]


def shown(thing):
    """All that a thing shows, to the last figure."""
    if isinstance(thing, np.ndarray):
        return thing.tolist()
    if isinstance(thing, (list, tuple)):
        return [shown(entry) for entry in thing]
    if isinstance(thing, (h.Values, h.Covariances)):
        return [(str(key), shown(thing[key])) for key in thing]
    if isinstance(thing, (h.ContinuousFactor, h.HybridFactor, h.Table)):
        return repr(thing)
    if hasattr(thing, "storage"):
        return thing.storage.tolist()
    names = [name for base in type(thing).__mro__ for name, member in vars(base).items() if isinstance(member, property)]
    if hasattr(type(thing), "__members__") or not names:
        return repr(thing)
    if isinstance(thing, h.Noise):
        return np.round(thing.covariance, 12).tolist()
    return {name: shown(getattr(thing, name)) for name in names}


@pytest.mark.parametrize("thing", results(), ids=lambda thing: type(thing).__name__)
def test_it_comes_back(thing):
    for made in (pickle.loads(pickle.dumps(thing)), copy.deepcopy(thing), copy.copy(thing)):
        assert type(made) is type(thing) and made is not thing
        assert shown(made) == shown(thing)


def test_what_is_not_a_field_of_its_own_comes_back():
    graph, initial = problem()
    posterior = h.posterior(graph, h.alternate(graph, initial).estimate, ["d0"])
    np.testing.assert_array_equal(pickle.loads(pickle.dumps(posterior))["d0"].p, posterior["d0"].p)
    change, made = h.IncrementalSmoother(), h.IncrementalSmoother()
    report, again = change.update(delta()), made.update(pickle.loads(pickle.dumps(delta())))
    assert again.objective_after == pytest.approx(report.objective_after) and len(again.handles) == 4
    handle = report.handles.all()[0]
    assert pickle.loads(pickle.dumps(handle)) == handle and pickle.loads(pickle.dumps(report)).ok
    assert len(copy.deepcopy(change)) == 3


def test_all_results_and_settings_are_kept():
    for name in h.__all__:
        if name.endswith(("Options", "Report", "Result", "Decision", "Certificate", "Evidence")) and name != "ReplayResult":
            assert "__getstate__" in vars(getattr(h, name)), name


def solve(shift):
    graph, initial = problem()
    initial.values["x2"] = h.SE2(2 + shift, 0, 0)
    return h.alternate(graph, initial)


def select(closures):
    return h.select_closures(closures)


def test_a_pool_of_processes_solves():
    with multiprocessing.Pool(2) as pool:
        several = pool.map(solve, [0.0, 0.1, 0.2])
        selected = pool.map(select, [robust(), robust()])
    for found, shift in zip(several, [0.0, 0.1, 0.2]):
        expected = solve(shift)
        assert shown(found.estimate.values) == shown(expected.estimate.values)
        assert found.report.objective == expected.report.objective
    assert [list(result.accepted) for result in selected] == [[False], [False]]
