#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Adds false loop closures to a graph with hypotheses: add_false_closures.py GRAPH --rate 0.2 --seed 1 -o FALSE.txt.

They are single hypotheses (EDGE2 i 1 j 0 1 x y angle) between poses of random ids that are not neighbours: x and y normal
with a standard deviation of 0.5 m, the angle uniform. They make up the share `rate` of all closures. The same seed gives
the same file. With --labels, the pairs of the closures that were there are written too, for `hybrid-pgo --labels`."""

import argparse
import math
import pathlib
import random


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("graph", type=pathlib.Path)
    parser.add_argument("--rate", type=float, required=True, help="share of false ones of all closures, below 1")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--labels", type=pathlib.Path)
    parser.add_argument("-o", "--output", type=pathlib.Path, required=True)
    options = parser.parse_args()
    if not 0 <= options.rate < 1:
        parser.error(f"--rate {options.rate}: from 0 to below 1")
    lines = [line for line in options.graph.read_text(encoding="utf-8").splitlines() if line.strip()]
    pairs = []
    for number, line in enumerate(lines, 1):
        words = line.split()
        if words[0] != "EDGE2" or len(words) < 9 or words[2] != "1" or words[4] != "0":
            parser.error(f"{options.graph}:{number}: expected EDGE2 i 1 j 0 n x y angle ...")
        pairs.append((int(words[1]), int(words[3])))
    true = [(i, j) for i, j in pairs if j != i + 1]
    last = max(j for _, j in pairs)
    if last < 2:
        parser.error(f"{options.graph}: fewer than three poses")
    chance = random.Random(options.seed)
    false = {}
    for _ in range(round(len(true) * options.rate / (1 - options.rate))):
        i = j = 0
        while j - i < 2:
            i, j = sorted((chance.randint(0, last), chance.randint(0, last)))
        x, y, angle = chance.gauss(0, 0.5), chance.gauss(0, 0.5), chance.uniform(-math.pi, math.pi)
        false.setdefault(j, []).append(f"EDGE2 {i} 1 {j} 0 1 {x:.6f} {y:.6f} {angle:.6f}")
    added = [line for j in sorted(false) for line in false[j]]
    options.output.write_text("\n".join(lines + added) + "\n", encoding="utf-8")
    if options.labels:
        options.labels.write_text("".join(f"{i} {j}\n" for i, j in true), encoding="utf-8")
    print(f"{len(true)} closures, {len(added)} false ones added -> {options.output}")


if __name__ == "__main__":
    main()
