#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Prints the errors against ground truth of replays: error_table.py OUT... (folders with a summary.json)."""

import json
import pathlib
import sys

ROWS = [  # label, path in summary.json, format
    ("keyframes", "keyframes", "d"),
    ("landmarks", "landmarks", "d"),
    ("trajectory, rmse [m]", "truth.trajectory.rmse_m", ".4f"),
    ("trajectory, max [m]", "truth.trajectory.max_m", ".4f"),
    ("trajectory, aligned rmse [m]", "truth.trajectory.aligned.rmse_m", ".4f"),
    ("dead reckoning, rmse [m]", "truth.dead_reckoning.rmse_m", ".4f"),
    ("landmarks, mean [m]", "truth.landmarks.mean_m", ".4f"),
    ("landmarks, max [m]", "truth.landmarks.max_m", ".4f"),
    ("right classes", "truth.class_accuracy", ".1%"),
    ("solver, all steps [s]", "solver_s", ".3f"),
    ("total [s]", "total_s", ".3f"),
]


def cell(summary, path, style):
    """The formatted value at a dotted path, or '-' where the summary has none."""
    for name in path.split("."):
        summary = summary.get(name) if isinstance(summary, dict) else None
    return "-" if summary is None else format(summary, style)


def main():
    folders = [pathlib.Path(name) for name in sys.argv[1:]]
    columns = [[folder.name] for folder in folders]
    for column, folder in zip(columns, folders):
        summary = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
        column += [cell(summary, path, style) for _, path, style in ROWS]
    labels = [""] + [label for label, _, _ in ROWS]
    for row in zip(labels, *columns):
        if any(value != "-" for value in row[1:]):
            print(f"{row[0]:<30}" + "".join(f"{value:>16}" for value in row[1:]).rstrip())


if __name__ == "__main__":
    main()
