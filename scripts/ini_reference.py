#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Writes the tables of docs/settings.md from what the programs print with --print-config.

usage: ini_reference.py BIN [PAGE]     BIN: the folder of the programs

What stands above the mark in the page is kept; keys that it names as `section.key` are bold in the tables. Exit code 1 where
it names a key that no program has.
"""

import pathlib
import re
import subprocess
import sys

PAGE = pathlib.Path(__file__).resolve().parents[1] / "docs/settings.md"
MARK = "<!-- What follows is written by scripts/ini_reference.py. -->"
PROGRAMS = {
    "hybrid-replay": "Plugins that a library adds (`-p`) print their own sections as well.",
    "hybrid-pgo": "Methods for pose graphs; only those of the method that is chosen count.",
    "hybrid-experiment": "The sections of the methods are those of `hybrid-pgo`.",
    "hybrid-simulate": "What is simulated, and what is seen of it.",
}
NOTE = re.compile(r"# (?P<meaning>.*) \((?P<kind>(?:number|whole number|list of|text|true or false|one of)[^;]*); (?:default (?P<default>.*)|required)\)$")
NAMED = re.compile(r"`([A-Za-z]\w*\.[a-z]\w*)(?:=[^`]*)?`")


def sections_of(text):
    """(name, meaning, [(key, default, kind, meaning)]) of each section that --print-config prints."""
    found, note = [], ""
    for line in text.splitlines():
        if line.startswith("["):
            found.append((line.strip("[]"), note.removeprefix("# "), []))
        elif line.startswith("#"):
            note = line
            continue
        elif " =" in line:
            told = NOTE.match(note)
            if not told:
                sys.exit(f"error: [{found[-1][0]}] {line}: its comment is not understood: {note}")
            found[-1][2].append((line.split(" =")[0], told["default"], told["kind"], told["meaning"]))
        note = ""
    return found


def cell(text):
    return re.sub(r"<(?=[A-Za-z/])", "&lt;", text.replace("|", "\\|"))


def table_of(section, keys, first):
    lines = ["| key | default | type | meaning |", "|---|---|---|---|"]
    for key, default, kind, meaning in keys:
        name = f"**`{key}`**" if f"{section}.{key}" in first else f"`{key}`"
        value = "required" if default is None else f"`{default}`" if default.strip() else ""
        lines.append(f"| {name} | {cell(value)} | {cell(kind)} | {cell(meaning)} |")
    return lines


def tables_of(bins, first):
    lines, seen, known = [], [], set()
    for program, about in PROGRAMS.items():
        text = subprocess.run([bins / program, "--print-config"], check=True, capture_output=True, text=True).stdout
        lines += [f"## {program}", "", about, ""]
        for section, meaning, keys in sections_of(text):
            known |= {f"{section}.{key[0]}" for key in keys}
            if (section, keys) in seen or not keys:
                continue
            seen.append((section, keys))
            lines += [f"### [{section}]", "", *([f"{meaning}.", ""] if meaning else []), *table_of(section, keys, first), ""]
    for name in sorted(first - known):
        sys.exit(f"error: docs/settings.md names {name}, which no program has")
    return lines


def page_of(bins, text):
    """The page with its tables anew."""
    if MARK not in text:
        sys.exit(f"error: the page lacks the line {MARK}")
    above = text[:text.index(MARK)]
    return above + "\n".join([MARK, "", *tables_of(bins, set(NAMED.findall(above)))])


def main():
    if len(sys.argv) < 2 or sys.argv[1] in ("-h", "--help"):
        sys.exit(__doc__)
    page = pathlib.Path(sys.argv[2]) if len(sys.argv) > 2 else PAGE
    page.write_text(page_of(pathlib.Path(sys.argv[1]), page.read_text(encoding="utf-8")), encoding="utf-8")


if __name__ == "__main__":
    main()
