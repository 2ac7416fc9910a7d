#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""The damage is reproducible and is damage; the oracle and the classes tell good from bad."""

import hashlib
import json
import os
import pathlib
import random
import tempfile
import unittest

import damage
import material
import oracle
import outcome
import sensors

CRASH = ["python3", "-c", "import os; os.abort()"]
HANG = ["python3", "-c", "while True: pass"]
MEMORY = ["python3", "-c", "x = bytearray(4 << 30)"]


class DamageTest(unittest.TestCase):
    def test_the_same_seed_gives_the_same_bytes_and_some_differ(self):
        log = (material.ROOT / "rawlogs" / "slip_demo.rawlog").read_bytes()
        seeds = [(damage.LOG_KINDS, log), (damage.TEXT_KINDS, material.graph_2d().encode()),
                 (damage.INI_KINDS, material.SCENARIO.encode())]
        for kinds, data in seeds:
            for name, kind in kinds.items():
                first = [kind(data, random.Random(i)) for i in range(6)]
                self.assertEqual(first, [kind(data, random.Random(i)) for i in range(6)], name)
                self.assertTrue(any(other != data for other in first), name)

    def test_special_files_are_what_they_are_called(self):
        with tempfile.TemporaryDirectory() as folder:
            seen = set()
            for i in range(60):
                path = os.path.join(folder, str(i))
                kind = damage.make_special(path, random.Random(i))
                seen.add(kind)
                self.assertEqual(os.path.isdir(path), kind == "folder")
                self.assertEqual(os.path.isfile(path), kind in ("empty", "100 GB"))
            self.assertEqual(len(seen), 9)


class OracleTest(unittest.TestCase):
    def test_finds_nothing_in_undamaged_files(self):
        files = [("graph", material.graph_2d()), ("graph", material.graph_2d(True)),
                 ("graph", material.graph_landmarks()), ("graph", material.graph_3d()),
                 ("graph", material.graph_hypotheses()), ("series", material.series()),
                 ("ranges", material.ranges()[0]), ("points", material.ranges()[1]),
                 ("cloud", material.rows_of(material.cloud(0, 0))),
                 ("cloud", material.rows_of(material.cloud(0, 0), ","))]
        files += [("tum", text) for text in material.tracks().values()]
        for name, (_, texts) in {**material.import_sets(), **sensors.import_sets()}.items():
            files += [(f"{name}/{n}", text) for n, text in texts.items()]
        for form, text in files:
            self.assertIn(form, oracle.FORMS)
            self.assertEqual(oracle.fault(text.encode(), form), "", form)
        log = (material.ROOT / "rawlogs" / "slip_demo.rawlog").read_bytes()
        self.assertEqual(oracle.fault(log, "log"), "")
        self.assertNotEqual(oracle.fault(log[:-4], "log"), "")

    def test_names_what_is_wrong(self):
        for text in (b"1 2 3 4\n", b"1 2\n", b"1 2 x\n", b"1 2 nan\n", b"1 2 1e400\n",
                     b"1,5 2 3\n", b"1 2 \x003\n", b"1 2 3"):
            self.assertNotEqual(oracle.fault(text, "cloud"), "", text)
        for text in (b"EDGE_SE2 0 1 0 0 0 1 0 0 1 0\n", b"EDGE_SE2 0.5 1 0 0 0 1 0 0 1 0 1\n"):
            self.assertNotEqual(oracle.fault(text, "graph"), "", text)


class OutcomeTest(unittest.TestCase):
    def outcome(self, command, files=(), fault="", former=None):
        with tempfile.TemporaryDirectory() as folder:
            out = pathlib.Path(folder) / "out"
            out.mkdir()
            for name, text in dict(files).items():
                (out / name).write_text(text)
            run = outcome.run(command, pathlib.Path(folder) / "text")
            expected = outcome.Expected({}, set(), (None, None), None)
            return outcome.classify(run, out, expected, fault, ["a.txt"], former)[0]

    def test_every_class_is_reached(self):
        fail = ["sh", "-c", "echo a.txt:1:1: wrong; exit 1"]
        good = {"summary.json": '{"status": "ok", "objective": 1}'}
        self.assertEqual(self.outcome(CRASH), "crash")
        self.assertEqual(self.outcome(MEMORY), "unclear message")  # Python's own, of its limit
        self.assertEqual(self.outcome(["sh", "-c", "echo std::bad_alloc; exit 1"]), "memory")
        self.assertEqual(self.outcome(["sh", "-c", "exit 127"]), "crash")
        self.assertEqual(self.outcome(fail), "clear message")
        self.assertEqual(self.outcome(["sh", "-c", "echo wrong; exit 1"]), "unclear message")
        self.assertEqual(self.outcome(fail, good), "mixed or half result")
        self.assertEqual(self.outcome(["true"], {"summary.json": '{"objective": null}'}),
                         "NaN in result")
        self.assertEqual(self.outcome(["true"], {"a.csv": "1,nan\n"}), "NaN in result")
        self.assertEqual(self.outcome(["sh", "-c", "exit 2"]), "partial, stated")
        self.assertEqual(self.outcome(["true"], good, "a line too few"), "silently wrong")
        self.assertEqual(self.outcome(["true"], good), "other result")
        self.assertEqual(self.outcome(["sh", "-c", "echo dropped: 3"], good, "fault"), "ok, stated")
        self.assertEqual(self.outcome(["true"]), "same result")

    def test_a_folder_holds_one_result(self):
        fail = ["sh", "-c", "echo a.txt:1:1: wrong; exit 1"]
        old = {"summary.json": "{}", "a.csv": "1\n"}
        former = {f"out/{name}": text.encode() for name, text in old.items()}
        self.assertEqual(self.outcome(fail, old, "", former), "clear message")
        for changed in ({**old, "a.csv": "2\n"}, {"a.csv": "1\n"}, {**old, ".b.part": ""}):
            self.assertEqual(self.outcome(fail, changed, "", former), "mixed or half result")
        digest = hashlib.sha256(b"1\n").hexdigest()
        files = [{"path": "a.csv", "sha256": digest}]
        summary = json.dumps({"status": "ok", "files": files})
        self.assertEqual(self.outcome(["true"], {"summary.json": summary, "a.csv": "1\n"}),
                         "other result")
        for rest in ({}, {"a.csv": "2\n"}, {"a.csv": "1\n", "b.csv": "1\n"}):
            self.assertEqual(self.outcome(["true"], {"summary.json": summary, **rest}),
                             "mixed or half result")

    def test_a_program_that_goes_on_for_ever_is_ended(self):
        limit, outcome.CPU_SECONDS = outcome.CPU_SECONDS, 1
        try:
            self.assertEqual(self.outcome(HANG), "hang")
        finally:
            outcome.CPU_SECONDS = limit


if __name__ == "__main__":
    unittest.main()
