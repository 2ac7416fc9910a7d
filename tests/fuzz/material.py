# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Undamaged inputs of all programs, made from nothing but this file, hybrid-simulate and the
repository's own logs and configurations."""

import math
import pathlib
import random
import struct
import subprocess
from dataclasses import dataclass, field

import sensors

ROOT = pathlib.Path(__file__).resolve().parents[2]


@dataclass
class Input:
    """A command and the files it reads. In the command, {NAME} is the path of file NAME, {out} that
    of the result and {dir} the folder of the files."""
    name: str
    program: str
    arguments: list
    files: dict
    formats: dict = field(default_factory=dict)  # of the files that are damaged: name -> format
    result: str = "folder"                       # or "file": the result is {out}.rawlog and others


def numbers(values):
    return " ".join(f"{v:.6g}" for v in values)


def rigid(a):
    return math.cos(a), math.sin(a)


def planar_truth(count):
    """A lap and a half of a square of 4 m with steps of 1 m."""
    pose, path = (0.0, 0.0, 0.0), []
    for i in range(count):
        path.append(pose)
        x, y, a = pose
        c, s = rigid(a)
        turn = math.pi / 2 if i % 4 == 3 else 0.0
        pose = (x + c, y + s, math.remainder(a + turn, 2 * math.pi))
    return path


def between(p, q):
    c, s = rigid(p[2])
    dx, dy = q[0] - p[0], q[1] - p[1]
    return c * dx + s * dy, -s * dx + c * dy, math.remainder(q[2] - p[2], 2 * math.pi)


def noisy(z, rng, sigma=0.01):
    return [v + rng.gauss(0, sigma) for v in z]


def planar_edges(path, rng):
    edges = [(i, i + 1) for i in range(len(path) - 1)]
    edges += [(i, i + 16) for i in range(len(path) - 16)]
    return [(i, j, noisy(between(path[i], path[j]), rng)) for i, j in edges]


def graph_2d(toro=False):
    rng, path = random.Random(1), planar_truth(24)
    information = "100 0 100 400 0 0" if toro else "100 0 0 100 0 400"
    names = ("VERTEX2", "EDGE2") if toro else ("VERTEX_SE2", "EDGE_SE2")
    rows = [f"{names[0]} {i} {numbers(noisy(p, rng, 0.1))}" for i, p in enumerate(path)]
    rows += [f"{names[1]} {i} {j} {numbers(z)} {information}" for i, j, z in planar_edges(path, rng)]
    return "\n".join(rows) + "\n"


def graph_landmarks():
    rng, path = random.Random(2), planar_truth(20)
    rows = [f"VERTEX_SE2 {i} {numbers(p)}" for i, p in enumerate(path)] + ["FIX 0"]
    points = [(1, 5), (6, 2), (2, -2)]
    rows += [f"VERTEX_XY {100 + k} {numbers(p)}" for k, p in enumerate(points)]
    rows += [f"EDGE_SE2 {i} {j} {numbers(z)} 100 0 0 100 0 400"
             for i, j, z in planar_edges(path, rng) if j == i + 1]
    for i, pose in enumerate(path):
        for k, point in enumerate(points):
            z = between(pose, (point[0], point[1], 0))[:2]
            rows.append(f"EDGE_SE2_XY {i} {100 + k} {numbers(noisy(z, rng))} 50 0 50")
    return "\n".join(rows) + "\n"


def graph_3d(toro=False):
    rng, path = random.Random(3), planar_truth(24)
    upper = " ".join("100" if i == j else "0" for i in range(6) for j in range(i, 6))
    rows = []
    for i, (x, y, a) in enumerate(path):
        turn = f"0 0 {a:.6g}" if toro else f"0 0 {math.sin(a / 2):.9g} {math.cos(a / 2):.9g}"
        rows.append(f"{'VERTEX3' if toro else 'VERTEX_SE3:QUAT'} {i} {x:.6g} {y:.6g} 0.1 {turn}")
    for i, j, (x, y, a) in planar_edges(path, rng):
        turn = f"0 0 {a:.6g}" if toro else f"0 0 {math.sin(a / 2):.9g} {math.cos(a / 2):.9g}"
        rows.append(f"{'EDGE3' if toro else 'EDGE_SE3:QUAT'} {i} {j} {x:.6g} {y:.6g} "
                    f"{rng.gauss(0, 0.01):.6g} {turn} {upper}")
    return "\n".join(rows) + "\n"


def graph_hypotheses():
    rng, path = random.Random(4), planar_truth(16)
    rows = [f"VERTEX_SE2 {i} {numbers(p)}" for i, p in enumerate(path)]
    for i, j, z in planar_edges(path, rng):
        if j == i + 1 and i % 5 == 2:
            rows.append(f"EDGE2 {i} 1 {j} 0 2 {numbers(z)} {numbers(noisy(z, rng, 2))}")
        elif j == i + 1:
            rows.append(f"EDGE2 {i} 1 {j} 0 1 {numbers(z)}")
    return "\n".join(rows) + "\n"


def cloud(turn, shift):
    """A corner of three walls."""
    c, s = rigid(turn)
    points = []
    for i in range(9):
        for j in range(9):
            u, v = 0.25 * i, 0.25 * j
            points += [(u, v, 0.03 * math.sin(3 * u)), (u, 0, v), (0, u, v + 0.1)]
    return [(c * x - s * y + shift, s * x + c * y, z) for x, y, z in points]


def rows_of(points, separator=" "):
    return "\n".join(separator.join(f"{v:.6f}" for v in p) for p in points) + "\n"


def ply(points, binary):
    head = ("ply\nformat " + ("binary_little_endian" if binary else "ascii") + " 1.0\n"
            f"element vertex {len(points)}\nproperty float x\nproperty float y\n"
            "property float z\nelement face 1\nproperty list uchar int i\nend_header\n").encode()
    if not binary:
        return head + rows_of(points).encode() + b"3 0 1 2\n"
    return head + b"".join(struct.pack("<3f", *p) for p in points) + struct.pack("<Biii", 3, 0, 1, 2)


def pcd(points):
    return (f"# .PCD v0.7\nVERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\n"
            f"WIDTH {len(points)}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {len(points)}\n"
            f"DATA ascii\n" + rows_of(points))


def tracks():
    """Files of hybrid-objects: a camera that moves along x past two objects."""
    rng, files = random.Random(5), {"odom.txt": "", "cam_gt.txt": ""}
    for name, place in (("cup", (1, 0, 3)), ("box", (2, 0.5, 4))):
        rows = ""
        for i in range(30):
            p = noisy([place[0] - 0.1 * i, place[1], place[2]], rng)
            turn = "0 0 0 0" if i % 7 == 3 else "0 0 0 1"
            rows += f"{0.1 * i:.6f} {numbers(p)} {turn}\n"
        files[f"det_{name}.txt"] = rows
    for i in range(30):
        files["cam_gt.txt"] += f"{0.1 * i:.6f} {0.1 * i:.6f} 0 0 0 0 0 1\n"
        files["odom.txt"] += f"{0.1 * i:.6f} {0.1 * i + rng.gauss(0, 0.01):.6f} 0 0 0 0 0 1\n"
    return files


def series():
    rng, angle, rows = random.Random(6), 0.0, "# k mode x y heading\n"
    for k in range(120):
        mode = (k // 20) % 3
        angle += (0.3, -0.3, 0.0)[mode] + rng.gauss(0, 0.03)
        rows += f"{k} {mode} {math.cos(angle):.6f} {math.sin(angle):.6f} {angle:.6f}\n"
    return rows


def ranges():
    rng, rows, truth = random.Random(7), "", ""
    anchors = [(0, 0), (8, 0), (8, 8), (0, 8)]
    for k in range(60):
        t, x, y = 0.2 * k, 1 + 0.1 * k, 2 + 0.5 * math.sin(0.1 * k)
        a = anchors[k % 4]
        extra = 1.0 if k % 9 == 4 else 0.0
        rows += (f"range2 {t:.6f} {math.dist((x, y), a) + extra + rng.gauss(0, 0.05):.6f} 0.01 "
                 f"{a[0]} {a[1]} {100 + k % 4} 0\n")
        rows += f"odom2diff {t:.6f} 0.5 0.5 0 0.2 0.01 0.01 0.01\n"
        truth += f"point2 {t:.6f} {x:.6f} {y:.6f}\n"
    return rows, truth


def camera_poses(count):
    return "".join(f"1 0 0 0 0 1 0 0 0 0 1 {i}\n" for i in range(count))


def boxes(count):
    return "".join(f"{i} 557 196 100 107.8 2 0.9\n" for i in range(count))


def labels(count):
    return "".join(f"{i} 3 Car 0 0 -1.5 700 160 800 250 1.5 1.6 4.2 2 1.5 {20 - i}.5 0.1\n"
                   for i in range(count))


def import_sets():
    """Files of every format of hybrid-import, with its arguments and the forms of their rows."""
    upper = " ".join("0.01" if i == j else "0" for i in range(6) for j in range(i, 6)) + "\n"
    g2o = "".join(f"EDGE_SE2 {i} {i + 1} 1 0.01 0.02 100 0 0 200 0 400\n" for i in range(9))
    fg = "".join(f"Variable Pose SE2 X{i} {i} 0 0\n" for i in range(6))
    fg += "".join(f"Variable Landmark R2 L{k} {5 * k} 5\n" for k in range(2))
    fg += "".join(f"Factor SE2RelativeGaussianLikelihoodFactor X{i} X{i + 1} 1 0 0.1 covariance "
                  "0.01 0 0 0 0.02 0 0 0 0.03\n" for i in range(5))
    known = fg + "".join(f"Factor SE2R2RangeGaussianLikelihoodFactor X{i} L{i % 2} 6.4 0.5\n"
                         for i in range(6))
    some = fg + "".join(
        f"Factor AmbiguousDataAssociationFactor Observer X{i} Observed L0 L1 Weights 0.5 0.5 "
        "Binary SE2R2RangeGaussianLikelihoodFactor Observation 6.4 Sigma 0.5\n" for i in range(6))
    return {
        "csv": (["csv", "--odometry", "{odometry.csv}", "--detections", "{detections.csv}"], {
            "odometry.csv": "time,x,y,yaw\n" + "".join(f"{i},{0.5 * i},0,0.1\n" for i in range(12)),
            "detections.csv": "time,range,yaw,class,score,id,sigma_range\n" + "".join(
                f"{i}.5,{3 + 0.1 * i:.1f},0.1,{'tree' if i % 2 else 'car'},0.8,{i % 3},0.1\n"
                for i in range(10))}),
        "kitti-2d": (["kitti", "--odometry", "{odometry.g2o}", "--boxes", "{boxes.txt}", "--truth",
                      "{poses.txt}"],
                     {"odometry.g2o": g2o, "boxes.txt": boxes(10), "poses.txt": camera_poses(10)}),
        "kitti-3d": (["kitti", "--odometry", "{odometry.txt}", "--covariances",
                      "{covariances.txt}", "--boxes", "{boxes.txt}", "--oracle-radius", "2",
                      "--truth", "{poses.txt}"],
                     {"odometry.txt": camera_poses(10), "covariances.txt": upper * 9,
                      "boxes.txt": boxes(10), "poses.txt": camera_poses(10)}),
        "kitti-tracking": (["kitti-tracking", "--labels", "{labels.txt}", "--poses", "{poses.txt}"],
                           {"labels.txt": labels(10), "poses.txt": camera_poses(10)}),
        "mrclam": (["mrclam", "{dir}"], {
            "Barcodes.dat": "1 5\n2 14\n6 63\n7 25\n",
            "Landmark_Groundtruth.dat": "6 2.0 1.0 0.0001 0.0002\n7 3.0 1.0 0.0001 0.0002\n",
            "Robot1_Odometry.dat": "".join(f"{i} 0.5 0.1\n" for i in range(20)),
            "Robot1_Groundtruth.dat": "".join(f"{i} {0.5 * i} 0 0.1\n" for i in range(20)),
            "Robot1_Measurement.dat": "".join(f"{i}.5 {(63, 25, 14)[i % 3]} 2.5 0.1\n"
                                              for i in range(15))}),
        "plaza": (["plaza", "{graph.fg}", "--identities", "{known.fg}"],
                  {"graph.fg": some, "known.fg": known}),
        "stata": (["stata", "{dir}"], {
            "frames.txt": "".join(f"{i} {i + 100} 1 0 0 0 0 1 0 0 0 0 1 {i}\n" for i in range(8)),
            "detections.txt": "".join(f"{i} 17 0.9 0.1 0.2 3.5 0.5 10 10 50 50\n"
                                      for i in range(8))}),
        "victoria-park": (["victoria-park", "{dir}"], {
            "odometry.txt": "".join(f"{i} 1 0.01\n" for i in range(12)),
            "scan_times.txt": "".join(f"{i}\n" for i in range(10)),
            "tree_detections.txt": "".join(f"{i} {20 - i} 1.57 0.3\n" for i in range(10)),
            "gps.txt": "".join(f"{i}.5 {i} 0\n" for i in range(9)),
            "victoria_park_known_assoc_gtsam.txt":
                "ODOMETRY 0 1 1 0 0 1 0 0 1 0 1\nODOMETRY 1 2 1 0 0 1 0 0 1 0 1\n"
                "LANDMARK 1 7 22.7 0.5 1 0 1\n"}),
    }


SCENARIO = """[simulation]
seed = {seed}
dimension = {dimension}
[world]
landmarks = 8
min_corner = -6 -2 0
max_corner = 6 12 0
[path]
shape = circle
radius = 4
step = 1
[sensor]
ids = {ids}
"""


def replays(binaries, folder):
    """Small logs by hybrid-simulate, each with its truth and an INI."""
    kinds = {"known": ("2d", "known", "ClassedBearingRangeKnownIds"),
             "unknown": ("2d", "hidden", "BearingRangeAssociation"),
             "space": ("3d", "known", "BearingRangeKnownIds")}
    inputs = []
    for seed, (name, (dimension, ids, plugin)) in enumerate(kinds.items(), 1):
        scenario = folder / f"{name}.ini"
        scenario.write_text(SCENARIO.format(seed=seed, dimension=dimension, ids=ids))
        log = folder / f"{name}.rawlog"
        subprocess.run([binaries / "hybrid-simulate", "-c", scenario, "-o", log], check=True,
                       stdout=subprocess.DEVNULL)
        files = {f.name.replace(name, "log"): f.read_bytes()
                 for f in sorted(folder.glob(f"{name}*")) if f.suffix != ".ini"}
        files["replay.ini"] = (
            "[log]\nrawlog = log.rawlog\ntruth_path = log_ground_truth_robot_path.txt\n"
            "truth_map = log_ground_truth.txt\n[solver]\nmode = incremental\n"
            "[prior]\nsigma_m = 1e-6\n[odometry]\nlost_sigma_m = 1\n[sensor]\nmax_range = 100\n"
            f"[keyframes]\nmin_distance = 0\n[plugins]\nclasses = {plugin}\n[{plugin}]\n").encode()
        formats = {"log.rawlog": "log", "log_ground_truth_robot_path.txt": "path",
                   "log_ground_truth.txt": "landmarks", "replay.ini": "INI"}
        inputs.append(Input(f"replay {name}", "hybrid-replay",
                            ["-c", "{replay.ini}", "--no-pictures", "-o", "{out}"], files, formats))
    return inputs


def shipped_replays():
    """The repository's own logs with their configurations."""
    inputs = []
    for name in ("classed_demo", "slip_demo"):
        ini = (ROOT / "config" / f"{name}.ini").read_bytes().replace(b"../rawlogs/", b"")
        files = {"replay.ini": ini}
        files.update({f.name: f.read_bytes() for f in sorted((ROOT / "rawlogs").glob(f"{name}*"))})
        inputs.append(Input(f"replay {name}", "hybrid-replay",
                            ["-c", "{replay.ini}", "--no-pictures", "-o", "{out}"], files,
                            {f"{name}.rawlog": "log", "replay.ini": "INI"}))
    return inputs


def all_inputs(binaries, folder):
    inputs = replays(binaries, folder) + shipped_replays()

    def add(name, program, arguments, files, formats, result="folder"):
        files = {n: t if isinstance(t, bytes) else t.encode() for n, t in files.items()}
        inputs.append(Input(name, program, arguments, files, formats, result))

    graphs = {"2d": graph_2d(), "toro": graph_2d(True), "landmarks": graph_landmarks(),
              "3d": graph_3d(), "toro 3d": graph_3d(True)}
    for name, text in graphs.items():
        for method in (["--method", "lm"], ["--online"]) if name != "toro 3d" else ([],):
            add(f"pgo {name} {' '.join(method)}".strip(), "hybrid-pgo",
                ["{graph.g2o}", *method, "-o", "{out}"], {"graph.g2o": text}, {"graph.g2o": "graph"})
    add("pgo hypotheses", "hybrid-pgo", ["{graph.g2o}", "--online", "-o", "{out}"],
        {"graph.g2o": graph_hypotheses()}, {"graph.g2o": "graph"})
    truth = "".join(numbers(p) + "\n" for p in planar_truth(24))
    pairs = "".join(f"{i} {i + 16} 1\n" for i in range(8))
    add("pgo truth", "hybrid-pgo",
        ["{graph.g2o}", "--method", "lm", "--truth", "{truth.txt}", "--labels", "{labels.txt}", "-o",
         "{out}"], {"graph.g2o": graphs["2d"], "truth.txt": truth, "labels.txt": pairs},
        {"truth.txt": "planar", "labels.txt": "pairs"})

    source, target = cloud(0.1, 0.05), cloud(0, 0)
    kinds = {"a.xyz": rows_of(source), "a.csv": rows_of(source, ","), "a.ply": ply(source, False),
             "b.ply": ply(source, True), "a.pcd": pcd(source)}
    for name, content in kinds.items():
        form = {"b.ply": "binary", "a.ply": "ply", "a.pcd": "pcd"}.get(name, "cloud")
        add(f"register {name}", "hybrid-register", ["{" + name + "}", "{target.xyz}", "-o", "{out}"],
            {name: content, "target.xyz": rows_of(target)}, {name: form})
    add("register start", "hybrid-register",
        ["{a.xyz}", "{target.xyz}", "--start", "{start.txt}", "-o", "{out}"],
        {"a.xyz": kinds["a.xyz"], "target.xyz": rows_of(target),
         "start.txt": "1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n"}, {"start.txt": "matrix"})

    files = tracks()
    add("objects", "hybrid-objects", ["{dir}", "-o", "{out}"], files, dict.fromkeys(files, "tum"))
    add("switching series", "hybrid-switching", ["{a.txt}", "-o", "{out}", "--no-pictures"],
        {"a.txt": series()}, {"a.txt": "series"})
    log, points = ranges()
    add("switching ranges", "hybrid-switching",
        ["{a.txt}", "--truth", "{t.txt}", "-o", "{out}", "--no-pictures"],
        {"a.txt": log, "t.txt": points}, {"a.txt": "ranges", "t.txt": "points"})
    for name, (arguments, files) in {**import_sets(), **sensors.import_sets()}.items():
        add(f"import {name}", "hybrid-import", [*arguments, "-o", "{out}.rawlog"], files,
            {n: f"{name}/{n}" for n in files}, "file")
    scenario = SCENARIO.format(seed=1, dimension="2d", ids="known")
    add("simulate", "hybrid-simulate", ["-c", "{a.ini}", "-o", "{out}.rawlog"], {"a.ini": scenario},
        {"a.ini": "INI"}, "file")
    experiment = ("[experiment]\nkind = pose_graph\ngraphs = square\nmethods = gnc dcs\ntrials = 1\n"
                  "jobs = 1\noutlier_rates = 0.2\n[square]\nfile = graph.g2o\n"
                  "[gnc]\ninlier_probability = 0.99\n")
    add("experiment", "hybrid-experiment",
        ["-c", "{a.ini}", "--data-dir", "{dir}", "-o", "{out}"],
        {"a.ini": experiment, "graph.g2o": graphs["2d"]}, {"a.ini": "INI", "graph.g2o": "graph"})
    sensors.add_inputs(add, binaries, folder, ROOT)
    return inputs
