// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

import { Run, Track } from './other_run';

export type Point = [number, number, number];

/** A turn about the vertical axis and a shift. */
export interface Motion { yaw: number; shift: Point }
export const kNoMotion: Motion = { yaw: 0, shift: [0, 0, 0] };

export function moved({ yaw, shift }: Motion, [x, y, z]: Point): Point {
  const c = Math.cos(yaw), s = Math.sin(yaw);
  return [c * x - s * y + shift[0], s * x + c * y + shift[1], z + shift[2]];
}

/** Where a path was at times in order, between its poses on the line; null before its begin and after its end. */
export function positionsAt(track: Track, times: number[]): (Point | null)[] {
  const { t, x, y, z } = track, slack = 1e-3;  // times are rounded to milliseconds
  let i = 0;
  return times.map(time => {
    while (i < t.length && t[i] < time - slack) ++i;
    if (i === t.length) return null;
    if (Math.abs(t[i] - time) <= slack) return [x[i], y[i], z[i]];
    if (i === 0) return null;
    const share = (time - t[i - 1]) / (t[i] - t[i - 1]), between = (v: number[]) => v[i - 1] + share * (v[i] - v[i - 1]);
    return [between(x), between(y), between(z)];
  });
}

function posesOf({ t, x, y, z }: Track, ids: number[]): (Point | null)[] {
  const place = new Map(t.map((id, i) => [id, i]));
  return ids.map(id => {
    const i = place.get(id);
    return i === undefined ? null : [x[i], y[i], z[i]];
  });
}

/** The other path at the times of ours, pair by pair; the other place is null where there is none. */
export interface Pairs { t: number[]; own: Point[]; other: (Point | null)[] }

/** Of each robot that both have; only what has the same time, or id of a pose, unless places `between` count. */
export function pairsOf(own: Run, other: Run, between: boolean): Pairs[] {
  return own.tracks.map((track, i) => {
    const same = other.tracks.find(o => o.robot === track.robot) ?? (own.tracks.length === 1 ? other.tracks[0] : undefined);
    const points = track.t.map((_, k): Point => [track.x[k], track.y[k], track.z[k]]);
    return { t: own.tracks[i].t, own: points, other: same ? (between ? positionsAt : posesOf)(same, track.t) : track.t.map(() => null) };
  });
}

/** The motion that brings the other paths nearest to ours, by least squares. */
export function alignment(all: Pairs[]): Motion {
  const from: Point[] = [], to: Point[] = [];
  for (const { own, other } of all) other.forEach((p, i) => { if (p) { from.push(p); to.push(own[i]); } });
  if (!from.length) return kNoMotion;
  const mean = (points: Point[]) => [0, 1, 2].map(d => points.reduce((sum, p) => sum + p[d], 0) / points.length) as Point;
  const a = mean(from), b = mean(to);
  let dot = 0, cross = 0;
  from.forEach((p, i) => {
    const [px, py] = [p[0] - a[0], p[1] - a[1]], [qx, qy] = [to[i][0] - b[0], to[i][1] - b[1]];
    dot += px * qx + py * qy;
    cross += px * qy - py * qx;
  });
  const yaw = Math.atan2(cross, dot), turned = moved({ yaw, shift: [0, 0, 0] }, a);
  return { yaw, shift: [b[0] - turned[0], b[1] - turned[1], b[2] - turned[2]] };
}

/** Distances between both paths after that motion. */
export function distances({ own, other }: Pairs, motion: Motion): (number | null)[] {
  return other.map((p, i) => {
    if (!p) return null;
    const [x, y, z] = moved(motion, p);
    return Math.hypot(x - own[i][0], y - own[i][1], z - own[i][2]);
  });
}

export function rootMeanSquare(values: (number | null)[]): number | null {
  const known = values.filter(v => v !== null) as number[];
  return known.length ? Math.sqrt(known.reduce((sum, v) => sum + v * v, 0) / known.length) : null;
}

function nearest([x, y, z]: Point, all: Point[], except = -1): { at: number; distance: number } {
  let at = -1, least = Infinity;
  for (let i = 0; i < all.length; ++i) {
    const q = all[i], squared = (q[0] - x) ** 2 + (q[1] - y) ** 2 + (q[2] - z) ** 2;
    if (squared < least && i !== except) { at = i; least = squared; }
  }
  return { at, distance: Math.sqrt(least) };
}

/** Distances of the landmarks that both maps have: each is the nearest one to the other, and none of its own map is as near. */
export function commonLandmarks(own: Point[], other: Point[]): number[] {
  const out: number[] = [];
  own.forEach((p, i) => {
    const there = nearest(p, other);
    if (there.at < 0 || nearest(other[there.at], own).at !== i) return;
    if (nearest(p, own, i).distance > there.distance && nearest(other[there.at], other, there.at).distance > there.distance) out.push(there.distance);
  });
  return out.sort((a, b) => a - b);
}

export const pointOf = (at: number[]): Point => [at[0], at[1], at[2] ?? 0];

/** Settings that are not the same in all runs, as section.key and their values; inputs by what they hold. */
export function differingSettings(summaries: any[]): [string, string[]][] {
  const flat = summaries.map(summary => {
    const out = new Map<string, string>();
    for (const [section, keys] of Object.entries(summary?.configuration ?? {})) {
      for (const [key, value] of Object.entries(keys as object)) out.set(`${section}.${key}`, String(value));
    }
    if (summary?.version) out.set('version', summary.version);
    return out;
  });
  const names = new Set(flat.flatMap(f => [...f.keys()]));
  return [...names].map((name): [string, string[]] => [name, flat.map(f => f.get(name) ?? '–')])
      .filter(([, values]) => values.some(v => v !== values[0]));
}
