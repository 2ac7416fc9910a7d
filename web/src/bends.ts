// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

import { Curves, Path } from './data';

type Axes = ArrayLike<number | null>[];

/** Paths over keyframes with what is drawn between them. */
export class Bends {
  private first: number[] = [];  // point of the curve to each keyframe
  private own: number[][];
  private ends: Axes;

  /** `ends`: the keyframes that the curves are of. */
  constructor(private curves: Curves | undefined, ends: Path) {
    let sum = 0;
    for (const n of curves?.n ?? []) { this.first.push(sum); sum += n; }
    this.own = curves ? [curves.x, curves.y, curves.z ?? []] : [];
    this.ends = [ends.x, ends.y, ends.z ?? []];
  }
  /** Axes of the path through keyframes of one robot, and behind the last one with the number of the robot. An earlier estimate of the
   * keyframes takes what is between along. */
  through(keyframes: number[], axes: Axes, robot = -1): number[][] {
    const after = this.curves?.after[robot];
    return axes.map((axis, d) => {
      const out: number[] = [];
      keyframes.forEach((k, i) => {
        if (i) out.push(...this.between(keyframes[i - 1], k, axis, d));
        out.push(axis[k] ?? 0);
      });
      if (after) for (const v of [after.x, after.y, after.z ?? []][d]) out.push(v);
      return out;
    });
  }
  /** What is between a keyframe and the next one of its robot. */
  private between(from: number, to: number, axis: ArrayLike<number | null>, d: number): number[] {
    const n = this.curves?.n[to] ?? 0, moved = (k: number) => (axis[k] ?? 0) - (this.ends[d][k] ?? 0);
    if (!n) return [];
    const a = moved(from), b = moved(to), points = this.own[d].slice(this.first[to], this.first[to] + n);
    return points.map((v, i) => v + a + ((b - a) * (i + 1)) / (n + 1));
  }
}
