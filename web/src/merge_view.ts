// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

import { MapData } from './data';
import { el, facts, link, odds, show } from './dom';
import { State } from './state';
import { Table } from './table';

/** Loops closed by several landmarks, and landmarks merged, with their evidence. */
export class MergeView {
  readonly root: HTMLElement;
  private detail = el('div', { class: 'why', 'aria-live': 'polite' });

  constructor(private data: MapData, private state: State) {
    const all = data.merges;
    const text = (i: number) => all[i].undone ? 'turned down' : 'kept';
    const table = new Table([
      { title: 'keyframe', width: '5.2rem', number: true, text: i => String(all[i].k), by: i => all[i].k },
      { title: 'what', width: '4.5rem', text: i => (all[i].loop ? 'loop' : 'merge'), by: i => Number(all[i].loop) },
      { title: 'pairs', width: '1fr', text: i => all[i].pairs.map(p => p.join('→')).join(' '), by: i => all[i].pairs.length },
      { title: 'odds', width: '5.5rem', number: true, text: i => odds(all[i].evidence), by: i => all[i].evidence },
      { title: 'χ²', width: '4rem', number: true, text: i => show(all[i].chi_square), by: i => all[i].chi_square },
      { title: 'state', width: '5.2rem', text, by: text },
    ], i => this.press(i), i => (all[i].undone ? 'faint' : ''), 'Loops and merges');
    const filter = el('select', { 'aria-label': 'Which closures' });
    for (const name of ['all', 'loops', 'merges', 'turned down']) filter.append(el('option', {}, name));
    const count = el('span', { class: 'quiet' });
    const update = () => {
      const rows = all.map((_, i) => i).filter(i => filter.value === 'all' ||
          (filter.value === 'loops' && all[i].loop) || (filter.value === 'merges' && !all[i].loop) ||
          (filter.value === 'turned down' && all[i].undone));
      count.textContent = `${rows.length} of ${all.length}`;
      table.set(rows);
    };
    filter.addEventListener('change', update);
    this.root = el('div', { class: 'pane' },
        el('div', { class: 'bar' }, el('label', {}, 'show ', filter), count),
        all.length ? el('p', { class: 'quiet' }, 'Landmarks that turned out to be one; a loop is a place recognised by several of them.')
            : el('p', { class: 'hint' }, 'No landmarks were merged, and no loop was closed by them.'),
        this.detail, table.root);
    update();
  }

  private press(i: number) {
    const m = this.data.merges[i], after = this.objectives(m.k);
    this.state.set({ keyframe: m.k, landmark: m.pairs[0][1], sighting: null });
    const pairs = el('span', {});
    m.pairs.forEach(([from, into], n) => pairs.append(n ? ', ' : '',
        link(String(from), () => this.state.set({ landmark: from })), ' → ',
        link(String(into), () => this.state.set({ landmark: into }))));
    this.detail.replaceChildren(
        el('h3', {}, `${m.loop ? 'Loop' : 'Merge'} at keyframe ${m.k}${m.undone ? ', turned down' : ''}`),
        facts([['pairs', pairs], ['odds that they are one', `${odds(m.evidence)} (${show(m.evidence)} nats)`],
          ['χ² of the differences', `${show(m.chi_square)} over ${m.pairs.length * this.data.dimension} coordinates`],
          ['the objective may rise by', show(m.allowed_rise)],
          ['objective at this keyframe', after]]));
  }
  private objectives(k: number): string {
    const { changes } = this.data;
    const lines = changes.k.map((at, i) => (at === k ? changes.objectives[i] : null)).filter(o => o !== null);
    return lines.map(o => `${show(o![0])} → ${show(o![o!.length - 1])}`).join('; ');
  }
}
