#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Judges association by many runs of the same logs, with other intervals between keyframes.

  intervals.py BIN INI [--ids INI] [-l RAWLOG ...] [-i SECONDS ...] [-t yes no] [-s SECTION.KEY=VALUE ...]

BIN is the folder of hybrid-replay. INI is replayed for every rawlog (that of the INI if none is named; its truth is
RAWLOG without .rawlog and _ground_truth_robot_path.txt), interval [s] and choice of tracklets, one run at a time.
With --ids, a configuration that knows which landmark is which, every error is divided by that of the run with ids of
the same rawlog and interval, with tracklets. Prints a line for each run, then median and worst of path rmse [m] and of
that ratio, of the ratio to dead reckoning, and the numbers of landmarks.
"""

import argparse
import json
import pathlib
import statistics
import subprocess
import sys
import tempfile


def replay(program, ini, rawlog, settings):
    """Path rmse after alignment [m], that of dead reckoning, landmarks; None where the run fails."""
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder, "result")
        command = [str(program), "--no-pictures", "-c", ini, "-o", str(out)]
        if rawlog:
            truth = rawlog.removesuffix(".rawlog") + "_ground_truth_robot_path.txt"
            command += ["--rawlog", rawlog, "--truth-path", truth]
        for setting in settings:
            command += ["--set", setting]
        if subprocess.run(command, capture_output=True, check=False).returncode not in (0, 2):
            return None
        summary = json.loads((out / "summary.json").read_text(encoding="utf-8"))
    truth = summary["truth"]
    rmse = [truth[name]["aligned"]["rmse_m"] for name in ("trajectory", "dead_reckoning")]
    return rmse[0], rmse[1], summary["landmarks"]


def spread(name, values):
    """A line of the summary."""
    if values:
        print(f"{name}: median {statistics.median(values):.3g}, worst {max(values):.3g}, of {len(values)} runs")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bin", type=pathlib.Path)
    parser.add_argument("ini")
    parser.add_argument("--ids", help="configuration with ids, to compare with")
    parser.add_argument("-l", "--rawlogs", nargs="+", default=[None])
    parser.add_argument("-i", "--intervals", nargs="+", type=float, default=[0.8, 1, 1.25, 1.5, 2])
    parser.add_argument("-t", "--tracklets", nargs="+", choices=["yes", "no"], default=["yes", "no"])
    parser.add_argument("-s", "--set", nargs="+", default=[], metavar="SECTION.KEY=VALUE")
    options = parser.parse_args()
    program = options.bin / "hybrid-replay"
    errors, by_ids, by_odometry, landmarks, failed = [], [], [], [], 0
    for rawlog in options.rawlogs:
        for interval in options.intervals:
            every = [f"keyframes.min_time={interval:g}"]
            named = None
            if options.ids:
                named = replay(program, options.ids, rawlog, every + ["keyframes.tracklets=yes"])
            for tracklets in options.tracklets:
                settings = every + [f"keyframes.tracklets={tracklets}"] + options.set
                found = replay(program, options.ini, rawlog, settings)
                label = f"{pathlib.Path(rawlog or options.ini).stem} every {interval:g} s, tracklets {tracklets}"
                if found is None:
                    failed += 1
                    print(f"{label}: failed", flush=True)
                    continue
                rmse, odometry, count = found
                errors.append(rmse)
                by_odometry.append(rmse / odometry)
                landmarks.append(count)
                if named:
                    by_ids.append(rmse / named[0])
                with_ids = f"{named[0]:.3f}" if named else "-"
                print(f"{label}: {rmse:.3f} m, with ids {with_ids}, odometry {odometry:.3f}, "
                      f"{count} landmarks", flush=True)
    spread("path rmse [m]", errors)
    spread("over that with ids", by_ids)
    spread("over that of odometry", by_odometry)
    spread("landmarks", landmarks)
    if failed:
        print(f"{failed} runs failed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
