#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""docs/settings.md is what scripts/ini_reference.py writes: settings_test.py BIN"""

import pathlib
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
BIN = sys.argv.pop(1) if len(sys.argv) > 1 else ""
PAGE = (ROOT / "docs/settings.md").read_text(encoding="utf-8")


def written(text):
    """The page anew, or what is said where it cannot be."""
    with tempfile.TemporaryDirectory() as folder:
        page = pathlib.Path(folder) / "settings.md"
        page.write_text(text, encoding="utf-8")
        done = subprocess.run([sys.executable, "-B", ROOT / "scripts/ini_reference.py", BIN, page], capture_output=True, text=True, check=False)
        return page.read_text(encoding="utf-8") if done.returncode == 0 else done.stderr


class Settings(unittest.TestCase):
    maxDiff = 2000

    def test_the_page_is_up_to_date(self):
        self.assertEqual(PAGE, written(PAGE), "run scripts/ini_reference.py BIN")

    def test_keys_that_are_named_first_are_there_and_bold(self):
        self.assertIn("| **`ids`** |", PAGE)
        self.assertIn("names sensor.idz, which no program has", written(PAGE.replace("`sensor.ids", "`sensor.idz", 1)))

    def test_a_key_that_changed_is_written_anew(self):
        row = next(line for line in PAGE.splitlines() if line.startswith("| `match_radius` |"))
        self.assertEqual(PAGE, written(PAGE.replace(row, row.replace("radius", "diameter"))))


if __name__ == "__main__":
    unittest.main()
