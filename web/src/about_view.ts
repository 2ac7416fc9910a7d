// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

import { el, facts, show } from './dom';

const text = (value: any): string =>
    value === null ? '–' : typeof value === 'number' ? show(value) : typeof value === 'object' ? JSON.stringify(value) : String(value);

function section(title: string, content: any, open = false): HTMLElement | string {
  if (content === undefined || content === null) return '';
  const rows = Object.entries(content).map(([name, value]) => [name, text(value)] as [string, string]);
  return rows.length ? el('details', { open }, el('summary', {}, title), facts(rows)) : '';
}

/** Settings, inputs, versions: everything in summary.json. */
export function aboutView(summary: any): HTMLElement {
  const root = el('div', { class: 'pane' });
  root.append(facts([
    ['status', summary.status + (summary.message ? `: ${summary.message}` : '')],
    ['version', summary.version ?? '–'],
    ['command', el('code', {}, (summary.command ?? []).join(' '))],
  ]));
  const warnings: string[] = summary.warnings ?? [];
  if (warnings.length) {
    root.append(el('h3', {}, 'Warnings'), el('ul', {}, ...warnings.map(w => el('li', {}, w))));
  }
  root.append(section('Measurements not used', summary.dropped, true));
  const plain = Object.fromEntries(Object.entries(summary).filter(([, v]) => typeof v === 'number' || typeof v === 'string'));
  root.append(section('Figures', plain), section('Of the plugins', summary.statistics),
      section('Times of the solver', summary.steps), section('Times of the plugins', summary.plugins));
  const inputs = el('details', {}, el('summary', {}, 'Inputs'));
  for (const input of summary.inputs ?? []) inputs.append(facts([[input.path, el('code', {}, input.sha256 ?? '')]]));
  root.append(inputs);
  const settings = el('details', {}, el('summary', {}, 'Settings'));
  for (const [name, keys] of Object.entries(summary.configuration ?? {})) {
    settings.append(el('h4', {}, `[${name}]`),
        facts(Object.entries(keys as object).map(([key, value]) => [key, text(value)] as [string, string])));
  }
  root.append(settings);
  root.append(el('details', {}, el('summary', {}, 'Keys'), facts([
    ['← →', 'a keyframe back, on (with shift ten)'], ['space', 'play, pause'], ['home end', 'first, last keyframe'],
    ['+ − f', 'zoom in, out, show all'], ['/', 'search a landmark or a keyframe (k120)'], ['n p', 'next, previous landmark'],
    ['1 … 8', 'the tabs'], ['d', 'dark or light'], ['Esc', 'nothing selected']])));
  const licences = document.getElementById('licences');
  if (licences) root.append(el('details', {}, el('summary', {}, 'Licences'), el('pre', {}, licences.textContent ?? '')));
  return root;
}
