// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

import { quadtree, Quadtree } from 'd3-quadtree';
import { Bends } from './bends';
import { boxOf, CanvasMap } from './canvas_map';
import { hasLandmarks, Id, Landmark, MapData, placesOf, robotAt, robotsOf, Snapshot } from './data';
import { el, show } from './dom';
import { CompareLayer } from './compare_layer';
import { drawEllipses, drawExtents, drawTrueLandmarks } from './ellipses';
import { History, mostProbable } from './history';
import { ErrorPaint } from './error_paint';
import { FixLayer } from './fix_layer';
import { classColor, classShape, robotColor, themed, trace } from './palette';
import { ScanLayer } from './scan_layer';
import { State } from './state';

interface Mark { id: Id; x: number; y: number }
type Paint = (c: CanvasRenderingContext2D) => void;

const kLayers = ['estimate', 'error', 'dead reckoning', 'truth', 'scans', 'closures', 'fixes', 'landmarks', 'ellipses', 'extents', 'rays', 'ids'] as const;
type Layer = typeof kLayers[number];

/** The map at a keyframe: path, landmarks with class and probability, sight rays. */
export class MapView {
  readonly map = new CanvasMap('Map: path of the robot and landmarks. Arrow keys step, plus and minus zoom.');
  readonly root: HTMLElement;
  private layers = new Map<Layer, boolean>();
  private sigmas = 3;
  private tree: Quadtree<Mark> = quadtree<Mark>();
  private marks: Mark[] = [];
  private snapshot: Snapshot | null = null;
  private places: number[][] = [];  // of the poses of each robot, in the path that is shown
  private hidden = new Set<number>();  // robots
  readonly scans: ScanLayer;
  private fixes: FixLayer;
  private tip = el('div', { class: 'tip', hidden: true });
  private hovered: Id | null = null;
  readonly paint: ErrorPaint;
  private bends: Bends;
  private reckoned: Bends;
  readonly compare = new CompareLayer(this.map);

  constructor(private data: MapData, private history: History, private state: State) {
    this.scans = new ScanLayer(data, this.map);
    this.fixes = new FixLayer(data.fixes, this.map);
    for (const layer of kLayers) this.layers.set(layer, layer !== 'ids' && layer !== 'error');
    this.paint = new ErrorPaint(data);
    this.bends = new Bends(data.curves, data.poses);
    this.reckoned = new Bends(data.reckoned_curves, data.reckoned);
    this.map.draw = () => this.draw();
    this.map.press = (x, y) => {
      const found = this.at(x, y);
      if (found) this.state.set({ landmark: found.id, sighting: null });
      else this.pressPath(x, y);
    };
    this.map.hover = (x, y) => this.hover(x, y);
    this.map.root.append(this.tip, this.legend());
    this.root = el('div', { class: 'map-room' }, this.controls(), this.map.root);
    this.measure();
    state.listen((view, changed) => {
      if (changed.has('keyframe')) this.update();
      if (changed.has('landmark') && view.landmark !== null) this.reveal(view.landmark);
      this.map.redraw();
    });
    this.update();
  }

  /** Chooses the part of the world that `Fit` shows: all that there is. */
  measure() {
    const { poses, landmarks, truth, curves } = this.data;
    const at = { x: landmarks.map(l => l.at[0]), y: landmarks.map(l => l.at[1]) };
    this.map.setBox(boxOf(poses, curves ?? at, at, truth.path, this.scans.extent(), this.compare.extent()));
  }

  private controls(): HTMLElement {
    const bar = el('div', { class: 'bar', role: 'group', 'aria-label': 'Layers of the map' });
    for (const layer of kLayers) {
      if (layer === 'truth' && !this.data.truth.path.x.length && !this.data.truth.landmarks.length) continue;
      if (['landmarks', 'ellipses', 'rays', 'ids'].includes(layer) && !hasLandmarks(this.data)) continue;
      if (layer === 'extents' && !this.data.landmarks.some(l => l.extent)) continue;
      if ((layer === 'error' && !this.paint.any) || (layer === 'scans' && !this.scans.any) || (layer === 'fixes' && !this.fixes.any)) continue;
      if (layer === 'closures' && !this.scans.closures) continue;
      const box = el('input', { type: 'checkbox', change: () => {
        this.layers.set(layer, box.checked);
        if (layer === 'error') this.paint.scale.hidden = !box.checked;
        this.map.redraw();
      } });
      box.checked = this.layers.get(layer)!;
      bar.append(el('label', {}, box, layer));
    }
    const { names } = this.data.robots;
    if (names.length > 1) {
      names.forEach((name, robot) => {
        const box = el('input', { type: 'checkbox', checked: true, change: () => {
          if (box.checked) this.hidden.delete(robot); else this.hidden.add(robot);
          this.map.redraw();
        } });
        bar.append(el('label', { 'data-robot': robot }, box, name));
      });
    }
    const slider = el('input', { type: 'range', min: 0, max: 4, step: 0.01, value: Math.log10(3),
      'aria-label': 'Size of the ellipses', title: 'size of the ellipses' });
    const text = el('span', { class: 'quiet' }, '3 σ');
    slider.addEventListener('input', () => {
      const wanted = 10 ** Number(slider.value);
      this.sigmas = Math.abs(wanted - 3) < 0.15 ? 3 : wanted;
      text.textContent = `${show(Number(this.sigmas.toPrecision(2)))} σ`;
      this.map.redraw();
    });
    if (hasLandmarks(this.data)) bar.append(el('label', { class: 'slider' }, slider, text));
    const button = (text: string, title: string, press: () => void) =>
        el('button', { type: 'button', class: 'small', title, 'aria-label': title, click: press }, text);
    bar.append(el('span', { class: 'zoom' },
        button('−', 'zoom out (-)', () => this.map.zoomBy(1 / 1.5)),
        button('+', 'zoom in (+)', () => this.map.zoomBy(1.5)),
        button('Fit', 'show all (f)', () => this.map.fit())));
    return bar;
  }

  private legend(): HTMLElement {
    const box = el('details', { class: 'legend', open: window.innerWidth > 700 }, el('summary', {}, 'Legend'));
    const entry = (mark: HTMLElement, text: string) => el('div', {}, mark, text);
    const line = (name: string, dashed = false) =>
        el('i', { class: `line${dashed ? ' dashed' : ''}`, style: `color: var(--${name})` });
    const { names } = this.data.robots;
    for (const [robot, name] of (names.length > 1 ? names : ['estimate']).entries()) {
      const mark = line('estimate');
      this.legendLines.push([mark, robot]);
      box.append(entry(mark, name));
    }
    box.append(entry(line('odometry', true), 'dead reckoning'));
    if (this.data.truth.path.x.length) box.append(entry(line('truth', true), 'truth'));
    box.append(this.paint.scale, this.compare.key);
    for (const [name, text] of this.scans.legend()) box.append(entry(line(name, name === 'rejected'), text));
    const drawn = (paint: Paint, text: string) => {
      const mark = el('canvas', { width: 32, height: 32 });
      this.legendMarks.push([mark, paint]);
      box.append(entry(mark, text));
      return mark;
    };
    for (const [mode, text] of this.fixes.legend()) {
      drawn(c => { c.fillStyle = this.fixes.color(mode); this.fixes.mark(c, mode, 16, 16, 2); }, text);
    }
    const counts = new Map<number, number>();
    for (const l of this.data.landmarks) {
      if (l.class !== null) counts.set(l.class, (counts.get(l.class) ?? 0) + 1);
    }
    for (const [index, count] of [...counts].sort((a, b) => a[0] - b[0])) {
      const paint: Paint = c => { c.fillStyle = classColor(index); trace(c, classShape(index), 16, 16, 10); };
      drawn(paint, `${this.data.classes[index]} (${count})`).dataset.class = String(index);
    }
    if (counts.size) box.append(el('div', { class: 'quiet' }, 'pale: class unsure'));
    if (this.data.landmarks.some(l => l.extent)) box.append(el('div', { class: 'quiet' }, 'dotted: extent, a standard deviation'));
    if (this.data.lives.some(l => !l[2])) box.append(el('div', { class: 'quiet' }, 'hollow: not in the final map'));
    this.drawMarks();
    return box;
  }
  private legendMarks: [HTMLCanvasElement, Paint][] = [];
  private legendLines: [HTMLElement, number][] = [];
  private drawMarks() {
    for (const [line, robot] of this.legendLines) line.style.color = robotColor(robot);
    for (const [canvas, paint] of this.legendMarks) {
      const c = canvas.getContext('2d')!;
      c.clearRect(0, 0, 32, 32);
      c.beginPath();
      paint(c);
      c.fill();
    }
  }
  restyle() {
    this.drawMarks();
    this.map.redraw();
  }

  private update() {
    this.snapshot = this.history.snapshot(this.state.view.keyframe);
    const marks: Mark[] = [];
    if (this.snapshot) {
      for (const [id, at] of this.snapshot.places) marks.push({ id, x: at[0], y: at[1] });
    } else {
      for (const l of this.data.landmarks) marks.push({ id: l.id, x: l.at[0], y: l.at[1] });
    }
    const k = this.snapshot?.k, length = this.snapshot?.path[0].length ?? this.data.poses.x.length;
    const every = k === undefined ? 1 : this.history.every(k);
    this.places = robotsOf(this.data).map(robot => placesOf(this.data, robot, length, every, k));
    this.marks = marks;
    this.tree = quadtree<Mark>(marks, m => m.x, m => m.y);
    this.map.redraw();
  }

  /** Where a landmark is on the screen. */
  screen(id: Id): [number, number] | null {
    const mark = this.marks.find(m => m.id === id);
    return mark ? [this.map.px(mark.x), this.map.py(mark.y)] : null;
  }
  private at(x: number, y: number): Mark | undefined {
    const [wx, wy] = this.map.toWorld(x, y);
    return this.tree.find(wx, wy, 14 / this.map.scale);
  }
  private pressPath(x: number, y: number) {
    const [wx, wy] = this.map.toWorld(x, y);
    const { poses } = this.data;
    let best = -1, least = (14 / this.map.scale) ** 2;
    for (let i = 0; i < poses.x.length; ++i) {
      const d = (poses.x[i] - wx) ** 2 + (poses.y[i] - wy) ** 2;
      if (d < least) { least = d; best = i; }
    }
    if (best >= 0) this.state.set({ keyframe: best });
  }
  private hover(x: number, y: number) {
    const found = this.at(x, y);
    this.map.canvas.style.cursor = found ? 'pointer' : 'grab';
    if ((found?.id ?? null) !== this.hovered) {
      this.hovered = found?.id ?? null;
      this.map.redraw();
    }
    const text = found ? this.words(found.id) : this.layers.get('fixes') ? this.fixes.tip(x, y, this.state.view.keyframe) : '';
    this.tip.hidden = !(this.tip.textContent = text);
    this.tip.style.left = `${Math.max(0, Math.min(x + 12, this.map.width - Math.max(170, this.tip.offsetWidth + 4)))}px`;
    this.tip.style.top = `${y + 12}px`;
  }
  private words(id: Id): string {
    const p = this.history.belief(id, this.state.view.keyframe), best = p && mostProbable(p);
    return `landmark ${id}` + (p && best !== null ? `: ${this.data.classes[best]} ${(100 * p[best]).toFixed(0)} %` : '');
  }
  private reveal(id: Id) {
    const at = this.screen(id);
    const place = this.marks.find(m => m.id === id);
    if (place && at && !this.map.inside(at[0], at[1], -30)) this.map.center(place.x, place.y);
  }

  private draw() {
    const c = this.map.context, k = this.state.view.keyframe;
    const on = (layer: Layer) => this.layers.get(layer);
    c.lineJoin = 'round';
    if (on('scans')) this.scans.draw(k, this.state.view.closure);
    if (on('truth')) {
      c.strokeStyle = themed('truth');
      c.lineWidth = 1.5;
      c.setLineDash([6, 4]);
      this.map.line(this.data.truth.path.x, this.data.truth.path.y);
      drawTrueLandmarks(this.map, this.data.truth.landmarks);
    }
    if (on('dead reckoning')) {
      c.strokeStyle = themed('odometry');
      c.lineWidth = 1.2;
      c.setLineDash([2, 3]);
      for (const robot of this.shown()) {
        const { x, y } = this.data.reckoned, tail = k >= this.history.last ? robot : -1;
        const [px, py] = this.reckoned.through(placesOf(this.data, robot, k + 1), [x, y], tail);
        this.map.line(px, py);
      }
    }
    c.setLineDash([]);
    this.compare.draw();
    if (on('fixes')) this.fixes.draw(k);
    if (on('estimate')) this.drawPath(k);
    if (on('closures')) this.scans.drawClosures(k, this.state.view.closure);
    if (on('rays') && !this.hidden.has(robotAt(this.data, k))) this.drawRays(k);
    const place = (l: Landmark) => this.place(l.id);
    if (on('ellipses')) drawEllipses(this.map, this.data.landmarks, place, this.sigmas);
    if (on('extents')) drawExtents(this.map, this.data.landmarks, place);
    if (on('landmarks')) this.drawLandmarks(k);
    for (const robot of this.shown()) this.drawRobot(robot, k);
    if (on('ids')) this.drawIds();
  }
  private shown(): number[] {
    return robotsOf(this.data).filter(robot => !this.hidden.has(robot));
  }
  /** Coordinates of the path that is shown. */
  private path(): ArrayLike<number>[] {
    return this.snapshot?.path ?? [this.data.poses.x, this.data.poses.y];
  }
  private drawPath(k: number) {
    const c = this.map.context, axes = this.path(), every = this.snapshot ? this.history.every(this.snapshot.k) : 1;
    const end = this.snapshot ? Math.ceil(k / this.history.every(k)) + 1 : axes[0].length;
    const bends = every === 1 ? this.bends : new Bends(undefined, this.data.poses);
    c.lineWidth = 2;
    for (const robot of this.shown()) {
      const places = this.places[robot].filter(i => i < end);
      c.strokeStyle = robotColor(robot);
      const [x, y] = bends.through(places, axes.slice(0, 2), this.snapshot ? -1 : robot);
      this.map.line(x, y);
      if (this.layers.get('error')) this.paint.draw(this.map, places, axes.slice(0, 2), every, bends);
    }
  }
  /** Where its robot was at keyframe k, by the estimate that is shown. */
  private robot(k: number): [number, number] {
    const [x, y] = this.path();
    if (!this.snapshot) return [x[k], y[k]];
    const every = this.history.every(k), wanted = k === this.snapshot.k ? x.length - 1 : k / every;
    let at = 0, least = Infinity;
    for (const i of this.places[robotAt(this.data, k)]) {
      if (Math.abs(i - wanted) <= least) { at = i; least = Math.abs(i - wanted); }
    }
    return [x[at], y[at]];
  }
  private place(id: Id): number[] | undefined {
    return this.snapshot ? this.snapshot.places.get(id) : this.history.position(id);
  }
  private drawRays(k: number) {
    const c = this.map.context, s = this.data.sightings;
    const ray = (i: number, from: [number, number], id: Id | null, strong: boolean) => {
      const to = id === null ? undefined : this.place(id);
      if (!to) return;
      c.strokeStyle = this.history.wrong(i) ? themed('wrong') : themed('ray');
      c.lineWidth = strong ? 2.5 : 1;
      c.setLineDash(strong ? [] : [3, 2]);
      c.beginPath();
      c.moveTo(this.map.px(from[0]), this.map.py(from[1]));
      c.lineTo(this.map.px(to[0]), this.map.py(to[1]));
      c.stroke();
    };
    const from = this.robot(k);
    for (const i of this.history.sightingsAt.get(k) ?? []) {
      ray(i, from, s.now[i] ?? s.first[i], this.state.view.sighting === i);
    }
    const selected = this.state.view.landmark;
    if (selected !== null && k >= this.history.last) {
      c.globalAlpha = 0.35;
      for (const i of this.history.sightingsOf.get(selected) ?? []) ray(i, this.robot(s.k[i]), selected, false);
      c.globalAlpha = 1;
    }
    c.setLineDash([]);
  }
  /** Those that look the same together: many small paths are slow. */
  private drawLandmarks(k: number) {
    const c = this.map.context, size = Math.max(3, Math.min(7, 2 + 0.6 * Math.sqrt(this.map.scale)));
    const groups = new Map<string, { best: number | null; alpha: number; gone: boolean; at: [number, number][] }>();
    const rings: [number, number][] = [];
    for (const { id, x, y } of this.marks) {
      const at: [number, number] = [this.map.px(x), this.map.py(y)];
      if (!this.map.inside(at[0], at[1])) continue;
      const p = this.history.belief(id, k), best = p ? mostProbable(p) : null;
      const gone = !this.history.landmarks.has(id);
      const alpha = p && best !== null ? Math.max(0.1, Math.round(20 * p[best]) / 20) : 0.9;
      const key = `${best} ${alpha} ${gone}`, group = groups.get(key);
      if (group) group.at.push(at); else groups.set(key, { best, alpha, gone, at: [at] });
      if (id === this.state.view.landmark || id === this.hovered) rings.push(at);
    }
    c.lineWidth = 1.2;
    for (const { best, alpha, gone, at } of groups.values()) {
      c.fillStyle = c.strokeStyle = gone ? themed('quiet') : classColor(best);
      c.beginPath();
      for (const [x, y] of at) trace(c, classShape(best), x, y, size);
      c.globalAlpha = alpha;
      if (!gone) c.fill();
      c.globalAlpha = 1;
      if (gone || alpha < 0.9) c.stroke();
    }
    c.strokeStyle = themed('select');
    c.lineWidth = 2.5;
    for (const [x, y] of rings) {
      c.beginPath();
      c.arc(x, y, size + 5, 0, 2 * Math.PI);
      c.stroke();
    }
  }
  /** A robot at its newest keyframe up to k, if it has one. */
  private drawRobot(robot: number, k: number) {
    while (k >= 0 && robotAt(this.data, k) !== robot) --k;
    if (k < 0) return;
    const c = this.map.context, [x, y] = this.robot(k), yaw = this.data.poses.yaw[k];
    const px = this.map.px(x), py = this.map.py(y), r = 8;
    c.fillStyle = robotColor(robot);
    c.strokeStyle = themed('panel');
    c.lineWidth = 1.5;
    c.beginPath();
    for (const [i, angle] of [0, 2.5, Math.PI, -2.5].entries()) {
      const reach = i === 0 ? 1.4 * r : i === 2 ? 0.3 * r : r;
      const at: [number, number] = [px + reach * Math.cos(yaw + angle), py - reach * Math.sin(yaw + angle)];
      if (i) c.lineTo(...at); else c.moveTo(...at);
    }
    c.closePath();
    c.fill();
    c.stroke();
  }
  /** Labels where they do not overlap. */
  private drawIds() {
    const c = this.map.context, taken: [number, number][] = [];
    c.font = '11px system-ui, sans-serif';
    c.textAlign = 'left';
    c.textBaseline = 'middle';
    c.fillStyle = themed('text');
    for (const { id, x, y } of this.marks) {
      const px = this.map.px(x) + 8, py = this.map.py(y) - 8;
      if (!this.map.inside(px, py) || taken.some(([a, b]) => Math.abs(a - px) < 30 && Math.abs(b - py) < 12)) continue;
      taken.push([px, py]);
      c.fillText(String(id), px, py);
    }
  }
}
