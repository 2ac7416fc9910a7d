// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

import { Id, MapData } from './data';
import { el, facts, link, odds, percent, show } from './dom';
import { History } from './history';
import { State } from './state';
import { Table } from './table';

const kFilters: [string, string][] = [
  ['all', 'all'], ['now', 'this keyframe'], ['landmark', 'this landmark'], ['wrong', 'wrong by the truth'],
  ['new', 'began a landmark'], ['several', 'could be seen in several ways'], ['revised', 'revised later'],
  ['moved', 'moved by merges'], ['none', 'belong to nothing'], ['far', 'NIS above 9'],
];

/** All sightings, and why each was given to its landmark. */
export class AssociationView {
  readonly root: HTMLElement;
  private why = el('div', { class: 'why', 'aria-live': 'polite' });
  private count = el('span', { class: 'quiet' });
  private filter = el('select', { 'aria-label': 'Which sightings' });
  private table: Table;
  private born = new Map<string, boolean>();

  constructor(private data: MapData, private history: History, private state: State) {
    const s = data.sightings;
    for (const [k, id, born] of data.lives) if (born) this.born.set(`${k} ${id}`, true);
    for (const [value, text] of kFilters) {
      if (value === 'wrong' && history.standsFor.size === 0) continue;
      this.filter.append(el('option', { value }, text));
    }
    this.filter.addEventListener('change', () => this.update());
    this.table = new Table([
      { title: 'sighting', width: '5rem', number: true, text: i => String(i), by: i => i },
      { title: 'keyframe', width: '5.2rem', number: true, text: i => String(s.k[i]), by: i => s.k[i] },
      { title: 'given to', width: '1fr', text: i => this.outcome(i), by: i => s.now[i] },
      { title: 'runner-up', width: '5.2rem', number: true, text: i => String(this.runnerUp(i)?.[0] ?? '–') },
      { title: 'odds', width: '5.5rem', number: true, hint: 'of its landmark, this sighting alone, against a new one',
        text: i => { const c = this.own(i); return c ? odds(c[2]) : '–'; }, by: i => this.own(i)?.[2] ?? null },
      { title: 'NIS', width: '4.8rem', number: true, text: i => show(s.nis[i], '', 3), by: i => s.nis[i] },
    ], i => this.press(i), i => (history.wrong(i) ? 'wrong' : ''), 'Sightings');
    this.root = el('div', { class: 'pane' },
        el('div', { class: 'bar' }, el('label', {}, 'show ', this.filter), this.count), this.why, this.table.root);
    state.listen((view, changed) => {
      if (changed.has('sighting') && view.sighting !== null) this.explain(view.sighting);
      const follows = this.filter.value === 'now' ? 'keyframe' : this.filter.value === 'landmark' ? 'landmark' : null;
      if (follows && changed.has(follows)) this.update();
    });
    this.why.append(el('p', { class: 'hint' }, 'Press a sighting to read why it was given to its landmark.'));
    this.update();
  }

  private own(i: number) {
    const first = this.data.sightings.first[i];
    return this.data.sightings.candidates[i].find(c => c[0] === first);
  }
  private runnerUp(i: number) {
    const first = this.data.sightings.first[i];
    return this.data.sightings.candidates[i].find(c => c[0] !== first && c[2] !== null);
  }
  private isNew(i: number) {
    const { first, k, id } = this.data.sightings;
    return first[i] !== null && id[i] === null && !this.own(i) && this.born.has(`${k[i]} ${first[i]}`);
  }
  private outcome(i: number): string {
    const { first, now } = this.data.sightings;
    if (now[i] === null) return first[i] === null ? 'nothing' : `${first[i]}, then nothing`;
    if (this.isNew(i) && now[i] === first[i]) return `${now[i]} (new)`;
    return first[i] !== null && first[i] !== now[i] ? `${first[i]} → ${now[i]}` : String(now[i]);
  }

  private update() {
    const { data, history, state } = this, s = data.sightings;
    const all = s.k.map((_, i) => i);
    const by: Record<string, () => number[]> = {
      all: () => all,
      now: () => [...(history.sightingsAt.get(state.view.keyframe) ?? [])],
      landmark: () => all.filter(i => s.now[i] === state.view.landmark || s.first[i] === state.view.landmark),
      wrong: () => all.filter(i => history.wrong(i)),
      new: () => all.filter(i => this.isNew(i)),
      several: () => all.filter(i => history.associationOf.has(i)),
      revised: () => all.filter(i => history.decisionOf.get(i)?.[2]),
      moved: () => all.filter(i => s.first[i] !== null && s.now[i] !== null && s.first[i] !== s.now[i]),
      none: () => all.filter(i => s.now[i] === null),
      far: () => all.filter(i => (s.nis[i] ?? 0) > 9),
    };
    const rows = by[this.filter.value]();
    this.count.textContent = `${rows.length.toLocaleString('en')} of ${all.length.toLocaleString('en')} sightings`;
    this.table.set(rows);
  }
  private press(i: number) {
    const { k, now, first } = this.data.sightings;
    this.state.set({ keyframe: k[i], landmark: now[i] ?? first[i], sighting: i });
  }

  /** Once it is seen, the sighting chosen stands in the middle. */
  shown() { this.table.select(this.state.view.sighting); }

  explain(i: number) {
    this.table.select(i);
    const s = this.data.sightings;
    const jump = (id: Id | null) => id === null ? 'nothing'
        : link(String(id), () => this.state.set({ landmark: id }));
    const rows: [string, Node | string][] = [
      ['measured', `${show(s.range[i])} m, ${show((s.yaw[i] * 180) / Math.PI)}° by ${s.sensors[s.sensor[i]] || 'the sensor'}`],
      ['taken for', el('span', {}, jump(s.first[i]), ...(s.now[i] !== s.first[i] ? [', in the end ', jump(s.now[i])] : []))],
    ];
    if (s.true[i] !== null) {
      const wrong = this.history.wrong(i);
      rows.push(['truth', `thing ${s.true[i]}: ${wrong ? 'wrong' : 'right'}`]);
    }
    if (s.dr[i] !== null) {
      rows.push(['residual at the end', `${show(s.dr[i])} m, ${show((s.dyaw[i]! * 180) / Math.PI)}°, ${show(s.chi[i])} squared sigmas`]);
    }
    const decision = this.history.decisionOf.get(i);
    if (decision) {
      rows.push(['decided', `at keyframe ${decision[0]}${decision[2] ? ', other than at first' : ', as at first'}`]);
    }
    this.why.replaceChildren(el('h3', {}, `Sighting ${i}: ${this.reason(i)}`), facts(rows),
        this.candidates(i), this.hypotheses(i));
  }
  private reason(i: number): string {
    const s = this.data.sightings, own = this.own(i), second = this.runnerUp(i);
    if (s.moving[i]) return 'left out, its thing moves.';
    if (s.id[i] !== null && s.first[i] === s.id[i]) return 'the log names its landmark.';
    if (s.first[i] === null) return 'not used.';
    if (!own) {
      return s.candidates[i].some(c => c[2] !== null)
          ? 'a new landmark explains the frame better than any candidate.' : 'a new landmark: no candidate was admitted.';
    }
    const better = own[2] !== null && second && second[2] !== null ? own[2] - second[2] : null;
    if (better === null) return `landmark ${own[0]} was the only candidate, ${odds(own[2])} against a new one.`;
    if (better < 0) return `by itself ${second![0]} is likelier, but with all detections of the frame it is ${own[0]}.`;
    return `landmark ${own[0]} is likelier than ${second![0]} by ${odds(better)}.`;
  }
  private candidates(i: number): HTMLElement | string {
    const list = this.data.sightings.candidates[i], first = this.data.sightings.first[i];
    if (!list.length) return '';
    const body = el('tbody', {});
    for (const [id, nis, log, classLog] of list) {
      body.append(el('tr', { class: id === first ? 'chosen' : '' },
          el('td', {}, link(String(id), () => this.state.set({ landmark: id })), id === first ? ' ✓' : ''),
          el('td', {}, show(nis)), el('td', {}, odds(log)), el('td', {}, classLog ? odds(classLog) : '–')));
    }
    return el('table', { class: 'small-table' },
        el('thead', {}, el('tr', {}, el('th', {}, 'candidate'), el('th', { title: 'squared sigmas of the innovation' }, 'NIS'),
            el('th', {}, 'odds against new'), el('th', {}, 'of these, class'))), body);
  }
  private hypotheses(i: number): HTMLElement | string {
    const at = this.history.associationOf.get(i);
    if (at === undefined) return '';
    const { hypotheses, sightings, open } = this.data.associations[at];
    const column = sightings.indexOf(i);
    const weights = hypotheses.map(h => Math.exp(h[1] ?? -Infinity));
    const sum = weights.reduce((a, b) => a + b, 0);
    const body = el('tbody', {});
    hypotheses.forEach(([landmarks], h) => body.append(el('tr', { class: h === 0 ? 'chosen' : '' },
        el('td', {}, landmarks[column] === null ? 'new' : String(landmarks[column])),
        el('td', {}, percent(weights[h] / sum)),
        el('td', {}, landmarks.map(l => l ?? 'new').join(' ')))));
    return el('details', { open: true },
        el('summary', {}, `The frame could be seen in ${hypotheses.length} ways${open ? '; they stayed open in the graph' : ''}`),
        el('table', { class: 'small-table' },
            el('thead', {}, el('tr', {}, el('th', {}, 'this one'), el('th', {}, 'p'), el('th', {}, 'all detections of the frame'))), body));
  }
}
