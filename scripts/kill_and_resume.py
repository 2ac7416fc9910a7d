#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Kills runs that make a map at random moments and resumes them: kill_and_resume.py -c INI -n 200.

Each run is killed (SIGKILL) at a moment that is uniform over the time of an undisturbed one. Its map is checked by
hybrid-map and resumed. Counts the runs that had written nothing yet, those that had ended, the maps that do not open, and
those whose landmarks and trajectory are in the end, byte by byte, those of the undisturbed run."""

import argparse
import json
import os
import pathlib
import random
import signal
import subprocess
import time

BIN = pathlib.Path(__file__).resolve().parent.parent / "build" / "release" / "bin"


def program(name, *arguments):
    """Exit code and output of a program."""
    done = subprocess.run([BIN / name, *map(str, arguments)], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    return done.returncode, done.stdout


def content(map_file, out):
    """Landmarks and trajectory of a map."""
    code, text = program("hybrid-map", "export", "--no-pictures", map_file, "-o", out)
    return (out / "landmarks.csv").read_text() + (out / "trajectory_1.tum").read_text() if code == 0 else text


def state(map_file):
    """What a killed run has left: nothing, damaged, interrupted or complete."""
    if not map_file.exists() or map_file.stat().st_size == 0:
        return "nothing"
    code, text = program("hybrid-map", "check", map_file)
    if "not a map yet" in text:
        return "nothing"
    if code != 0:
        return "damaged"
    sessions = json.loads(program("hybrid-map", "info", "--json", map_file)[1])["sessions"]
    return "complete" if sessions and sessions[0]["complete"] else "interrupted"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-c", "--config", required=True, help="INI of the run")
    parser.add_argument("--rawlog", required=True, help="its log")
    parser.add_argument("-n", "--runs", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("-o", "--out", default="kill_and_resume", help="folder of the maps")
    args = parser.parse_args()
    out = pathlib.Path(args.out)
    out.mkdir(parents=True, exist_ok=True)
    arguments = ["--no-pictures", "-c", args.config, "--rawlog", args.rawlog, "-o", out / "run", "--map"]

    whole, killed = out / "whole.hmap", out / "killed.hmap"
    whole.unlink(missing_ok=True)
    start = time.monotonic()
    code, text = program("hybrid-replay", *arguments, whole)
    duration = time.monotonic() - start
    if code != 0:
        raise SystemExit(text)
    expected = content(whole, out / "export")

    draw = random.Random(args.seed)
    count = {"nothing": 0, "interrupted": 0, "complete": 0, "damaged": 0, "same": 0}
    for run in range(args.runs):
        for old in out.glob("killed.hmap*"):
            old.unlink()
        replay = subprocess.Popen([BIN / "hybrid-replay", *map(str, [*arguments, killed])], stdout=subprocess.DEVNULL,
                                  stderr=subprocess.DEVNULL, start_new_session=True)
        time.sleep(draw.uniform(0, duration))
        if replay.poll() is None:
            os.killpg(replay.pid, signal.SIGKILL)
        replay.wait()
        left = state(killed)
        count[left] += 1
        if left != "complete":
            code, text = program("hybrid-replay", *arguments, killed, "--resume")
            if code != 0:
                print(f"run {run}: {text}")
        count["same"] += content(killed, out / "export") == expected
        print(f"\r{run + 1} of {args.runs}", end="", flush=True)
    print("\r" + ", ".join(f"{n} {what}" for what, n in count.items()))
    return 0 if count["same"] == args.runs else 1


if __name__ == "__main__":
    raise SystemExit(main())
