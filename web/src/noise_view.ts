// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

import { el, show } from './dom';

/** Noise of one kind of measurement, as summary.json has it; without a unit, factors of what is stated. */
export interface NoiseRecord {
  sensor: string;
  kind: string;
  unit?: string;
  at_range_m?: number;
  stated: number | null;
  measured: number | null;
  sigma: number | null;
  used: number;
  not_measured?: string;
}

const kFar = 1.5;  // off by this factor, what is stated is wrong

function isFar(record: NoiseRecord): boolean {
  if (!record.stated || !record.measured) return false;
  const ratio = record.measured / record.stated;
  return ratio > kFar || ratio < 1 / kFar;
}

function row(record: NoiseRecord): HTMLElement {
  const unit = record.unit ?? '';
  const measured = record.measured === null
      ? el('td', { class: 'quiet', title: record.not_measured }, record.not_measured ?? '–')
      : el('td', {}, `${show(record.measured, '', 3)} ± ${show(record.sigma, unit, 2)}`);
  const at = record.at_range_m ? ` at ${show(record.at_range_m, 'm', 2)}` : '';
  return el('tr', { class: isFar(record) ? 'far' : '' },
      el('td', {}, record.sensor), el('td', {}, record.kind + at),
      el('td', {}, unit || 'factor'), el('td', {}, show(record.stated, '', 3)), measured,
      el('td', {}, show(record.used, '', 3)));
}

/** What is stated of the noise, what was measured and what is used; rows that are far off are marked. */
export function noiseView(noise: NoiseRecord[] = []): HTMLElement | null {
  if (!noise.length) return null;
  const head = el('tr', {});
  for (const title of ['of', 'kind', 'unit', 'stated', 'measured', 'used']) head.append(el('th', {}, title));
  const body = el('tbody', {});
  for (const record of noise) body.append(row(record));
  return el('section', { class: 'noise' }, el('h4', {}, 'Noise'),
      el('table', {}, el('thead', {}, head), body),
      el('p', { class: 'quiet' }, 'One standard deviation. Marked: off by a factor of 1.5 or more.'));
}
