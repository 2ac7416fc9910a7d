// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

import { Plot, Series } from './plots';

export interface Group { label: string; color: string; values: (number | null)[]; dash?: number[] }

/** Shares of the numbers in bins of one width from 0 on; the last bin has all that is beyond. */
export function shares(values: (number | null)[], width: number, bins: number): number[] {
  const counts = new Array<number>(bins).fill(0);
  let all = 0;
  for (const v of values) {
    if (v === null) continue;
    ++counts[Math.max(0, Math.min(bins - 1, Math.floor(v / width)))];
    ++all;
  }
  return counts.map(c => (all ? c / all : 0));
}

/** Abramowitz and Stegun, 7.1.26: to 1.5e-7. */
function erf(x: number): number {
  const t = 1 / (1 + 0.3275911 * x);
  return 1 - t * (0.254829592 + t * (-0.284496736 + t * (1.421413741 + t * (-1.453152027 + t * 1.061405429)))) * Math.exp(-x * x);
}

/** P(chi-square <= x) with 2 or 3 degrees of freedom. */
export function chiSquareCdf(x: number, freedom: 2 | 3): number {
  if (freedom === 2) return 1 - Math.exp(-x / 2);
  return erf(Math.sqrt(x / 2)) - Math.sqrt((2 * x) / Math.PI) * Math.exp(-x / 2);
}

/** The shares that a chi-square distribution has in such bins. */
export function chiSquareShares(freedom: 2 | 3, width: number, bins: number): number[] {
  return Array.from({ length: bins }, (_, b) =>
    (b === bins - 1 ? 1 : chiSquareCdf((b + 1) * width, freedom)) - chiSquareCdf(b * width, freedom));
}

/** Shares as steps over the bins. */
export function histogramPlot(title: string, axis: string, width: number, bins: number, groups: Group[],
                              more: Series[] = [], note = ''): Plot {
  const x = Array.from({ length: bins + 1 }, (_, b) => b * width);
  const closed = (values: number[]) => [...values, values[bins - 1]];
  const series: Series[] = groups.map(g => ({ label: g.label, color: g.color, dash: g.dash, steps: true, values: closed(shares(g.values, width, bins)) }));
  return new Plot(title, axis, x, [...series, ...more.map(s => ({ ...s, steps: true, values: closed(s.values as number[]) }))], { height: 150, note });
}
