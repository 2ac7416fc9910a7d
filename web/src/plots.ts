// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

import uPlot from 'uplot';
import { el, show } from './dom';
import { themed } from './palette';

export interface Series {
  label: string;
  values: (number | null)[];
  color: string;  // of the style sheet, or a colour
  dash?: number[];
  width?: number;
  fill?: boolean;
  points?: boolean;
  steps?: boolean;
  gaps?: boolean;  // lines go on where a value is missing
  shown?: number[];  // in the legend, instead of the values
}

const color = (name: string) => (name.startsWith('#') ? name : themed(name));

/** Of a logarithmic axis the powers of ten. */
const powers = (_: uPlot, ticks: number[]) => ticks.map(t => (Math.abs(Math.log10(t) - Math.round(Math.log10(t))) < 1e-9 ? t : null));

/** Hands a table to the browser as a file that is named by the title. */
function saveTable(title: string, text: string) {
  const url = URL.createObjectURL(new Blob([text], { type: 'text/csv' }));
  const name = title.toLowerCase().replace(/\[[^\]]*\]/g, '').replace(/[^a-z0-9]+/g, '_').replace(/^_|_$/g, '');
  el('a', { href: url, download: `${name}.csv` }).click();
  URL.revokeObjectURL(url);
}

/** A plot over numbers that fits its place; pressing it gives the x that is nearest. */
export class Plot {
  readonly root: HTMLElement;
  private chart: uPlot | null = null;
  private marker: number | null = null;
  private place = el('div', { class: 'plot' });

  constructor(title: string, private axis: string, private x: number[], private series: Series[],
              private options: { log?: boolean; height?: number; max?: number;
                                 press?: (x: number) => void; note?: string } = {}) {
    const save = el('button', { type: 'button', class: 'link csv', title: `save the curves of "${title}" as a table`,
      click: () => saveTable(title, this.table()) }, 'CSV');
    this.root = el('figure', {}, el('figcaption', {}, title, ' ', save), this.place,
        options.note ? el('p', { class: 'quiet' }, options.note) : null);
    new ResizeObserver(() => this.build()).observe(this.place);
  }

  /** The curves as a table with commas: x, then a column for each. */
  table(): string {
    const cell = (text: string) => (/[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);
    const rows = this.x.map((x, i) => [x, ...this.series.map(s => s.values[i] ?? '')].join(','));
    return [[this.axis, ...this.series.map(s => s.label)].map(cell).join(','), ...rows, ''].join('\n');
  }
  restyle() {
    this.chart?.destroy();
    this.chart = null;
    this.build();
  }
  /** A line at this x. */
  mark(x: number | null) {
    this.marker = x;
    this.chart?.redraw(false);
  }

  private build() {
    const width = this.place.clientWidth, height = this.options.height ?? 170;
    if (width < 40) return;
    if (this.chart) {
      if (this.chart.width !== width) this.chart.setSize({ width, height });
      return;
    }
    const axis = { stroke: themed('text'), grid: { stroke: themed('grid'), width: 1 },
      ticks: { stroke: themed('grid'), width: 1 }, font: '11px system-ui, sans-serif' };
    const lines = this.series.map(s => ({
      label: s.label,
      stroke: color(s.color),
      width: s.width ?? 1.5,
      dash: s.dash,
      fill: s.fill ? color(s.color) : undefined,
      points: { show: s.points ?? false, size: 5 },
      paths: s.steps ? uPlot.paths.stepped!({ align: 1 }) : undefined,
      spanGaps: s.gaps ?? false,
      value: (_: uPlot, v: number | null, __: number, at: number | null) => show(at !== null && s.shown ? s.shown[at] : v),
    }));
    const options: uPlot.Options = {
      width,
      height,
      padding: [8, 8, 0, 0],
      scales: { x: { time: false }, y: this.options.log ? { distr: 3 } :
          this.options.max !== undefined ? { range: [0, this.options.max] } : {} },
      axes: [{ ...axis, label: undefined }, { ...axis, ...(this.options.log ? { filter: powers, grid: { ...axis.grid, filter: powers } } : {}), size: 56, values: (_, ticks) => ticks.map(t => t === null ? '' : show(t)) }],
      series: [{ label: this.axis, value: (_, v) => show(v) }, ...lines],
      legend: { live: true },
      cursor: { drag: { x: true, y: false } },
      hooks: { draw: [chart => this.drawMarker(chart)] },
    };
    const values = this.options.log
        ? this.series.map(s => s.values.map(v => (v !== null && v > 0 ? v : null))) : this.series.map(s => s.values);
    this.chart = new uPlot(options, [this.x, ...values] as uPlot.AlignedData, this.place);
    this.chart.over.addEventListener('click', () => {
      const at = this.chart!.cursor.idx;
      if (at !== null && at !== undefined) this.options.press?.(this.x[at]);
    });
  }
  private drawMarker(chart: uPlot) {
    if (this.marker === null) return;
    const x = chart.valToPos(this.marker, 'x', true);
    const { left, top, width, height } = chart.bbox;
    if (x < left || x > left + width) return;
    chart.ctx.save();
    chart.ctx.strokeStyle = themed('select');
    chart.ctx.lineWidth = 1.5 * (window.devicePixelRatio || 1);
    chart.ctx.beginPath();
    chart.ctx.moveTo(x, top);
    chart.ctx.lineTo(x, top + height);
    chart.ctx.stroke();
    chart.ctx.restore();
  }
}
