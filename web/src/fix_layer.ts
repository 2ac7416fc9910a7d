// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

import { CanvasMap } from './canvas_map';
import { Fixes } from './data';
import { percent } from './dom';
import { Shape, themed, trace } from './palette';

const kModes: [string, Shape, number][] = [['good', 'circle', 1.8], ['biased', 'triangle', 4], ['false', 'cross', 4.5], ['not used', 'bar', 2.5]];
const kOrder = [3, 0, 1, 2];  // from the lowest

/** Fixes of satellite receivers by their modes; of biased and false ones a line to where the map says that the antenna is. */
export class FixLayer {
  constructor(private fixes: Fixes | undefined, private map: CanvasMap) {}

  get any() { return !!this.fixes?.k.length; }
  /** [mode, text]. */
  legend(): [number, string][] {
    return kOrder.filter(m => this.any && this.fixes!.counts[m]).map(m => [m, `fix ${kModes[m][0]} (${this.fixes!.counts[m]})`]);
  }
  /** The mark of a mode. */
  mark(c: CanvasRenderingContext2D, mode: number, x: number, y: number, factor = 1) {
    const [, shape, radius] = kModes[mode];
    trace(c, shape, x, y, factor * radius);
  }
  color = (mode: number) => themed(`fix${mode}`);

  /** Those up to keyframe k. */
  draw(k: number) {
    if (!this.any) return;
    const f = this.fixes!, c = this.map.context;
    for (const mode of kOrder) {
      c.strokeStyle = c.fillStyle = this.color(mode);
      c.lineWidth = 0.8;
      const marks: [number, number][] = [];
      c.beginPath();
      f.mode.forEach((m, i) => {
        if (m !== mode || f.k[i] > k) return;
        const x = this.map.px(f.x[i]), y = this.map.py(f.y[i]);
        if (this.map.inside(x, y)) marks.push([x, y]);
        if (mode !== 1 && mode !== 2) return;
        const ax = this.map.px(f.ax[i]), ay = this.map.py(f.ay[i]), length = Math.hypot(x - ax, y - ay);
        const part = this.map.inside(x, y) ? 1 : Math.min(1, 26 / length);  // one that is outside has its beginning
        c.moveTo(ax, ay);
        c.lineTo(ax + part * (x - ax), ay + part * (y - ay));
      });
      c.stroke();
      c.beginPath();
      for (const [x, y] of marks) this.mark(c, mode, x, y);
      c.fill();
    }
  }
  /** What is to be said of the fix at a place on the screen, if there is one. */
  tip(x: number, y: number, k: number): string {
    let best = -1, least = 8;
    this.fixes?.k.forEach((of, i) => {
      const d = Math.hypot(this.map.px(this.fixes!.x[i]) - x, this.map.py(this.fixes!.y[i]) - y);
      if (of <= k && d < least) { best = i; least = d; }
    });
    if (best < 0) return '';
    const f = this.fixes!, p = f.p[best];
    const odds = p.map((v, m) => `${kModes[m][0]} ${percent(v)}`).join(', ');
    const off = Math.hypot(f.x[best] - f.ax[best], f.y[best] - f.ay[best]);
    return `fix ${kModes[f.mode[best]][0]}, ${off.toFixed(1)} m off${odds && ': '}${odds}`;
  }
}
