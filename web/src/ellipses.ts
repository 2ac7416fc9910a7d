// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

import { CanvasMap } from './canvas_map';
import { Landmark } from './data';
import { themed } from './palette';

type Place = (landmark: Landmark) => number[] | undefined;

/** How well it is known where landmarks are: ellipses of so many sigmas. */
export function drawEllipses(map: CanvasMap, landmarks: Landmark[], place: Place, sigmas: number) {
  const c = map.context;
  c.lineWidth = 1;
  c.strokeStyle = themed('ellipse');
  for (const l of landmarks) {
    const at = place(l), [xx, xy, yy] = l.covariance;
    if (!at || xx === null || xy === null || yy === null || xx + yy <= 0) continue;
    const x = map.px(at[0]), y = map.py(at[1]);
    if (!map.inside(x, y, 100)) continue;
    const mean = (xx + yy) / 2, spread = Math.hypot((xx - yy) / 2, xy);
    const factor = sigmas * map.scale;
    const a = factor * Math.sqrt(Math.max(mean + spread, 0)), b = factor * Math.sqrt(Math.max(mean - spread, 0));
    if (a < 1.5) continue;
    c.beginPath();
    c.ellipse(x, y, a, b, -0.5 * Math.atan2(2 * xy, xx - yy), 0, 2 * Math.PI);
    c.stroke();
  }
}

/** How far from landmarks things are that were not told apart from them: a standard deviation, as on map.png. */
export function drawExtents(map: CanvasMap, landmarks: Landmark[], place: Place) {
  const c = map.context;
  c.lineWidth = 1.2;
  c.strokeStyle = themed('quiet');
  c.setLineDash([2, 3]);
  for (const l of landmarks) {
    const at = place(l);
    if (!at || !l.extent) continue;
    const x = map.px(at[0]), y = map.py(at[1]), radius = l.extent * map.scale;
    if (!map.inside(x, y, 100) || radius < 1.5) continue;
    c.beginPath();
    c.arc(x, y, radius, 0, 2 * Math.PI);
    c.stroke();
  }
  c.setLineDash([]);
}

/** Crosses where landmarks really are. */
export function drawTrueLandmarks(map: CanvasMap, landmarks: { at: number[] }[]) {
  const c = map.context;
  c.setLineDash([]);
  c.strokeStyle = themed('truth');
  c.lineWidth = 1.2;
  c.beginPath();
  for (const l of landmarks) {
    const x = map.px(l.at[0]), y = map.py(l.at[1]);
    c.moveTo(x - 4, y - 4);
    c.lineTo(x + 4, y + 4);
    c.moveTo(x - 4, y + 4);
    c.lineTo(x + 4, y - 4);
  }
  c.stroke();
}
