// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

import { aboutView } from './about_view';
import { boxOf, CanvasMap } from './canvas_map';
import { CompareLayer } from './compare_layer';
import { CompareView } from './compare_view';
import { GraphData } from './data';
import { el, facts, link, percent, show } from './dom';
import { isTyping, Tabs, theme } from './frame';
import { healthView } from './health_view';
import { histogramPlot } from './histogram';
import { OrbitView, spaceSwitch, Strand } from './orbit';
import { decisionColor as colorOf, themed } from './palette';
import { Plot } from './plots';
import { Table } from './table';

/** The report of a pose graph: before and after, closures and why, how the objective fell; gives the view that takes other results. */
export function graphPage(data: GraphData): CompareView {
  const { closures } = data;
  let chosen: number | null = null, before = false;
  const layers = new Map<string, boolean>();
  const map = new CanvasMap('Pose graph. Plus and minus zoom, f shows all.');
  map.setBox(boxOf(data.after, data.before, data.truth));
  const others = new CompareLayer(map);
  others.key.classList.add('legend');
  map.root.append(others.key);
  const poses = () => (before ? data.before : data.after);

  const counts = new Map<string, number>();
  for (const d of closures.decision) counts.set(d, (counts.get(d) ?? 0) + 1);
  const bar = el('div', { class: 'bar', role: 'group', 'aria-label': 'Layers of the map' });
  const toggle = (name: string, text: string, on = true) => {
    layers.set(name, on);
    const box = el('input', { type: 'checkbox', change: () => { layers.set(name, box.checked); map.redraw(); } });
    box.checked = on;
    bar.append(el('label', {}, box, text));
  };
  const time = el('button', { type: 'button', class: 'small', id: 'before', 'aria-pressed': 'false', click: () => {
    before = !before;
    time.textContent = before ? 'before' : 'after';
    time.setAttribute('aria-pressed', String(before));
    map.redraw();
  }, title: 'before or after optimisation (b)' }, 'after');
  bar.append(time);
  toggle('graph', 'graph');
  for (const [decision, count] of counts) toggle(decision, `${decision} (${count})`);
  if (data.truth.x.length) toggle('truth', 'truth');
  bar.append(el('span', { class: 'zoom' },
      el('button', { type: 'button', class: 'small', 'aria-label': 'zoom out', click: () => map.zoomBy(1 / 1.5) }, '−'),
      el('button', { type: 'button', class: 'small', 'aria-label': 'zoom in', click: () => map.zoomBy(1.5) }, '+'),
      el('button', { type: 'button', class: 'small', click: () => map.fit() }, 'Fit')));

  map.draw = () => {
    const c = map.context, { x, y } = poses();
    const edges = (list: { i: number[]; j: number[] }, wanted: (e: number) => boolean) => {
      c.beginPath();
      for (let e = 0; e < list.i.length; ++e) {
        if (!wanted(e)) continue;
        c.moveTo(map.px(x[list.i[e]]), map.py(y[list.i[e]]));
        c.lineTo(map.px(x[list.j[e]]), map.py(y[list.j[e]]));
      }
      c.stroke();
    };
    if (layers.get('truth')) {
      c.strokeStyle = themed('truth');
      c.setLineDash([6, 4]);
      map.line(data.truth.x, data.truth.y);
      c.setLineDash([]);
    }
    c.lineWidth = 1.5;
    if (layers.get('graph')) {
      c.strokeStyle = themed('estimate');
      edges(data.edges, () => true);
    }
    for (const decision of counts.keys()) {
      if (!layers.get(decision)) continue;
      const color = colorOf(decision);
      c.strokeStyle = themed(color);
      c.lineWidth = color === 'rejected' ? 1 : 1.3;
      c.setLineDash(color === 'rejected' ? [4, 4] : color === 'undecided' ? [1, 3] : []);
      edges(closures, e => closures.decision[e] === decision);
    }
    c.setLineDash([]);
    others.draw();
    if (chosen === null) return;
    c.strokeStyle = themed('select');
    c.lineWidth = 4;
    edges(closures, e => e === chosen);
  };
  map.press = (px, py) => {
    const { x, y } = poses();
    let best = -1, least = 8;
    for (let e = 0; e < closures.i.length; ++e) {
      if (!layers.get(closures.decision[e])) continue;
      const d = fromSegment(px, py, map.px(x[closures.i[e]]), map.py(y[closures.i[e]]), map.px(x[closures.j[e]]), map.py(y[closures.j[e]]));
      if (d < least) { least = d; best = e; }
    }
    choose(best >= 0 ? best : null);
  };

  const detail = el('div', { class: 'why', 'aria-live': 'polite' });
  const reason = (e: number) => {
    if (colorOf(closures.decision[e]) === 'rejected') return 'the graph without it explains the other measurements better.';
    if (!closures.checkable[e]) return 'it is believed, but no other measurement checks it.';
    return 'the other measurements agree with it.';
  };
  const choose = (e: number | null) => {
    chosen = e;
    map.redraw();
    table.select(e);
    if (e === null) { detail.replaceChildren(); return; }
    tabs.openNamed('Closures');
    const { x, y } = poses(), i = closures.i[e], j = closures.j[e];
    detail.replaceChildren(
        el('h3', {}, `Closure ${data.ids[i]} – ${data.ids[j]}: ${closures.decision[e]}`), el('p', {}, reason(e)),
        facts([['probability that it is right', percent(closures.probability[e])],
          ['residual', `${show(closures.residual[e])} sigmas`], ['redundancy', show(closures.redundancy[e])],
          ['margin of the objective', show(closures.margin[e])],
          ...(closures.history[e].length ? [['online', closures.history[e].map(([pose, text]) => `${text} at pose ${pose}`).join(', then ')] as [string, string]] : []),
          ['', link('show on the map', () => map.center((x[i] + x[j]) / 2, (y[i] + y[j]) / 2, 60 / (1e-6 + Math.hypot(x[i] - x[j], y[i] - y[j]))))]]));
  };
  const table = new Table([
    { title: 'from', width: '3.8rem', number: true, text: e => String(data.ids[closures.i[e]]), by: e => closures.i[e] },
    { title: 'to', width: '3.8rem', number: true, text: e => String(data.ids[closures.j[e]]), by: e => closures.j[e] },
    { title: 'decision', width: '1fr', text: e => closures.decision[e], by: e => closures.decision[e] },
    { title: 'p', width: '4.4rem', number: true, hint: 'probability that it is right',
      text: e => percent(closures.probability[e]), by: e => closures.probability[e] },
    { title: 'residual', width: '4.4rem', number: true, text: e => show(closures.residual[e]), by: e => closures.residual[e] },
    { title: 'redund.', width: '4.2rem', number: true, hint: 'redundancy: how far other measurements check it', text: e => show(closures.redundancy[e]), by: e => closures.redundancy[e] },
    { title: 'margin', width: '4.2rem', number: true, hint: 'by which the objective decides', text: e => show(closures.margin[e]), by: e => closures.margin[e] },
  ], e => choose(e), e => (colorOf(closures.decision[e]) === 'rejected' ? 'faint' : ''), 'Closures');
  const filter = el('select', { 'aria-label': 'Which closures', change: () => update() });
  for (const name of ['all', ...counts.keys(), 'not checkable', 'narrow margin (< 10)']) filter.append(el('option', {}, name));
  const count = el('span', { class: 'quiet' });
  const update = () => {
    const rows = closures.i.map((_, e) => e).filter(e => filter.value === 'all' || closures.decision[e] === filter.value ||
        (filter.value === 'not checkable' && !closures.checkable[e]) ||
        (filter.value.startsWith('narrow') && closures.margin[e] !== null && Math.abs(closures.margin[e]!) < 10));
    count.textContent = `${rows.length} of ${closures.i.length}`;
    table.set(rows);
  };
  update();
  const groups = [...counts.keys()].map(decision => ({ label: decision, color: colorOf(decision),
    dash: colorOf(decision) === 'accepted' ? undefined : [4, 3],
    values: closures.probability.filter((_, e) => closures.decision[e] === decision) })).filter(g => g.values.some(v => v !== null));
  const histogram = groups.length ? histogramPlot('Closures by the probability that they are right', 'probability', 0.05, 20, groups, [],
      'Shares of each decision. Where deciding was easy they stand at both ends.') : null;
  const closurePane = el('div', { class: 'pane' }, el('div', { class: 'bar' }, el('label', {}, 'show ', filter), count), detail, table.root, histogram?.root ?? '');

  const plots = [new Plot(data.steps.solver_ms.length ? 'Objective after each pose' : 'Objective after each iteration', data.steps.solver_ms.length ? 'pose' : 'iteration', data.objectives.map((_, i) => i),
      [{ label: 'objective', values: data.objectives, color: 'estimate', points: data.objectives.length < 60 }], { height: 220,
        log: data.objectives.length > 0 && data.objectives.every(v => v > 0) })];
  if (data.steps.solver_ms?.length) {
    const x = data.steps.solver_ms.map((_, i) => i);
    plots.push(new Plot('Time for each pose [ms]', 'pose', x, [{ label: 'solver', values: data.steps.solver_ms, color: 'estimate', width: 1 }], { log: true }));
    plots.push(new Plot('Decisions that changed', 'pose', x, [{ label: 'flips', values: data.steps.flips, color: 'wrong', steps: true }], { height: 120 }));
  }
  const solver = el('div', { class: 'pane' }, ...plots.map(p => p.root));

  const orbit = data.after.z ? new OrbitView(strands(data)) : null;
  const stage = el('main', {}, el('div', { class: 'map-room' }, bar, map.root));
  if (orbit) {
    map.root.append(orbit.root);
    bar.prepend(spaceSwitch(orbit));
  }
  const compare = new CompareView(data, others, added => {
    map.setBox(boxOf(data.after, data.before, data.truth, others.extent()));
    orbit?.setOthers(others.strands());
    if (added) tabs.openNamed('Compare');
  });
  const tabs: Tabs = new Tabs([{ name: 'Health', root: healthView(data.summary.health, data.summary.noise, 'pose') }, { name: 'Closures', root: closurePane }, { name: 'Solver', root: solver }, { name: 'Compare', root: compare.root }, { name: 'About', root: aboutView(data.summary) }]);
  const truth = data.summary.truth?.trajectory;
  const header = el('header', {}, el('h1', {}, data.title || 'Pose graph'), el('span', { class: 'quiet head-line' },
      `${data.summary.method}: ${data.after.x.length} poses, ${closures.i.length} closures` + (truth ? `, path rmse ${show(truth.rmse_m)} m` : '')),
      theme(() => { map.redraw(); for (const plot of plots) plot.restyle(); histogram?.restyle(); orbit?.restyle(); compare.restyle(); }));
  document.body.append(el('div', { class: 'page no-time' }, header, stage, tabs.root));
  document.addEventListener('keydown', e => {
    if (isTyping(e) || e.ctrlKey || e.metaKey || e.altKey) return;
    const actions: Record<string, () => void> = {
      '+': () => map.zoomBy(1.5), '-': () => map.zoomBy(1 / 1.5), f: () => map.fit(), b: () => time.click(),
      d: () => document.getElementById('theme')!.click(), Escape: () => choose(null),
      1: () => tabs.open(0), 2: () => tabs.open(1), 3: () => tabs.open(2), 4: () => tabs.open(3), 5: () => tabs.open(4),
    };
    if (!actions[e.key]) return;
    e.preventDefault();
    actions[e.key]();
  });
  (window as any).report = { data, map, compare };
  return compare;
}

function fromSegment(px: number, py: number, ax: number, ay: number, bx: number, by: number): number {
  const dx = bx - ax, dy = by - ay, length = dx * dx + dy * dy;
  const t = length ? Math.max(0, Math.min(1, ((px - ax) * dx + (py - ay) * dy) / length)) : 0;
  return Math.hypot(px - ax - t * dx, py - ay - t * dy);
}

function strands(data: GraphData): Strand[] {
  const columns = (c: GraphData['after']) => [c.x, c.y, c.z ?? c.x.map(() => 0)];
  const segments = (list: { i: number[]; j: number[] }, wanted: (e: number) => boolean) => {
    const out: number[][] = [[], [], []], all = columns(data.after);
    for (let e = 0; e < list.i.length; ++e) {
      if (wanted(e)) for (let d = 0; d < 3; ++d) out[d].push(all[d][list.i[e]], all[d][list.j[e]]);
    }
    return out;
  };
  const of = (color: string) => segments(data.closures, e => colorOf(data.closures.decision[e]) === color);
  const all: Strand[] = [
    { label: 'graph', points: segments(data.edges, () => true), color: 'estimate', mode: 'segments' },
    { label: 'before', points: columns(data.before), color: 'odometry', mode: 'line', alpha: 0.5 },
    { label: 'accepted closures', points: of('accepted'), color: 'accepted', mode: 'segments', alpha: 0.7 },
    { label: 'rejected closures', points: of('rejected'), color: 'rejected', mode: 'segments', alpha: 0.4 },
    { label: 'truth', points: columns(data.truth), color: 'truth', mode: 'line', alpha: 0.8 },
  ];
  return all.filter(s => s.points[0].length > 0);
}
