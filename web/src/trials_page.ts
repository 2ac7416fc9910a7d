// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

import { aboutView } from './about_view';
import { TrialsData } from './data';
import { el, show } from './dom';
import { Tabs, theme } from './frame';
import { classColor } from './palette';
import { Plot } from './plots';
import { Table } from './table';

type Cell = string | number | null;

function median(values: number[]): number {
  const sorted = [...values].sort((a, b) => a - b), n = sorted.length;
  return (sorted[(n - 1) >> 1] + sorted[n >> 1]) / 2;
}

/** The report of an experiment: medians by method, and every trial, to sort and filter. */
export function trialsPage(data: TrialsData): undefined {
  const said = (c: number) => data.rows.some(r => r[c] !== '' && r[c] !== null);
  const wanted = data.columns.map((_, c) => c).filter(c => said(c) && data.columns[c] !== 'reliability');
  const columns = wanted.map(c => data.columns[c]), rows: Cell[][] = data.rows.map(r => wanted.map(c => r[c]));
  const numeric = columns.map((_, c) => rows.some(r => typeof r[c] === 'number'));
  const table = new Table(columns.map((title, c) => ({
    title, width: numeric[c] ? '6.5rem' : c === 0 ? '14rem' : 'minmax(7rem, 1fr)', number: numeric[c],
    text: (r: number) => typeof rows[r][c] === 'number' ? show(rows[r][c] as number) : String(rows[r][c] ?? '–'),
    by: (r: number) => rows[r][c],
  })), () => {}, () => '', 'Trials');
  const find = el('input', { type: 'search', id: 'search', placeholder: 'filter', 'aria-label': 'Filter trials' });
  const metric = el('select', { 'aria-label': 'What is plotted' });
  const at = (name: string) => columns.indexOf(name);
  const plotted = columns.filter((name, c) => numeric[c] && !['seed', 'outlier_rate'].includes(name));
  for (const name of plotted) metric.append(el('option', {}, name));
  if (plotted.includes('ate_mean_m')) metric.value = 'ate_mean_m';
  const count = el('span', { class: 'quiet' });
  const place = el('div', {});
  let plot: Plot | null = null;

  const update = () => {
    const words = find.value.toLowerCase().split(/\s+/).filter(w => w);
    const shown = rows.map((_, r) => r).filter(r => words.every(w => rows[r].some(v => String(v).toLowerCase().includes(w))));
    count.textContent = `${shown.length} of ${rows.length} trials`;
    table.set(shown);
    plot = at('method') < 0 || at('outlier_rate') < 0 || !plotted.length ? null : medians(shown);
    place.replaceChildren(...(plot ? [plot.root] : []));
  };
  /** Of the trials in view, by method over the share of false closures. */
  const medians = (shown: number[]) => {
    const groups = new Map<string, Map<number, number[]>>(), rates = new Set<number>();
    for (const r of shown) {
      const value = rows[r][at(metric.value)], rate = rows[r][at('outlier_rate')];
      if (typeof value !== 'number' || typeof rate !== 'number') continue;
      const method = String(rows[r][at('method')]);
      if (!groups.has(method)) groups.set(method, new Map());
      const group = groups.get(method)!;
      if (!group.has(rate)) group.set(rate, []);
      group.get(rate)!.push(value);
      rates.add(rate);
    }
    const x = [...rates].sort((a, b) => a - b);
    const series = [...groups].map(([method, by], i) => ({ label: method, color: classColor(i), points: true,
      dash: i > 7 ? [6, 4] : undefined, values: x.map(rate => (by.has(rate) ? median(by.get(rate)!) : null)) }));
    const positive = series.every(s => s.values.every(v => v === null || v > 0));
    return new Plot(`Median of ${metric.value} over outlier_rate`, 'outlier_rate', x, series, { height: 240, log: positive,
      note: 'of the trials that the filter leaves' });
  };
  find.addEventListener('input', update);
  metric.addEventListener('change', update);
  update();
  const pane = el('div', { class: 'pane' }, el('div', { class: 'bar' }, find, el('label', {}, 'plot ', metric), count), place, table.root);
  const tabs = new Tabs([{ name: 'Trials', root: pane }, { name: 'About', root: aboutView(data.summary) }]);
  const header = el('header', {}, el('h1', {}, data.title || 'Experiment'), el('span', { class: 'head-line' }), theme(() => update()));
  document.body.append(el('div', { class: 'page only' }, header, tabs.root));
}
