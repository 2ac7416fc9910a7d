#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Links of pages to files of the project and to headings have what they point to."""

import functools
import pathlib
import re
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
PAGES = [*ROOT.glob("*.md"), *(page for folder in ("docs", "notes", "rawlogs") for page in (ROOT / folder).glob("*.md"))]


@functools.lru_cache(maxsize=None)
def anchors(page):
    """Those of the headings of a page; equal ones are numbered."""
    found = []
    text = re.sub(r"^```.*?^```", "", page.read_text(encoding="utf-8"), flags=re.S | re.M)
    for heading in re.findall(r"^#+\s+(.*)$", text, flags=re.M):
        plain = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading)
        name = re.sub(r"[^\w\- ]", "", plain.strip().lower()).replace(" ", "-")
        found.append(name if name not in found else f"{name}-{found.count(name)}")
    return frozenset(found)


def broken(page):
    text = re.sub(r"^```.*?^```", "", page.read_text(encoding="utf-8"), flags=re.S | re.M)
    for target in re.findall(r"\]\(([^)]+)\)", text):
        if re.match(r"[a-z]+:", target):
            continue
        name, _, anchor = re.sub(r"\s", "", target).partition("#")
        file = (page.parent / name).resolve() if name else page
        if not file.exists() or (anchor and file.suffix == ".md" and anchor not in anchors(file)):
            yield target


class Links(unittest.TestCase):
    def test_they_lead_somewhere(self):
        self.assertGreater(len(PAGES), 40)
        self.assertEqual([f"{page.relative_to(ROOT)}: {target}" for page in PAGES for target in broken(page)], [])


if __name__ == "__main__":
    unittest.main()
