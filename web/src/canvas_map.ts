// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

import { select } from 'd3-selection';
import { scaleLinear } from 'd3-scale';
import { zoom, zoomIdentity, ZoomTransform } from 'd3-zoom';
import { el } from './dom';
import { themed } from './palette';

/** A picture of the map and of what surrounds it, so that panning need not draw anew. */
interface Layer { picture: HTMLCanvasElement; transform: ZoomTransform }

/** World coordinates (y up) on a canvas: pan, zoom, a scale bar; what is drawn is up to others. */
export class CanvasMap {
  readonly root = el('div', { class: 'map' });
  readonly canvas = el('canvas', { tabindex: 0, role: 'img' });
  /** What `draw` draws on: the canvas, or the layer. */
  context: CanvasRenderingContext2D;
  draw: () => void = () => {};
  press: (x: number, y: number) => void = () => {};
  hover: (x: number, y: number) => void = () => {};
  width = 300;
  height = 200;
  private transform: ZoomTransform = zoomIdentity;
  private base = { scale: 1, x: 0, y: 0 };
  private box = [0, 0, 1, 1];
  private behavior = zoom<HTMLCanvasElement, unknown>().scaleExtent([0.2, 2000]);
  private asked = false;
  private layer: Layer | null = null;  // where what is drawn has not changed since
  private margin = 0;                  // about the canvas, of what is being drawn [pixels]

  constructor(label: string) {
    this.canvas.setAttribute('aria-label', label);
    this.context = this.canvas.getContext('2d')!;
    this.root.append(this.canvas);
    this.behavior.on('zoom', event => {
      const pans = event.transform.k === this.transform.k;
      this.transform = event.transform;
      this.request(pans);
    });
    select(this.canvas).call(this.behavior).on('dblclick.zoom', null);
    this.canvas.addEventListener('dblclick', () => this.fit());
    this.canvas.addEventListener('click', e => this.press(e.offsetX, e.offsetY));
    this.canvas.addEventListener('mousemove', e => this.hover(e.offsetX, e.offsetY));
    this.canvas.addEventListener('mouseleave', () => this.hover(-1e9, -1e9));
    new ResizeObserver(() => this.resize()).observe(this.root);
  }

  /** Shows [min x, min y, max x, max y] as a whole. */
  setBox(box: number[]) {
    this.box = box;
    this.rebase();
  }
  private rebase() {
    const [x0, y0, x1, y1] = this.box;
    const w = Math.max(x1 - x0, 1e-6), h = Math.max(y1 - y0, 1e-6);
    const scale = 0.9 * Math.min(this.width / w, this.height / h);
    this.base = {
      scale,
      x: this.width / 2 - scale * (x0 + x1) / 2,
      y: this.height / 2 + scale * (y0 + y1) / 2,
    };
    this.redraw();
  }
  private resize() {
    const ratio = window.devicePixelRatio || 1;
    this.width = this.root.clientWidth;
    this.height = this.root.clientHeight;
    if (this.width === 0 || this.height === 0) return;
    this.canvas.width = Math.round(this.width * ratio);
    this.canvas.height = Math.round(this.height * ratio);
    this.behavior.extent([[0, 0], [this.width, this.height]]);
    this.rebase();
  }

  fit() { select(this.canvas).call(this.behavior.transform, zoomIdentity); }
  zoomBy(factor: number) { select(this.canvas).call(this.behavior.scaleBy, factor); }
  panBy(dx: number, dy: number) {
    const k = this.transform.k;
    select(this.canvas).call(this.behavior.translateBy, dx / k, dy / k);
  }
  /** Brings a point of the world into the middle, at least so many pixels a metre large. */
  center(x: number, y: number, least = 0) {
    const k = Math.max(this.transform.k, least / this.base.scale);
    const bx = this.base.x + this.base.scale * x, by = this.base.y - this.base.scale * y;
    select(this.canvas).call(
        this.behavior.transform,
        zoomIdentity.translate(this.width / 2 - k * bx, this.height / 2 - k * by).scale(k));
  }

  get scale() { return this.base.scale * this.transform.k; }
  px(x: number) { return this.transform.applyX(this.base.x + this.base.scale * x); }
  py(y: number) { return this.transform.applyY(this.base.y - this.base.scale * y); }
  toWorld(px: number, py: number): [number, number] {
    return [
      (this.transform.invertX(px) - this.base.x) / this.base.scale,
      (this.base.y - this.transform.invertY(py)) / this.base.scale,
    ];
  }
  inside(x: number, y: number, margin = 20) {
    const m = margin + this.margin;
    return x > -m && y > -m && x < this.width + m && y < this.height + m;
  }

  /** What is drawn has changed. */
  redraw() { this.request(false); }

  private request(pans: boolean) {
    this.pans = pans && (this.pans || !this.asked);
    if (this.asked) return;
    this.asked = true;
    requestAnimationFrame(() => {
      this.asked = false;
      if (this.width > 0) this.paint(this.pans);
    });
  }
  private pans = false;  // no more than that has happened since the last frame

  private paint(pans: boolean) {
    const ratio = this.canvas.width / this.width;
    if (!pans) this.layer = null;
    else if (!this.layer || !this.covers(this.layer)) this.layer = this.drawLayer(ratio);
    this.context.setTransform(ratio, 0, 0, ratio, 0, 0);
    this.context.clearRect(0, 0, this.width, this.height);
    if (this.layer) {
      const { picture, transform } = this.layer, m = this.reach();
      const whole = (v: number) => Math.round(v * ratio);  // in between it would be blurred
      this.context.setTransform(1, 0, 0, 1, 0, 0);
      this.context.drawImage(picture, whole(this.transform.x - transform.x - m), whole(this.transform.y - transform.y - m));
      this.context.setTransform(ratio, 0, 0, ratio, 0, 0);
    } else {
      this.draw();
    }
    this.drawScaleBar();
  }
  /** How far beyond the canvas a layer reaches. */
  private reach() { return Math.round(0.4 * Math.min(this.width, this.height)); }
  private covers({ transform }: Layer) {
    const m = this.reach();
    return Math.abs(this.transform.x - transform.x) <= m && Math.abs(this.transform.y - transform.y) <= m;
  }
  private drawLayer(ratio: number): Layer {
    const m = this.reach(), screen = this.context, picture = el('canvas', {});
    picture.width = Math.round((this.width + 2 * m) * ratio);
    picture.height = Math.round((this.height + 2 * m) * ratio);
    this.context = picture.getContext('2d')!;
    this.context.setTransform(ratio, 0, 0, ratio, m * ratio, m * ratio);
    this.margin = m;
    this.draw();
    this.margin = 0;
    this.context = screen;
    return { picture, transform: this.transform };
  }

  /** A line through points; null is a gap. */
  line(x: ArrayLike<number | null>, y: ArrayLike<number | null>, from = 0, to = x.length) {
    const c = this.context;
    c.beginPath();
    let lastX = NaN, lastY = NaN, gap = true;
    for (let i = from; i < to; ++i) {
      if (x[i] === null) { gap = true; continue; }
      const px = this.px(x[i]!), py = this.py(y[i]!);
      // Less than half a pixel is not seen.
      if (!gap && i < to - 1 && Math.abs(px - lastX) < 0.5 && Math.abs(py - lastY) < 0.5) continue;
      if (gap) c.moveTo(px, py); else c.lineTo(px, py);
      gap = false;
      lastX = px;
      lastY = py;
    }
    c.stroke();
  }

  private drawScaleBar() {
    const [step] = scaleLinear().domain([0, 140 / this.scale]).ticks(2).filter(v => v > 0);
    if (!step) return;
    const c = this.context, length = step * this.scale, y = this.height - 14;
    c.strokeStyle = c.fillStyle = themed('text');
    c.lineWidth = 2;
    c.beginPath();
    c.moveTo(14, y - 4);
    c.lineTo(14, y);
    c.lineTo(14 + length, y);
    c.lineTo(14 + length, y - 4);
    c.stroke();
    c.font = '12px system-ui, sans-serif';
    c.textAlign = 'left';
    c.textBaseline = 'bottom';
    c.fillText(`${step} m`, 18, y - 3);
  }
}

/** The box about some columns of coordinates. */
export function boxOf(...columns: { x: ArrayLike<number | null>; y: ArrayLike<number | null> }[]): number[] {
  const box = [Infinity, Infinity, -Infinity, -Infinity];
  for (const { x, y } of columns) {
    for (let i = 0; i < x.length; ++i) {
      if (x[i] === null) continue;
      box[0] = Math.min(box[0], x[i]!);
      box[1] = Math.min(box[1], y[i]!);
      box[2] = Math.max(box[2], x[i]!);
      box[3] = Math.max(box[3], y[i]!);
    }
  }
  return box[0] > box[2] ? [-1, -1, 1, 1] : box;
}
