# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""A replay as a function. The first call loads MRPT."""

import csv
import json
import os
import pathlib
import sys
from collections.abc import Callable, Sequence

import numpy as np

from . import _core


class ReplayResult(dict):
    """The content of summary.json as a dict; the files of the result as arrays, read when they are asked for.

    folder: where they are. Paths are arrays of n x 8: time [s], x, y, z [m], and the quaternion qx, qy, qz, qw.
    """

    def __init__(self, summary: dict, folder: str | os.PathLike):
        super().__init__(summary)
        self.folder = pathlib.Path(folder).absolute()  # also where the program goes to another folder

    @classmethod
    def read(cls, folder: str | os.PathLike) -> "ReplayResult":
        """The result of a former run of hybrid-replay."""
        try:
            return cls(json.loads((pathlib.Path(folder) / "summary.json").read_text(encoding="utf-8")), folder)
        except (OSError, ValueError) as error:
            raise _core.Error(f"{os.fspath(folder)}: is no result of hybrid-replay: {error}") from None

    def _path(self, name):
        file = self.folder / name
        if not file.exists():
            raise _core.Error(f"{file}: no such file; of several robots, the paths are in folders of their names")
        return np.loadtxt(file, comments="#", ndmin=2).reshape(-1, 8)

    @property
    def path(self) -> np.ndarray:
        """The estimated path (n, 8)."""
        return self._path("trajectory.tum")

    @property
    def dead_reckoning(self) -> np.ndarray:
        """The path by odometry alone (n, 8)."""
        return self._path("trajectory_dead_reckoning.tum")

    @property
    def true_path(self) -> np.ndarray | None:
        """The true path (n, 8) in the frame of the map; None where none was given."""
        return self._path("trajectory_truth.tum") if (self.folder / "trajectory_truth.tum").exists() else None

    @property
    def landmarks(self) -> list[dict]:
        """Each landmark: id, position (2,) or (3,) [m], covariance [m^2], class, class_probabilities, sightings,
        extent_m, things."""
        text = (self.folder / "landmarks.json").read_text(encoding="utf-8")
        arrays = ("position", "covariance")
        return [{name: np.array(value) if name in arrays else value for name, value in landmark.items()}
                for landmark in json.loads(text)["landmarks"]]

    @property
    def positions(self) -> np.ndarray:
        """Of the landmarks (n, 2) or (n, 3) [m]."""
        return np.array([landmark["position"] for landmark in self.landmarks])

    @property
    def covariances(self) -> np.ndarray:
        """Of the landmarks (n, 2, 2) or (n, 3, 3) [m^2]."""
        return np.array([landmark["covariance"] for landmark in self.landmarks])

    @property
    def extents(self) -> np.ndarray:
        """How far from each landmark (n,) what is taken for it is, a standard deviation along each axis [m]."""
        return np.array([landmark["extent_m"] for landmark in self.landmarks], dtype=float)

    @property
    def things(self) -> np.ndarray:
        """How many things each landmark (n,) stands for."""
        return np.array([landmark["things"] for landmark in self.landmarks], dtype=int)

    @property
    def fixes(self) -> list[dict]:
        """Each fix of satellite receivers: time [s], keyframe, measured (3,) and antenna (3,) [m, in the map], error (3,)
        that lasts [m, east, north, up], sigma as stated [m], mode ("good", "biased", "false", or None where it is not
        used), probabilities of these modes (3,), not_used: why, sensor: label of the receiver. Empty where the log
        has none."""
        file = self.folder / "fixes.csv"
        if not file.exists():
            return []

        def numbers(row, *names):
            return np.array([float(row[name]) if row[name] else np.nan for name in names])

        with file.open(encoding="utf-8", newline="") as table:
            return [{"time": float(row["time"]), "keyframe": int(row["keyframe"]),
                     "measured": numbers(row, "x", "y", "z"),
                     "antenna": numbers(row, "antenna_x", "antenna_y", "antenna_z"),
                     "error": numbers(row, "error_east", "error_north", "error_up"),
                     "sigma": float(row["sigma"]), "mode": row["mode"] or None,
                     "probabilities": numbers(row, "p_good", "p_biased", "p_false"),
                     "not_used": row["not_used"], "sensor": row["sensor"]} for row in csv.DictReader(table)]

    def __repr__(self):
        return (f"<ReplayResult {str(self.folder)!r}: {self.get('status')}, {self.get('keyframes')} keyframes, "
                f"{self.get('landmarks')} landmarks>")


def replay(
    config: str | os.PathLike = "",
    output: str | os.PathLike = "hybrid-replay-out",
    *,
    rawlog: str | os.PathLike = "",
    truth_path: str | os.PathLike = "",
    truth_map: str | os.PathLike = "",
    settings: dict[str, object] | None = None,
    plugins: Sequence[str] = (),
    pictures: bool = True,
    progress: Callable[[float, int, int, float], None] | None = None,
) -> ReplayResult:
    """Maps a rawlog as hybrid-replay does, and returns the content of summary.json, with arrays of path and landmarks.

    config: an INI file; output: the folder of the result, which is replaced as a whole or not at all; rawlog,
    truth_path, truth_map: override those of the INI; settings: override values of the INI, by "section.key"; plugins:
    libraries to load; progress: called after every keyframe with the share of the log, the numbers of keyframes and
    landmarks, and the objective. If it raises an exception, or on Ctrl-C, the replay ends and nothing is written. An
    Error names file, section or key.
    """
    from . import _mrpt

    text = _mrpt.replay(os.fspath(config), os.fspath(output), os.fspath(rawlog), os.fspath(truth_path),
                        os.fspath(truth_map), [f"{key}={value}" for key, value in (settings or {}).items()],
                        list(plugins), pictures, list(sys.orig_argv), progress)
    return ReplayResult(json.loads(text), output)
