// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

import { groupBy, MapData } from './data';
import { el, link, show } from './dom';
import { Plot } from './plots';
import { State } from './state';

/** How the objective fell, half-step by half-step, what flipped, and the time it took. */
export class SolverView {
  readonly root = el('div', { class: 'pane' });
  private detail = el('div', { 'aria-live': 'polite' });
  private plots: Plot[] = [];
  private changesAt: Map<number, number[]>;

  constructor(private data: MapData, private state: State) {
    this.changesAt = groupBy(data.changes.k);
    this.build();
    state.listen((view, changed) => {
      if (!changed.has('keyframe')) return;
      for (const plot of this.plots) plot.mark(view.keyframe);
      this.showChanges();
    });
  }

  private build() {
    const { steps } = this.data, x = steps.objective.map((_, k) => k);
    const go = (k: number) => this.state.set({ keyframe: k });
    const rises = this.rises();
    this.plots = [
      new Plot('Objective after each keyframe', 'keyframe', x, [
        { label: 'objective (eq. 6)', values: steps.objective, color: 'estimate' },
        { label: 'cost of the continuous factors', values: steps.cost, color: 'truth' }], { press: go }),
      new Plot('Discrete variables that flipped', 'keyframe', x,
          [{ label: 'flips', values: steps.flips, color: 'wrong', steps: true }], { press: go, height: 120 }),
      new Plot('Time for each keyframe [ms]', 'keyframe', x, [
        { label: 'solver', values: steps.solver_ms, color: 'estimate', width: 1 },
        { label: 'plugins, with association', values: steps.plugin_ms, color: 'truth', width: 1 }],
          { press: go, log: true }),
    ];
    this.root.replaceChildren(
        el('p', { class: rises === 0 ? 'good' : 'bad' },
            rises === 0 ? `In ${this.count().toLocaleString('en')} half-steps the objective never rose.`
                : `The objective rose in ${rises} half-steps.`),
        this.detail, ...this.plots.map(p => p.root), this.flippers());
    this.showChanges();
    for (const plot of this.plots) plot.mark(this.state.view.keyframe);
  }
  restyle() { for (const plot of this.plots) plot.restyle(); }

  private count() { return this.data.changes.objectives.reduce((n, o) => n + o.length - 1, 0); }
  private rises() {
    let count = 0;
    for (const o of this.data.changes.objectives) {
      // Rounded to three decimals here.
      for (let i = 1; i < o.length; ++i) if (o[i] > o[i - 1] + 2e-3 + 1e-9 * Math.abs(o[i])) ++count;
    }
    return count;
  }

  private showChanges() {
    const k = this.state.view.keyframe, list = this.changesAt.get(k) ?? [];
    const { objectives, flips } = this.data.changes;
    const body = el('tbody', {});
    for (const [n, i] of list.slice(0, 40).entries()) {
      objectives[i].forEach((value, h) => {
        const flipped = flips[i].filter(f => f[3] === h);
        const gain = h ? value - objectives[i][h - 1] : null;
        const text = el('td', { class: 'wide' });
        if (flipped.length) {
          flipped.slice(0, 12).forEach(([name, from, to], f) => text.append(f ? ', ' : '', this.variable(name, from, to)));
          if (flipped.length > 12) text.append(` and ${flipped.length - 12} more`);
        }
        body.append(el('tr', { class: flipped.length ? 'discrete' : '' },
            el('td', {}, h ? '' : `change ${n + 1}`), el('td', {}, !h ? 'start' : flipped.length ? 'discrete' : 'continuous'),
            el('td', { class: 'number' }, show(value)), el('td', { class: 'number' }, gain === null ? '' : show(gain)), text));
      });
    }
    this.detail.replaceChildren(el('h3', {}, `Half-steps at keyframe ${k}`),
        list.length ? el('table', { class: 'small-table' }, el('thead', {}, el('tr', {}, el('th', {}, ''), el('th', {}, 'half-step'),
            el('th', { class: 'number' }, 'objective'), el('th', { class: 'number' }, 'gain'), el('th', {}, 'flipped'))), body)
            : el('p', { class: 'quiet' }, 'Nothing was solved here.'),
        list.length > 40 ? el('p', { class: 'quiet' }, `and ${list.length - 40} more changes`) : '');
  }
  private variable(name: string, from: number, to: number): Node {
    const { classes, modes } = this.data;
    const of = (v: number) => name[0] === 's' ? classes[v] ?? v : name[0] === 'm' ? modes.names[v] ?? v : v;
    const text = `${name}: ${of(from)} → ${of(to)}`;
    if (name[0] === 's') return link(text, () => this.state.set({ landmark: Number(name.slice(1)) }));
    if (name[0] === 'm') return link(text, () => this.state.set({ keyframe: Number(name.slice(1)) }));
    return el('span', {}, text);
  }

  /** The variables that changed most often. */
  private flippers(): HTMLElement {
    const counts = new Map<string, number>();
    for (const list of this.data.changes.flips) for (const [name] of list) counts.set(name, (counts.get(name) ?? 0) + 1);
    const most = [...counts].sort((a, b) => b[1] - a[1]).slice(0, 12);
    const out = el('section', {}, el('h3', {}, 'Variables that flipped most often'));
    if (!most.length) out.append(el('p', { class: 'quiet' }, 'None flipped.'));
    out.append(el('p', {}, most.map(([name, n]) => `${name} ${n}×`).join(', ')));
    for (const [k, reason] of this.data.changes.refusals.slice(0, 20)) {
      out.append(el('p', { class: 'bad' }, link(`keyframe ${k}`, () => this.state.set({ keyframe: k })), `: refused: ${reason}`));
    }
    return out;
  }
}
