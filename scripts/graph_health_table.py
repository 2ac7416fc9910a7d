#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""What the verdict of hybrid-pgo on its map is worth: planar pose graphs with false closures, mapped and compared with the optimum.

usage: graph_health_table.py BIN FOLDER SEEDS METHOD GRAPH.g2o...        SEEDS as 1-4 or 1,3,7

Of each graph the optimum with its own closures (--method lm) is the truth. Then false closures are added: 20, 50 or 100 % of the
true ones, at random or in passages of 20 that follow the odometry as true ones do, in a graph of one robot, or cut into three robots without
odometry between them. A map is wrong where its path is more than TOLERANCE off after alignment. Prints a row a case: the errors of its
paths in the median and at worst, how many are wrong, and how many of the wrong and of the right ones are called bad.
"""
import json
import math
import pathlib
import random
import statistics
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from health_table import seeds_of  # noqa: E402

TOLERANCE = 0.5  # m
APART = 30  # poses between the two ends of a false closure, at least
CASES = [(share, passage, robots) for robots in (1, 3) for passage in (1, 20) for share in (0.2, 0.5, 1.0)]


def compose(p, q):
    c, s = math.cos(p[2]), math.sin(p[2])
    return p[0] + c * q[0] - s * q[1], p[1] + s * q[0] + c * q[1], p[2] + q[2]


def inverse(p):
    c, s = math.cos(p[2]), math.sin(p[2])
    return -c * p[0] - s * p[1], s * p[0] - c * p[1], -p[2]


class Graph:
    """Poses are numbered by rank; an edge is (rank, rank, the rest of its words)."""

    def __init__(self, path):
        rows = [line.split() for line in path.read_text().splitlines() if line.strip()]
        if not any(row[0] == "EDGE_SE2" for row in rows):
            sys.exit(f"{path}: no EDGE_SE2: only planar graphs are cut and extended")
        self.vertices = [row for row in rows if row[0] == "VERTEX_SE2"]
        rank = {row[1]: i for i, row in enumerate(sorted(self.vertices, key=lambda row: int(row[1])))}
        edges = [(rank[row[1]], rank[row[2]], row[3:]) for row in rows if row[0] == "EDGE_SE2"]
        self.vertices = [(rank[row[1]], row[2:]) for row in self.vertices]
        self.odometry = [edge for edge in edges if abs(edge[0] - edge[1]) == 1]
        self.closures = [edge for edge in edges if abs(edge[0] - edge[1]) != 1]

    def false_closures(self, share, passage, chance):
        steps = {(i, j): tuple(map(float, words[:3])) for i, j, words in self.odometry}
        information = self.closures[0][2][3:]
        count, wanted, made = len(self.vertices), round(share * len(self.closures)), []
        while len(made) < wanted:
            i, j = chance.randrange(count - passage), chance.randrange(count - passage)
            if abs(i - j) < APART + passage:
                continue
            at = chance.uniform(-2, 2), chance.uniform(-2, 2), chance.uniform(-3, 3)
            for k in range(min(passage, wanted - len(made))):
                if k:
                    before, after = steps.get((i + k - 1, i + k)), steps.get((j + k - 1, j + k))
                    if before is None or after is None:
                        break
                    at = compose(compose(inverse(before), at), after)
                made.append((i + k, j + k, [repr(value) for value in at] + information))
        return made

    def write(self, path, false, robots, chance):
        """The graph with false closures, its true poses, and which closures are true."""
        size = len(self.vertices) // robots + 1

        def name(rank):
            return str(rank) if robots == 1 else str(((ord("a") + rank // size) << 56) | rank % size)

        closures = self.closures + false
        chance.shuffle(closures)
        within = [edge for edge in self.odometry if edge[0] // size == edge[1] // size]
        with open(path, "w") as out:
            for i, j, words in within + closures:
                out.write(" ".join(["EDGE_SE2", name(i), name(j), *words]) + "\n")
        with open(f"{path}.truth", "w") as out:
            for rank, words in self.vertices:
                out.write(" ".join(["VERTEX_SE2", name(rank), *words]) + "\n")


def solve(binary, graph, result, *options):
    """The summary of a run, which an earlier call may have left."""
    if not (result / "summary.json").exists():
        subprocess.run([binary, graph, "--no-pictures", "-o", result, *options], capture_output=True, timeout=1200)
    return json.loads((result / "summary.json").read_text())


def judged(binary, folder, base, case, seed, method):
    """The error of the path, and whether the map is called bad."""
    share, passage, robots = case
    path = folder / f"{base.stem}_{share}_{passage}_{robots}_{seed}.g2o"
    solve(binary, base, folder / base.stem, "--method", "lm")
    if not path.exists():
        chance, graph = random.Random(seed), Graph(folder / base.stem / "graph.g2o")
        graph.write(path, graph.false_closures(share, passage, chance), robots, chance)
    summary = solve(binary, path, folder / f"{path.stem}_{method}", "--method", method, "--truth", f"{path}.truth")
    return (summary["truth"]["trajectory"]["aligned"]["rmse_m"], any(entry["verdict"] == "bad" for entry in summary["health"]))


def main():
    if len(sys.argv) < 6:
        sys.exit(__doc__)
    binary, folder, seeds, method = pathlib.Path(sys.argv[1]) / "hybrid-pgo", pathlib.Path(sys.argv[2]), seeds_of(sys.argv[3]), sys.argv[4]
    folder.mkdir(parents=True, exist_ok=True)
    print("| false closures | robots | maps | path [m] | wrong | called bad | right | called bad |\n|---|---|---|---|---|---|---|---|")
    for case in CASES:
        share, passage, robots = case
        runs = [judged(binary, folder, pathlib.Path(base), case, seed, method) for base in sys.argv[5:] for seed in seeds]
        wrong = [bad for error, bad in runs if error > TOLERANCE]
        right = [bad for error, bad in runs if error <= TOLERANCE]
        errors = [error for error, _ in runs]
        print(f"| {share:.0%}, {'at random' if passage == 1 else f'passages of {passage}'} | {robots} | {len(runs)} | "
              f"{statistics.median(errors):.3f}, {max(errors):.3f} | {len(wrong)} | {sum(wrong)} | {len(right)} | {sum(right)} |", flush=True)


if __name__ == "__main__":
    main()
