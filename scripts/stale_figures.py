#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Lists figures of the pages that are older than what makes them.

usage: stale_figures.py [--lines N] [PAGE]...     (default: README.md and docs/*.md but tries.md)
       stale_figures.py --unnamed [PAGE]...

A figure is a paragraph, list or table with measured numbers, or a picture. The command that makes it is the nearest one before it
in its section, or else the first one there, or else that of the section around it. A picture has that of its caption, or of the
code below it; where its page names none, another page may. What a script writes into a page ("What follows is written by") is
skipped.

The inputs of a figure are the configuration, the script or the benchmark that the command names, and the rooms of the library
that its program and plugins are about (PROGRAMS, PLUGINS). A figure is listed where lines of code in an input are younger than
all lines of the figure by `git blame`, or than the picture. Comments, lines that a commit only moves, and renamed files do not
count. Nor do commits whose message begins with "Reword", for the age of a figure. A line that uses a renamed name counts. Whoever
measures a figure again and finds it unchanged adds the line "<!-- measured YYYY-MM-DD -->" to its end, with no empty line between,
or changes its date. By the blame of that line a figure is as young as a new one, and so is a picture.

Figures of what was turned back cannot be measured again: sections whose heading begins with "Tried, not in" are skipped, with all
below them. They are no place for figures of what is in. docs/tries.md is skipped too, since a test compares its output.

With --lines, figures are listed whose inputs have at least N changed lines (an added and a removed line are two), so that those of
large changes can be measured first.

With --unnamed, figures are listed that no command makes. Numbers of settings, limits and methods are no figures: there a result
is a table of numbers, or a sentence in which a number stands beside a word of measuring (RESULT). What a page says "no command here repeats" is left out. Exit code 0, or 1 where a page
is not in the repository.
"""

import collections
import pathlib
import re
import subprocess
import sys
import time

LANDMARKS = ["libhybrid/landmarks", "libhybrid/detections", "libhybrid/association", "libhybrid/movers", "mrpt_plugins/plugins"]
KNOWN_IDS = ["libhybrid/initialization", "libhybrid/detections/sighting.cpp"]
# What a replay is about by its plugins; LANDMARKS where none is named.
PLUGINS = {
    "BearingRangeAssociation": LANDMARKS[:3] + ["mrpt_plugins/plugins/bearing_range_association.cpp"],
    "BearingRangeKnownIds": [*KNOWN_IDS, "mrpt_plugins/plugins/bearing_range_plugins.cpp"],
    "ClassedBearingRangeKnownIds": [*KNOWN_IDS, "mrpt_plugins/plugins/bearing_range_plugins.cpp"],
    "BeaconRanges": [*KNOWN_IDS, "mrpt_plugins/plugins/beacon_ranges.cpp"],
    "BearingOnly": [*KNOWN_IDS, "mrpt_plugins/plugins/bearing_only.cpp"],
    "LaserScans": ["libhybrid/scans", "mrpt_plugins/plugins/laser_scans.cpp"],
}
SELECTION = ["libhybrid/selection", "libhybrid/choices", "libhybrid/methods", "libhybrid/baselines", "libhybrid/closures"]
# What a program is about; what all programs share is left out, or every figure would be listed after every commit.
PROGRAMS = {
    "hybrid-replay": ["mrpt_plugins/mapping"],
    "hybrid-import": ["mrpt_plugins/import"],
    "hybrid-map": ["libhybrid/maps", "mrpt_plugins/map_file"],
    "hybrid-objects": ["libhybrid/objects"],
    "hybrid-pgo": SELECTION,
    "hybrid-experiment": SELECTION,
    "hybrid-register": ["libhybrid/registration"],
    "hybrid-simulate": ["mrpt_plugins/simulation"],
    "hybrid-switching": ["libhybrid/switching"],
}
MEASURED = re.compile(r"\d+\.\d+|\d\s?%|\d (m|s|ms|MB|kB|rad|degrees)\b")
COMMAND = re.compile(r"(?:^|[\s`/])((?:hybrid|bench)-[a-z0-9-]+|(?:scripts|examples)/[a-z0-9_]+(?:\.(?:py|cpp))?|test_[a-z_]+)(?=[\s`]|$)")
PICTURE = re.compile(r"!\[[^\]]*\]\(([^)]+\.(?:png|svg))\)")
TURNED_BACK = re.compile(r"#+ Tried, not in\b")
TESTED = "docs/tries.md"
AGAIN = re.compile(r"<!-- measured \d{4}-\d\d-\d\d -->$")
GENERATED = re.compile(r"<!-- What follows is written by ")
RESULT = re.compile(r"\b(error of|rmse|recall|precision|median|took|takes?|save[sd]?|faster|slower|instead of|compiles in)\b")
SETTINGS = re.compile(r"\|\s*default\s*\|")  # in the head of a table
NOT_REPEATED = "no command here repeats it"  # said of what was measured once
NO_CODE = re.compile(r"\s*(//|#(?!define)|;|\W*$)")  # comments, includes, brackets
ROOMS = ("libhybrid", "mrpt_plugins", "bench", "config", "scripts", "tests", "examples")


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
    settings = re.findall(r"config/[\w/]+\.ini", command_line)
    text = command_line + "".join((root / name).read_text(encoding="utf-8") for name in settings if (root / name).exists())
    for word in COMMAND.findall(command_line):
        paths += PROGRAMS.get(word, [])
        if PROGRAMS.get(word) is SELECTION and re.search(r"\bonline\b", text):
            paths.append("libhybrid/online")
        if word.startswith("bench-"):
            paths.append(f"bench/{word}.cpp")
        if word == "hybrid-replay":
            named = [paths_of for plugin, paths_of in PLUGINS.items() if re.search(rf"\b{plugin}\b", text)]
            paths += sum(named, []) or LANDMARKS
        if word.startswith(("scripts/", "examples/")):
            paths.append(word)
        if word.startswith("test_"):
            paths.append(tests_of(root, word.removeprefix("test_")))
    paths += settings
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
    return not is_code(block) and not block[0].startswith("#") and not SETTINGS.search(block[0]) and MEASURED.search(re.sub(r"`[^`]*`", "", "\n".join(block)))


def is_result(block):
    """Whether numbers were measured; only asked where no command stands, since settings have units too."""
    if block[0].startswith("!["):
        return True
    if block[0].startswith("|"):
        cells = [cell for row in block[2:] for cell in row.strip("| ").split("|")[1:]]
        return sum(bool(re.match(r"\W*\d", cell)) for cell in cells) > len(cells) / 2
    sentences = re.split(r"(?<=[.?!])\s+", re.sub(r"`[^`]*`", "", " ".join(line.strip() for line in block)))
    return any(MEASURED.search(sentence) and RESULT.search(sentence) for sentence in sentences)


def pictures_of(block):
    """Paths of the pictures in a block."""
    return [] if is_code(block) else PICTURE.findall("\n".join(block))


def figures_of(root, lines):
    """(first line, last line, inputs) of each figure; no inputs where no command is named."""
    around = {}  # level of a heading -> inputs of the first command below it
    turned_back = None  # the level of a heading whose section is skipped
    for section in sections(lines):
        made = [(start, inputs_of(root, "\n".join(block))) for start, block in section]
        made = [(start, inputs) for start, inputs in made if inputs]
        level = len(section[0][1][0]) - len(section[0][1][0].lstrip("#"))
        if turned_back and level > turned_back:
            continue
        turned_back = level if TURNED_BACK.match(section[0][1][0]) else None
        if turned_back:
            continue
        around = {above: inputs for above, inputs in around.items() if above < level}
        inherited = around[max(around)] if around else []
        if made and level > 1:  # the head of a page is of no figure in particular
            around[level] = made[0][1]
        for at, (start, block) in enumerate(section):
            below = section[at + 1] if at + 1 < len(section) else (0, [""])
            if pictures_of(block) and (is_code(below[1]) or below[1][0].startswith("*")) and inputs_of(root, "\n".join(below[1])):
                yield start, start + len(block) - 1, inputs_of(root, "\n".join(below[1]))
            elif is_figure(block) or pictures_of(block):
                before = [m for m in made if m[0] <= start] or made[:1] or [(start, inherited)]
                yield start, start + len(block) - 1, before[-1][1]


def times_of_lines(root, page):
    """The commit time of each line; now for lines that are not committed."""
    times, out = {}, []
    told = [line.split(" ", 1) for line in git(root, "log", "--format=%H %s", "--", str(page)).splitlines()]
    words = [word for commit, subject in told if subject.startswith("Reword") for word in ("--ignore-rev", commit)]
    for line in git(root, "blame", *words, "--line-porcelain", "--", str(page)).splitlines():
        if re.match(r"[0-9a-f]{40} ", line):
            commit = line.split()[0]
        elif line.startswith("committer-time "):
            times[commit] = time.time() if set(commit) == {"0"} else int(line.split()[1])
        elif line.startswith("\t"):
            out.append(times[commit])
    return out


def changes_of_code(root):
    """{file: [(commit time, number of lines of code)]}: lines that were changed and not only moved."""
    changes = collections.defaultdict(list)
    log = git(root, "log", "-M", "-p", "-U0", "--no-color", "--format=%x00%ct", "--", *(name for name in ROOMS if (root / name).exists()))
    for commit in log.split("\0")[1:]:
        time_of, _, diff = commit.partition("\n")
        counts, files, name = {"+": collections.Counter(), "-": collections.Counter()}, [], None
        header = False
        for line in diff.splitlines():
            if line.startswith("diff --git "):
                name, header = line.split(" b/", 1)[1], True
            elif line.startswith("@@"):
                header = False
            elif not header and line[:1] in counts and not NO_CODE.match(line[1:]):
                plain = "".join(line[1:].split())
                counts[line[0]][plain] += 1
                files.append((name, line[0], plain))
        lines = collections.Counter(name for name, sign, plain in files if counts["+"][plain] != counts["-"][plain])
        for name, count in lines.items():
            changes[name].append((int(time_of), count))
    return changes


def stale(root, page, changes):
    """(first line, day of the figure, [(path, day of its last change, lines of code)]) of the figures that are older than an input."""
    lines = shown_lines(root, page)
    times = times_of_lines(root, page)
    for first, last, inputs in figures_of(root, lines):
        written = [max(times[first - 1:last])]
        pictures = pictures_of(lines[first - 1:last])
        for picture in pictures:
            found = git(root, "log", "-1", "--format=%ct", "--", str(pathlib.Path(page).parent / picture)).strip()
            written.append(int(found) if found else time.time())
        again = [times[line - 1] for line in range(first, last + 1) if AGAIN.match(lines[line - 1])]
        written = max([min(written[1:]) if pictures else written[0], *again])
        younger = []
        for path in inputs:
            found = [change for name, of in changes.items() if name == path or name.startswith(path + "/") for change in of if change[0] > written]
            if found:
                younger.append((path, max(found)[0], sum(count for _, count in found)))
        if younger:
            yield first, written, younger


def shown_lines(root, page):
    """Lines of a page but for those that a script writes."""
    lines = (root / page).read_text(encoding="utf-8").splitlines()
    return lines[:next((n for n, line in enumerate(lines) if GENERATED.match(line)), len(lines))]


def pictures_with_commands(root):
    """Paths of the pictures that some page names a command for."""
    named = set()
    for page in [root / "README.md", *(root / "docs").glob("*.md")]:
        if page.exists():
            lines = shown_lines(root, page)
            for first, last, inputs in figures_of(root, lines):
                if inputs:
                    named.update((page.parent / picture).resolve() for picture in pictures_of(lines[first - 1:last]))
    return named


def unnamed(root, page):
    """First lines of the figures of a page that no command makes."""
    lines = shown_lines(root, page)
    elsewhere = pictures_with_commands(root)
    for first, last, inputs in figures_of(root, lines):
        pictures = [(root / page).parent / picture for picture in pictures_of(lines[first - 1:last])]
        if pictures and all(picture.resolve() in elsewhere for picture in pictures) or NOT_REPEATED in " ".join(lines[max(first - 6, 0):last]):
            continue
        if not inputs and is_result(lines[first - 1:last]):
            yield first


def day(seconds):
    return time.strftime("%Y-%m-%d", time.gmtime(seconds))


def main():
    if any(word in ("-h", "--help") for word in sys.argv[1:]):
        print(__doc__)
        return
    root = pathlib.Path(git(pathlib.Path.cwd(), "rev-parse", "--show-toplevel").strip())
    words = sys.argv[1:]
    without = "--unnamed" in words
    least = 1
    if "--lines" in words:
        at = words.index("--lines")
        if not words[at + 1:] or not words[at + 1].isdigit():
            sys.exit("error: --lines needs a number")
        least = int(words[at + 1])
        del words[at:at + 2]
    pages = [word for word in words if word != "--unnamed"] or ["README.md", *sorted(str(p.relative_to(root)) for p in (root / "docs").glob("*.md") if str(p.relative_to(root)) != TESTED)]
    count = 0
    changes = {} if without else changes_of_code(root)
    for page in pages:
        try:
            for first in unnamed(root, page) if without else ():
                count += 1
                print(f"{page}:{first}: names no command")
            for first, written, younger in () if without else stale(root, page, changes):
                if sum(lines for _, _, lines in younger) < least:
                    continue
                count += 1
                told = ", ".join(f"{path} ({day(changed)}, {lines} lines)" for path, changed, lines in younger)
                print(f"{page}:{first}: figures of {day(written)}; changed since: {told}")
        except (OSError, subprocess.CalledProcessError) as error:
            sys.exit(f"error: {page}: {getattr(error, 'stderr', None) or error}".strip())
    print(f"{count} paragraphs or tables {'name no command' if without else 'are older than an input of theirs'}")


if __name__ == "__main__":
    main()
