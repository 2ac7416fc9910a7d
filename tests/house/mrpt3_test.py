#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""scripts/mrpt3, with modules of one line each in place of those of MRPT."""

import pathlib
import subprocess
import tempfile
import unittest

SCRIPT = pathlib.Path(__file__).parents[2] / "scripts/mrpt3"


class Mrpt3(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.module("core", "")
        self.module("io", "find_package(mrpt_core REQUIRED)")
        self.module("broken", "message(FATAL_ERROR \"no such thing as fyaml\")")

    def module(self, name, line):
        """A module that installs a CMake package of its name."""
        path = self.folder / f"sources/modules/mrpt_{name}"
        path.mkdir(parents=True)
        config = f"mrpt_{name}Config.cmake"
        (path / config).touch()
        (path / "CMakeLists.txt").write_text(f"cmake_minimum_required(VERSION 3.16)\nproject(mrpt_{name} NONE)\n{line}\n"
                                             f"install(FILES {config} DESTINATION lib/cmake/mrpt_{name})\n", encoding="utf-8")

    def run_script(self, *arguments):
        return subprocess.run([SCRIPT, *arguments], cwd=self.folder, capture_output=True, text=True, check=False)

    def test_modules_are_installed_one_after_the_other(self):
        done = self.run_script("sources", "there", "core", "io")
        self.assertEqual((done.returncode, done.stdout), (0, "mrpt_core\nmrpt_io\n"), done.stderr)
        self.assertTrue((self.folder / "there/lib/cmake/mrpt_io/mrpt_ioConfig.cmake").exists())

    def test_what_fails_is_shown_and_ends_it(self):
        done = self.run_script("sources", "there", "broken", "core")
        self.assertEqual(done.returncode, 1)
        self.assertIn("no such thing as fyaml", done.stdout)
        self.assertIn("mrpt_broken was not built", done.stderr)
        self.assertFalse((self.folder / "there/lib").exists())

    def test_another_folder_is_no_source(self):
        done = self.run_script(".", "there")
        self.assertEqual(done.returncode, 1)
        self.assertIn("it is not the source of MRPT 3", done.stderr)
        self.assertIn("usage", self.run_script("sources").stderr)


if __name__ == "__main__":
    unittest.main()
