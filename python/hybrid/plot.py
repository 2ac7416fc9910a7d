# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Pictures of paths, landmarks and covariances by matplotlib (Debian: python3-matplotlib).

Maps in space are seen from above. Functions draw into the axes `ax`, or into new ones of equal scale, and return them.
"""

import os

import numpy as np

from . import _core

# Of the letters of keys: those of landmarks; any other variable that is a pose belongs to a path.
LANDMARKS = "l"
PROBABILITY = 0.95
_COLOURS = {"path": "#1f5fa8", "odometry": "#b0b0b0", "truth": "#2e7d32", "landmarks": "#c4511d", "edges": "#9aa7b5"}


def _pyplot():
    try:
        from matplotlib import pyplot
    except ImportError as error:
        raise ImportError(f"hybrid.plot needs matplotlib (Debian: python3-matplotlib): {error}") from None
    return pyplot


def axes(title: str = ""):
    """New axes of equal scale, in metres."""
    _, ax = _pyplot().subplots(figsize=(8, 6), layout="constrained")
    ax.set_aspect("equal", adjustable="datalim")
    ax.set(xlabel="x [m]", ylabel="y [m]", title=title)
    ax.grid(True, linewidth=0.4, alpha=0.5)
    return ax


def save(file: str | os.PathLike, ax) -> None:
    """Writes the figure of axes (.png, .pdf, .svg) and closes it."""
    ax.figure.savefig(file, dpi=120)
    _pyplot().close(ax.figure)


def _position(value):
    """x and y of a pose or point; None for other variables."""
    if isinstance(value, (_core.SE2, _core.SE3)):
        return value.translation[:2]
    if isinstance(value, np.ndarray) and value.size in (2, 3):
        return value[:2]
    return None


def _poses(values, letters):
    """The poses of each letter, in the order of their numbers."""
    paths = {}
    for key in values.keys(letters):
        if isinstance(values[key], (_core.SE2, _core.SE3)):
            paths.setdefault(key.letter, []).append((key.index, _position(values[key])))
    return [np.array([position for _, position in sorted(path, key=lambda p: p[0])]) for path in paths.values()]


def path(values, letters: str = "", ax=None, **style):
    """Lines through the poses of a `Values`, one for each letter of keys; only these letters, if any are given."""
    ax = ax or axes()
    style = {"color": _COLOURS["path"], "linewidth": 1.2, **style}
    for i, points in enumerate(_poses(values, letters)):
        ax.plot(points[:, 0], points[:, 1], **(style if i == 0 else {**style, "color": f"C{i}"}))
    return ax


def landmarks(values, letters: str = LANDMARKS, ax=None, names: bool = False, **style):
    """Dots at the points of a `Values` with these letters, with their keys if `names`."""
    ax = ax or axes()
    found = [(key, _position(values[key])) for key in values.keys(letters) if isinstance(values[key], np.ndarray)]
    found = [(key, position) for key, position in found if position is not None]
    if found:
        xy = np.array([position for _, position in found])
        ax.scatter(xy[:, 0], xy[:, 1], **{"s": 18, "color": _COLOURS["landmarks"], "zorder": 3, **style})
    if names:
        for key, position in found:
            ax.annotate(str(key), position, xytext=(3, 3), textcoords="offset points", fontsize=7)
    return ax


def planar_covariance(value, covariance) -> np.ndarray:
    """Covariance (2, 2) of x and y in the map, of the covariance of a pose or point over its tangent.

    The tangent of a pose has the translation first, in the frame of the pose.
    """
    if isinstance(value, (_core.SE2, _core.SE3)):
        n = len(value.translation)
        R = value.rotation.matrix()
        return (R @ covariance[:n, :n] @ R.T)[:2, :2]
    return np.asarray(covariance)[:2, :2]


def ellipse(position, covariance, probability: float = PROBABILITY, points: int = 60) -> np.ndarray:
    """Outline (points, 2) of the region that holds this share of a normal distribution of x and y."""
    widths, directions = np.linalg.eigh(covariance)
    radius = np.sqrt(_core.chi_square_quantile(probability, 2) * np.maximum(widths, 0))
    angle = np.linspace(0, 2 * np.pi, points)
    return np.asarray(position) + np.column_stack([np.cos(angle), np.sin(angle)]) @ (directions * radius).T


def covariances(values, marginals, keys=None, ax=None, probability: float = PROBABILITY, most: int = 200, **style):
    """Ellipses that hold a variable with this probability, of `ContinuousMarginals`.

    keys: of these variables; by default of all points and poses, of at most `most` of them, evenly chosen.
    """
    ax = ax or axes()
    if keys is None:
        keys = [key for key in values.keys() if _position(values[key]) is not None]
        keys = keys[::max(1, -(-len(keys) // most))]
    outlines = [ellipse(_position(values[key]), planar_covariance(values[key], marginals.covariance(key)), probability)
                for key in keys]
    for outline in outlines:
        ax.plot(outline[:, 0], outline[:, 1], **{"color": _COLOURS["landmarks"], "linewidth": 0.7, "alpha": 0.7, **style})
    return ax


def edges(graph, values, ax=None, **style):
    """Lines between the variables of each factor of a `HybridGraph` that has two."""
    ax = ax or axes()
    ends = []
    for factor in graph.continuous:
        if len(factor.keys) == 2:
            a, b = (_position(values[key]) for key in factor.keys)
            if a is not None and b is not None:
                ends += [a, b, [np.nan, np.nan]]
    if ends:
        xy = np.array(ends)
        ax.plot(xy[:, 0], xy[:, 1], **{"color": _COLOURS["edges"], "linewidth": 0.5, "zorder": 1, **style})
    return ax


def estimate(values, marginals=None, graph=None, ax=None):
    """Paths and landmarks of a `Values` or an `Estimate`; with marginals their ellipses, with the graph its edges."""
    values = values.values if isinstance(values, _core.Estimate) else values
    ax = ax or axes()
    if graph is not None:
        edges(graph, values, ax)
    path(values, ax=ax)
    landmarks(values, ax=ax)
    if marginals is not None:
        covariances(values, marginals, ax=ax)
    return ax


def run(folder: str | os.PathLike, ax=None):
    """Path, dead reckoning, truth and landmarks of a result of `replay` or hybrid-replay."""
    from ._replay import ReplayResult

    result = folder if isinstance(folder, ReplayResult) else ReplayResult.read(folder)
    ax = ax or axes()
    lines = [("dead reckoning", result.dead_reckoning, "odometry"), ("truth", result.true_path, "truth"),
             ("path", result.path, "path")]
    for label, points, colour in lines:
        if points is not None:
            ax.plot(points[:, 1], points[:, 2], color=_COLOURS[colour], linewidth=1.1, label=label)
    for i, landmark in enumerate(result.landmarks):
        outline = ellipse(landmark["position"][:2], landmark["covariance"][:2, :2])
        ax.plot(*landmark["position"][:2], "o", markersize=3.5, color=_COLOURS["landmarks"], label="" if i else "landmarks")
        ax.plot(outline[:, 0], outline[:, 1], color=_COLOURS["landmarks"], linewidth=0.7)
    ax.legend(loc="best", fontsize=8)
    return ax
