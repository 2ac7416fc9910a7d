// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

import { el } from './dom';

export interface Column {
  title: string;
  width: string;  // of the grid
  text: (row: number) => string;
  hint?: string;
  number?: boolean;
  by?: (row: number) => number | string | null;  // to sort by
}

const kRowHeight = 26;

/** A table of any length: only the rows in view are in the page. Arrow keys move, Enter presses. */
export class Table {
  readonly root: HTMLElement;
  private body = el('div', { class: 'rows', tabindex: 0, role: 'grid' });
  private space = el('div', { class: 'space' });
  private rows: number[] = [];
  private order: { column: Column; down: boolean } | null = null;
  private selected = -1;
  private head = el('div', { class: 'head', role: 'row' });

  constructor(private columns: Column[], private press: (row: number) => void,
              private style: (row: number) => string = () => '', label = 'Table') {
    const template = columns.map(c => c.width).join(' ');
    this.head.style.gridTemplateColumns = template;
    this.body.style.setProperty('--columns', template);
    this.body.setAttribute('aria-label', label);
    // Columns that stretch have five rem at least; where there is less room the table scrolls.
    const least = columns.reduce((sum, c) => sum + (parseFloat(c.width) >= 2 ? parseFloat(c.width) : 5), 1);
    this.head.style.minWidth = this.body.style.minWidth = `${least}rem`;
    for (const column of columns) {
      const cell = el('button', { type: 'button', class: column.number ? 'number' : '', title: column.hint,
        click: () => this.sortBy(column) }, column.title);
      this.head.append(cell);
    }
    this.body.append(this.space);
    this.root = el('div', { class: 'table' }, el('div', { class: 'scroll' }, this.head, this.body));
    this.body.addEventListener('scroll', () => this.render());
    this.body.addEventListener('keydown', e => this.key(e));
    new ResizeObserver(() => this.render()).observe(this.body);
  }

  set(rows: number[]) {
    this.rows = rows;
    this.sort();
    this.body.setAttribute('aria-rowcount', String(rows.length));
    this.space.style.height = `${this.rows.length * kRowHeight}px`;
    this.body.style.setProperty('--height', `${this.rows.length * kRowHeight + 2}px`);
    this.body.scrollTop = 0;
    this.render();
  }
  /** Marks a row and brings it into view. */
  select(row: number | null) {
    this.selected = row ?? -1;
    const at = this.rows.indexOf(this.selected);
    if (at >= 0) {
      const top = at * kRowHeight, { scrollTop, clientHeight } = this.body;
      if (top < scrollTop || top + kRowHeight > scrollTop + clientHeight) {
        this.body.scrollTop = Math.max(0, top - clientHeight / 2);
      }
    }
    this.render();
  }
  private sortBy(column: Column) {
    if (!column.by) return;
    const again = this.order?.column === column;
    this.order = again && this.order!.down ? null : { column, down: again };
    for (const [i, cell] of [...this.head.children].entries()) {
      const active = this.order?.column === this.columns[i];
      cell.setAttribute('data-order', !active ? '' : this.order!.down ? 'down' : 'up');
    }
    this.rows.sort((a, b) => a - b);
    this.sort();
    this.render();
  }
  private sort() {
    if (!this.order) return;
    const { column, down } = this.order, sign = down ? -1 : 1;
    const value = (row: number) => column.by!(row);
    this.rows.sort((a, b) => {
      const x = value(a), y = value(b);
      if (x === null || y === null) return x === y ? 0 : x === null ? 1 : -1;
      return x === y ? 0 : (x < y ? -1 : 1) * sign;
    });
  }
  private key(e: KeyboardEvent) {
    const step = { ArrowDown: 1, ArrowUp: -1, PageDown: 10, PageUp: -10 }[e.key];
    if (!step) return;
    e.preventDefault();
    e.stopPropagation();
    const at = this.rows.indexOf(this.selected);
    const next = Math.max(0, Math.min(this.rows.length - 1, at < 0 ? 0 : at + step));
    if (this.rows.length) { this.select(this.rows[next]); this.press(this.rows[next]); }
  }
  render() {
    const first = Math.max(0, Math.floor(this.body.scrollTop / kRowHeight) - 4);
    const last = Math.min(this.rows.length, first + Math.ceil(this.body.clientHeight / kRowHeight) + 8);
    const shown: HTMLElement[] = [];
    for (let i = first; i < last; ++i) {
      const row = this.rows[i];
      const line = el('div', { class: `row ${this.style(row)}${row === this.selected ? ' selected' : ''}`,
        role: 'row', style: `top: ${i * kRowHeight}px`, click: () => { this.select(row); this.press(row); } });
      for (const column of this.columns) {
        const text = column.text(row);
        line.append(el('span', { role: 'gridcell', class: column.number ? 'number' : '', title: text }, text));
      }
      shown.push(line);
    }
    this.body.replaceChildren(this.space, ...shown);
  }
}
