// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

import { CanvasMap } from './canvas_map';
import { MapData, robotAt, sums } from './data';
import { themed } from './palette';

/** Points of one keyframe in the frame of the map. */
interface Seen { k: number; x: Float64Array; y: Float64Array; z: Float64Array | null }

/** How a decision on a closure is drawn. */
export const closureColor = (decision: string) => (decision === 'accepted' || decision === 'rejected' ? decision : 'undecided');

/** What lasers saw, where the map places it, and the closures that scans made. */
export class ScanLayer {
  private seen: Seen[];

  constructor(private data: MapData, private map: CanvasMap) {
    const { poses, scans } = data;
    this.seen = scans.list.map(scan => {
      const x = sums(scan.x, 0, scans.unit), y = sums(scan.y, 0, scans.unit), z = scan.z ? sums(scan.z, 0, scans.unit) : null;
      const cos = Math.cos(poses.yaw[scan.k]), sin = Math.sin(poses.yaw[scan.k]);
      x.forEach((a, n) => {
        const b = y[n];
        x[n] = poses.x[scan.k] + cos * a - sin * b;
        y[n] = poses.y[scan.k] + sin * a + cos * b;
        if (z) z[n] += poses.z?.[scan.k] ?? 0;
      });
      return { k: scan.k, x, y, z };
    });
  }

  get any() { return this.seen.length > 0; }
  get closures() { return this.data.scan_closures.i.length > 0; }
  /** All points in space, as columns; none of a map in the plane. */
  inSpace(): number[][] {
    const high = this.seen.filter(s => s.z !== null);
    return [high.flatMap(s => [...s.x]), high.flatMap(s => [...s.y]), high.flatMap(s => [...s.z!])];
  }
  /** Coordinates of all points, for the box of the map. */
  extent(): { x: number[]; y: number[] } {
    const range = (axis: 'x' | 'y') => this.seen.flatMap(s => {
      let low = Infinity, high = -Infinity;
      for (const v of s[axis]) { low = Math.min(low, v); high = Math.max(high, v); }
      return low <= high ? [low, high] : [];
    });
    return { x: range('x'), y: range('y') };
  }
  /** Colours with what they mean. */
  legend(): [string, string][] {
    const seen = this.seen.some(s => s.z) ? 'walls' : 'scan';
    const out: [string, string][] = this.any ? [['ray', `${seen} here`]] : [];
    if (this.any && this.closures) out.push(['select', `chosen closure, its ${seen}`]);
    for (const name of ['accepted', 'undecided', 'rejected']) {
      const count = this.data.scan_closures.decision.filter(d => closureColor(d) === name).length;
      if (count) out.push([name, `closure ${name} (${count})`]);
    }
    return out;
  }
  /** The keyframe whose scan is shown at keyframe k: the newest one of the same robot that has points; -1: none. */
  at(k: number): number {
    const robot = robotAt(this.data, k);
    let best = -1;
    for (const s of this.seen) if (s.k <= k && s.k > best && robotAt(this.data, s.k) === robot) best = s.k;
    return best;
  }

  private points(wanted: (k: number) => boolean, size: number) {
    const c = this.map.context;
    for (const s of this.seen) {
      if (!wanted(s.k)) continue;
      for (let n = 0; n < s.x.length; ++n) {
        const x = this.map.px(s.x[n]), y = this.map.py(s.y[n]);
        if (this.map.inside(x, y)) c.fillRect(x - size / 2, y - size / 2, size, size);
      }
    }
  }
  /** All that was seen up to keyframe k, pale, and what is seen there. */
  draw(k: number, closure: number | null) {
    const c = this.map.context, now = this.at(k);
    c.fillStyle = themed('wall');
    this.points(seen => seen <= k, Math.max(1, Math.min(2.5, 0.05 * this.map.scale)));
    c.fillStyle = themed('ray');
    this.points(seen => seen === now, 2.5);
    if (closure === null) return;
    c.fillStyle = themed('select');
    const from = this.at(this.data.scan_closures.i[closure]);
    this.points(seen => seen === from, 2.5);
  }
  /** Closures found up to keyframe k, those of that keyframe and the chosen one strong. */
  drawClosures(k: number, closure: number | null) {
    const c = this.map.context, { i, j, decision } = this.data.scan_closures, { x, y } = this.data.poses;
    for (let e = 0; e < i.length; ++e) {
      if (j[e] > k) continue;
      const color = closureColor(decision[e]), strong = j[e] === k || e === closure;
      c.strokeStyle = themed(e === closure ? 'select' : color);
      c.lineWidth = strong ? 2.5 : 1;
      c.setLineDash(color === 'rejected' ? [4, 4] : color === 'undecided' ? [1, 3] : []);
      c.beginPath();
      c.moveTo(this.map.px(x[i[e]]), this.map.py(y[i[e]]));
      c.lineTo(this.map.px(x[j[e]]), this.map.py(y[j[e]]));
      c.stroke();
    }
    c.setLineDash([]);
  }
}
