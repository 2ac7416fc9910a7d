// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

import { Bends } from './bends';
import { CanvasMap } from './canvas_map';
import { MapData, robotAt } from './data';
import { el, show } from './dom';

/** From small to large: cividis, which is told apart without red and green. */
const kColors = ['#00336f', '#3c4d6e', '#666970', '#8a8678', '#b3a469', '#ddc84c', '#fde737'];

/** Colours of the path by its error after alignment, where the truth is known. */
export class ErrorPaint {
  readonly any: boolean;
  readonly most: number = 0;  // the error of the last colour [m]: 95 % are smaller
  readonly scale = el('div', { class: 'scale', hidden: true });  // of the colours, for the legend
  private of: (number | null)[] = [];  // colours of the keyframes

  constructor(data: MapData) {
    const all = data.errors.flatMap(e => e.aligned).sort((a, b) => a - b);
    this.any = all.length > 0;
    if (!this.any) return;
    this.most = Math.max(all[Math.floor(0.95 * (all.length - 1))], 1e-9);
    this.scale.append(el('span', {}, '0'), ...kColors.map(c => el('i', { style: `background: ${c}` })),
        el('span', {}, `${show(this.most, 'm', 2)} and more`));
    const known = data.errors.map(e => new Map(e.t.map((t, i) => [Math.round(1000 * t), e.aligned[i]])));
    this.of = data.poses.t.map((t, k) => {
      const names = data.robots.names;
      const robot = names.length ? data.errors.findIndex(e => e.robot === names[robotAt(data, k)]) : 0;
      const error = known[robot]?.get(Math.round(1000 * t));
      return error === undefined ? null : Math.min(kColors.length - 1, Math.floor((kColors.length * error) / this.most));
    });
  }
  color(k: number): string | null {
    const c = this.of[k] ?? null;
    return c === null ? null : kColors[c];
  }
  /** Over the path, whose place i is of keyframe `every` i: the error of the final estimate there. */
  draw(map: CanvasMap, places: number[], axes: ArrayLike<number>[], every: number, bends: Bends) {
    const pieces = new Map<string, [number, number][]>();
    for (let i = 1; i < places.length; ++i) {
      const color = this.color(Math.min(places[i] * every, this.of.length - 1));
      if (color === null) continue;
      const list = pieces.get(color), piece: [number, number] = [places[i - 1], places[i]];
      if (list) list.push(piece); else pieces.set(color, [piece]);
    }
    const c = map.context;
    c.lineWidth = 4;
    for (const [color, list] of pieces) {
      c.strokeStyle = color;
      c.beginPath();
      for (const piece of list) {
        const [x, y] = bends.through(piece, axes);
        x.forEach((at, i) => (i ? c.lineTo(map.px(at), map.py(y[i])) : c.moveTo(map.px(at), map.py(y[i]))));
      }
      c.stroke();
    }
  }
}
