// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

import { aboutView } from './about_view';
import { TrialsData } from './data';
import { el, show } from './dom';
import { Tabs, theme } from './frame';
import { Table } from './table';

/** The report of an experiment: every trial, to sort and filter. */
export function trialsPage(data: TrialsData) {
  const wanted = data.columns.map((_, c) => c).filter(c => data.columns[c] !== 'reliability');
  const columns = wanted.map(c => data.columns[c]), rows = data.rows.map(r => wanted.map(c => r[c]));
  const numeric = columns.map((_, c) => rows.some(r => typeof r[c] === 'number'));
  const table = new Table(columns.map((title, c) => ({
    title, width: numeric[c] ? '6rem' : 'minmax(7rem, 1fr)', number: numeric[c],
    text: (r: number) => typeof rows[r][c] === 'number' ? show(rows[r][c] as number) : String(rows[r][c] ?? '–'),
    by: (r: number) => rows[r][c],
  })), () => {}, () => '', 'Trials');
  const find = el('input', { type: 'search', id: 'search', placeholder: 'filter', 'aria-label': 'Filter trials' });
  const count = el('span', { class: 'quiet' });
  const update = () => {
    const words = find.value.toLowerCase().split(/\s+/).filter(w => w);
    const shown = rows.map((_, r) => r).filter(r => words.every(w => rows[r].some(v => String(v).toLowerCase().includes(w))));
    count.textContent = `${shown.length} of ${rows.length} trials`;
    table.set(shown);
  };
  find.addEventListener('input', update);
  update();
  const pane = el('div', { class: 'pane' }, el('div', { class: 'bar' }, find, count), table.root);
  const tabs = new Tabs([{ name: 'Trials', root: pane }, { name: 'About', root: aboutView(data.summary) }]);
  const header = el('header', {}, el('h1', {}, data.title || 'Experiment'), theme(() => {}));
  document.body.append(el('div', { class: 'page only' }, header, tabs.root));
}
