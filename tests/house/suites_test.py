#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""tests/suites.cmake: entries of ctest for a test program that is a script made here."""

import os
import pathlib
import shutil
import subprocess
import tempfile
import time
import unittest

SUITES = pathlib.Path(__file__).parents[1] / "suites.cmake"
LISTED = """Running main() from gtest_main.cc
Plain.
  Fast
  Slow
Groups/0.  # TypeParam = int
  IsClosed
Groups/1.  # TypeParam = long
  IsClosed
Kinds/Lines.
  AreRead/0  # GetParam() = "a;b"
"""
SKIPPED = "[  PASSED  ] 1 test.\n[  SKIPPED ] 1 test, listed below:\n[  SKIPPED ] Plain.Fast\n"


class SuitesTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        shutil.copy(SUITES, self.folder)
        self.write_program(LISTED, "true")
        self.write_costs("room/Plain.Slow:9")
        (self.folder / "CTestTestfile.cmake").write_text(
            f"set(room room)\nset(program {self.folder}/program)\nset(entries {self.folder}/entries.cmake)\n"
            f"include({self.folder}/suites.cmake)\n")

    def write_program(self, listed, runs):
        program = self.folder / "program"
        program.write_text(f'#!/bin/sh\nif [ "$1" = --gtest_list_tests ]; then cat <<"X"\n{listed}X\n'
                           f'else echo "$1" >>{self.folder}/filters\n{runs}\nfi\n')
        program.chmod(0o755)
        os.utime(program, (time.time() + 5,) * 2)  # newer than what was made of an older one

    def write_costs(self, cost):
        (self.folder / "costs.cmake").write_text(f"set(costs {cost})\n")

    def ctest(self):
        return subprocess.run(["ctest", "--output-on-failure"], cwd=self.folder, capture_output=True, text=True)

    def test_a_suite_is_one_entry_and_a_long_test_is_one(self):
        run = self.ctest()
        self.assertEqual(0, run.returncode, run.stdout + run.stderr)
        for name in ["room/Plain.Slow", "room/Plain", "room/Groups", "room/Kinds/Lines"]:
            self.assertRegex(run.stdout, f"Test +#[0-9]: {name} [.]+ +Passed")
        self.assertEqual({"--gtest_filter=Plain.Slow", "--gtest_filter=Plain.*-Plain.Slow",
                          "--gtest_filter=Groups/*.*", "--gtest_filter=Kinds/Lines.*"},
                         set((self.folder / "filters").read_text().split()))

    def test_follows_the_program(self):
        self.ctest()
        self.write_program(LISTED + "New.\n  Test\n", "true")
        self.assertIn("room/New ", self.ctest().stdout)

    def test_skipped_tests_are_said_and_hide_no_failure(self):
        self.write_program(LISTED, f"printf '{SKIPPED}'")
        self.assertIn("***Skipped", self.ctest().stdout)
        for runs in [f"printf '{SKIPPED}[  FAILED  ] Plain.Other\n\n 1 FAILED TEST\n'; false",
                     "echo '[  SKIPPED ] Plain.Fast (0 ms)'; echo crash; false"]:
            self.write_program(LISTED, runs)
            run = self.ctest()
            self.assertNotEqual(0, run.returncode)
            self.assertNotIn("***Skipped", run.stdout)
            self.assertIn("room/Plain (Failed)", run.stdout)

    def test_refuses_a_cost_of_no_test(self):
        self.write_costs("room/Plain.Gone:9")
        run = self.ctest()
        self.assertIn("no test or suite of room is called Plain.Gone", " ".join(run.stderr.split()))  # it is wrapped
        self.assertNotEqual(0, run.returncode)

    def test_a_program_that_is_not_built_fails(self):
        (self.folder / "program").unlink()
        self.assertNotEqual(0, self.ctest().returncode)


if __name__ == "__main__":
    unittest.main()
