#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Structure of the source tree: who may include whom, headers, sizes, words that must not appear.

Prints one `file:line: message` for each finding and exits with 1 if there are any.
"""

import pathlib
import re
import subprocess
import sys

SPDX = ("SPDX-License-Identifier: BSD-3-Clause", "Copyright (c) 2026, the hybrid mapping authors")
MAX_LINES = 400
MAX_FUNCTION_LINES = 60  # of a body, as clang-tidy counts, which reads only a part of the files at a time

# Top-level rooms, and what each may include of the others.
ROOMS = {
    "libhybrid": {"libhybrid"},
    "mrpt_plugins": {"libhybrid", "mrpt_plugins"},
    "apps": {"libhybrid", "mrpt_plugins", "apps"},
    "tests": {"libhybrid", "mrpt_plugins", "apps", "tests"},
    "bench": {"libhybrid", "mrpt_plugins", "tests", "bench"},
    "examples": {"libhybrid", "mrpt_plugins"},
    "python": {"libhybrid", "mrpt_plugins", "python"},
}

TOP = {*ROOMS, ".ci", ".clang-format", ".clang-tidy", ".devcontainer", ".dockerignore", ".github", ".gitignore", "CHANGELOG.md", "CITATION.cff",
       "CMakeLists.txt", "CMakePresets.json", "CONTRIBUTING.md", "Dockerfile", "LICENSE", "README.md", "cmake", "config", "docs", "notes",
       "pyproject.toml", "rawlogs", "scripts", "web"}

# Their rooms stand on floors, since none include each other in a circle: see floors().
LIBRARIES = ("libhybrid", "mrpt_plugins")
# Where files, too, must not include each other in a circle.
LAYERED = (*LIBRARIES, "apps")
# Folders whose headers are not part of the API.
INTERNAL = {"detail", "kernels"}
# Files directly in one room.
MAX_FILES = 40

# Included by all installed headers that show Eigen types.
EIGEN = "libhybrid/geometry/eigen.h"

FOREIGN = re.compile(r"^(mrpt|opencv2?|cv|nlohmann|fmt|CLI|rclcpp|ros)\b", re.IGNORECASE)
INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]')
UNFINISHED = re.compile(r"\b(TO" r"DO|FIX" r"ME|XX" r"X)\b")
MACHINE_PATH = re.compile(r"(?<![\w.}/~-])/(work|home|root|Users)/")
MACRO = re.compile(r"^\s*#\s*define\b")
# MRPT registers classes with macros only, and ours joins two of them; another names an attribute. Those for what differs
# between the versions of MRPT are in mrpt_plugins/mrpt_version.h.
OUR_MACRO = re.compile(r"^#define (HYBRID_REGISTER_PLUGIN\(|HYBRID_API\b|HYBRID_(DEFINE|MRPT)_)")
# Those of the standard library end the program when memory is exhausted.
LISTS_FOLDER = re.compile(r"directory_iterator\b")
PRINTS = re.compile(r"\bstd::(cout|cerr|clog|puts)\b|\bprintf\s*\(|\bfmt::print\s*\(")
# How lines at the left margin begin that open no function.
NO_FUNCTION = ("namespace", "class", "struct", "enum", "extern", "template", "using")

NOT_OURS = {".git", "compile_commands.json"}
CODE = {".h", ".cpp"}
TEXT = CODE | {".cmake", ".txt", ".py", ".sh", ".ini", ".md", ".json", ".in", ""}


def room_of(path):
    """'libhybrid/core/key.h' -> 'core'; a file directly in the top-level room is one of its own."""
    parts = path.split("/")
    return parts[1] if len(parts) > 1 else None


def is_foreign_detail(path, target):
    """Whether a file includes what stands in detail/ of another room."""
    return "detail" in target.split("/") and target.split("/")[:2] != path.split("/")[:2]


def check_include(path, target, quoted):
    """A message if the file `path` must not include `target`, else None."""
    top = path.split("/")[0]
    target_top = target.split("/")[0]
    if top == "libhybrid" and (FOREIGN.match(target) or "opencv" in target.lower()):
        return f"libhybrid must not include {target}"
    if target_top not in ROOMS:
        if quoted:
            return f'"{target}": give the path from the top of the repository, or use <>'
        return None
    if target_top not in ROOMS[top]:
        return f"{top} must not include {target}: dependence runs the other way"
    if top not in ("tests", "bench", "python") and is_foreign_detail(path, target):
        return f"{target} is for its own room: what other rooms use does not stand in detail/"
    return None


def below(includes):
    """{room: {room that it includes: 'file:line' of one such include}} of one library, from {path: [(line, target)]}."""
    rooms = {}
    for path, targets in sorted(includes.items()):
        own = rooms.setdefault(room_of(path), {})
        for line, target in targets:
            if target.split("/")[0] == path.split("/")[0] and room_of(target) != room_of(path):
                own.setdefault(room_of(target), f"{path}:{line}")
    return rooms


def floors(rooms):
    """The rooms from the ground up, each one floor above the highest that it includes; and those that stand on none."""
    level, left = {}, dict(rooms)
    while left:
        ready = {room for room in left if all(there in level or there not in rooms for there in left[room])}
        if not ready:
            break
        for room in ready:
            level[room] = 1 + max((level[there] for there in left[room] if there in level), default=-1)
        left = {room: targets for room, targets in left.items() if room not in ready}
    return [{room for room in level if level[room] == i} for i in range(1 + max(level.values(), default=-1))], set(left)


def circle_of(parts):
    """Those parts that include each other in a circle, of {part: {part that it includes: 'file:line'}}."""
    circle = floors(parts)[1]
    while above := {part for part in circle if not any(part in parts[other] for other in circle)}:
        circle -= above
    return circle


def leads_to(parts, start, end):
    """Whether a part includes another, directly or through others."""
    seen, left = set(), [start]
    while left:
        part = left.pop()
        if part == end:
            return True
        if part not in seen:
            seen.add(part)
            left += parts.get(part, ())
    return False


def check_circles(includes):
    """A finding for a circle of rooms in each library, at the includes that close it."""
    for top in LIBRARIES:
        rooms = below({path: targets for path, targets in includes.items() if path.split("/")[0] == top})
        circle = circle_of(rooms)
        for room in sorted(circle):
            for there in sorted(circle & set(rooms[room])):
                yield f"{rooms[room][there]}: {top}/{room} and {top}/{there} are in a circle of rooms that include each other"


def unit_of(path):
    """A header and its source are one: 'libhybrid/core/detail/key.h' and 'libhybrid/core/key.cpp' -> 'libhybrid/core/key'."""
    return pathlib.PurePath(path).with_suffix("").as_posix().replace("/detail/", "/")


def check_file_circles(includes):
    """A finding for a circle of files, at the includes that close it."""
    units = {}
    for path, targets in sorted(includes.items()):
        own = units.setdefault(unit_of(path), {})
        for line, target in targets:
            if target in includes and unit_of(target) != unit_of(path):
                own.setdefault(unit_of(target), f"{path}:{line}: {path} and {target}")
    circle = circle_of(units)
    for unit in sorted(circle):
        for there in sorted(there for there in circle & set(units[unit]) if leads_to(units, there, unit)):
            yield f"{units[unit][there]} are in a circle of files that include each other"


def check_code(path, lines):
    top = path.split("/")[0]
    if path.endswith(".h") and "#pragma once" not in lines:
        yield 1, "header without #pragma once"
    for number, line in enumerate(lines, 1):
        include = INCLUDE.match(line)
        if include and top in ROOMS:
            message = check_include(path, include.group(2), include.group(1) == '"')
            if message:
                yield number, message
        if (top in ("libhybrid", "mrpt_plugins", "apps") and MACRO.match(line)
                and not OUR_MACRO.match(line)):
            yield number, "a macro of our own"
        if top in ("libhybrid", "mrpt_plugins") and PRINTS.search(line):
            yield number, "libraries do not print"
        if top in ("libhybrid", "mrpt_plugins", "apps", "python") and LISTS_FOLDER.search(line):
            yield number, "folders are listed by libhybrid/io/folders.h"


def check_functions(lines):
    """Bodies of functions at the left margin that are too long, in code as clang-format leaves it."""
    head = body = None
    for number, line in enumerate(lines, 1):
        if line[:1].isalpha() and not line.startswith(NO_FUNCTION):
            head, body = number, None
        if head and body is None and line.endswith("{"):
            body = number
        if line == "}" and body:
            if number - body > MAX_FUNCTION_LINES:
                yield head, f"a body of {number - body} lines; a function has at most {MAX_FUNCTION_LINES}"
            head = body = None


def own_header(path, exists):
    """The header of a source, beside it or in detail/; None where it has none."""
    header = pathlib.PurePath(path).with_suffix(".h")
    places = (header, header.parent / "detail" / header.name)
    return next((place.as_posix() for place in places if exists(place)), None)


def check_own_header(own, text):
    """A message unless a source includes its own header first: so that header needs no other."""
    first = next((m.group(2) for m in map(INCLUDE.match, text.splitlines()) if m), None)
    return None if first == own else f"the first include must be {own}"


def check_eigen(includes):
    """A finding for each header that shows Eigen but reaches EIGEN through none of its includes."""

    def reaches(header, seen):
        return header == EIGEN or any(
            reaches(h, seen) for h in includes.get(header, ()) if not (h in seen or seen.add(h)))

    for header in sorted(includes):
        shows = any(target.startswith("Eigen/") for target in includes[header])
        if shows and not reaches(header, {header}):
            yield f"{header}:1: shows Eigen without {EIGEN}, which checks how Eigen is compiled"


def check_api(path, lines):
    """A finding for a header of the API that hides what it declares, and for one that should hide it and does not."""
    internal = not INTERNAL.isdisjoint(path.split("/")[:-1])
    for number, line in enumerate(lines, 1):
        include = INCLUDE.match(line)
        if not internal and include and not INTERNAL.isdisjoint(include.group(2).split("/")):
            yield number, "a header of the API includes no other: detail/ and kernels/ are not installed"
        if internal and line.startswith("namespace HYBRID_API hybrid"):
            yield number, "not a header of the API: no HYBRID_API here"
        if not internal and line.startswith("namespace hybrid {"):
            yield number, "a header of the API says `namespace HYBRID_API hybrid {`; others stand in detail/"


def is_source(path, lines):
    return pathlib.PurePath(path).suffix in CODE | {".py", ".sh"} or (
        bool(lines) and lines[0].startswith("#!"))


def check_file(path, text):
    """(line, message) of each finding in one file; `path` is relative to the repository."""
    lines = text.splitlines()
    if is_source(path, lines):
        head = [line.lstrip("#/ ") for line in lines[:3]]
        if not all(line in head for line in SPDX):
            yield 1, "the two-line SPDX header is missing"
        if len(lines) > MAX_LINES:
            yield len(lines), f"{len(lines)} lines; a file has at most {MAX_LINES}"
    if pathlib.PurePath(path).suffix in CODE:
        yield from check_code(path, lines)
        if not path.startswith("tests/"):
            yield from check_functions(lines)
    if path.endswith(".h") and path.split("/")[0] in LIBRARIES:
        yield from check_api(path, lines)
    for number, line in enumerate(lines, 1):
        if UNFINISHED.search(line):
            yield number, "unfinished work is not marked in the code"
        if MACHINE_PATH.search(line):
            yield number, "an absolute path of somebody's machine"


def check_rooms(files):
    """A finding for each room with too many files."""
    counts = {}
    for path in files:
        room = path.rsplit("/", 1)[0]
        if path.split("/")[0] in LIBRARIES and pathlib.PurePath(path).suffix in CODE:
            counts[room] = counts.get(room, 0) + 1
    for room, count in sorted(counts.items()):
        if count > MAX_FILES:
            yield f"{room}:1: {count} files; a room has at most {MAX_FILES}"


def files_of(root):
    tops = [*ROOMS, "cmake", "scripts", "config", "docs", "notes", ".ci", ".github", ".devcontainer"]
    for top in tops:
        yield from sorted((root / top).rglob("*"))
    yield from sorted(f for f in root.glob("*") if f.name not in NOT_OURS)


def check_examples(root):
    """Each ```cpp block after a comment `from FILE` must be part of FILE, indentation aside."""
    for page in [root / "README.md", *sorted((root / "docs").rglob("*.md"))]:
        text = page.read_text(encoding="utf-8") if page.is_file() else ""
        for block in re.finditer(r"(?:<!-- from (\S+) -->\n)?```cpp\n(.*?)```", text, re.DOTALL):
            where = f"{page.relative_to(root)}:{text.count(chr(10), 0, block.start()) + 1}"
            source = root / block.group(1) if block.group(1) else None
            if source is None or not source.is_file():
                yield f"{where}: say which compiled file the example is from: <!-- from FILE -->"
            elif flat(block.group(2)) not in flat(source.read_text(encoding="utf-8")):
                yield f"{where}: the example differs from {block.group(1)}"


def check_top(root):
    """Only what is known is committed at the top: no results of runs."""
    try:
        listed = subprocess.run(["git", "-C", root, "ls-files", "-z"], capture_output=True, text=True, check=True).stdout
    except (OSError, subprocess.CalledProcessError):
        return []  # not a checkout
    tops = sorted({name.split("/")[0] for name in listed.split("\0") if name})
    return [f"{top}:1: nothing of this name is expected at the top" for top in tops if top not in TOP]


def flat(text):
    return "\n".join(line.strip() for line in text.strip().splitlines())


def check_tree(root):
    """All findings as 'file:line: message', and the number of files looked at."""
    findings, paths, headers, includes = [], [], {}, {}
    for file in files_of(root):
        if not file.is_file() or file.suffix not in TEXT or "__pycache__" in file.parts:
            continue
        path = file.relative_to(root).as_posix()
        try:
            text = file.read_text(encoding="utf-8")
        except UnicodeDecodeError:
            findings.append(f"{path}:1: not a text file in UTF-8")
            continue
        paths.append(path)
        findings += [f"{path}:{line}: {message}" for line, message in check_file(path, text)]
        if file.suffix in CODE and path.split("/")[0] in LAYERED:
            includes[path] = [(i, m.group(2)) for i, m in enumerate(map(INCLUDE.match, text.splitlines()), 1) if m]
            if file.suffix == ".h" and path.split("/")[0] in LIBRARIES:
                headers[path] = [target for _, target in includes[path]]
        own = own_header(path, lambda place: (root / place).exists()) if file.suffix == ".cpp" else None
        message = check_own_header(own, text) if own else None
        findings += [f"{path}:1: {message}"] if message else []
    findings += check_rooms(paths)
    findings += check_top(root)
    findings += check_circles(includes)
    findings += check_file_circles(includes)
    findings += check_eigen(headers)
    findings += check_examples(root)
    return findings, len(paths)


def main():
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else __file__).resolve()
    if root.is_file():
        root = root.parents[2]
    findings, count = check_tree(root)
    print("\n".join(findings + [f"{count} files, {len(findings)} findings"]))
    return 1 if findings or count == 0 else 0


if __name__ == "__main__":
    sys.exit(main())
