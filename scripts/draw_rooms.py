#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Draws the rooms of both libraries and the includes between them: scripts/draw_rooms.py > docs/images/rooms.svg

Rooms are on the floors that tests/house/check.py finds; an arrow points from a room to one that it includes. Only
arrows inside a library are drawn, and none that a longer path replaces.
"""

import pathlib
import sys

ROOT = pathlib.Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests" / "house"))
import check  # noqa: E402

WIDTH, FLOOR, BOX, HEIGHT, LEFT = 1240, 58, 118, 30, 150
INK, BOXES, LINES = "#22313f", {"libhybrid": "#dbe9f6", "mrpt_plugins": "#fbe6cf"}, "#7d8a97"


def room(path):
    top, name = path.split("/")[0], check.room_of(path)
    return (top, name) if top in check.LIBRARIES and name and not name.endswith(".h") else None


def edges():
    found = set()
    for top in check.LIBRARIES:
        for file in sorted((ROOT / top).rglob("*")):
            here = room(file.relative_to(ROOT).as_posix())
            if file.suffix not in check.CODE or here is None:
                continue
            for line in file.read_text(encoding="utf-8").splitlines():
                include = check.INCLUDE.match(line)
                there = room(include.group(2)) if include else None
                if there and there != here:
                    found.add((here, there))
    return found


def without_shortcuts(found):
    """The edges that no longer path replaces."""
    after = {}
    for a, b in found:
        after.setdefault(a, set()).add(b)

    def reaches(a, b, seen):
        return any(n == b or (n not in seen and not seen.add(n) and reaches(n, b, seen)) for n in after.get(a, ()))

    return {(a, b) for a, b in found
            if not any(n != b and reaches(n, b, {a}) for n in after[a])}


def places(found):
    """Room -> (x, level of its floor); the floors of libhybrid are below those of mrpt_plugins."""
    at, level = {}, 0
    for top in ("libhybrid", "mrpt_plugins"):
        below = {folder.name: {} for folder in (ROOT / top).iterdir() if folder.is_dir()}
        for (_, here), (library, there) in found:
            if library == top and here in below:
                below[here][there] = ""
        for rooms in check.floors(below)[0]:
            names = sorted(rooms)
            step = (WIDTH - LEFT) / len(names)
            for i, name in enumerate(names):
                # Single rooms of a floor alternate between left and right, so that arrows can pass beside them.
                x = LEFT + step * (i + 0.5) + (0 if len(names) > 1 else (level % 3 - 1) * 190)
                at[top, name] = (x, level)
            level += 1
        level += 0.5
    return at, level


def main():
    found = edges()
    at, levels = places(found)
    height = int(levels * FLOOR + 70)

    def y(level):
        return height - 80 - level * FLOOR

    out = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{height}" '
           f'viewBox="0 0 {WIDTH} {height}" font-family="sans-serif" font-size="13">',
           "<!-- SPDX-License-Identifier: BSD-3-Clause; made by scripts/draw_rooms.py -->",
           f'<rect width="{WIDTH}" height="{height}" fill="white"/>',
           '<defs><marker id="a" markerWidth="7" markerHeight="7" refX="6" refY="3" orient="auto">'
           f'<path d="M0,0 L6,3 L0,6 z" fill="{LINES}"/></marker></defs>']
    for a, b in sorted(without_shortcuts({(a, b) for a, b in found if a[0] == b[0]})):
        (xa, la), (xb, lb) = at[a], at[b]
        start, end = y(la) + HEIGHT, y(lb) - 2
        bend = (end - start) / 2
        out.append(f'<path d="M{xa:.0f},{start:.0f} C{xa:.0f},{start + bend:.0f} {xb:.0f},{end - bend:.0f} '
                   f'{xb:.0f},{end:.0f}" fill="none" stroke="{LINES}" marker-end="url(#a)"/>')
    for (top, name), (x, level) in sorted(at.items()):
        out.append(f'<rect x="{x - BOX / 2:.0f}" y="{y(level):.0f}" width="{BOX}" height="{HEIGHT}" rx="5" '
                   f'fill="{BOXES[top]}" stroke="{INK}"/>')
        out.append(f'<text x="{x:.0f}" y="{y(level) + 20:.0f}" text-anchor="middle" fill="{INK}">{name}</text>')
    for top in check.LIBRARIES:
        levels_of = [level for (t, _), (_, level) in at.items() if t == top]
        middle = (y(min(levels_of)) + y(max(levels_of)) + HEIGHT) / 2
        out.append(f'<text x="14" y="{middle:.0f}" font-size="17" font-weight="bold" fill="{INK}">{top}</text>')
    out.append(f'<text x="14" y="{height - 8}" fill="{LINES}">{len(at)} rooms, {len(found)} arrows. '
               'Left out: those that a longer way replaces, and those from mrpt_plugins down to libhybrid</text>')
    out.append("</svg>")
    print("\n".join(out))


if __name__ == "__main__":
    main()
