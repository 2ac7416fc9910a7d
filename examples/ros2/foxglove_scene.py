# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Maps as messages foxglove.SceneUpdate: landmarks are spheres with their names, the path is a line, the robot an arrow."""

import json
import math

NAME = "foxglove.SceneUpdate"
TOPIC = "/hybrid/map"
COLORS = ((0.3, 0.5, 0.8), (0.9, 0.5, 0.2), (0.3, 0.65, 0.35), (0.8, 0.3, 0.3), (0.55, 0.4, 0.7), (0.5, 0.35, 0.3))
KINDS = ("arrows", "cubes", "spheres", "cylinders", "lines", "triangles", "texts", "models")
POINTS = 100  # of a line; then the next line begins, so that a long path is not sent again with each step


def record(**fields):
    return {"type": "object", "properties": fields}


def array(of):
    return {"type": "array", "items": of}


NUMBER, TEXT = {"type": "number"}, {"type": "string"}
TIME = record(sec={"type": "integer"}, nsec={"type": "integer"})
POINT, COLOR = record(x=NUMBER, y=NUMBER, z=NUMBER), record(r=NUMBER, g=NUMBER, b=NUMBER, a=NUMBER)
POSE = record(position=POINT, orientation=record(x=NUMBER, y=NUMBER, z=NUMBER, w=NUMBER))
SCHEMA = record(
    deletions=array(record(timestamp=TIME, type={"type": "integer"}, id=TEXT)),
    entities=array(record(
        timestamp=TIME, frame_id=TEXT, id=TEXT, lifetime=TIME, frame_locked={"type": "boolean"},
        metadata=array(record(key=TEXT, value=TEXT)),
        arrows=array(record(pose=POSE, shaft_length=NUMBER, shaft_diameter=NUMBER, head_length=NUMBER,
                            head_diameter=NUMBER, color=COLOR)),
        spheres=array(record(pose=POSE, size=POINT, color=COLOR)),
        lines=array(record(type={"type": "integer"}, pose=POSE, thickness=NUMBER, scale_invariant={"type": "boolean"},
                           points=array(POINT), color=COLOR, colors=array(COLOR), indices=array({"type": "integer"}))),
        texts=array(record(pose=POSE, billboard={"type": "boolean"}, font_size=NUMBER,
                           scale_invariant={"type": "boolean"}, color=COLOR, text=TEXT)),
        cubes=array(record()), cylinders=array(record()), triangles=array(record()), models=array(record()))))


def point(p):
    return dict(zip("xyz", (*p, 0.0, 0.0, 0.0)[:3] if len(p) < 3 else p))


def color(rgb):
    return dict(zip("rgba", (*rgb, 1.0)))


def pose_at(position, orientation=(0.0, 0.0, 0.0, 1.0)):
    return {"position": point(position), "orientation": dict(zip("xyzw", orientation))}


def rotation(pose):
    """The quaternion of [x, y, yaw], or of [x, y, z, yaw, pitch, roll]."""
    yaw, pitch, roll = (pose[2], 0.0, 0.0) if len(pose) == 3 else pose[3:]
    (cy, sy), (cp, sp), (cr, sr) = ((math.cos(a / 2), math.sin(a / 2)) for a in (yaw, pitch, roll))
    return (sr * cp * cy - cr * sp * sy, cr * sp * cy + sr * cp * sy, cr * cp * sy - sr * sp * cy, cr * cp * cy + sr * sp * sy)


class Scene:
    """Makes an update of each step of a map."""

    def __init__(self, frame="map"):
        self.frame, self.path, self.classes = frame, [], []

    def time(self, seconds):
        seconds = max(0.0, seconds)
        whole = math.floor(seconds)
        return {"sec": whole, "nsec": min(round((seconds - whole) * 1e9), 999_999_999)}

    def entity(self, seconds, name, metadata=(), **parts):
        return {"timestamp": self.time(seconds), "frame_id": self.frame, "id": name, "lifetime": {"sec": 0, "nsec": 0},
                "frame_locked": False, "metadata": [{"key": k, "value": str(v)} for k, v in metadata],
                **{kind: parts.get(kind, []) for kind in KINDS}}

    def landmark(self, seconds, landmark):
        name, at = landmark.get("class", ""), landmark["position"]
        if name not in self.classes:
            self.classes.append(name)
        paint = color(COLORS[self.classes.index(name) % len(COLORS)])
        label = {"pose": pose_at((at[0], at[1], (at[2] if len(at) > 2 else 0.0) + 0.3)), "billboard": True, "font_size": 12.0,
                 "scale_invariant": True, "color": color((0.6, 0.6, 0.6)), "text": f"{landmark['id']} {name}".strip()}
        sphere = {"pose": pose_at(at), "size": {"x": 0.3, "y": 0.3, "z": 0.3}, "color": paint}
        return self.entity(seconds, f"landmark/{landmark['id']}", [("sightings", landmark.get("sightings", ""))],
                           spheres=[sphere], texts=[label])

    def step(self, seconds, pose):
        """The robot, and the piece of the path that ends with it."""
        at = pose[:2] if len(pose) == 3 else pose[:3]
        self.path.append(point(at))
        first = (len(self.path) - 1) // POINTS * POINTS
        line = {"type": 0, "pose": pose_at((0.0, 0.0, 0.0)), "thickness": 2.0, "scale_invariant": True,
                "points": self.path[max(first - 1, 0):], "color": color((0.4, 0.4, 0.4)), "colors": [], "indices": []}
        arrow = {"pose": pose_at(at, rotation(pose)), "shaft_length": 0.6, "shaft_diameter": 0.15, "head_length": 0.3,
                 "head_diameter": 0.3, "color": color((0.1, 0.1, 0.1))}
        return [self.entity(seconds, f"path/{first // POINTS}", lines=[line]), self.entity(seconds, "robot", arrows=[arrow])]

    def of_line(self, line):
        """(time, update) of a line of `hybrid-replay --stream`."""
        step = json.loads(line)
        seconds = step["time"]
        gone = [{"timestamp": self.time(seconds), "type": 0, "id": f"landmark/{number}"} for number in step["removed"]]
        entities = [*self.step(seconds, step["pose"]), *(self.landmark(seconds, l) for l in step["changed"])]
        return seconds, {"deletions": gone, "entities": entities}
