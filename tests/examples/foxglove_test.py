#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Maps in the form of Foxglove: messages keep the published schema, files and the live protocol carry them.

usage: foxglove_test.py BIN
"""

import asyncio
import json
import pathlib
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import unittest

import strict_mcap

ROOT = pathlib.Path(__file__).parents[2]
SCRIPTS = ROOT / "examples/ros2"
sys.path.insert(0, str(SCRIPTS))
BIN = pathlib.Path(sys.argv.pop(1)) if len(sys.argv) > 1 else None

from foxglove_scene import SCHEMA, Scene  # noqa: E402

LINES = [
    {"keyframe": 0, "time": 0.0, "pose": [0, 0, 0], "landmarks": 1, "objective": 0, "cost": 0,
     "changed": [{"id": 3, "position": [5.1, 1.9], "class": "tree", "sightings": 1}], "removed": []},
    {"keyframe": 1, "time": 0.4, "pose": [1, 2, 1.5], "landmarks": 1, "objective": 0, "cost": 0,
     "changed": [{"id": 4, "position": [1, 2, 3], "sightings": 1}], "removed": [3]},
    {"keyframe": 2, "time": 0.8, "pose": [1, 2, 3, 0.1, 0.2, 0.3], "landmarks": 1, "objective": 0, "cost": 0, "changed": [],
     "removed": []}]


def updates(lines=LINES):
    scene = Scene()
    return [scene.of_line(json.dumps(line)) for line in lines]


def published_schema():
    """That of foxglove.SceneUpdate in the package of its authors; None where it is not installed."""
    if not shutil.which("node") or not (ROOT / "web/node_modules/@foxglove/schemas").is_dir():
        return None
    code = "console.log(JSON.stringify(require('@foxglove/schemas/jsonschema').SceneUpdate))"
    return json.loads(subprocess.run(["node", "-e", code], cwd=ROOT / "web", check=True, capture_output=True, text=True).stdout)


def strict(schema):
    """The same schema where nothing may be there that it does not name, and numbers must be finite."""
    if isinstance(schema, list):
        return [strict(s) for s in schema]
    if not isinstance(schema, dict):
        return schema
    out = {k: {n: strict(s) for n, s in v.items()} if k == "properties" else strict(v) for k, v in schema.items()}
    return {**out, "additionalProperties": False} if "properties" in out else out


def messages_in(path):
    """(time, message) of a file in MCAP, and the name of its schema."""
    schemas, channels, messages = strict_mcap.read(path.read_bytes())
    (topic, schema), = channels.values()
    assert topic == "/hybrid/map" and len(schemas) == 1
    return [(time, message) for _, time, message in messages], schemas[schema][0]


class Foxglove(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.at = pathlib.Path(self.folder.name)
        self.text = "".join(json.dumps(line) + "\n" for line in LINES)

    def run_script(self, name, *options, text=""):
        return subprocess.run([sys.executable, "-B", SCRIPTS / name, *map(str, options)], input=text, text=True,
                              capture_output=True, check=False)

    def check(self, messages):
        try:
            import jsonschema
        except ImportError:
            self.skipTest("skipped: python3-jsonschema is not installed")
        published = published_schema()
        if published is None:
            self.skipTest("skipped: web/node_modules/@foxglove/schemas is not there")
        for schema in (strict(published), strict(SCHEMA)):
            for message in messages:
                jsonschema.Draft7Validator(schema).validate(message)

    def test_steps_keep_the_schema(self):
        self.check([message for _, message in updates()])

    def test_the_check_can_fail(self):
        message = updates()[0][1]
        self.check([message])
        import jsonschema
        for spoil in (lambda e: e.update(colour=1), lambda e: e.pop("lifetime"), lambda e: e["spheres"][0]["size"].update(x="a")):
            bad = json.loads(json.dumps(message))
            spoil(bad["entities"][-1])
            with self.assertRaises(jsonschema.ValidationError):
                self.check([bad])

    def test_what_a_step_shows(self):
        (_, first), (time, second), (_, third) = updates()
        self.assertEqual([e["id"] for e in first["entities"]], ["path/0", "robot", "landmark/3"])
        self.assertEqual(first["entities"][2]["texts"][0]["text"], "3 tree")
        self.assertEqual(time, 0.4)
        self.assertEqual(second["deletions"], [{"timestamp": {"sec": 0, "nsec": 400000000}, "type": 0, "id": "landmark/3"}])
        self.assertEqual([p["x"] for p in second["entities"][0]["lines"][0]["points"]], [0, 1])
        turned = third["entities"][1]["arrows"][0]["pose"]["orientation"]
        self.assertAlmostEqual(sum(x * x for x in turned.values()), 1)
        self.assertAlmostEqual(turned["z"], 0.0343, delta=0.001)  # roll .3, pitch .2, yaw .1

    def test_a_long_path_is_sent_in_pieces(self):
        lines = [{**LINES[0], "pose": [k, 0, 0], "changed": []} for k in range(250)]
        pieces = {}
        for _, update in updates(lines):
            path = update["entities"][0]
            pieces[path["id"]] = [p["x"] for p in path["lines"][0]["points"]]
        self.assertEqual(pieces, {"path/0": [*range(100)], "path/1": [*range(99, 200)], "path/2": [*range(199, 250)]})

    def test_a_stream_becomes_a_file(self):
        ran = self.run_script("stream_to_foxglove.py", "-o", self.at / "a.mcap", text=self.text)
        self.assertEqual(ran.returncode, 0, ran.stderr)
        found, name = messages_in(self.at / "a.mcap")
        self.assertEqual(name, "foxglove.SceneUpdate")
        self.assertEqual(found, [(round(time * 1e9), update) for time, update in updates()])
        wrong = self.run_script("stream_to_foxglove.py", "-o", self.at / "a.mcap", text="12 keyframes\n")
        self.assertEqual(wrong.returncode, 1)
        self.assertIn("standard input is what hybrid-replay --stream writes", wrong.stderr)

    def test_the_strict_reader_refuses_what_is_damaged(self):
        self.run_script("stream_to_foxglove.py", "-o", self.at / "a.mcap", text=self.text)
        data = (self.at / "a.mcap").read_bytes()
        strict_mcap.read(data)
        for at in (0, len(data) - 1, 9, data.index(b"jsonschema") - 4, len(data) - 8 - 20, len(data) - 8 - 29 - 4):
            with self.assertRaises((AssertionError, UnicodeDecodeError)):
                strict_mcap.read(data[:at] + bytes([data[at] ^ 5]) + data[at + 1:])
        with self.assertRaises(AssertionError):
            strict_mcap.read(data[:-9] + data[-8:])

    def test_files_of_any_stream_are_whole(self):
        tree = {**LINES[0]["changed"][0], "class": "Bäume \U0001f332"}
        for lines in ([], [{**LINES[0], "time": -0.5}, LINES[1]], [{**LINES[0], "changed": [tree]}]):
            text = "".join(json.dumps(line, ensure_ascii=False) + "\n" for line in lines)
            ran = self.run_script("stream_to_foxglove.py", "-o", self.at / "a.mcap", text=text)
            self.assertEqual(ran.returncode, 0, ran.stderr)
            found, _ = messages_in(self.at / "a.mcap")
            self.assertEqual([time for time, _ in found], [max(0, round(line["time"] * 1e9)) for line in lines])
        self.assertEqual(found[0][1]["entities"][2]["texts"][0]["text"], "3 Bäume \U0001f332")

    def test_a_stream_that_is_none_leaves_the_steps_before_it(self):
        for bad in ("12 keyframes", [1], {**LINES[1], "time": None}, {**LINES[1], "pose": [float("nan")] * 3},
                    {**LINES[1], "changed": ["tree"]}):
            text = f"{json.dumps(LINES[0])}\n{json.dumps(bad)}\n"
            ran = self.run_script("stream_to_foxglove.py", "-o", self.at / "a.mcap", text=text)
            self.assertEqual((ran.returncode, len(ran.stderr.splitlines())), (1, 1), ran.stderr)
            self.assertIn("standard input is what hybrid-replay --stream writes", ran.stderr)
            self.assertEqual(len(messages_in(self.at / "a.mcap")[0]), 1)
        ran = self.run_script("stream_to_foxglove.py", "-o", self.at / "none/a.mcap", text=self.text)
        self.assertEqual((ran.returncode, ran.stderr), (1, f"error: cannot write {self.at}/none/a.mcap: No such file or directory\n"))

    def test_a_stream_that_is_broken_off_leaves_a_whole_file(self):
        with subprocess.Popen([sys.executable, "-B", SCRIPTS / "stream_to_foxglove.py", "-o", self.at / "a.mcap"], text=True,
                              stdin=subprocess.PIPE, stdout=subprocess.PIPE, bufsize=1) as script:
            script.stdin.write(self.text)
            script.stdin.flush()
            while not (self.at / "a.mcap").exists() or b'"nsec": 800000000' not in (self.at / "a.mcap").read_bytes():
                self.assertIsNone(script.poll())
            script.send_signal(signal.SIGINT)
            self.assertEqual(script.wait(20), 0)
        self.assertEqual(len(messages_in(self.at / "a.mcap")[0]), len(LINES))

    def test_a_viewer_gets_what_was_and_what_comes(self):
        try:
            import websockets
        except ImportError:
            self.skipTest("skipped: python3-websockets is not installed")

        async def view():
            server = await asyncio.create_subprocess_exec(sys.executable, "-B", SCRIPTS / "stream_to_foxglove.py", "--port", "0",
                                                          stdin=-1, stdout=-1, stderr=-1)
            try:
                address = (await server.stdout.readline()).decode().split()[1]
                lines = self.text.splitlines(keepends=True)
                server.stdin.write(lines[0].encode())
                async with websockets.connect(address, subprotocols=["foxglove.websocket.v1"]) as socket:
                    self.assertEqual(socket.subprotocol, "foxglove.websocket.v1")
                    info, offer = [json.loads(await socket.recv()) for _ in range(2)]
                    self.assertEqual((info["op"], offer["op"]), ("serverInfo", "advertise"))
                    (channel,) = offer["channels"]
                    self.assertEqual(channel["schemaName"], "foxglove.SceneUpdate")
                    await socket.send(json.dumps({"op": "subscribe", "subscriptions": [{"id": 7, "channelId": channel["id"]}]}))
                    for k, (time, update) in enumerate(updates()):
                        if k > 0:
                            server.stdin.write(lines[k].encode())
                        data = await asyncio.wait_for(socket.recv(), 20)
                        self.assertEqual(struct.unpack("<BIQ", data[:13]), (1, 7, round(time * 1e9)))
                        self.assertEqual(json.loads(data[13:]), update)
            finally:
                server.kill()
                await server.communicate()

        asyncio.run(asyncio.wait_for(view(), 60))

    def replay(self, log, *options):
        if BIN is None:
            self.skipTest("skipped: no programs")
        ran = subprocess.run([BIN / "hybrid-replay", ROOT / "rawlogs" / log, "--no-pictures", "-o", self.at / "out", *options],
                             text=True, capture_output=True, check=False)
        self.assertEqual(ran.returncode, 0, ran.stderr)
        return ran.stdout

    def test_a_replay_is_shown_live(self):
        live = [message for _, message in updates(map(json.loads, self.replay("classed_demo.rawlog", "--stream").splitlines()))]
        self.assertGreater(len(live), 10)
        self.check(live)

    def exported(self, log, *options):
        """Messages of the map of a log, what it holds as JSON, and its path."""
        (self.at / "map.hmap").unlink(missing_ok=True)
        self.replay(log, "--map", self.at / "map.hmap", *options)
        subprocess.run([BIN / "hybrid-map", "export", self.at / "map.hmap", "--mcap", "--no-pictures", "-o", self.at / "map"],
                       check=True, capture_output=True)
        found, name = messages_in(self.at / "map/map.mcap")
        self.assertEqual(name, "foxglove.SceneUpdate")
        return (found, json.loads((self.at / "map/landmarks.json").read_text())["landmarks"],
                [row for row in (self.at / "map/trajectory_1.tum").read_text().splitlines() if not row.startswith("#")])

    def test_a_map_file_is_shown(self):
        coarse = ("--set", "sensor.ids=none", "--set", "BearingRangeAssociation.extent=1")
        for log, *options in (("classed_demo.rawlog",), ("classed_demo_3d.rawlog",), ("classed_demo.rawlog", *coarse)):
            with self.subTest(log=log, options=options):
                found, landmarks, path = self.exported(log, *options)
                self.assertEqual(len(found), 1 + len(path))
                self.assertEqual([time for time, _ in found], sorted(time for time, _ in found))
                entities = {e["id"]: e for e in found[0][1]["entities"]}
                self.assertEqual(len(entities), len(landmarks) + 1)
                line = entities["path/1"]["lines"][0]["points"]
                for point, row, (_, message) in zip(line, path, found[1:], strict=True):
                    self.assertAlmostEqual(point["x"], float(row.split()[1]), delta=1e-6)
                    (robot,) = message["entities"]
                    self.assertEqual((robot["id"], robot["arrows"][0]["pose"]["position"]), ("robot/1", point))
                    turn = robot["arrows"][0]["pose"]["orientation"]
                    near = sum(float(word) * turn[axis] for word, axis in zip(row.split()[4:], "xyzw"))
                    self.assertAlmostEqual(abs(near), 1, delta=1e-6)
                for landmark in landmarks:
                    entity = entities[f"landmark/{landmark['id']}"]
                    several = f" \u00d7{landmark['things']}" if landmark["things"] > 1 else ""
                    self.assertEqual(entity["texts"][0]["text"], f"{landmark['id']} {landmark['class']}{several}")
                    told = {m["key"]: m["value"] for m in entity["metadata"]}
                    self.assertEqual(int(told["things"]), landmark["things"])
                    self.assertEqual(float(told.get("extent_m", 0)), landmark["extent_m"])
                    center, ellipsoid = entity["spheres"]
                    self.assertAlmostEqual(center["pose"]["position"]["y"], landmark["position"][1], delta=1e-9)
                    trace = sum(landmark["covariance"][i][i] for i in range(len(landmark["covariance"])))
                    variances = [(ellipsoid["size"][axis] / 6) ** 2 for axis in "xyz"]
                    self.assertAlmostEqual(sum(variances), trace, delta=1e-2 * trace)
                self.check([message for _, message in found])

    def test_the_schema_in_a_file_is_that_of_the_scripts(self):
        self.exported("classed_demo.rawlog")
        schemas, _, _ = strict_mcap.read((self.at / "map/map.mcap").read_bytes())
        self.assertEqual(schemas, {1: ("foxglove.SceneUpdate", SCHEMA)})


if __name__ == "__main__":
    unittest.main()
