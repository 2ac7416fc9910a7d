# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Pose graphs in one step; graphs and factors in pickles."""

import os

from . import _core


def made(name, *arguments):
    """A factor that a pickle holds, by the function that makes it."""
    return getattr(_core, name)(*arguments)


def _reduce_factor(factor):
    recipe = _core._recipe(factor)
    if recipe is None:
        how = (f"define __reduce__ in the class, such as `return {type(factor).__name__}, (what __init__ takes)`"
               if isinstance(factor, _core.Factor) else "its class has no form in Python")
        raise TypeError(f"{factor!r} cannot be pickled: {how}")
    name, arguments = recipe
    return made, (name, *arguments)


def _reduce_graph(graph):
    return _core.HybridGraph, (list(graph),)


def _reduce_ex(thing, protocol):
    return object.__reduce_ex__(thing, max(protocol, 2))


def add_pickling():
    """Factors are kept by what they are made of, graphs by their factors. Copies of factors, which never change, are the same.
    Protocols 0 and 1, which would make an object of the base of all classes, use the form of 2."""
    for cls in vars(_core).values():
        if isinstance(cls, type) and not issubclass(cls, Exception):
            cls.__reduce_ex__ = _reduce_ex
    for cls in (_core.ContinuousFactor, _core.HybridFactor):
        cls.__reduce__ = _reduce_factor
        cls.__copy__ = lambda factor: factor
        cls.__deepcopy__ = lambda factor, memo: factor
    _core.HybridGraph.__reduce__ = _reduce_graph


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
    return _core.HybridGraph(_core.to_factors(poses, initial)), initial
