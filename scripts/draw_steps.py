#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
# Copyright (c) 2026, the hybrid mapping authors
"""Draws what steps of the incremental smoother eliminate, and how many factors wait: scripts/draw_steps.py OUT/steps.csv FIRST LAST > steps.svg

OUT/steps.csv is that of hybrid-pgo --online or hybrid-replay. Above the line stands one bar for each step, as high as it has eliminated
variables; below it hangs one, as long as factors wait after it.
"""

import csv
import sys

WIDTH, LEFT, RIGHT, TOP, UP, DOWN = 1000, 60, 14, 34, 150, 60
INK, GRID, GONE, WAITS = "#22313f", "#d9dfe5", "#1f5fa8", "#d98c2b"


def round_up(value):
    """The next of 1, 2, 5, 10, 20, ..."""
    step = 1
    while True:
        for factor in (1, 2, 5):
            if factor * step >= value:
                return factor * step
        step *= 10


def main(file, first, last):
    with open(file, encoding="utf-8") as lines:
        rows = [row for row in csv.DictReader(lines) if first <= int(row["keyframe"]) <= last]
    if not rows:
        sys.exit(f"draw_steps: {file} has no step from {first} to {last}")
    gone, waits = ([int(row[name]) for row in rows] for name in ("eliminated", "pending"))
    most_gone, most_waits = round_up(max(*gone, 1)), round_up(max(*waits, 1))
    line, height = TOP + UP, TOP + UP + DOWN + 54
    step = (WIDTH - LEFT - RIGHT) / len(rows)
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{height}" viewBox="0 0 {WIDTH} {height}" '
           f'font-family="sans-serif" font-size="13" fill="{INK}">',
           "<!-- SPDX-License-Identifier: BSD-3-Clause; made by scripts/draw_steps.py -->",
           f'<rect width="{WIDTH}" height="{height}" fill="white"/>']

    def text(x, y, words, anchor="start", colour=INK):
        out.append(f'<text x="{x:.0f}" y="{y:.0f}" text-anchor="{anchor}" fill="{colour}">{words}</text>')

    for share in (0.5, 1):
        for y, most, sign in ((line - UP * share, most_gone, 1), (line + DOWN * share, most_waits, -1)):
            if sign < 0 and share < 1:
                continue
            out.append(f'<path d="M{LEFT},{y:.1f} H{WIDTH - RIGHT}" stroke="{GRID}"/>')
            text(LEFT - 6, y + 4, f"{most * share:g}", "end")
    for i, (up, down) in enumerate(zip(gone, waits)):
        x = LEFT + i * step
        for count, most, length, sign, colour in ((up, most_gone, UP, -1, GONE), (down, most_waits, DOWN, 1, WAITS)):
            size = length * count / most
            if count:
                out.append(f'<rect x="{x:.1f}" y="{line - size if sign < 0 else line:.1f}" width="{0.8 * step:.1f}" '
                           f'height="{size:.1f}" fill="{colour}"/>')
    out.append(f'<path d="M{LEFT},{line} H{WIDTH - RIGHT}" stroke="{INK}"/>')
    text(LEFT - 6, line + 4, "0", "end")
    text(LEFT, TOP - 14, "variables that a step eliminates", colour=GONE)
    text(LEFT, height - 16, "factors that wait after it", colour=WAITS)
    for i in range(0, len(rows), max(1, len(rows) // 6)):
        text(LEFT + (i + 0.5) * step, height - 34, rows[i]["keyframe"], "middle")
    text(WIDTH - RIGHT, height - 16, "step", "end")
    out.append("</svg>")
    print("\n".join(out))


if __name__ == "__main__":
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    main(sys.argv[1], int(sys.argv[2]), int(sys.argv[3]))
