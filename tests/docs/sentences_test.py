#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Pages for a reader with a task: sentences of at most 25 words in the mean, and none of more than 40.

usage: sentences_test.py [PAGE]...     (prints the mean, the longest and the number of sentences of pages)
"""

import pathlib
import re
import sys
import unittest

DOCS = pathlib.Path(__file__).resolve().parents[2] / "docs"
PAGES = sorted(page.stem for page in DOCS.glob("*.md"))
MOST_IN_THE_MEAN, LONG = 25, 40  # words


def sentences_of(text):
    """Sentences of the paragraphs and list items; not those of code, tables, headings and pictures."""
    kept, fenced, before = [], False, ""
    for line in text.splitlines():
        if line.startswith("```"):
            fenced = not fenced
        elif not fenced and not re.match(r"( {4,}(?![*-] )\S|\||#|!\[|<)", line) or (line.startswith("    ") and before.startswith(("* ", "- "))):
            new = re.match(r"\s*([*-]|\d+\.)\s", line) or not before.strip()
            kept.append(("\n" if new else " ") + line.strip())
        before = line if line.strip() else ""
    for paragraph in "".join(kept).split("\n"):
        plain = re.sub(r"^([*-]|\d+\.)\s+", "", paragraph.strip())
        plain = re.sub(r"`[^`]*`", "code", plain)
        plain = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", plain)
        for sentence in re.split(r"(?<=[.?!])\s+(?=\S)", plain):
            words = re.findall(r"[A-Za-z0-9][\w'.,/%-]*", sentence)
            if len(words) > 2:
                yield len(words), sentence


def measure(name):
    found = list(sentences_of((DOCS / f"{name}.md").read_text(encoding="utf-8")))
    lengths = [n for n, _ in found]
    return sum(lengths) / len(lengths), found


class Sentences(unittest.TestCase):
    def test_they_are_short(self):
        for name in PAGES:
            with self.subTest(name):
                mean, found = measure(name)
                self.assertLessEqual(mean, MOST_IN_THE_MEAN)
                self.assertEqual([f"{n}: {sentence}" for n, sentence in found if n > LONG], [], f"{name}: sentences of more than {LONG} words")

    def test_sentences_are_counted(self):
        text = ("# No sentence here at all\n\nThree words here. This one: has `a b c` of six words\nover two lines.\n\n"
                "    code that is not counted\n\n* An item, it counts.\n  It goes on here.\n\n| a table | is not |\n")
        self.assertEqual([n for n, _ in sentences_of(text)], [3, 10, 4, 4])


if __name__ == "__main__":
    if len(sys.argv) > 1:
        for page in sys.argv[1:]:
            mean, found = measure(pathlib.Path(page).stem)
            print(f"{page}: {mean:.1f} words in the mean of {len(found)}, {sum(n > LONG for n, _ in found)} of more than {LONG}")
            for n, sentence in sorted(found, reverse=True)[:8]:
                print(f"    {n}: {sentence[:240]}")
    else:
        unittest.main()
