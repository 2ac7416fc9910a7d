// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

import { PathErrors } from './data';

export interface RelativeErrors { way: number[]; median: (number | null)[]; most: (number | null)[] }

const kWays = 24, kFewestPairs = 5, kMostPairs = 2000;

/** By how much the way from one pose to another is wrong, over how far the robot drove between them: the median of all such pairs, and what 95 % of them stay below. */
export function relativeErrors(errors: PathErrors): RelativeErrors {
  const { off, way } = errors, n = way.length, out: RelativeErrors = { way: [], median: [], most: [] };
  const whole = n ? way[n - 1] : 0;
  if (!(whole > 0)) return out;
  const least = Math.max(whole / 1000, 2 * whole / n);
  for (let w = 0; w < kWays; ++w) {
    const wanted = least * (whole / 2 / least) ** (w / (kWays - 1)), found: number[] = [];
    const every = Math.max(1, Math.floor(n / kMostPairs));
    for (let i = 0, j = 0; i < n; i += every) {
      while (j < n && way[j] - way[i] < wanted) ++j;
      if (j === n) break;
      found.push(Math.hypot(off[j][0] - off[i][0], off[j][1] - off[i][1], off[j][2] - off[i][2]));
    }
    if (found.length < kFewestPairs) continue;
    found.sort((a, b) => a - b);
    out.way.push(wanted);
    out.median.push(found[Math.floor(found.length / 2)]);
    out.most.push(found[Math.floor(0.95 * found.length)]);
  }
  return out;
}
