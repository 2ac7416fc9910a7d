#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Runs the commands of all pages: commands_test.py BIN [MPIRUN].

BIN is the folder of the programs, MPIRUN the launcher that they were built for, if any. Files of public data sets and of the reader are stood in for by small ones that are made
here. A command that would take minutes is not run, but its program must know its options, and its files must exist. Commands of
other programs must be listed here with the reason why they are not run. docs/tries.md has a test of its own, which compares
the answers.
"""

import contextlib
import functools
import math
import os
import pathlib
import re
import shlex
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest
import zlib

ROOT = pathlib.Path(__file__).resolve().parents[2]
BIN = pathlib.Path()
MPIRUN = ""
DATASETS = "/usr/share/mrpt/datasets"

# First words of lines in code blocks that are commands, and why those of others are not run.
OWN = re.compile(r"(hybrid|bench)-[a-z]+$")
NOT_RUN = {
    "cmake": "the build itself", "scripts/": "they build and install", ".ci/run": "it builds", "apt-get": "installs",
    "evo_ape": "no package of Debian", "ffmpeg": "a program of others", "docker": "builds an image", "git": "fetches another project", "rawlog-edit": "make_files() and a test of observations run it",
    "cd": "jq, and npm, which needs a registry; ctest -R web builds the page",
    "sbatch": "needs the daemons of Slurm",
    "cp": "tests/consumer builds the example of a plugin", "python3": "the tests of examples and of Python run them",
}
SLOW = {
    r"bench-": "measures for minutes",
    r"hybrid-experiment ": "takes minutes to hours",
    r"simulate_laps|laps\.ini": "a log of hours",
    r"--method portfolio": "compares all methods",
    r"mrclam_6|kitti_0|victoria_park": "needs a public data set",
    r"hybrid-objects ": "needs a public data set",
    r"hybrid-register (dragon|bunny)": "needs a public data set",
    r"hybrid-import plaza|plaza1\.ini": "needs a public data set",
    r"hybrid-switching ": "needs a public data set",
    r"hypotheses\.graph|T1_city10000": "needs a public data set",
    r"-p mine/build/": "needs the installation of a plugin",
    r"directions\.rawlog --truth": "a log of three minutes",
    r"--resume": "needs a session that was interrupted; a test of map files does that",
}
# What a reader has, or puts in place of a name of his own.
PLACES = {"OUT": "out", "NAME": "classed_demo", "BearingRangeAssociation.OPTION=VALUE": "BearingRangeAssociation.detection_probability=0.8",
          "LOG.rawlog": "my.rawlog", "SOURCE": "source.xyz", "TARGET": "target.xyz", "DIR": ".", "SEED": "1",
          "/usr/share/hybrid/config/classed_demo.ini": "config/classed_demo.ini"}


def pages():
    found = [ROOT / name for name in ("README.md", "CONTRIBUTING.md", "rawlogs/README.md")]
    return found + sorted(p for p in (ROOT / "docs").glob("*.md") if p.name != "tries.md")


def code_lines(text):
    """(number, line) of indented blocks and of fenced ones of a shell; those that end with a backslash are joined."""
    fence, joined, start = None, "", 0
    for number, line in enumerate(text.splitlines(), 1):
        if line.startswith("```"):
            fence = line[3:].strip() if fence is None else None
            continue
        if not (fence in ("sh", "bash", "console") or (fence is None and line.startswith("    "))):
            continue
        start = start if joined else number
        joined += line.strip()
        if joined.endswith("\\"):
            joined = joined[:-1]
            continue
        yield start, joined
        joined = ""


def commands_of(page):
    """(number, words, whole line) of the commands of a page; a line may hold several."""
    for number, line in code_lines(page.read_text(encoding="utf-8")):
        try:
            words = shlex.split(line, comments=True)
        except ValueError:
            continue  # no command
        while words and re.match(r"[A-Z_]+=", words[0]):
            words = words[1:]
        if not words:
            continue
        name = words[0].removeprefix("build/release/bin/")
        if name == "mpirun" or (OWN.match(name) and len(words) > 1):
            yield number, [name, *words[1:]], line
        elif any(name == key or (key.endswith("/") and name.startswith(key)) for key in NOT_RUN):
            yield number, None, line


def square(name, in_space=False):
    """A pose graph: a square of 40 poses driven twice, with closures."""
    lines = []
    for i in range(80):
        turn = math.pi / 2 if i % 10 == 9 else 0
        lines.append((i, i + 1, 1, turn))
    lines += [(i, i + 40, 0, 0) for i in range(0, 40, 4)]
    upper = "100 0 0 100 0 400"
    if in_space:
        upper = "100 0 0 0 0 0 100 0 0 0 0 100 0 0 0 400 0 0 400 0 400"
        rows = [f"EDGE_SE3:QUAT {i} {j} {x} 0 0 0 0 {math.sin(a / 2)} {math.cos(a / 2)} {upper}" for i, j, x, a in lines]
    else:
        rows = [f"EDGE_SE2 {i} {j} {x} 0 {a} {upper}" for i, j, x, a in lines]
    pathlib.Path(name).write_text("\n".join(rows) + "\n", encoding="utf-8")


def truth_of_square(name):
    rows, x, y = [], 0.0, 0.0
    for i in range(81):
        a = math.pi / 2 * (i // 10)
        rows.append(f"VERTEX_SE2 {i} {x:.6f} {y:.6f} {math.remainder(a, 2 * math.pi):.6f}")
        x, y = x + math.cos(a), y + math.sin(a)
    pathlib.Path(name).write_text("\n".join(rows) + "\n", encoding="utf-8")


def depth_png(width, height):
    """A PNG file of 16 bits, all 0."""
    chunks = ((b"IHDR", struct.pack(">IIBBBBB", width, height, 16, 0, 0, 0, 0)), (b"IDAT", zlib.compress(bytes((1 + 2 * width) * height))), (b"IEND", b""))
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content)) for kind, content in chunks)


def cloud_of_room(x):
    """The walls of a room of 12 x 8 x 3 m, 0.2 m apart, from a sensor at x, as a file of KITTI."""
    grid = [[0.2 * i for i in range(n + 1)] for n in (60, 40, 15)]
    points = [(a, b, c) for a in (0, 12) for b in grid[1] for c in grid[2]]
    points += [(a, b, c) for a in grid[0] for b in (0, 8) for c in grid[2]]
    points += [(a, b, c) for a in grid[0] for b in grid[1] for c in (0, 3)]
    return b"".join(struct.pack("<4f", a - 4 - x, b - 4, c - 1, 0) for a, b, c in points)


def make_files():
    """The files that pages name: those of the repository, and stand-ins."""
    os.symlink(ROOT / "config", "config")
    shutil.copytree(ROOT / "rawlogs", "rawlogs", ignore=shutil.ignore_patterns("imported"))
    for name in ("intel.g2o", "graph.g2o", "ring.g2o"):
        square(name)
    square("sphere2500.g2o", in_space=True)
    for name in ("ring_groundtruth.g2o", "truth.g2o"):
        truth_of_square(name)
    for name, pairs in (("pairs.txt", [(i, i + 1) for i in range(80)]), ("true.txt", [(i, i + 40) for i in range(0, 40, 4)])):
        pathlib.Path(name).write_text("".join(f"{i} {j}\n" for i, j in pairs), encoding="utf-8")
    odometry = "time,x,y,yaw\n" + "".join(f"{t},{t},0,0\n" for t in range(4))
    seen = "time,range,yaw,class,score,id\n" + "".join(
        f"{t},{math.hypot(5 - t, 1):.4f},{math.atan2(1, 5 - t):.4f},tree,0.9,17\n" for t in range(4))
    subprocess.run([sys.executable, ROOT / "scripts/detector_world.py", "world", "seed=1", "seconds=10"], check=True)
    subprocess.run([sys.executable, ROOT / "scripts/boards_world.py", "room", "seconds=60"], check=True)
    rows = [line.split(",") for line in pathlib.Path("world/detections.csv").read_text(encoding="utf-8").splitlines()]
    pathlib.Path("directions.csv").write_text("".join(",".join([row[0], *row[2:]]) + "\n" for row in rows), encoding="utf-8")
    pathlib.Path("fixes.csv").write_text("time,lat,lon\n" + "".join(f"{t},-33.885,{151.19 + 1e-5 * t}\n" for t in range(4)), encoding="utf-8")
    pathlib.Path("enu.csv").write_text("time,x,y,sigma\n" + "".join(f"{t},{t},0,0.5\n" for t in range(4)), encoding="utf-8")
    os.mkdir("drive")  # to the east, 2 m a second
    pathlib.Path("drive/odometry.csv").write_text("time,x,y,yaw\n" + "".join(f"{t},{2 * t},0,0\n" for t in range(60)), encoding="utf-8")
    degree = 111320 * math.cos(math.radians(33.885))  # of longitude [m]
    pathlib.Path("drive/fixes.csv").write_text("time,lat,lon\n" + "".join(f"{t},-33.885,{151.19 + 2 * t / degree:.9f}\n" for t in range(60)), encoding="utf-8")
    os.mkdir("tables")
    for folder in (".", "tables"):
        pathlib.Path(folder, "odometry.csv").write_text(odometry, encoding="utf-8")
        pathlib.Path(folder, "detections.csv").write_text(seen, encoding="utf-8")
    os.mkdir("labels")
    pathlib.Path("labels/classes.txt").write_text("car\ntree\n", encoding="utf-8")
    for image in range(1, 30):
        pathlib.Path(f"labels/left_{image:06}.txt").write_text("1 0.4 0.5 0.05 0.3 0.9\n", encoding="utf-8")
    # Clouds on the way through a room, and depth images without a return.
    os.mkdir("velodyne")
    os.mkdir("depth")
    for i in range(4):
        pathlib.Path(f"velodyne/{i}.bin").write_bytes(cloud_of_room(i))
        pathlib.Path(f"depth/{i}.png").write_bytes(depth_png(4, 2))
    shutil.copytree("velodyne", "my_clouds")
    for name in ("odometry.txt", "truth.txt", "poses.txt", "my_clouds/odometry.txt"):
        pathlib.Path(name).write_text("".join(f"{t} {t} 0 0 0 0 0 1\n" for t in range(4)), encoding="utf-8")
    # A laser in a corridor of 10 m.
    pathlib.Path("my_bag.clf").write_text("".join(
        "FLASER 181 " + " ".join(f"{1 / max(abs(math.sin(math.radians(a))), 0.1):.3f}" for a in range(-90, 91))
        + f" {0.1 * t} 0 0 {0.1 * t} 0 0 {t} here {t}\n" for t in range(12)), encoding="utf-8")
    pathlib.Path("path.tum").write_text("".join(f"{t} {t} 0 0 0 0 0 1\n" for t in range(4)), encoding="utf-8")
    pathlib.Path("things.txt").write_text("5 1 0 5 0 0 17 tree\n", encoding="utf-8")
    cloud = "".join(f"{math.cos(7 * i):.4f} {math.sin(3 * i):.4f} {0.01 * i:.4f}\n" for i in range(50))
    for name in ("source.xyz", "target.xyz"):
        pathlib.Path(name).write_text(cloud, encoding="utf-8")
    for name, cut in (("monday", ["--to-index", "299"]), ("tuesday", ["--from-index", "220"])):
        subprocess.run(["rawlog-edit", "--cut", "-w", "-i", f"{DATASETS}/kf-slam_demo.rawlog", "-o", f"{name}.rawlog", *cut],
                       check=True, capture_output=True)


def run_ranks(words):
    """Runs a command of mpirun, on a small experiment in place of the one that it names."""
    pathlib.Path("small.ini").write_text(
        "[experiment]\ngraphs = graph\nmethods = gnc\ntrials = 9\n"
        f"[graph]\nfile = {pathlib.Path('graph.g2o').resolve()}\n", encoding="utf-8")
    at = next(i for i, word in enumerate(words) if OWN.match(word))
    words = [MPIRUN, "--oversubscribe", *words[1:at], BIN / words[at],
             *("small.ini" if word.startswith("config/") else word for word in words[at + 1:])]
    root = {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
    return subprocess.run(words, env={**os.environ, **root}, capture_output=True, text=True, check=False)


def ready(words):
    """The command with the files of the reader."""
    words = [PLACES.get(word, word.replace("NAME", PLACES["NAME"])) for word in words]
    if words[0] == "hybrid-replay" and "--no-pictures" not in words:
        words.append("--no-pictures")  # they are drawn by other tests
    return words


@functools.cache
def known_options(program, *subcommand):
    """Those that --help or, of a benchmark, its source names."""
    if program.startswith("bench-"):
        text = (ROOT / f"bench/{program}.cpp").read_text(encoding="utf-8")
    else:
        text = subprocess.run([BIN / program, *subcommand, "--help"], capture_output=True, text=True, check=False).stdout
    return set(re.findall(r"(?<![\w-])--?[a-zA-Z][\w-]*", text))


def unknown_options(program, words):
    known = known_options(program, *(words[1:2] if program == "hybrid-import" else []))
    return [w for w in (word.split("=")[0] for word in words[1:]) if re.match(r"--?[a-zA-Z]", w) and w not in known]


class Pages(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.enterContext(contextlib.chdir(folder.name))
        make_files()

    def check(self, where, words, line):
        if words[0] == "mpirun" and MPIRUN:
            ran = run_ranks(words)
            self.assertEqual(ran.returncode, 0, f"{where}: {line}\n{ran.stdout}{ran.stderr}")
        while not OWN.match(words[0]):
            words = words[1:]
        slow = [reason for pattern, reason in SLOW.items() if re.search(pattern, line)]
        if slow:
            self.assertEqual(unknown_options(words[0], words), [], f"{where}: {line}")
            for word in words:
                if word.startswith("config/"):
                    self.assertTrue(pathlib.Path(word).exists(), f"{where}: no file {word}")
            return False
        with open(f"{DATASETS}/kf-slam_demo.rawlog", "rb") as log:  # for commands that read a log as it comes
            ran = subprocess.run([BIN / words[0], *ready(words)[1:]], stdin=log, capture_output=True, text=True, check=False)
        self.assertEqual(ran.returncode, 0, f"{where}: {line}\n{ran.stderr}")
        return True

    def test_their_commands_run(self):
        count = 0
        for page in pages():
            for number, words, line in commands_of(page):
                if words is None:
                    continue
                where = f"{page.relative_to(ROOT)}:{number}"
                with self.subTest(where):
                    count += self.check(where, words, line)
        self.assertGreater(count, 25)

    def test_every_reason_is_that_of_a_command(self):
        lines = [line for page in pages() for _, _, line in commands_of(page)]
        for name in NOT_RUN:
            self.assertTrue(any(re.match(rf"([A-Z]+=\S+ )?{re.escape(name)}", line) for line in lines), name)
        for pattern in SLOW:
            self.assertTrue(any(re.search(pattern, line) for line in lines), pattern)

    def test_code_blocks_hold_no_other_programs(self):
        """A line that begins like a command of a shell is one that is run, or one that is listed with a reason."""
        usual = re.compile(r"(\./|build/|sudo |pip|make |curl |wget |ros2 |srun |mpiexec )")
        for page in pages():
            for number, line in code_lines(page.read_text(encoding="utf-8")):
                if usual.match(line) and not line.startswith("build/release/bin/"):
                    self.fail(f"{page.relative_to(ROOT)}:{number}: {line}: neither run nor listed here")


if __name__ == "__main__":
    BIN = pathlib.Path(sys.argv.pop(1)).resolve()
    MPIRUN = sys.argv.pop(1) if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else ""
    if not (BIN / "hybrid-replay").exists():
        print("skipped: the programs are not built")
        sys.exit(77)
    unittest.main()
