// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

import { MapData } from './data';
import { el, facts, link, percent, show } from './dom';
import { State } from './state';
import { Table } from './table';

/** Closures by laser scans with their probabilities, by keyframe. */
export class ScanClosureView {
  readonly root: HTMLElement;
  private detail = el('div', { class: 'why', 'aria-live': 'polite' });
  private table: Table;
  private filter = el('select', { 'aria-label': 'Which closures by scans', change: () => this.update() });
  private count = el('span', { class: 'quiet' });

  constructor(private data: MapData, private state: State) {
    const all = data.scan_closures;
    const number = (title: string, width: string, column: (number | null)[], hint = '') =>
        ({ title, width, number: true, hint, text: (e: number) => show(column[e], '', 3), by: (e: number) => column[e] });
    this.table = new Table([
      number('keyframe', '4.8rem', all.j), number('to', '3.6rem', all.i, 'keyframe that the local map begins with'),
      { title: 'decision', width: '1fr', text: e => all.decision[e], by: e => all.decision[e] },
      { title: 'p', width: '4.4rem', number: true, hint: 'probability that it is right', text: e => percent(all.probability[e]),
        by: e => all.probability[e] },
      number('margin', '4.2rem', all.margin, 'logarithm of the evidence, less the threshold of admission'),
      number('modes', '3.6rem', all.modes, 'poses that the same search found'),
    ], e => this.press(e), e => (all.decision[e] === 'rejected' ? 'faint' : ''), 'Closures by scans');
    for (const name of ['all', 'this keyframe', ...new Set(all.decision)]) this.filter.append(el('option', {}, name));
    this.root = el('div', { class: 'scan-closures' },
        el('div', { class: 'bar' }, el('label', {}, 'show ', this.filter), this.count),
        el('p', { class: 'quiet' }, 'Places that scans or clouds recognise: each is a relative pose that may be false.'),
        this.detail, this.table.root);
    state.listen((view, changed) => {
      if (changed.has('closure') && view.closure === null) { this.table.select(null); this.detail.replaceChildren(); }
      if (changed.has('keyframe') && this.filter.value === 'this keyframe') this.update();
    });
    this.update();
  }

  private update() {
    const all = this.data.scan_closures, wanted = this.filter.value, k = this.state.view.keyframe;
    const rows = all.i.map((_, e) => e).filter(e => wanted === 'all' || all.decision[e] === wanted ||
        (wanted === 'this keyframe' && (all.j[e] === k || all.i[e] === k)));
    this.count.textContent = `${rows.length} of ${all.i.length}`;
    this.table.set(rows);
  }
  private press(e: number) {
    const all = this.data.scan_closures, to = (k: number) => link(String(k), () => this.state.set({ keyframe: k }));
    this.state.set({ keyframe: all.j[e], closure: e, landmark: null, sighting: null });
    const checked = all.checkable[e] ? 'the other measurements agree with it.' : 'it is believed, but no other measurement checks it.';
    this.detail.replaceChildren(
        el('h3', {}, `Closure ${all.j[e]} – ${all.i[e]}: ${all.decision[e]}`),
        el('p', {}, all.decision[e] === 'accepted' ? checked : 'without it the other measurements are explained better.'),
        facts([['keyframes', el('span', {}, to(all.j[e]), ' and ', to(all.i[e]))],
          ['probability that it is right', percent(all.probability[e])], ['margin', `${show(all.margin[e])} nats`],
          ['residual', `${show(all.residual[e])} sigmas`], ['redundancy', show(all.redundancy[e])],
          ['points on surfaces', percent(all.inliers[e])], ['modes of its search', String(all.modes[e])]]));
  }
}
