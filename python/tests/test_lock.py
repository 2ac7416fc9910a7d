# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Other threads of Python run while the library computes."""

import sys
import threading
import time

import hybrid as h
import numpy as np
import pytest


def register():
    points = np.random.default_rng(1).normal(size=(3000, 3))
    return lambda: h.register_clouds(points, points + 0.01, h.RegistrationOptions(threads=1))


def walk():
    noise = h.Noise.isotropic(6, 0.1)
    graph, start = h.HybridGraph(), h.Values()
    graph.add(h.Prior("x0", h.SE3(), noise))
    for i in range(800):
        step = h.SE3.exp([1, 0, 0, 0.1, 0.2, 0.3])
        graph.add(h.Between(f"x{i}", f"x{i + 1}", step, noise))
        graph.add(h.Between(f"x{i // 2}", f"x{i + 1}", step, noise))
    for i in range(801):
        start[f"x{i}"] = h.SE3([i, 0, 0], h.SO3())
    return graph, h.Estimate(start)


def solve():
    graph, start = walk()
    return lambda: h.levenberg_marquardt(graph, start, h.SolverOptions(max_iterations=3, threads=1))


def covariances():
    graph, start = walk()
    return lambda: h.ContinuousMarginals(graph, start).all()


def update():
    graph, start = walk()
    delta = h.Delta()
    for factor in graph.continuous:
        delta.add(factor)
    delta.values = start.values
    return lambda: h.IncrementalSmoother().update(delta)


def held():
    return lambda: sum(range(100000))


@pytest.mark.parametrize("make", [held, register, solve, covariances, update])
def test_the_lock_is_free_while_the_library_computes(make):
    """The interpreter never forces a thread to release the lock here: the other runs only if this one releases it."""
    work = make()
    counts, started, stop = [0], threading.Event(), threading.Event()

    def count():
        while not stop.is_set():
            counts[0] += 1
            started.set()
            time.sleep(1e-4)

    interval = sys.getswitchinterval()
    sys.setswitchinterval(1000)
    other = threading.Thread(target=count)
    try:
        other.start()
        started.wait()
        before = counts[0]
        for _ in range(100):  # on a busy machine, the other thread may not run during each of them
            work()
            if counts[0] > before:
                break
        during = counts[0] - before
    finally:
        stop.set()
        sys.setswitchinterval(interval)
        other.join()
    assert (during > 0) == (make is not held)
