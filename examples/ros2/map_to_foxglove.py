#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Makes a file in MCAP, which Foxglove opens, of the results of hybrid-replay: map_to_foxglove.py OUT -o map.mcap

It holds the final path, pose by pose at its own time, and all landmarks from the first pose on, on the topic /hybrid/map.
"""

import argparse
import json
import pathlib
import sys

from foxglove_scene import NAME, SCHEMA, TOPIC, Scene
from mcap_to_csv import angles_of
from mcap_writer import McapWriter


def poses_of(path):
    """(time, pose) of each row of a trajectory in TUM form."""
    for line in path.read_text(encoding="utf-8").splitlines():
        if line and line[0] != "#":
            time, x, y, z, *q = map(float, line.split())
            yield time, [x, y, z, *angles_of(q)]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("results", help="the output folder of hybrid-replay")
    parser.add_argument("-o", "--output", metavar="FILE.mcap", required=True)
    options = parser.parse_args()
    folder, scene = pathlib.Path(options.results), Scene()
    try:
        landmarks = json.loads((folder / "landmarks.json").read_text(encoding="utf-8"))["landmarks"]
        poses = list(poses_of(folder / "trajectory.tum"))
        with open(options.output, "wb") as file:
            writer = McapWriter(file, TOPIC, NAME, SCHEMA)
            for k, (time, pose) in enumerate(poses):
                entities = scene.step(time, pose) + ([scene.landmark(time, l) for l in landmarks] if k == 0 else [])
                writer.write(time, {"deletions": [], "entities": entities})
            writer.close()
    except (OSError, ValueError, KeyError) as error:
        sys.exit(f"error: {error}: {folder} should be an output folder of hybrid-replay")
    print(f"wrote {options.output}: {writer.count} poses, {len(landmarks)} landmarks")


if __name__ == "__main__":
    main()
