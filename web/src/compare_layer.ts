// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

import { CanvasMap } from './canvas_map';
import { kNoMotion, Motion, moved, Point, pointOf } from './comparison';
import { el } from './dom';
import { Strand } from './orbit';
import { Run } from './other_run';
import { classColor } from './palette';

/** Of the run that was added as number i: other colours than those of path, odometry and truth. */
export const runColor = (i: number) => classColor([4, 6, 2, 0, 7][i % 5]);

interface Columns { x: number[]; y: number[]; z: number[] }
interface Shown { name: string; tracks: Columns[]; landmarks: Columns }

const columns = (points: Point[]): Columns => ({ x: points.map(p => p[0]), y: points.map(p => p[1]), z: points.map(p => p[2]) });

/** Paths (solid) and landmarks (rings) of other runs on the map. */
export class CompareLayer {
  readonly key = el('div', { class: 'runs', hidden: true });  // for the legend
  private shown: Shown[] = [];

  constructor(private map: CanvasMap) {}
  /** Shows these runs, each after a motion. */
  set(runs: Run[], motions: Motion[]) {
    this.shown = runs.map((run, i) => {
      const motion = motions[i] ?? kNoMotion;
      const tracks = run.tracks.map(({ x, y, z }) => columns(x.map((_, k) => moved(motion, [x[k], y[k], z[k]]))));
      return { name: run.name, tracks, landmarks: columns(run.landmarks.map(l => moved(motion, pointOf(l.at)))) };
    });
    this.restyle();
    this.map.redraw();
  }
  restyle() {
    this.key.hidden = !this.shown.length;
    this.key.replaceChildren(...this.shown.map((run, i) =>
        el('div', {}, el('i', { class: 'line', style: `color: ${runColor(i)}` }), run.name)));
  }
  /** The same in space. */
  strands(): Strand[] {
    return this.shown.flatMap(({ name, tracks, landmarks }, i) => [
      ...tracks.map(({ x, y, z }) => ({ label: name, points: [x, y, z], color: runColor(i), mode: 'line' as const })),
      { label: name, points: [landmarks.x, landmarks.y, landmarks.z], color: runColor(i), mode: 'points' as const, size: 4 }]);
  }
  /** The columns that must be in view. */
  extent(): { x: number[]; y: number[] } {
    const tracks = this.shown.flatMap(s => s.tracks);
    return { x: tracks.flatMap(t => t.x), y: tracks.flatMap(t => t.y) };
  }
  draw() {
    const c = this.map.context;
    this.shown.forEach(({ tracks, landmarks }, i) => {
      c.strokeStyle = runColor(i);
      c.lineWidth = 1.5;
      for (const { x, y } of tracks) this.map.line(x, y);
      c.lineWidth = 1.2;
      c.beginPath();
      for (let l = 0; l < landmarks.x.length; ++l) {
        const px = this.map.px(landmarks.x[l]), py = this.map.py(landmarks.y[l]);
        if (!this.map.inside(px, py)) continue;
        c.moveTo(px + 6, py);
        c.arc(px, py, 6, 0, 2 * Math.PI);
      }
      c.stroke();
    });
  }
}
