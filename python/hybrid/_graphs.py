# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Pose graphs in one step."""

import os

from . import _core


def _refuse_to_pickle(graph, _protocol=0):
    raise TypeError(f"{graph!r} cannot be pickled: write_g2o keeps pose graphs, and of other graphs what they are made from is kept")


def refuse_to_pickle(cls):
    """Tells what to do in place of pickle's `cannot pickle`. copy.copy and copy.deepcopy stay."""
    cls.__reduce_ex__ = _refuse_to_pickle


def read_g2o(path: str | os.PathLike, *, repair_information: bool = False) -> tuple[_core.HybridGraph, _core.Values]:
    """Reads a pose graph in g2o or TORO form as a graph that a solver takes, and its initial values.

    The values are those of the file if it has one for every vertex, else the odometry chained from the first pose. The
    first pose gets a prior if nothing else fixes where the graph is. All loop closures are trusted: `read_graph` and
    `select_closures` are for graphs whose closures may be false. repair_information: see `read_graph`. An Error names the
    line of the file.
    """
    poses = _core.read_graph(os.fspath(path), repair_information)
    edges = (*poses.poses2, *poses.poses3, *poses.points2, *poses.points3)
    complete = all(edge.from_key in poses.values and edge.to_key in poses.values for edge in edges)
    initial = poses.values if complete else _core.initialize_from_odometry(poses)
    graph = _core.HybridGraph()
    for factor in _core.to_factors(poses, initial):
        graph.add(factor)
    return graph, initial
