// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

import { el, show } from './dom';
import { type NoiseRecord, noiseView } from './noise_view';
import { Plot } from './plots';

/** One quantity that a run tells about itself, as summary.json has it. */
export interface HealthEntry {
  name: string;
  value: number | null;
  expected: [number | null, number | null];
  verdict: 'good' | 'doubtful' | 'bad' | 'not judged';
  sentence: string;
  knob: string;
  over_time?: { time: number; value: number; weight: number }[];
}

const rank = { bad: 0, doubtful: 1, good: 2, 'not judged': 3 };
const mark = { bad: '✕', doubtful: '?', good: '✓', 'not judged': '–' };

function expected([least, most]: [number | null, number | null]): string {
  if (least === null || least === 0) return most === null ? '' : `at most ${show(most)}`;
  return most === null ? `at least ${show(least)}` : `${show(least)} to ${show(most)}`;
}

/** How many verdicts are of each kind, the worst first. */
export function healthHeadline(health: HealthEntry[]): string {
  const count = (verdict: string) => health.filter(e => e.verdict === verdict).length;
  if (count('bad')) return `${count('bad')} of ${health.length} checks say that the result is wrong`;
  if (count('doubtful')) return `${count('doubtful')} of ${health.length} checks are doubtful`;
  return `${count('good')} of ${health.length} checks are good`;
}

/** The value by stretches of the log: where a map goes wrong it dips. */
function overTime(entry: HealthEntry, axis: string): HTMLElement | null {
  const samples = entry.over_time ?? [];
  if (samples.length < 2) return null;
  return new Plot(entry.name, axis, samples.map(s => s.time - samples[0].time),
      [{ label: 'value', values: samples.map(s => s.value), color: 'estimate' }]).root;
}

/** What the run says about itself, without truth, the worst first; and its noise. */
export function healthView(health: HealthEntry[] = [], noise: NoiseRecord[] = [], axis = 'time [s]'): HTMLElement {
  const root = el('div', { class: 'pane' });
  if (health.length) root.append(el('p', { class: 'health-headline' }, healthHeadline(health)));
  else root.append(el('p', { class: 'hint' }, 'This result has nothing that could be checked.'));
  for (const entry of [...health].sort((a, b) => rank[a.verdict] - rank[b.verdict])) {
    root.append(el('section', { class: `health ${entry.verdict}` },
        el('h4', {}, el('span', { class: 'mark', 'aria-hidden': 'true' }, mark[entry.verdict]), ` ${entry.name} `,
            el('span', { class: 'verdict' }, entry.verdict)),
        el('p', {}, entry.sentence),
        entry.verdict === 'not judged' ? null : el('p', { class: 'quiet' }, `${show(entry.value)}; expected ${expected(entry.expected) || 'anything'}`),
        entry.knob ? el('p', { class: 'knob' }, `Look at: ${entry.knob}`) : '', overTime(entry, axis)));
  }
  const table = noiseView(noise);
  if (table) root.append(table);
  return root;
}
