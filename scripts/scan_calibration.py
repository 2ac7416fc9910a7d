#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""How far the probabilities of closures by laser scans are right: scan_calibration.py -c INI -o OUT [--seeds 20] [--first 1].

For each seed, hybrid-simulate makes a log of the scenario and hybrid-replay maps it. A closure is false if its pose is more
than half a metre or 0.15 rad from the truth, further than poses that the search takes for one, or if the same search found a
pose that is nearer to the truth: at most one of them is right. Prints for each seed the
closures, those that are false, those accepted with probability above 0.99 and the false ones among these, the expected
calibration error of the probabilities (ten bins of equal width, weighted by their closures), the same of closures whose search
found several poses, the root mean square of the position along the path [m], and the NEES of poses per degree of freedom; at
the end the median and the worst of all seeds, and the figures of all closures together."""

import argparse
import csv
import json
import math
import pathlib
import statistics
import subprocess

BUILD = pathlib.Path(__file__).resolve().parent.parent / "build" / "release"
FAR, TURNED = 0.5, 0.15  # [m], [rad]: beyond, a closure is false
SURE = 0.99
BINS = 10


def run(name, *arguments):
    done = subprocess.run([BUILD / "bin" / name, *map(str, arguments)], stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          text=True)
    if done.returncode != 0:
        raise SystemExit(f"{name}: {done.stdout}")


def wrapped(angle):
    return math.atan2(math.sin(angle), math.cos(angle))


def between(a, b):
    """Pose b in the frame of pose a, of (x, y, yaw)."""
    dx, dy = b[0] - a[0], b[1] - a[1]
    c, s = math.cos(a[2]), math.sin(a[2])
    return c * dx + s * dy, c * dy - s * dx, wrapped(b[2] - a[2])


def rows_of(name):
    """The numbers of each line that is no comment."""
    lines = name.read_text().splitlines()
    return [[float(word) for word in line.split()] for line in lines if line.strip() and line[0] not in "#%"]


def true_poses(out, truth):
    """The true (x, y, yaw) by the time of its scan [ms]; the truth has a row of x y z yaw pitch roll for each."""
    scans, poses = rows_of(out / "trajectory.tum"), rows_of(truth)
    if len(scans) != len(poses):
        raise SystemExit(f"{len(scans)} scans, {len(poses)} true poses")
    return {round(1e3 * scan[0]): (pose[0], pose[1], pose[3]) for scan, pose in zip(scans, poses)}


def error_of(measured, a, b):
    """Distance and angle of a relative pose from the true one."""
    true = between(a, b)
    return math.hypot(measured[0] - true[0], measured[1] - true[1]), abs(wrapped(measured[2] - true[2]))


def right_of(errors):
    """Of the (distance, angle) of all poses of one search, which is right."""
    nearest = min(range(len(errors)), key=lambda k: max(errors[k][0] / FAR, errors[k][1] / TURNED))
    return [int(k == nearest and e[0] <= FAR and e[1] <= TURNED) for k, e in enumerate(errors)]


def calibration_error(judged):
    """Expected calibration error of (probability, is it right); None of nothing."""
    if not judged:
        return None
    bins = [[] for _ in range(BINS)]
    for p, right in judged:
        bins[min(int(p * BINS), BINS - 1)].append((p, right))
    return sum(abs(sum(p for p, _ in b) - sum(r for _, r in b)) for b in bins) / len(judged)


def judged_closures(out, truth):
    """(probability, right, accepted, poses of the same search) of each closure of a replay."""
    with open(out / "steps.csv") as file:
        times = [float(row["time"]) for row in csv.DictReader(file)]
    rows = []
    if not (out / "loops.csv").exists():
        return rows
    with open(out / "loops.csv") as file:
        closures = list(csv.DictReader(file))
    while closures:  # those of one search follow each other
        modes = int(closures[0]["modes"])
        search, closures = closures[:modes], closures[modes:]
        errors = []
        for r in search:
            a, b = (truth[round(1e3 * times[int(r[k])])] for k in "ij")
            errors.append(error_of(tuple(float(r[k]) for k in ("x", "y", "yaw")), a, b))
        for r, right in zip(search, right_of(errors)):
            rows.append((float(r["inlier_probability"]), right, r["decision"] == "accepted", modes))
    return rows


def figures(rows, summary):
    sure = [r for r in rows if r[2] and r[0] > SURE]
    several = [r for r in rows if r[3] > 1]
    truth = summary.get("truth", {})
    return {
        "closures": len(rows),
        "false": sum(1 - r[1] for r in rows),
        "sure": len(sure),
        "sure_false": sum(1 - r[1] for r in sure),
        "ece": calibration_error([r[:2] for r in rows]),
        "ambiguous": len(several),
        "ece_ambiguous": calibration_error([r[:2] for r in several]),
        "rmse": truth.get("trajectory", {}).get("rmse_m"),
        "nees": truth.get("nees_pose"),
    }


def shown(value):
    return "-" if value is None else f"{value:.3g}" if isinstance(value, float) else str(value)


def print_row(name, values):
    print("| " + " | ".join([name] + [shown(v) for v in values]) + " |", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-c", dest="config", type=pathlib.Path, required=True)
    parser.add_argument("-o", dest="out", type=pathlib.Path, required=True)
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--first", type=int, default=1, help="seed")
    parser.add_argument("--set", action="append", default=[], help="of hybrid-replay, as given")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    pooled, table = [], []
    names = None
    for seed in range(options.first, options.first + options.seeds):
        log = options.out / f"{seed}.rawlog"
        out = options.out / str(seed)
        run("hybrid-simulate", "-c", options.config, "--seed", seed, "-o", log)
        true_path = log.with_name(f"{seed}_ground_truth_robot_path.txt")
        settings = [w for s in options.set for w in ("--set", s)]
        run("hybrid-replay", "--no-pictures", log, "--truth-path", true_path, *settings, "-o", out)
        rows = judged_closures(out, true_poses(out, true_path))
        log.unlink()
        row = figures(rows, json.loads((out / "summary.json").read_text()))
        if names is None:
            names = list(row)
            print_row("seed", names)
            print("|---" * (len(names) + 1) + "|")
        print_row(str(seed), row.values())
        pooled += rows
        table.append(row)
    for name, choose in (("median", statistics.median), ("worst", max), ("least", min)):
        print_row(name, [choose([r[k] for r in table if r[k] is not None] or [math.nan]) for k in names])
    together = figures(pooled, {})
    print_row("together", together.values())


if __name__ == "__main__":
    main()
