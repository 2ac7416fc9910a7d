#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""scripts/weight, in repositories made here."""

import pathlib
import subprocess
import sys
import tempfile
import unittest

SCRIPT = pathlib.Path(__file__).parents[2] / "scripts/weight"
LIGHT = '#include "libhybrid/a/detail/own.h"\nint f(int a, std::map<int, int> b, int c, int d, int e, int g) {\n  return a;\n}\n'
HEAVY = '#include "libhybrid/b/detail/other.h"\nint f(int a, std::map<int, int> b, int c, int d, int e,\n      int g, int h) {\n  return g(a, b, c, d, e, 6, 7, 8);\n}\n'


class Weight(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.top = pathlib.Path(scratch.name)
        self.git("init", "-q", "-b", "main")
        self.write(LIGHT)
        self.commit("first")

    def git(self, *arguments):
        subprocess.run(["git", "-c", "user.name=a", "-c", "user.email=a@b", *arguments], cwd=self.top, check=True, capture_output=True)

    def write(self, text):
        (self.top / "libhybrid/a").mkdir(parents=True, exist_ok=True)
        (self.top / "libhybrid/a/f.cpp").write_text(text)

    def commit(self, message):
        self.git("add", "-A")
        self.git("commit", "-q", "-m", message)

    def weight(self, *arguments):
        ran = subprocess.run([sys.executable, "-B", SCRIPT, *arguments], cwd=self.top, capture_output=True, text=True, check=False)
        return ran.returncode, {line.rsplit("  ", 1)[0].strip(): line.rsplit("  ", 1)[1].strip() for line in ran.stdout.splitlines()}, ran.stderr

    def test_counts_what_is_heavy(self):
        self.write(HEAVY)
        code, said, _ = self.weight()
        self.assertEqual(code, 0)
        changes = {name.split("  ")[0]: change for name, change in said.items()}
        self.assertEqual(changes["libraries: lines"], "+1")
        self.assertEqual(changes["functions of more than 6 parameters"], "+1")
        self.assertEqual(changes["includes of detail/ of another room"], "+1")

    def test_what_has_grown_needs_a_word(self):
        self.assertEqual(self.weight("--check")[0], 0)  # the first commit
        self.write(HEAVY)
        self.assertEqual(self.weight("--check")[0], 0)  # has no message yet
        self.commit("more")
        code, _, error = self.weight("--check")
        self.assertEqual(code, 1)
        self.assertIn("1 lines more", error)
        self.git("commit", "-q", "--amend", "-m", "more\n\nWeight: a line, since it takes two")
        self.assertEqual(self.weight("--check")[0], 0)
        self.write(LIGHT)
        self.commit("less")
        self.assertEqual(self.weight("--check")[0], 0)
        self.assertEqual(self.weight("--check", "HEAD~2")[0], 0)

    def test_a_commit_that_does_not_exist(self):
        code, _, error = self.weight("nowhere")
        self.assertEqual(code, 1)
        self.assertIn("no such commit: nowhere", error)


if __name__ == "__main__":
    unittest.main()
