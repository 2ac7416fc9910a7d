#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Bags that are damaged, pipes or too large end in one line, and files are written whole or not at all."""

import csv
import importlib
import os
import struct
import subprocess
import sys
import unittest
import unittest.mock

from bags import BagTest, Cdr, DETECTED, ODOMETRY, SCRIPT, TOPICS, bag, chunk, detections, drive, odometry, record, text, transforms


class McapResults(BagTest):
    def test_what_is_no_regular_file_is_not_waited_for(self):
        (self.at / "run").mkdir()
        os.mkfifo(self.at / "run/b.mcap")
        (self.at / "c.mcap").symlink_to(self.at / "run/b.mcap")
        for name in ("run", "run/b.mcap", "c.mcap"):
            self.check_refused(self.convert(name), "mcap: is a pipe, not a regular file")
        (self.at / "run/b.mcap").unlink()
        self.check_refused(self.convert("run"), f"{self.at}/run: no MCAP file is there")
        (self.at / "d.mcap").symlink_to("/dev/zero")
        (self.at / "odometry.csv").touch()
        self.check_refused(self.convert("none.mcap"), "none.mcap: No such file or directory")
        self.check_refused(self.convert("d.mcap"), "d.mcap: is a device, not a regular file")
        self.check_refused(self.convert("x" * 300), "File name too long")

    def test_values_without_bytes_are_limited(self):
        levels = {f"vision_msgs/A{i}": f"A{i + 1} a\nA{i + 1} b\n" for i in range(60)}
        doubling = {DETECTED: "std_msgs/Header header\nA0 a\n", **levels, "vision_msgs/A60": "uint8[0] x\n"}
        many = {DETECTED: "std_msgs/Header header\nA[100] a\n", "vision_msgs/A": "B[100] b\n",
                "vision_msgs/B": "C[100] c\n", "vision_msgs/C": "uint8[0] x\n"}
        for definitions in (doubling, many, {**many, DETECTED: "std_msgs/Header header\nA[] a\n"}):
            message = Cdr().header(0).put("I", 100).put("B", *[0] * 100).whole()
            ran = self.run_script(bag([TOPICS[0], ("/objects", definitions)], [*drive()[::2], (1, message)]))
            self.check_refused(ran, "a.mcap: vision_msgs/msg/Detection3DArray: a message has too many values")

    def test_sizes_are_limited(self):
        line_ends = record(3, struct.pack("<H", 9) + text("x/Y") + text("ros2msg") + text("\n" * (9 << 20)))
        self.check_bag(drive(), "a.mcap: a text of 9437184 bytes is longer than", begin=line_ends)
        self.check_bag([], "a.mcap: a text of 605 bytes is longer than", topics=[("/odom" + "m" * 600, ODOMETRY)])
        self.check_bag(drive(), "a.mcap: damaged: its chunks have more than 1000", begin=3 * chunk("", b"", 90 << 20))
        nested = chunk("", chunk("", chunk("", b"", 1 << 62), 0), 0)
        self.assertEqual(self.run_script(bag(TOPICS, drive(), begin=nested), "--plane").returncode, 0)

    def test_large_records(self):
        whole, size = bag(TOPICS, drive()), 1 << 40  # of a file with a hole
        for code in (5, 9):
            with open(self.at / "b.mcap", "wb") as file:
                file.write(whole[:8] + struct.pack("<BQ", code, size))
                file.seek(size, os.SEEK_CUR)
                file.write(whole[8:])
            ran = self.convert("b.mcap", "--plane")
            if code == 5:
                self.check_refused(ran, "b.mcap: damaged: a record or a chunk is said to have 1099511627776 bytes")
        self.assertEqual(ran.returncode, 0, ran.stderr)  # that of another kind is left out
        self.check_tables()

    def test_packed_definitions_are_limited(self):
        try:
            zstd = importlib.import_module("zstandard").ZstdCompressor()
        except ImportError:
            self.skipTest("skipped: python3-zstandard is not installed")
        for fill in ("\n", "\U0001f600"):
            definition = record(3, struct.pack("<H", 9) + text("x/Y") + text("ros2msg") + text(fill * (9 << 20)))
            self.check_bag(drive(), "is longer than", pack=("zstd", zstd.compress), begin=definition)

    def test_what_cannot_be_written_is_told(self):
        (self.at / "file").write_text("of before")
        (self.at / "link").symlink_to(self.at / "none")
        for output in ("file", "file/below", "link", "n" * 300, "/proc/x", "/dev/null"):
            ran = self.run_script(bag(TOPICS, drive()), output=self.at / output)
            self.check_refused(ran, f"cannot write {self.at / output}: ")
        self.assertEqual(self.names(), ["a.mcap", "file", "link"])
        ran = self.run_script(bag(TOPICS, drive()[:1]), output=self.at / "new/er")
        self.check_refused(ran, "there is no detection")
        self.assertFalse((self.at / "new").exists())

    def test_all_tables_are_written_or_none(self):
        self.check_bag(drive(), "no transforms lead from wheel to map", "--base", "wheel")
        self.assertEqual(self.names(), ["a.mcap"])
        (self.at / "detections.csv").mkdir()
        self.check_refused(self.run_script(bag(TOPICS, drive())), f"cannot write {self.at}/detections.csv: is a folder")
        self.assertEqual(self.names(), ["a.mcap", "detections.csv"])

    def test_a_move_that_fails_is_undone(self):
        results, move = self.module("bag_results"), os.replace
        (self.at / "part").mkdir()
        for name in "ab":
            (self.at / name).write_text("old")
            (self.at / f"part/{name}").write_text("new")

        def fails(before, now):
            if before == self.at / "part/b":
                raise OSError
            move(before, now)

        with unittest.mock.patch("os.replace", fails), self.assertRaises(OSError):
            results.publish(self.at / "part", self.at, True)
        self.assertEqual(self.names(), ["a", "b", "part"])
        self.assertEqual([path.read_text() for path in (self.at / "a", self.at / "b")], ["old"] * 2)
        self.assertEqual(len(list((self.at / "part").iterdir())), 2)

    def module(self, name):
        sys.path.insert(0, str(SCRIPT.parent))
        self.addCleanup(sys.path.remove, str(SCRIPT.parent))
        return importlib.import_module(name)

    def test_files_of_others_stay(self):
        for name in ("odometry.csv", "odometry.csv.part", "odometry.csv~"):
            (self.at / name).write_text(f"foreign {name}")
        ran = self.run_script(bag(TOPICS, drive()), "--plane")
        self.assertEqual(ran.returncode, 0, ran.stderr)
        self.assertIn(f"{self.at}/odometry.csv was there before; it is now {self.at}/odometry.csv~2\n", ran.stdout)
        self.check_tables()
        for name, now in (("odometry.csv", "odometry.csv~2"), ("odometry.csv.part",) * 2, ("odometry.csv~",) * 2):
            self.assertEqual((self.at / now).read_text(), f"foreign {name}")
        again = self.run_script(bag(TOPICS, drive()), "--plane")
        self.assertNotIn("before", again.stdout)  # the same tables
        self.assertEqual(len(self.names()), 6)

    def test_a_bag_is_not_replaced(self):
        (self.at / "odometry.csv").write_bytes(bag(TOPICS, drive()))
        ran = self.convert("odometry.csv")
        self.check_refused(ran, f"cannot write {self.at}/odometry.csv: is the bag that is read")
        self.assertEqual(self.names(), ["odometry.csv"])

    def test_an_output_that_is_full(self):
        (self.at / "a.mcap").write_bytes(bag(TOPICS, drive()))
        with open("/dev/full", "w", encoding="utf-8") as full:
            command = [sys.executable, "-B", SCRIPT, self.at / "a.mcap", "-o", self.at, "--plane"]
            ran = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True, check=False)
        self.assertEqual((ran.returncode, ran.stderr), (0, ""))
        self.check_tables()

    def test_a_signal_leaves_nothing(self):
        results = self.module("bag_results")
        for error, code in ((KeyboardInterrupt(), 130), (SystemExit(143), None)):
            def convert(_, error=error):
                with results.staged(self.at / "new", self.at / "new", "refused") as part:
                    (part / "a").write_text("new")
                    raise error
            options = type("Options", (), {"bag": ["a.mcap"]})
            if code:
                self.assertEqual(results.told("x", convert, options), code)
            else:
                self.assertRaises(SystemExit, results.told, "x", convert, options)
            self.assertEqual(self.names(), [])


if __name__ == "__main__":
    unittest.main()
