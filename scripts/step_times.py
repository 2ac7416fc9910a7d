#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Times of single poses in online selection of closures, of pose graphs with false closures.

usage: PYTHONPATH=build/release/python /usr/bin/python3 scripts/step_times.py BIN GRAPH.g2o... [--rate R] [--seeds S...]
           [--set SECTION.KEY=VALUE ...]

Adds false closures (`--rate` for each true one, as hybrid-experiment does) and solves pose by pose, odometry trusted. Prints for each
graph the mean time of a pose, the 99th percentile, the longest and how many times the mean that is, median and worst over the seeds,
and the processor time of the run over that of a plain run of the graph without false closures, in which all closures are trusted.
"""

import argparse
import csv
import pathlib
import resource
import statistics
import subprocess
import tempfile

import hybrid


def solved(program, graph, folder, *words):
    """Times of the poses [ms], and the processor time of the run [s]."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    subprocess.run([program, graph, "--online", *words, "-o", folder], check=True, capture_output=True)
    used = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
    with (folder / "steps.csv").open(encoding="utf-8") as rows:
        return sorted(float(row["solver_ms"]) for row in csv.DictReader(rows)), used


def figures(program, file, rate, seed, work, settings):
    graph = hybrid.add_false_closures(hybrid.read_graph(str(file)), rate, seed)
    corrupted = work / f"{file.stem}_{seed}.g2o"
    hybrid.write_g2o(str(corrupted), graph)
    words = [word for setting in settings for word in ("--set", setting)]
    times, used = solved(program, corrupted, work / f"{file.stem}_{seed}", "--trusted", "odometry", *words)
    mean = statistics.fmean(times)
    return mean, times[int(0.99 * len(times))], times[-1], times[-1] / mean, used


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bin", type=pathlib.Path)
    parser.add_argument("graphs", nargs="+", type=pathlib.Path)
    parser.add_argument("--rate", type=float, default=0.2)
    parser.add_argument("--seeds", nargs="+", type=int, default=[1])
    parser.add_argument("--set", action="append", default=[])
    arguments = parser.parse_args()
    program = arguments.bin / "hybrid-pgo"
    print("| graph | mean [ms] | 99 % [ms] | longest [ms] | longest / mean | time / plain |\n|---|---|---|---|---|---|")
    for file in arguments.graphs:
        with tempfile.TemporaryDirectory() as folder:
            work = pathlib.Path(folder)
            plain = solved(program, file, work / "plain")[1]
            runs = [figures(program, file, arguments.rate, seed, work, arguments.set) for seed in arguments.seeds]
        *columns, used = zip(*runs)
        columns.append([time / plain for time in used])
        cells = [f"{statistics.median(column):.3g}, {max(column):.3g}" for column in columns]
        print("| " + " | ".join([file.stem, *cells]) + " |", flush=True)


if __name__ == "__main__":
    main()
