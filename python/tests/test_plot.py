# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Pictures hold the numbers of the estimates."""

import os
import pathlib

import hybrid as h
import numpy as np
import pytest

matplotlib = pytest.importorskip("matplotlib", reason="python3-matplotlib is not installed")
matplotlib.use("Agg")

from hybrid import plot  # noqa: E402

NOISE = h.Noise.diagonal([0.3, 0.1, 0.05])


def drive():
    graph = h.HybridGraph()
    graph.add(h.Prior("x0", h.SE2(0, 0, np.pi / 2), NOISE))
    values = h.Values({"x0": h.SE2(0, 0, np.pi / 2)})
    for i in range(1, 12):  # keys in another order than their numbers as texts
        values[f"x{i}"] = values[f"x{i - 1}"] * h.SE2(1, 0, 0)
        graph.add(h.Between(f"x{i - 1}", f"x{i}", h.SE2(1, 0, 0), NOISE))
    values["l0"] = [1.0, 2.0]
    graph.add(h.BearingRange("x0", "l0", [np.sqrt(5), np.arctan2(-1, 2)], h.Noise.diagonal([0.1, 0.05])))
    return graph, values, h.ContinuousMarginals(graph, h.Estimate(values))


def test_an_ellipse_holds_its_share():
    rng = np.random.default_rng(1)
    covariance = np.array([[2.0, 0.8], [0.8, 0.5]])
    outline = plot.ellipse([1, 2], covariance, 0.9) - [1, 2]
    distances = np.einsum("ni,ij,nj->n", outline, np.linalg.inv(covariance), outline)
    np.testing.assert_allclose(distances, distances[0])
    drawn = rng.multivariate_normal([0, 0], covariance, 20000)
    inside = np.einsum("ni,ij,nj->n", drawn, np.linalg.inv(covariance), drawn) < distances[0]
    assert abs(inside.mean() - 0.9) < 0.01


def test_covariances_of_poses_are_turned_into_the_map():
    _, values, marginals = drive()
    turned = plot.planar_covariance(values["x0"], marginals.covariance("x0"))
    np.testing.assert_allclose(turned, np.diag([0.01, 0.09]), atol=1e-9)  # the robot looks along y
    space = h.SE3([0, 0, 0], h.SO3.exp([0, 0, np.pi / 2]))
    np.testing.assert_allclose(plot.planar_covariance(space, np.diag([9.0, 4, 1, 1, 1, 1])), np.diag([4, 9]), atol=1e-12)


def test_an_estimate_is_drawn(tmp_path):
    graph, values, marginals = drive()
    ax = plot.estimate(h.Estimate(values), marginals, graph)
    edges, path, *ellipses = ax.lines
    np.testing.assert_allclose(path.get_ydata(), range(12), atol=1e-12)
    assert len(edges.get_xdata()) == 3 * 12 and len(ellipses) == 13
    np.testing.assert_allclose(ax.collections[0].get_offsets(), [[1, 2]])
    assert len(plot.covariances(values, marginals, most=5).lines) <= 5
    assert [text.get_text() for text in plot.landmarks(values, names=True).texts] == ["l0"]
    plot.save(tmp_path / "a.png", ax)
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")


def test_an_empty_estimate_is_an_empty_picture():
    assert plot.estimate(h.Values()).lines[:] == []


@pytest.mark.skipif(os.environ.get("HYBRID_WITH_MRPT") != "ON", reason="built without MRPT")
def test_a_run_is_drawn(source, tmp_path):
    log = source / "rawlogs" / "classed_demo"
    result = h.replay(rawlog=f"{log}.rawlog", truth_path=f"{log}_ground_truth_robot_path.txt", output=tmp_path / "out",
                      pictures=False)
    ax = plot.run(pathlib.Path(tmp_path / "out"))
    labels = [text.get_text() for text in ax.get_legend().get_texts()]
    assert labels == ["dead reckoning", "truth", "path", "landmarks"]
    np.testing.assert_array_equal(ax.lines[2].get_xdata(), result.path[:, 1])
    plot.save(tmp_path / "run.png", ax)
