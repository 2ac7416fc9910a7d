#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Median and worst of the columns of an experiment of replays, method by method, as a table.

usage: median_and_worst.py OUT/results.csv [COLUMN...]     COLUMN: such as truth.trajectory.rmse_m; by default all below truth

The worst of precision and recall is the least, that of a NEES the farthest from 1, and of all else the largest.
"""

import csv
import math
import statistics
import sys


def worst(column, values):
    if column.rsplit(".", 1)[-1] in ("precision", "recall"):
        return min(values)
    if "nees" in column:
        return max(values, key=lambda v: abs(math.log(max(v, 1e-300))))
    return max(values)


def main(path, columns):
    with open(path, encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    columns = columns or [c for c in rows[0] if c.startswith("truth.")]
    methods = list(dict.fromkeys(row["method"] for row in rows))
    print("| median, worst | " + " | ".join(methods) + " |")
    print("|---" * (len(methods) + 1) + "|")
    for column in columns:
        cells = []
        for method in methods:
            values = [float(row[column]) for row in rows if row["method"] == method and row[column]]
            cells.append(f"{statistics.median(values):.3g}, {worst(column, values):.3g}" if values else "")
        print(f"| {column} | " + " | ".join(cells) + " |")
    for method in methods:
        bad = sum(row["method"] == method and row["status"] != "ok" for row in rows)
        if bad:
            print(f"{method}: {bad} trials are not ok", file=sys.stderr)


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    main(sys.argv[1], sys.argv[2:])
