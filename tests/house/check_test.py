#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Every structure check finds its bad sample, and passes the good one."""

import pathlib
import subprocess
import tempfile
import unittest

import check

HEADER = f"// {check.SPDX[0]}\n// {check.SPDX[1]}\n"


def findings(files):
    with tempfile.TemporaryDirectory() as directory:
        root = pathlib.Path(directory)
        for path, text in files.items():
            (root / path).parent.mkdir(parents=True, exist_ok=True)
            (root / path).write_text(text, encoding="utf-8")
        return check.check_tree(root)[0]


def code(*lines):
    return HEADER + "\n".join(lines) + "\n"


class CheckTest(unittest.TestCase):
    def expect(self, path, text, *expected):
        found = findings({path: text})
        self.assertEqual(len(found), len(expected), found)
        for line, (where, message) in zip(found, expected):
            self.assertTrue(line.startswith(where), line)
            self.assertIn(message, line)

    def test_results_of_runs_are_not_committed(self):
        with tempfile.TemporaryDirectory() as directory:
            root = pathlib.Path(directory)
            for name in ("README.md", "a.hmap", "out.txt"):
                (root / name).write_text("x\n", encoding="utf-8")
            if subprocess.run(["git", "-C", directory, "init", "-q"], check=False).returncode != 0:
                self.skipTest("no git")
            subprocess.run(["git", "-C", directory, "add", "README.md", "a.hmap"], check=True)
            self.assertEqual([line.split(":")[0] for line in check.check_top(root)], ["a.hmap"])

    def test_good_tree_has_no_findings(self):
        self.assertEqual(findings({
            "libhybrid/factors/a.h": code("#pragma once", '#include "libhybrid/core/key.h"'),
            "mrpt_plugins/output/a.cpp": code('#include "libhybrid/core/key.h"',
                                              "#include <mrpt/poses/CPose3D.h>"),
            "apps/hybrid-x/main.cpp": code('#include "mrpt_plugins/output/a.h"'),
            "tests/libhybrid/core/a_test.cpp": code('#include "mrpt_plugins/output/a.h"'),
            "scripts/run": f"#!/bin/sh\n# {check.SPDX[0]}\n# {check.SPDX[1]}\n",
        }), [])

    def test_details_are_for_their_own_room(self):
        detail = '#include "libhybrid/core/detail/a.h"'
        self.expect("libhybrid/core/b.cpp", code(detail))
        self.expect("tests/libhybrid/factors/b_test.cpp", code(detail))
        for path in ("libhybrid/factors/b.cpp", "mrpt_plugins/output/b.cpp", "apps/hybrid-x/b.cpp"):
            self.expect(path, code(detail), (f"{path}:3:", "is for its own room"))

    def test_libhybrid_knows_nothing_of_mrpt_or_opencv(self):
        for name in ("mrpt/poses/CPose2D.h", "opencv2/core.hpp", "nlohmann/json.hpp"):
            self.expect("libhybrid/core/a.cpp", code(f"#include <{name}>"),
                        ("libhybrid/core/a.cpp:3:", "libhybrid must not include"))

    def test_long_functions(self):
        def function(lines):
            return code("int f(int a,", "      int b) {", *["  ++a;"] * lines, "}")
        self.expect("apps/a.cpp", function(59))
        self.expect("apps/a.cpp", function(60), ("apps/a.cpp:3:", "a body of 61 lines"))

    def test_no_include_runs_backwards(self):
        for path, target in (("libhybrid/io/a.cpp", "mrpt_plugins/output/a.h"),
                             ("libhybrid/io/a.cpp", "tests/a.h"),
                             ("mrpt_plugins/input/a.cpp", "apps/hybrid-x/a.h"),
                             ("apps/hybrid-x/a.cpp", "tests/a.h")):
            self.expect(path, code(f'#include "{target}"'), (f"{path}:3:", "the other way"))

    def test_rooms_that_include_each_other_in_a_circle(self):
        def tree(**includes):
            return {f"libhybrid/{room}/a.cpp": code(*(f'#include "libhybrid/{there}/a.h"' for there in targets))
                    for room, targets in includes.items()}

        self.assertEqual(findings(tree(core=[], factors=["core"], io=["core", "factors"], attic=["io"])), [])
        found = findings(tree(core=["io"], factors=["core"], io=["factors"], attic=["io"]))
        self.assertEqual([line.split(": ")[0] for line in found],
                         ["libhybrid/core/a.cpp:3", "libhybrid/factors/a.cpp:3", "libhybrid/io/a.cpp:3"])
        self.assertTrue(all("circle" in line for line in found), found)

    def test_files_that_include_each_other_in_a_circle(self):
        def circles(room, **includes):
            found = findings({f"{room}/{name.replace('__', '/').replace('_', '.')}":
                              code(*(f'#include "{room}/{there}"' for there in targets)) for name, targets in includes.items()})
            return [line for line in found if "circle of files" in line]

        for room in ("libhybrid/core", "mrpt_plugins/output", "apps/hybrid-x"):
            # A header, its source and what detail/ has of it are one.
            self.assertEqual(circles(room, a_h=[], detail__a_h=["a.h"], a_cpp=["a.h", "detail/a.h", "b.h"], b_h=["c.h"], c_h=[],
                                     b_cpp=["b.h", "c.h"]), [])
            # Files beside a circle, above and below, are not named.
            found = circles(room, a_h=["below.h"], a_cpp=["a.h", "detail/b.h"], detail__b_h=["c.h"], c_h=["a.h"], below_h=[],
                            above_cpp=["a.h"])
            self.assertEqual([line.split(": ")[0] for line in found],
                             [f"{room}/a.cpp:4", f"{room}/detail/b.h:3", f"{room}/c.h:3"])
            self.assertIn(f": {room}/a.cpp and {room}/detail/b.h are in a circle of files", found[0])

    def test_a_room_stands_on_those_that_it_includes(self):
        rooms = {"core": {}, "factors": {"core": ""}, "io": {"core": ""}, "maps": {"io": "", "factors": ""}}
        self.assertEqual(check.floors(rooms), ([{"core"}, {"factors", "io"}, {"maps"}], set()))
        self.assertEqual(check.floors({**rooms, "core": {"maps": ""}})[1], set(rooms))

    def test_headers_of_the_api_and_no_others_are_seen_from_outside(self):
        api = code("#pragma once", "namespace HYBRID_API hybrid {")
        hidden = code("#pragma once", "namespace hybrid {")
        for room in ("libhybrid/core", "mrpt_plugins/output"):
            self.expect(f"{room}/a.h", api)
            self.expect(f"{room}/detail/a.h", hidden)
            self.expect(f"{room}/a.h", hidden, (f"{room}/a.h:4:", "HYBRID_API hybrid {"))
            self.expect(f"{room}/detail/a.h", api, (f"{room}/detail/a.h:4:", "no HYBRID_API"))
            inner = code("#pragma once", f'#include "{room}/detail/b.h"')
            self.expect(f"{room}/detail/a.h", inner)
            self.expect(f"{room}/a.h", inner, (f"{room}/a.h:4:", "not installed"))

    def test_rooms_are_not_too_full(self):
        files = {f"libhybrid/core/a{i}.cpp": code("int x;") for i in range(check.MAX_FILES + 1)}
        found = findings(files)
        self.assertEqual(len(found), 1, found)
        self.assertIn("libhybrid/core:1: 41 files", found[0])
        files.popitem()
        self.assertEqual(findings(files), [])

    def test_include_paths_start_at_the_top(self):
        self.expect("libhybrid/core/a.cpp", code('#include "key.h"'),
                    ("libhybrid/core/a.cpp:3:", "from the top"))

    def test_the_header_of_a_source_comes_first(self):
        header, other = code("#pragma once"), '#include "libhybrid/core/b.h"'
        own = '#include "libhybrid/core/a.h"'
        good = {"libhybrid/core/a.h": header, "libhybrid/core/a.cpp": code(own, other)}
        self.assertEqual(findings(good), [])
        for lines in ((other, own), ("#include <vector>", own), (other,)):
            found = findings({**good, "libhybrid/core/a.cpp": code(*lines)})
            self.assertEqual(len(found), 1, found)
            self.assertIn("the first include must be libhybrid/core/a.h", found[0])
            inner = {"libhybrid/core/detail/a.h": header, "libhybrid/core/a.cpp": code(*lines)}
            self.assertIn("must be libhybrid/core/detail/a.h", findings(inner)[0])

    def test_headers_that_show_eigen_check_how_it_is_compiled(self):
        show = ("#pragma once", "#include <Eigen/Geometry>")
        good = {
            check.EIGEN: code("#pragma once", "#include <Eigen/Core>"),
            "libhybrid/core/a.h": code(*show, f'#include "{check.EIGEN}"'),
            "mrpt_plugins/output/b.h": code(*show, '#include "libhybrid/core/a.h"'),
        }
        self.assertEqual(findings(good), [])
        found = findings({**good, "libhybrid/core/a.h": code(*show)})
        self.assertEqual([line.split(":")[0] for line in found],
                         ["libhybrid/core/a.h", "mrpt_plugins/output/b.h"])

    def test_spdx_header(self):
        self.expect("bench/a.cpp", "int x;\n", ("bench/a.cpp:1:", "SPDX"))
        self.expect("scripts/run", "#!/bin/sh\ntrue\n", ("scripts/run:1:", "SPDX"))

    def test_header_guard(self):
        self.expect("libhybrid/core/a.h", code("int x;"), ("libhybrid/core/a.h:1:", "pragma once"))

    def test_length(self):
        self.expect("bench/a.cpp", code(*["int x;"] * 399), ("bench/a.cpp:401:", "401 lines"))
        self.expect("bench/a.cpp", code(*["int x;"] * 398))

    def test_unfinished_work(self):
        self.expect("bench/a.cpp", code("// TO" "DO: more"), ("bench/a.cpp:3:", "unfinished"))
        self.expect("docs/a.md", "FIX" "ME\n", ("docs/a.md:1:", "unfinished"))

    def test_machine_paths(self):
        for path in ("config/a.ini", "scripts/a.sh.in", "CMakeLists.txt"):
            self.expect(path, "x = /ho" "me/someone/a\n", (f"{path}:1:", "absolute path"))
        self.expect("config/a.ini", "x = ../wo" "rk/a, ${root}/wo" "rk/a, a/ro" "ot/b\n")

    def test_macros(self):
        self.expect("libhybrid/core/a.cpp", code("#define X 1"),
                    ("libhybrid/core/a.cpp:3:", "macro"))

    def test_printing(self):
        for line in ('std::cout << "x";', 'std::printf("x");', 'fmt::print("x");'):
            self.expect("mrpt_plugins/input/a.cpp", code(line),
                        ("mrpt_plugins/input/a.cpp:3:", "print"))
        self.expect("mrpt_plugins/input/a.cpp", code("std::snprintf(text, 8, format);"))

    def test_folders_are_listed_by_our_functions(self):
        line = "for (const auto& entry : std::filesystem::%s(folder)) {}"
        for name in ("directory_iterator", "recursive_directory_iterator"):
            self.expect("apps/hybrid-map/a.cpp", code(line % name), ("apps/hybrid-map/a.cpp:3:", "folders.h"))

    def test_examples_are_compiled(self):
        source = {"tests/a.cpp": code("  int x;", "  int y;")}
        page = "<!-- from tests/a.cpp -->\n```cpp\nint x;\n%s\n```\n"
        self.assertEqual(findings({**source, "README.md": page % "int y;"}), [])
        found = findings({**source, "README.md": page % "int z;", "docs/a.md": "```cpp\nint x;\n```\n"})
        self.assertEqual(len(found), 2, found)
        self.assertIn("README.md:1: the example differs", found[0])
        self.assertIn("docs/a.md:1: say which", found[1])

    def test_binary_file(self):
        with tempfile.TemporaryDirectory() as directory:
            root = pathlib.Path(directory)
            (root / "config").mkdir()
            (root / "config" / "a.ini").write_bytes(b"\xff\xfe\x00")
            self.assertIn("UTF-8", check.check_tree(root)[0][0])


if __name__ == "__main__":
    unittest.main()
