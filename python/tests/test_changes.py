# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""What is changed while a call uses it ends no interpreter, and circles through graphs are freed."""

import copy
import gc
import os
import subprocess
import sys
import threading
import weakref

import hybrid as h
import numpy as np
import pytest

POSES = 300
NOISE = h.Noise.isotropic(3, 1.0)


def prior(i):
    return h.Prior(f"x{i % POSES}", h.SE2(), NOISE)


def beside(change, use):
    """Runs `use` in two threads until `change` has ended in a third; returns what they raised."""
    done, raised = threading.Event(), []

    def run(work):
        try:
            work()
        except Exception as error:  # noqa: BLE001: all of them are looked at
            raised.append(error)

    def changing():
        run(change)
        done.set()

    def using():
        while not done.is_set():
            use()

    threads = [threading.Thread(target=changing)] + [threading.Thread(target=run, args=(using,)) for _ in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return raised


def test_a_graph_and_values_may_change_while_they_are_solved():
    graph, start = h.HybridGraph(), h.Values()
    graph.add([prior(i) for i in range(POSES)])
    for i in range(POSES):
        start[f"x{i}"] = h.SE2(0.1, 0.1, 0.2)
    estimate = h.Estimate(start)

    def change():
        for i in range(2000):
            handle = graph.add(prior(i))
            estimate.values[f"y{i}"] = h.SE2()
            if i % 3 == 0:
                graph.remove(handle)

    def use():
        h.objective(graph, estimate.values)
        h.levenberg_marquardt(graph, estimate, h.SolverOptions(max_iterations=2))

    raised = beside(change, use)
    # A variable that no factor holds is not determined, which is no fault of the threads.
    assert all(isinstance(error, h.Error) for error in raised)


GROWING = """
import hybrid as h

class Grows(h.Factor):
    \"\"\"Adds to its graph while it is asked, as another thread might.\"\"\"
    def __init__(self):
        super().__init__(["x0"], [h.SE2], h.Noise.isotropic(1, 1.0))
    def residual(self, pose):
        for i in range(5000):
            graph.add(h.Prior("x0", h.SE2(), h.Noise.isotropic(3, 1.0)))
            values[f"y{len(values)}"] = h.SE2()
        return [0.0]

graph, values = h.HybridGraph(), h.Values({"x0": h.SE2(1, 0, 0)})
graph.add(Grows())
for _ in range(3):
    graph.add(h.Prior("x0", h.SE2(), h.Noise.isotropic(3, 1.0)))
print(h.cost(graph, values), len(graph), len(values))
"""


def test_a_call_sees_the_graph_as_it_was():
    """Whatever freed memory holds."""
    environment = dict(os.environ, MALLOC_PERTURB_="165")
    run = subprocess.run([sys.executable, "-B", "-c", GROWING], capture_output=True, text=True, env=environment)
    assert run.returncode == 0, run.stderr
    assert run.stdout.split() == ["1.5", "5004", "5001"]


def smoother_of(poses):
    delta = h.Delta()
    for i in range(poses):
        delta.values[f"x{i}"] = h.SE2(0.1, 0, 0)
        delta.add(prior(i))
    smoother = h.IncrementalSmoother()
    smoother.update(delta)
    return smoother


def test_one_call_at_a_time_changes_a_smoother():
    smoother = smoother_of(POSES)
    refused = []

    def guarded(work):
        try:
            work()
        except h.Error as error:
            refused.append(str(error))

    def change():
        for i in range(100):
            delta = h.Delta()
            delta.add(prior(i))
            guarded(lambda: smoother.update(delta))

    def use():
        guarded(lambda: smoother["x7"])
        guarded(lambda: smoother.joint_covariance(["x1", "x2"]))
        guarded(smoother.converge)

    assert not beside(change, use)
    assert all("in use" in text for text in refused)
    assert np.isfinite(smoother.objective())


def test_a_factor_cannot_change_the_smoother_that_calls_it():
    smoother = smoother_of(3)

    class Meddles(h.Factor):
        def __init__(self):
            super().__init__(["x0"], [h.SE2], h.Noise.isotropic(1, 1.0))

        def residual(self, pose):
            smoother.update(h.Delta())
            return [0.0]

    before = smoother.objective()
    delta = h.Delta()
    delta.add(Meddles())
    with pytest.raises(h.Error, match="in use"):
        smoother.update(delta)
    assert smoother.objective() == before
    assert smoother.update(h.Delta()).ok


def test_a_feed_does_not_see_what_is_added_to_its_graph():
    graph = h.PoseGraph()
    graph.add_edge("x0", "x1", h.SE2(1, 0, 0), NOISE)
    feed = h.PoseFeed(graph, h.initialize_from_odometry(graph))
    for i in range(1, 500):  # moves the edges in memory
        graph.add_edge(f"x{i}", f"x{i + 1}", h.SE2(1, 0, 0), NOISE)
    smoother = h.IncrementalSmoother()
    while not feed.done:
        smoother.update(feed.next(smoother))
    assert len(smoother) == 2
    with pytest.raises(h.Error):
        feed.next(smoother)
    with pytest.raises(h.Error):
        h.PoseFeed(h.PoseGraph(), h.Values()).pose  # noqa: B018


class Pull(h.Factor):
    def __init__(self):
        super().__init__(["x0"], [2], h.Noise.isotropic(2, 0.5))

    def residual(self, x):
        return x


def in_graph(factor):
    factor.owner = h.HybridGraph()
    factor.owner.add(factor)


def in_mixture(factor):
    factor.owner = h.HybridGraph()
    factor.owner.add(h.OutlierMixture(h.DiscreteKey("d0", 2), factor, h.Inflated(factor, 100.0)))


def in_delta(factor):
    factor.owner = h.Delta()
    factor.owner.add(factor)


def in_problem(factor):
    factor.owner = h.RobustProblem([factor], [factor], h.Values({"x0": np.ones(2)}))


@pytest.mark.parametrize("put", [in_graph, in_mixture, in_delta, in_problem])
def test_a_factor_that_knows_its_owner_is_freed(put):
    factor = Pull()
    put(factor)
    gone = weakref.ref(factor)
    owner = factor.owner
    del factor
    gc.collect()
    assert gone() is not None and gone().owner is owner  # someone holds the owner
    del owner
    gc.collect()
    assert gone() is None


def test_a_factor_of_two_graphs_stays_while_one_does():
    factor = Pull()
    in_graph(factor)
    other = copy.copy(factor.owner)
    gone = weakref.ref(factor)
    del factor
    gc.collect()
    assert gone().owner is not None
    result = h.levenberg_marquardt(other, h.Estimate({"x0": np.ones(2)}))
    assert np.allclose(result.values["x0"], 0)
    del other
    gc.collect()
    assert gone() is None
