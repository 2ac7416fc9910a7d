#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Lists figures of the pages that are older than what makes them.

usage: stale_figures.py [--unnamed] [PAGE]...     (default: README.md and docs/*.md)

A figure is a paragraph, list or table with measured numbers. The command that makes it is the nearest one before it in its
section, or else the first one there, or else that of the section around it. With --unnamed, figures are listed that no command
makes: either one is missing, or the numbers are no measurements, such as limits and settings. Otherwise: the inputs of a figure are the configuration, the script or the benchmark that the command names,
and the rooms of the library that its program is about (PROGRAMS). A figure is listed where an input has a commit that is
younger than all lines of the figure by `git blame`; whoever finds it unchanged touches its lines, or leaves it for the next
measurement. Exit code 0, or 1 where a page is not in the repository.
"""

import pathlib
import re
import subprocess
import sys
import time

LANDMARKS = ["libhybrid/landmarks", "libhybrid/association", "libhybrid/movers", "mrpt_plugins/plugins"]
# What a program is about; what all programs share is left out, or every figure would be listed after every commit.
PROGRAMS = {
    "hybrid-replay": LANDMARKS + ["mrpt_plugins/mapping"],
    "hybrid-import": ["mrpt_plugins/import"],
    "hybrid-map": ["libhybrid/maps", "mrpt_plugins/map_file"],
    "hybrid-objects": ["libhybrid/objects"],
    "hybrid-pgo": ["libhybrid/selection", "libhybrid/baselines", "libhybrid/closures"],
    "hybrid-experiment": ["libhybrid/selection", "libhybrid/baselines", "libhybrid/closures"],
    "hybrid-register": ["libhybrid/registration"],
    "hybrid-simulate": ["mrpt_plugins/simulation"],
    "hybrid-switching": ["libhybrid/switching"],
}
MEASURED = re.compile(r"\d+\.\d+|\d\s?%|\d (m|s|ms|MB|kB|rad|degrees)\b")
COMMAND = re.compile(r"(?:^|[\s`/])((?:hybrid|bench)-[a-z-]+|scripts/[a-z_]+(?:\.py)?|test_[a-z_]+)(?=[\s`]|$)")
DAY = 86400


def git(root, *words):
    return subprocess.run(["git", "-C", str(root), *words], check=True, capture_output=True, text=True).stdout


def blocks(lines):
    """(first line, text) of each block between blank lines; headings and fences stand alone."""
    start, held, fenced = 0, [], False
    for number, line in enumerate([*lines, ""], 1):
        fence = line.startswith("```")
        if held and not fenced and (not line.strip() or line.startswith("#")):
            yield start, held
            held = []
        if line.strip():
            start = start if held else number
            held.append(line)
            if line.startswith("#") and not fenced:
                yield start, held
                held = []
        fenced = fenced != fence


def is_code(block):
    return block[0].startswith(("    ", "```"))


def inputs_of(root, command_line):
    """Paths of the repository that a command uses."""
    paths = []
    for word in COMMAND.findall(command_line):
        paths += PROGRAMS.get(word, [])
        if word.startswith("bench-"):
            paths.append(f"bench/{word}.cpp")
        if word.startswith("scripts/"):
            paths.append(word)
        if word.startswith("test_"):
            paths.append(tests_of(root, word.removeprefix("test_")))
    paths += re.findall(r"config/[\w/]+\.ini", command_line)
    return [path for path in dict.fromkeys(paths) if path and (root / path).exists()]


def tests_of(root, name):
    """The folder of a test program: test_a_b_c is of tests/a/b_c or tests/a_b/c, whichever is there."""
    parts = name.split("_")
    for cuts in range(2 ** (len(parts) - 1)):
        path = parts[0] + "".join(("/" if cuts >> i & 1 else "_") + part for i, part in enumerate(parts[1:]))
        if (root / "tests" / path).is_dir():
            return f"tests/{path}"
    return None


def sections(lines):
    """Blocks of each section in turn."""
    held = []
    for start, block in blocks(lines):
        if block[0].startswith("#") and held:
            yield held
            held = []
        held.append((start, block))
    if held:
        yield held


def is_figure(block):
    return not is_code(block) and not block[0].startswith("#") and MEASURED.search(re.sub(r"`[^`]*`", "", "\n".join(block)))


def figures_of(root, lines):
    """(first line, last line, inputs) of each figure; no inputs where no command is named."""
    around = {}  # level of a heading -> inputs of the first command below it
    for section in sections(lines):
        made = [(start, inputs_of(root, "\n".join(block))) for start, block in section]
        made = [(start, inputs) for start, inputs in made if inputs]
        level = len(section[0][1][0]) - len(section[0][1][0].lstrip("#"))
        around = {above: inputs for above, inputs in around.items() if above < level}
        inherited = around[max(around)] if around else []
        if made and level > 1:  # the head of a page is of no figure in particular
            around[level] = made[0][1]
        for start, block in section:
            if is_figure(block):
                before = [m for m in made if m[0] <= start] or made[:1] or [(start, inherited)]
                yield start, start + len(block) - 1, before[-1][1]


def times_of_lines(root, page):
    """The commit time of each line; now for lines that are not committed."""
    times, out = {}, []
    for line in git(root, "blame", "--line-porcelain", "--", str(page)).splitlines():
        if re.match(r"[0-9a-f]{40} ", line):
            commit = line.split()[0]
        elif line.startswith("committer-time "):
            times[commit] = time.time() if set(commit) == {"0"} else int(line.split()[1])
        elif line.startswith("\t"):
            out.append(times[commit])
    return out


def stale(root, page):
    """(first line, day of the figure, [(path, day of its last commit)]) of the figures that are older than an input."""
    lines = (root / page).read_text(encoding="utf-8").splitlines()
    times = times_of_lines(root, page)
    for first, last, inputs in figures_of(root, lines):
        written = max(times[first - 1:last])
        younger = []
        for path in inputs:
            found = git(root, "log", "-1", "--format=%ct", "--", path).strip()
            if found and int(found) > written:
                younger.append((path, int(found)))
        if younger:
            yield first, written, younger


def unnamed(root, page):
    """First lines of the figures of a page that no command makes."""
    lines = (root / page).read_text(encoding="utf-8").splitlines()
    return [first for first, _, inputs in figures_of(root, lines) if not inputs]


def day(seconds):
    return time.strftime("%Y-%m-%d", time.gmtime(seconds))


def main():
    if any(word in ("-h", "--help") for word in sys.argv[1:]):
        print(__doc__)
        return
    root = pathlib.Path(git(pathlib.Path.cwd(), "rev-parse", "--show-toplevel").strip())
    without = "--unnamed" in sys.argv[1:]
    pages = [word for word in sys.argv[1:] if word != "--unnamed"] or ["README.md", *sorted(str(p.relative_to(root)) for p in (root / "docs").glob("*.md"))]
    count = 0
    for page in pages:
        try:
            for first in unnamed(root, page) if without else ():
                count += 1
                print(f"{page}:{first}: names no command")
            for first, written, younger in () if without else stale(root, page):
                count += 1
                told = ", ".join(f"{path} ({day(changed)})" for path, changed in younger)
                print(f"{page}:{first}: figures of {day(written)}; changed since: {told}")
        except (OSError, subprocess.CalledProcessError) as error:
            sys.exit(f"error: {page}: {getattr(error, 'stderr', None) or error}".strip())
    print(f"{count} paragraphs or tables {'name no command' if without else 'are older than an input of theirs'}")


if __name__ == "__main__":
    main()
