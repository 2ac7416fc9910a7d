#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Prints what results become with each constant of an INI section at half and at twice its default.

  half_and_twice.py replay [-s SECTION] [-k KEY,...] LABEL=INI ...      aligned path rmse [m], landmarks
  half_and_twice.py experiment [-s SECTION] [-k KEY,...] LABEL=INI ...  mean error [m], precision, recall

Odds are halved and doubled of a probability, every number of a list. Prints a Markdown table with a row
for each key and a column for each log, or for each graph and method.
"""

import argparse
import configparser
import csv
import json
import pathlib
import re
import subprocess
import sys
import tempfile

PROBABILITIES = {"gate", "detection_probability", "moving_share", "min_redundancy"}
FORMAT = re.compile(r"\((?P<kind>number|whole number|list of numbers)(?P<limits>.*); default (?P<value>.*)\)$")


def keys_of(program, section):
    """Numeric keys of a section: name, default as a list of numbers, whether they are whole."""
    text = subprocess.run([program, "--print-config"], check=True, capture_output=True, text=True).stdout
    keys, inside, note = {}, False, ""
    for line in text.splitlines():
        if line.startswith("["):
            inside = line == f"[{section}]"
        elif line.startswith("#"):
            note = line
        elif "=" in line and inside:
            found = FORMAT.search(note)
            if found and found["value"].strip():
                values = [float(word) for word in found["value"].split()]
                keys[line.split("=")[0].strip()] = (values, found["kind"] == "whole number")
    return keys


def scaled(key, values, whole, by):
    """The value of a key at `by` times its default, as text."""
    out = []
    for value in values:
        if key in PROBABILITIES and value < 1:
            odds = by * value / (1 - value)
            value = odds / (1 + odds)
        else:
            value *= by
        out.append(str(max(1, round(value))) if whole else f"{value:.9g}")
    return " ".join(out)


def replay(bins, ini, settings):
    """The figures of one log: {'': text}."""
    with tempfile.TemporaryDirectory() as out:
        command = [str(bins / "hybrid-replay"), "--no-pictures", "-c", ini, "-o", f"{out}/result"]
        for setting in settings:
            command += ["--set", setting]
        if subprocess.run(command, capture_output=True, check=False).returncode not in (0, 2):
            return {"": "failed"}
        summary = json.loads(pathlib.Path(out, "result", "summary.json").read_text(encoding="utf-8"))
    rmse = summary["truth"]["trajectory"]["aligned"]["rmse_m"]
    return {"": f"{rmse:.3g}, {summary['landmarks']}"}


def experiment(bins, ini, settings):
    """The figures of an experiment: {' graph method': text}."""
    parser = configparser.ConfigParser(interpolation=None)
    parser.read(ini, encoding="utf-8")
    for setting in settings:
        name, value = setting.split("=", 1)
        section, key = name.split(".", 1)
        if not parser.has_section(section):
            parser.add_section(section)
        parser.set(section, key, value)
    with tempfile.TemporaryDirectory() as out:
        with open(f"{out}/changed.ini", "w", encoding="utf-8") as file:
            parser.write(file)
        command = [str(bins / "hybrid-experiment"), "-c", f"{out}/changed.ini", "-o", f"{out}/result", "-j", "1"]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode not in (0, 2):
            sys.exit(done.stderr)
        with open(f"{out}/result/results.csv", encoding="utf-8", newline="") as file:
            rows = list(csv.DictReader(file))
    return {
        f" {row['graph']} {row['method']}": "failed" if row["status"] != "ok" else
        f"{float(row['ate_mean_m']):.3g}, {float(row['precision']):.3g}, {float(row['recall']):.3g}"
        for row in rows
    }


def measure(run, bins, inputs, settings):
    cells = {}
    for label, ini in inputs:
        for name, text in run(bins, ini, settings).items():
            cells[(label + name).strip()] = text
    return cells


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("kind", choices=["replay", "experiment"])
    parser.add_argument("inputs", nargs="+", metavar="LABEL=INI")
    parser.add_argument("-b", "--bins", type=pathlib.Path, default=pathlib.Path("build/release/bin"))
    parser.add_argument("-s", "--section", default=None, help="default: BearingRangeAssociation or selection")
    parser.add_argument("-k", "--keys", default="", help="only these")
    options = parser.parse_args()
    run = replay if options.kind == "replay" else experiment
    section = options.section or ("BearingRangeAssociation" if run is replay else "selection")
    program = options.bins / ("hybrid-replay" if run is replay else "hybrid-pgo")
    keys = keys_of(str(program), section)
    if options.keys:
        keys = {key: keys[key] for key in options.keys.split(",")}
    inputs = [tuple(word.split("=", 1)) for word in options.inputs]
    default = measure(run, options.bins, inputs, [])
    print("| " + " | ".join(["constant"] + list(default)) + " |")
    print("|" + "---|" * (1 + len(default)))
    print("| " + " | ".join(["defaults"] + list(default.values())) + " |", flush=True)
    for key, (values, whole) in keys.items():
        texts = [scaled(key, values, whole, by) for by in (0.5, 2.0)]
        half, twice = (measure(run, options.bins, inputs, [f"{section}.{key}={text}"]) for text in texts)
        row = ["same" if half[c] == twice[c] == default[c] else
               half[c] + " both" if half[c] == twice[c] else f"{half[c]}; {twice[c]}" for c in default]
        print("| " + " | ".join([f"`{key}` {texts[0]}; {texts[1]}"] + row) + " |", flush=True)


if __name__ == "__main__":
    main()
