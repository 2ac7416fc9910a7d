#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Localises a robot that starts anywhere in a log in the map of its first part: random_starts.py -c INI --split ENTRY.

The log of the INI is cut at ENTRY by MRPT's rawlog-edit (package mrpt-apps). The first part makes a map, which the second
extends; then pieces of the second, from random entries to its end, are localised in it. Prints for each at which of its
keyframes it came within 5 m of the path of the first part, and at which its place was known; and how far its path is from
then on from that of one run over the whole log, and how far both are from the truth, where that is known: means in the frame
of the map, without alignment [m]. With --map, the starts are localised in that map, of another place."""

import argparse
import json
import pathlib
import random
import re
import shutil
import subprocess

import numpy as np

BUILD = pathlib.Path(__file__).resolve().parent.parent / "build" / "release"


def run(name, *arguments):
    """Output of a program of the build, or of the system; a replay may find no place (2)."""
    program = BUILD / "bin" / name
    done = subprocess.run([program if program.exists() else name, *map(str, arguments)], stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, text=True)
    if done.returncode not in (0, 2):
        raise SystemExit(done.stdout)
    return done.stdout


def cut(log, out, first, last=None):
    """Entries first to last of a log."""
    limits = ["--from-index", first] if last is None else ["--from-index", first, "--to-index", last]
    run("rawlog-edit", "-p", BUILD / "lib" / "libhybrid_mrpt.so", "--cut", "-w", "-i", log, "-o", out, *limits)


def replay(config, log, out, *more):
    """Summary of a replay, and its path."""
    run("hybrid-replay", "--no-pictures", "-c", config, "--rawlog", log, "-o", out, *more)
    return json.loads((out / "summary.json").read_text()), path(out / "trajectory.tum")


def path(name):
    """Rows of time, x, y, z; None without a file."""
    return np.loadtxt(name, ndmin=2)[:, :4] if name.exists() else None


def distance(a, b):
    """Mean and largest distance of path a from b at the times of a, where b is known."""
    if a is None or b is None:
        return np.nan, np.nan
    a = a[(a[:, 0] >= b[0, 0]) & (a[:, 0] <= b[-1, 0])]
    at = np.column_stack([np.interp(a[:, 0], b[:, 0], b[:, k]) for k in (1, 2, 3)])
    d = np.linalg.norm(a[:, 1:] - at, axis=1)
    return d.mean(), d.max()


def first_near(a, b, c):
    """The first row of path a at whose time path b is within 5 m, a street's width, of path c."""
    for k, row in enumerate(a):
        at = [np.interp(row[0], b[:, 0], b[:, i]) for i in (1, 2, 3)]
        if np.linalg.norm(c[:, 1:] - at, axis=1).min() < 5:
            return k
    return "never"


def value_of(config, key):
    """The value of a key of [log] in an INI, as a path from there."""
    value = re.search(rf"^{key}\s*=\s*(\S+)", config.read_text(), re.M)
    return (config.parent / value.group(1)).resolve() if value else None


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-c", dest="config", type=pathlib.Path, required=True)
    parser.add_argument("--split", type=int, required=True, help="first entry of the second part")
    parser.add_argument("--end", type=int, help="last entry of the second part")
    parser.add_argument("--starts", type=int, default=20)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--map", type=pathlib.Path, help="of another place, where none may be found")
    parser.add_argument("-o", dest="out", type=pathlib.Path, required=True)
    options = parser.parse_args()
    out, config, log = options.out, options.config, value_of(options.config, "rawlog")
    out.mkdir(parents=True, exist_ok=True)
    info = run("rawlog-edit", "-p", BUILD / "lib" / "libhybrid_mrpt.so", "--info", "-i", log)
    end = options.end or int(re.search(r"Overall number of objects\s*:\s*(\d+)", info).group(1)) - 1

    whole, known_streets, truth = None, None, None
    place = options.map
    if place is None:
        place = out / "place.hmap"
        place.unlink(missing_ok=True)
        given = value_of(config, "truth_path")
        _, whole = replay(config, log, out / "whole", *(["--truth-path", given] if given else []))
        truth = path(out / "whole" / "trajectory_truth.tum")
        cut(log, out / "first.rawlog", 0, options.split - 1)
        cut(log, out / "second.rawlog", options.split, end)
        replay(config, out / "first.rawlog", out / "first", "--map", place)
        shutil.copy(place, out / "extended.hmap")
        known_streets = path(out / "first" / "trajectory.tum")
        summary, extended = replay(config, out / "second.rawlog", out / "extended", "--map", out / "extended.hmap")
        print(f"extended, place known at {summary['localized_at']}: {distance(extended, truth)[0]:.3f} from the truth, "
              f"one run {distance(whole[whole[:, 0] >= extended[0, 0]], truth)[0]:.3f}", flush=True)

    print("   entry keyframes entered known_at  from_one_run (largest)   from_truth one_run_from_truth", flush=True)
    draw = random.Random(options.seed)
    for _ in range(options.starts):
        start = draw.randrange(options.split, options.split + (end - options.split) * 3 // 4, 2)  # entries are pairs
        cut(log, out / "piece.rawlog", start, end)
        summary, piece = replay(config, out / "piece.rawlog", out / "piece", "--map", place, "--map-mode", "localize")
        known = summary["localized_at"]
        entered = "-" if whole is None else first_near(piece, whole, known_streets)
        piece = piece[known or 0:]
        near = distance(piece, whole) if known is not None else (np.nan, np.nan)
        right = distance(piece, truth)[0] if known is not None else np.nan
        same = whole[whole[:, 0] >= piece[0, 0]] if whole is not None else None
        print(f"{start:8} {summary['keyframes']:9} {entered:>7} {'never' if known is None else known:>8}  "
              f"{near[0]:12.3f} {near[1]:9.3f}   {right:10.3f} {distance(same, truth)[0]:18.3f}", flush=True)


if __name__ == "__main__":
    main()
