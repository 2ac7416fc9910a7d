// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

type Child = Node | string | null | undefined | false;

/** An element with attributes (functions are listeners) and children. */
export function el<K extends keyof HTMLElementTagNameMap>(
    tag: K, attributes: Record<string, any> = {}, ...children: Child[]): HTMLElementTagNameMap[K] {
  const out = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value === undefined || value === null || value === false) continue;
    if (typeof value === 'function') out.addEventListener(name, value);
    else out.setAttribute(name, value === true ? '' : String(value));
  }
  for (const child of children) if (child) out.append(child);
  return out;
}

/** A number with four significant digits, or as many as asked for. */
export function show(value: number | null | undefined, unit = '', digits = 4): string {
  if (value === null || value === undefined || !Number.isFinite(value)) return '–';
  const size = Math.abs(value);
  const text = size !== 0 && (size < 1e-3 || size >= 1e6) ? value.toExponential(Math.min(2, digits - 1))
      : String(Number(value.toPrecision(digits)));
  return unit ? `${text} ${unit}` : text;
}

/** Log odds as odds that one can say: 20 : 1. */
export function odds(log: number | null | undefined): string {
  if (log === null || log === undefined) return 'not admitted';
  const size = Math.exp(Math.min(Math.abs(log), 690));
  const text = size >= 1e5 ? `10^${Math.round(Math.abs(log) / Math.LN10)}` : String(Number(size.toPrecision(3)));
  return log >= 0 ? `${text} : 1` : `1 : ${text}`;
}

export function percent(p: number | null | undefined): string {
  if (p === null || p === undefined) return '–';
  if (p > 0.9995 && p < 1) return '> 99.9 %';
  return `${(100 * p).toFixed(1)} %`;
}

/** Something to press that looks like a link in a text. */
export function link(text: string, press: () => void, title = ''): HTMLButtonElement {
  return el('button', { class: 'link', type: 'button', click: press, title }, text);
}

/** Rows of a name and a value. */
export function facts(rows: [string, Child][]): HTMLElement {
  const list = el('dl', { class: 'facts' });
  for (const [name, value] of rows) list.append(el('dt', {}, name), el('dd', {}, value ?? '–'));
  return list;
}
