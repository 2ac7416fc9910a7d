#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""What bash and zsh complete. Usage: completion_test.py FOLDER_OF_PROGRAMS"""
import functools
import os
import pathlib
import pty
import select
import shutil
import subprocess
import sys
import tempfile
import unittest

ZSH = shutil.which("zsh")
ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")


class Completion(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.written = cls.enterClassContext(tempfile.TemporaryDirectory())

    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    @classmethod
    @functools.cache
    def write(cls, program):
        subprocess.run([sys.executable, "-B", f"{ROOT}/scripts/completion.py", f"{PROGRAMS}/{program}", f"{cls.written}/{program}.bash",
                        f"{cls.written}/_{program}"], check=True)

    def complete(self, *words, program="hybrid-replay"):
        self.write(program)
        listed = " ".join(f"'{word}'" for word in words)
        text = (f"source {self.written}/{program}.bash; compopt() {{ :; }}; COMP_WORDS=({program} {listed}); COMP_CWORD={len(words)}; "
                f'_{program.replace("-", "_")}; printf "%s\\n" "${{COMPREPLY[@]}}"')
        return subprocess.run(["bash", "-c", text], check=True, capture_output=True, text=True, cwd=self.folder.name).stdout.split()

    def test_names_of_options(self):
        self.assertEqual(self.complete("--map-m"), ["--map-mode"])

    def test_values_that_the_help_lists(self):
        self.assertEqual(self.complete("--map-mode", ""), ["auto", "build", "extend", "localize"])

    def test_keys_of_settings(self):
        self.assertEqual(self.complete("--set", "sensor.noi"), ["sensor.noise="])
        self.assertGreater(len(self.complete("--set", "")), 100)

    def test_values_of_settings(self):
        self.assertEqual(self.complete("--set", "sensor.noise", "="), ["auto", "stated", "measured"])
        self.assertEqual(self.complete("--set", "sensor.noise", "=", "st"), ["stated"])
        self.assertEqual(self.complete("--set", "keyframes.tracklets", "="), ["true", "false"])
        self.assertEqual(self.complete("--set", "sensor.max_range", "="), [])

    def test_values_in_the_same_word(self):
        self.assertEqual(self.complete("--map-mode", "="), ["auto", "build", "extend", "localize"])
        self.assertEqual(self.complete("--map-mode", "=", "ex"), ["extend"])
        self.assertEqual(self.complete("--set", "=", "sensor.noi"), ["sensor.noise="])
        self.assertEqual(self.complete("--set", "=", "sensor.noise", "=", "st"), ["stated"])
        self.assertEqual(self.complete("--method", "=", "gnc-", program="hybrid-pgo"), ["gnc-gm"])
        self.assertEqual(self.complete("--output", "=", "x"), [])

    def test_plugins(self):
        plugins = self.complete("--set", "plugins.classes", "=")
        self.assertEqual(plugins[0], "auto")
        self.assertLessEqual({"BeaconRanges", "BearingRangeAssociation", "LaserScans"}, set(plugins))
        self.assertEqual(self.complete("--set", "plugins.classes", "=", "Beac"), ["BeaconRanges"])

    def test_methods(self):
        self.assertIn("switchable", self.complete("--method", "", program="hybrid-pgo"))
        self.assertEqual(self.complete("--method", "gnc-", program="hybrid-pgo"), ["gnc-gm"])

    def test_a_word_or_a_file(self):
        self.assertEqual(self.complete("--trusted", "o", program="hybrid-pgo"), ["odometry"])
        pathlib.Path(self.folder.name, "own.txt").touch()
        self.assertEqual(self.complete("--trusted", "o", program="hybrid-pgo"), ["odometry", "own.txt"])

    @unittest.skipUnless(ZSH, "zsh is not installed")
    def test_zsh(self):
        for program, line, wanted in (("hybrid-replay", "--map-mode e", "extend"), ("hybrid-replay", "--map-mode=e", "extend"), ("hybrid-replay", "--set sensor.noise=st", "sensor.noise=stated"),
                                      ("hybrid-pgo", "--method gnc-", "gnc-gm"), ("hybrid-pgo", "--trusted od", "odometry")):
            self.write(program)
            self.assertIn(wanted, self.zsh(f"{program} {line}", wanted), line)

    def zsh(self, line, wanted):
        """What a terminal shows after the line and a tab: up to what is wanted, or for 20 seconds."""
        main, terminal = pty.openpty()
        start = f"fpath=({self.written} $fpath); PS1=; autoload -Uz compinit; compinit -u -D; echo ready\n"
        shell = subprocess.Popen([ZSH, "-f", "-i"], stdin=terminal, stdout=terminal, stderr=terminal, cwd=self.folder.name,
                                 env={**os.environ, "TERM": "dumb"}, start_new_session=True)
        os.close(terminal)
        try:
            self.send(main, start, lambda shown: shown.count("ready") > 1)  # the command, and what it prints
            return self.send(main, f"{line}\t", lambda shown: wanted in shown)
        finally:
            shell.kill()
            shell.wait()
            os.close(main)

    @staticmethod
    def send(main, text, is_done):
        """What comes back until it is all there, or nothing comes for 20 seconds."""
        os.write(main, text.encode())
        shown = ""
        while not is_done(shown) and select.select([main], [], [], 20)[0]:
            shown += os.read(main, 4096).decode(errors="replace")
        return shown

    def test_files_after_other_options(self):
        self.assertEqual(self.complete("-o", "x"), [])


if __name__ == "__main__":
    PROGRAMS = os.path.abspath(sys.argv.pop(1))
    unittest.main()
