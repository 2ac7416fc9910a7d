#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Shows a map in Rerun while it is made: hybrid-replay ... --stream | stream_to_rerun.py [-o FILE.rrd]

Opens the viewer, which is part of Rerun's Python package (pip install rerun-sdk, 0.23 or later). With -o, the steps are
written to a file that the viewer opens.
"""

import argparse
import json
import math
import sys

from bag_words import DAMAGE
from foxglove_scene import COLORS, POINTS


class Scene:
    """Logs each step of a map: landmarks are points with their names, the path is a line, the robot an arrow."""

    def __init__(self, rr):
        self.rr, self.path, self.classes = rr, [], []

    def landmark(self, landmark):
        name, at = landmark.get("class", ""), [*landmark["position"], 0.0][:3]
        if name not in self.classes:
            self.classes.append(name)
        paint = [round(255 * c) for c in COLORS[self.classes.index(name) % len(COLORS)]]
        self.rr.log(f"map/landmarks/{landmark['id']}",
                    self.rr.Points3D([at], radii=[0.15], colors=[paint], labels=[f"{landmark['id']} {name}".strip()]))

    def step(self, pose):
        """The robot, and the piece of the path that ends with it."""
        yaw, pitch = (pose[2], 0.0) if len(pose) == 3 else pose[3:5]
        at = [*pose[:2], 0.0] if len(pose) == 3 else pose[:3]
        self.path.append(at)
        first = (len(self.path) - 1) // POINTS * POINTS
        self.rr.log(f"map/path/{first // POINTS}", self.rr.LineStrips3D([self.path[max(first - 1, 0):]]))
        ahead = [math.cos(yaw) * math.cos(pitch), math.sin(yaw) * math.cos(pitch), -math.sin(pitch)]
        self.rr.log("map/robot", self.rr.Arrows3D(origins=[at], vectors=[ahead]))

    def log_line(self, line):
        """A line of `hybrid-replay --stream`."""
        step = json.loads(line)
        self.rr.set_time("keyframe", sequence=step["keyframe"])
        self.rr.set_time("time", timestamp=step["time"])
        for number in step["removed"]:
            self.rr.log(f"map/landmarks/{number}", self.rr.Clear(recursive=False))
        self.step(step["pose"])
        for landmark in step["changed"]:
            self.landmark(landmark)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", "--output", metavar="FILE.rrd", help="write a file instead of opening the viewer")
    options = parser.parse_args()
    try:
        import rerun
        rerun.init("hybrid", spawn=not options.output)
        if options.output:
            rerun.save(options.output)
        scene = Scene(rerun)
        for line in sys.stdin:
            scene.log_line(line)
    except KeyboardInterrupt:
        pass
    except ImportError:
        sys.exit("error: this needs Rerun's Python package: pip install rerun-sdk")
    except (OSError, *DAMAGE) as error:
        sys.exit(f"error: {error}: standard input is what hybrid-replay --stream writes")


if __name__ == "__main__":
    main()
