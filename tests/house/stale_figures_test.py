#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""scripts/stale_figures.py, in repositories made here."""

import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

SCRIPT = pathlib.Path(__file__).parents[2] / "scripts/stale_figures.py"
PAGE = """# A page

It is about 3 things.

## Errors

    hybrid-replay -c config/a.ini -o OUT

The error is 0.25 m.

| run | error |
|---|---|
| `hybrid-replay -c config/b.ini` | 0.5 m |

### Of parts

Half of it is 0.1 m.

## Time

A run takes 1.5 s (`bench-fast`).

## Elsewhere

Half of them take 2.5 ms.

| key | default |
|---|---|
| `lag` | 0.5 s |

It waits for 0.5 s.

## Written down

The error of the scale is 0.5 m. It was measured by hand; no command here repeats it.

## Words

Nothing is measured here, 0.5 m or not.
"""


class StaleFigures(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.at = pathlib.Path(self.folder.name)
        self.git("init", "-q")
        for name in ("config/a.ini", "config/b.ini", "bench/bench-fast.cpp", "libhybrid/landmarks/x.cpp", "libhybrid/linear/y.cpp"):
            self.write(name, "1")
        self.write("docs/page.md", PAGE)
        self.commit(1)

    def git(self, *words, **environment):
        subprocess.run(["git", "-c", "user.name=a", "-c", "user.email=a@b", *words], cwd=self.at, check=True,
                       env={**os.environ, **environment}, capture_output=True)

    def write(self, name, text):
        path = self.at / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")

    def commit(self, day, message="x"):
        date = f"2026-01-{day:02}T12:00:00Z"
        self.git("add", "-A")
        self.git("commit", "-qm", message, GIT_AUTHOR_DATE=date, GIT_COMMITTER_DATE=date)

    def listed(self, *pages):
        ran = subprocess.run([sys.executable, "-B", SCRIPT, *pages], cwd=self.at, text=True, capture_output=True, check=False)
        self.assertEqual(ran.returncode, 0, ran.stderr)
        *lines, total = ran.stdout.splitlines()
        self.assertEqual(total.split()[0], str(len(lines)))
        return lines

    def test_nothing_is_older_than_its_inputs(self):
        self.write("README.md", "# x\n")
        self.commit(1)
        self.assertEqual(self.listed(), [])

    def test_a_figure_is_listed_with_what_changed(self):
        self.write("config/a.ini", "2")
        self.commit(5)
        self.assertEqual(self.listed("docs/page.md"),
                         [f"docs/page.md:{line}: figures of 2026-01-01; changed since: config/a.ini (2026-01-05, 2 lines)" for line in (9, 17)])

    def test_small_changes_can_be_left_out(self):
        self.write("config/a.ini", "2")
        self.write("config/b.ini", "2\n3\n4\n5\n")
        self.commit(5)
        self.assertEqual(len(self.listed("--lines", "2", "docs/page.md")), 3)
        self.assertEqual([line.split(": ")[0] for line in self.listed("--lines", "3", "docs/page.md")], ["docs/page.md:11"])
        ran = subprocess.run([sys.executable, "-B", SCRIPT, "--lines"], cwd=self.at, text=True, capture_output=True, check=False)
        self.assertEqual((ran.returncode, ran.stderr), (1, "error: --lines needs a number\n"))

    def test_a_table_names_its_own_command(self):
        self.write("config/b.ini", "2")
        self.commit(5)
        self.assertEqual([line.split(": ")[0] for line in self.listed("docs/page.md")], ["docs/page.md:11"])

    def test_rooms_of_a_program_and_benchmarks_count(self):
        self.write("libhybrid/linear/y.cpp", "2")  # all programs share it
        self.commit(4)
        self.assertEqual(self.listed("docs/page.md"), [])
        self.write("libhybrid/landmarks/x.cpp", "2")
        self.write("bench/bench-fast.cpp", "2")
        self.commit(5)
        self.assertEqual([line.split(": ")[0] for line in self.listed("docs/page.md")],
                         ["docs/page.md:9", "docs/page.md:11", "docs/page.md:17", "docs/page.md:21"])

    def test_results_without_a_command_are_listed(self):
        line = PAGE.splitlines().index("Half of them take 2.5 ms.") + 1
        self.assertEqual(self.listed("--unnamed", "docs/page.md"), [f"docs/page.md:{line}: names no command"])

    def test_numbers_of_a_table_are_results_those_of_methods_are_not(self):
        self.write("docs/page.md", "# A\n\nIt waits for 0.5 s, or 3 m.\n\n| a | b |\n|---|---|\n| x | 0.5 m |\n\n| a | b |\n|---|---|\n| x | at 0.5 m |\n")
        self.commit(5)
        self.assertEqual(self.listed("--unnamed", "docs/page.md"), ["docs/page.md:5: names no command"])

    def test_comments_and_moved_lines_are_no_change(self):
        self.write("libhybrid/landmarks/x.cpp", "// Why.\n#include <cmath>\n1\n")
        self.write("libhybrid/landmarks/z.cpp", "int f();\n")
        self.commit(4)
        self.write("docs/page.md", PAGE.replace("0.25", "0.26").replace("0.5 m", "0.6 m").replace("0.1 m", "0.2 m"))
        self.commit(4)
        (self.at / "libhybrid/landmarks/z.cpp").rename(self.at / "libhybrid/landmarks/w.cpp")
        self.write("libhybrid/landmarks/x.cpp", "1\n")
        self.commit(5)
        self.write("libhybrid/landmarks/w.cpp", "")
        self.write("libhybrid/landmarks/x.cpp", "  int f();\n1\n")
        self.commit(6)
        self.assertEqual(self.listed("docs/page.md"), [])
        self.write("libhybrid/landmarks/x.cpp", "int g();\n1\n")
        self.commit(7)
        self.assertEqual(self.listed("docs/page.md")[0].split("; ")[1], "changed since: libhybrid/landmarks (2026-01-07, 2 lines)")

    def test_a_replay_is_about_its_plugins(self):
        for name in ("libhybrid/scans/s.cpp", "libhybrid/association/t.cpp"):
            self.write(name, "1")
        self.write("docs/page.md", "# A\n\n## B\n\n`hybrid-replay -c config/l.ini` takes 2 s.\n")
        self.write("config/l.ini", "classes = LaserScans\n")
        self.commit(5)
        self.write("libhybrid/association/t.cpp", "2")
        self.commit(6)
        self.assertEqual(self.listed("docs/page.md"), [])
        self.write("libhybrid/scans/s.cpp", "2")
        self.commit(7)
        self.assertEqual(len(self.listed("docs/page.md")), 1)

    def test_online_selection_counts_where_it_is_used(self):
        for name in ("libhybrid/online/o.cpp", "libhybrid/selection/s.cpp"):
            self.write(name, "1")
        self.write("config/o.ini", "methods = online\n")
        self.write("docs/page.md", "# A\n\n## B\n\n`hybrid-pgo a.g2o` takes 2 s.\n\n## C\n\n`hybrid-pgo a.g2o --online` takes 3 s.\n\n"
                   "## D\n\n`hybrid-experiment -c config/o.ini` takes 4 s.\n")
        self.commit(5)
        self.write("libhybrid/online/o.cpp", "2")
        self.commit(6)
        self.assertEqual([line.split(": ")[0] for line in self.listed("docs/page.md")], ["docs/page.md:9", "docs/page.md:13"])
        self.write("libhybrid/selection/s.cpp", "2")
        self.commit(7)
        self.assertEqual(len(self.listed("docs/page.md")), 3)

    def test_a_reworded_sentence_stays_as_old_as_it_was(self):
        self.write("config/a.ini", "2")
        self.commit(5)
        self.write("docs/page.md", PAGE.replace("The error is 0.25 m.", "Its error is 0.25 m."))
        self.commit(6, "Reword a sentence")
        self.assertEqual([line.split(": ")[0] for line in self.listed("docs/page.md")], ["docs/page.md:9", "docs/page.md:17"])

    def test_pictures_are_looked_at(self):
        page = "# A\n\n## B\n\n![x](images/x.png)\n\n*`hybrid-replay -c config/a.ini`*\n\n## C\n\n![y](images/y.png)\n\n![x](images/x.png)\n"
        self.write("docs/page.md", page)
        for name in ("x", "y"):
            self.write(f"docs/images/{name}.png", name)
        self.commit(4)
        self.write("config/a.ini", "2")
        self.commit(5)
        self.write("docs/page.md", page.replace("[x]", "[z]"))  # the line is younger, the picture is not
        self.commit(6)
        self.assertEqual(self.listed("docs/page.md"), ["docs/page.md:5: figures of 2026-01-04; changed since: config/a.ini (2026-01-05, 2 lines)"])
        self.assertEqual(self.listed("--unnamed", "docs/page.md"), ["docs/page.md:11: names no command"])
        self.write("docs/images/x.png", "z")
        self.commit(7)
        self.assertEqual(self.listed("docs/page.md"), [])

    def test_a_figure_measured_again_and_found_the_same_says_so(self):
        page = "# A\n\n## B\n\n`hybrid-replay -c config/a.ini`\n\n![x](images/x.png)\n\n| a | b |\n|---|---|\n| x | 0.5 m |\n"
        self.write("docs/page.md", page)
        self.write("docs/images/x.png", "x")
        self.commit(4)
        self.write("config/a.ini", "2")
        self.commit(5)
        self.write("docs/page.md", page.replace("x.png)\n", "x.png)\n<!-- measured 2026-01-06 -->\n"))
        self.commit(6)
        self.assertEqual([line.split(": ")[0] for line in self.listed("docs/page.md")], ["docs/page.md:10"])
        self.write("docs/page.md", page.replace("x.png)\n", "x.png)\n<!-- measured 2026-01-06 -->\n") + "<!-- measured 2026-01-07 -->\n")
        self.commit(7)
        self.assertEqual(self.listed("docs/page.md"), [])
        self.write("config/a.ini", "3")
        self.commit(8)
        self.assertEqual([line.split(";")[0] for line in self.listed("docs/page.md")],
                         ["docs/page.md:7: figures of 2026-01-06", "docs/page.md:10: figures of 2026-01-07"])

    def test_another_comment_makes_no_picture_younger(self):
        page = "# A\n\n## B\n\n`hybrid-replay -c config/a.ini`\n\n![x](images/x.png)\n"
        self.write("docs/page.md", page)
        self.write("docs/images/x.png", "x")
        self.commit(4)
        self.write("config/a.ini", "2")
        self.commit(5)
        self.write("docs/page.md", page + "<!-- not measured -->\n")
        self.commit(6)
        self.assertEqual(len(self.listed("docs/page.md")), 1)

    def test_what_was_turned_back_is_skipped(self):
        page = PAGE.replace("## Errors", "## Tried, not in: errors")
        self.write("docs/page.md", page)
        self.write("docs/tries.md", PAGE)
        self.write("README.md", "# x\n")
        self.commit(4)
        for name in ("config/a.ini", "config/b.ini", "bench/bench-fast.cpp"):
            self.write(name, "2")
        self.commit(5)
        time = page.splitlines().index("A run takes 1.5 s (`bench-fast`).") + 1
        self.assertEqual([line.split(": ")[0] for line in self.listed()], [f"docs/page.md:{time}"])
        self.write("docs/page.md", page.replace("Tried, not in", "Tried, and in"))
        self.commit(4)
        self.assertEqual(len(self.listed()), 4)

    def test_what_a_script_writes_is_skipped(self):
        self.write("docs/page.md", PAGE.replace("## Errors", "<!-- What follows is written by scripts/a.py. -->\n\n## Errors"))
        self.commit(4)
        self.write("config/a.ini", "2")
        self.commit(5)
        self.assertEqual(self.listed("docs/page.md"), [])

    def test_a_new_measurement_is_young_again(self):
        self.write("config/a.ini", "2")
        self.commit(5)
        self.write("docs/page.md", PAGE.replace("0.25 m", "0.24 m").replace("0.1 m", "0.2 m"))
        self.assertEqual(self.listed("docs/page.md"), [])  # before it is committed
        self.commit(6)
        self.assertEqual(self.listed("docs/page.md"), [])

    def test_a_page_that_is_not_there_is_told(self):
        ran = subprocess.run([sys.executable, "-B", SCRIPT, "docs/none.md"], cwd=self.at, text=True, capture_output=True, check=False)
        self.assertEqual(ran.returncode, 1)
        self.assertIn("docs/none.md", ran.stderr)


if __name__ == "__main__":
    unittest.main()
