#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""What bash completes for hybrid-replay. Usage: completion_test.py FOLDER_OF_PROGRAMS"""
import os
import subprocess
import sys
import tempfile
import unittest

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")


class Completion(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.script = f"{self.folder.name}/bash"
        subprocess.run([sys.executable, "-B", f"{ROOT}/scripts/completion.py", f"{PROGRAMS}/hybrid-replay", self.script,
                        f"{self.folder.name}/zsh"], check=True)

    def complete(self, *words):
        listed = " ".join(f"'{word}'" for word in words)
        text = (f"source {self.script}; compopt() {{ :; }}; COMP_WORDS=(hybrid-replay {listed}); COMP_CWORD={len(words)}; "
                '_hybrid_replay; printf "%s\\n" "${COMPREPLY[@]}"')
        return subprocess.run(["bash", "-c", text], check=True, capture_output=True, text=True).stdout.split()

    def test_names_of_options(self):
        self.assertEqual(self.complete("--map-m"), ["--map-mode"])

    def test_values_that_the_help_lists(self):
        self.assertEqual(self.complete("--map-mode", ""), ["auto", "build", "extend", "localize"])

    def test_keys_of_settings(self):
        self.assertEqual(self.complete("--set", "sensor.noi"), ["sensor.noise="])
        self.assertGreater(len(self.complete("--set", "")), 100)

    def test_files_after_other_options(self):
        self.assertEqual(self.complete("-o", "x"), [])


if __name__ == "__main__":
    PROGRAMS = os.path.abspath(sys.argv.pop(1))
    unittest.main()
