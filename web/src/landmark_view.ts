// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

import { Id, MapData } from './data';
import { el, facts, link, percent, show } from './dom';
import { History, mostProbable } from './history';
import { classColor } from './palette';
import { figureOf, shownOf } from './photograph';
import { Plot, Series } from './plots';
import { State } from './state';
import { Table } from './table';

/** What is known of one landmark, and how it came to be known. */
export class LandmarkView {
  readonly root = el('div', { class: 'pane' });
  private picture = el('div', {});
  private plots: [Plot, (keyframe: number) => number][] = [];  // and where a keyframe is on the axis

  constructor(private data: MapData, private history: History, private state: State,
              private explain: (sighting: number) => void) {
    state.listen((view, changed) => {
      if (changed.has('landmark')) this.render();
      else if (changed.has('keyframe') || changed.has('sighting')) this.photograph();
      if (changed.has('keyframe')) for (const [plot, at] of this.plots) plot.mark(at(view.keyframe));
    });
    this.render();
  }
  restyle() { this.render(); }

  private render() {
    const id = this.state.view.landmark;
    this.plots = [];
    if (id === null) {
      this.root.replaceChildren(
          el('p', { class: 'hint' }, 'Press a landmark on the map, or search for its number.'),
          this.list());
      return;
    }
    this.root.replaceChildren(
        el('h2', {}, `Landmark ${id}`), this.summary(id), this.picture, this.probabilities(id), this.beliefs(id),
        this.innovations(id), this.sightings(id));
    for (const [plot, at] of this.plots) plot.mark(at(this.state.view.keyframe));
    this.photograph();
  }

  /** What a camera saw when the landmark was sighted; nothing where the log has no images. */
  private photograph() {
    const { landmark, keyframe, sighting } = this.state.view;
    const shown = landmark === null ? null : shownOf(this.data, this.history, landmark, keyframe, sighting);
    const { unreadable } = this.data.photographs;
    this.picture.replaceChildren(
        ...(shown ? [figureOf(this.data, shown, this.history.position(landmark!), k => this.go(k))] : []),
        ...(unreadable ? [el('p', { class: 'hint' }, `${unreadable} images of the log could not be read.`)] : []));
  }

  private list(): HTMLElement {
    const all = this.data.landmarks;
    const probability = (i: number) => all[i].p[all[i].class ?? -1] ?? null;  // of its class
    const name = (i: number) => this.data.classes[all[i].class ?? -1] ?? null;
    const table = new Table([
      { title: 'landmark', width: '5.5rem', number: true, text: i => String(all[i].id), by: i => all[i].id },
      { title: 'class', width: '1fr', text: i => name(i) ?? '–', by: name },
      { title: 'p', width: '5.4rem', number: true, hint: 'probability of the class',
        text: i => percent(probability(i)), by: probability },
      { title: 'sightings', width: '5.5rem', number: true, text: i => String(all[i].sightings), by: i => all[i].sightings },
    ], i => this.state.set({ landmark: all[i].id }), () => '', 'Landmarks');
    table.set(all.map((_, i) => i));
    return table.root;
  }

  private summary(id: Id): HTMLElement {
    const landmark = this.history.landmarks.get(id);
    const life = this.data.lives.filter(l => l[1] === id);
    const rows: [string, Node | string][] = [];
    if (landmark) {
      const [xx, , yy, , , zz] = landmark.covariance;
      const sigmas = [xx, yy, ...(zz !== undefined ? [zz] : [])].map(v => show(Math.sqrt(v ?? 0)));
      rows.push(['position', `${landmark.at.map(v => show(v)).join(', ')} m`]);
      rows.push(['sigma', `${sigmas.join(', ')} m`]);
      rows.push(['sightings', String(landmark.sightings)]);
      if (landmark.things) rows.push(['things in one place', String(landmark.things)]);
      if (landmark.extent) rows.push(['extent', `${show(landmark.extent)} m`]);
    } else {
      const into = this.history.mergedInto.get(id);
      rows.push(['state', into ? el('span', {}, 'merged into ', this.jump(into[0]), ' at keyframe ', this.go(into[1]))
          : 'not in the final map: taken for clutter']);
    }
    if (life.length) {
      const text = el('span', {});
      life.forEach(([k, , born], i) => text.append(i ? ', ' : '', born ? 'entered at ' : 'left at ', this.go(k)));
      rows.push(['life', text]);
    }
    const merges = this.data.merges.filter(m => m.pairs.some(p => p.includes(id)));
    if (merges.length) {
      const text = el('span', {});
      merges.forEach((m, i) => {
        const [from, into] = m.pairs.find(p => p.includes(id))!;
        text.append(i ? '; ' : '', m.undone ? 'turned down: ' : '', this.jump(from), ' into ', this.jump(into), ' at ', this.go(m.k));
      });
      rows.push(['merges', text]);
    }
    const truth = this.trueDistance(id);
    if (truth !== null) rows.push(['from the truth', `${show(truth)} m`]);
    return facts(rows);
  }
  private trueDistance(id: Id): number | null {
    const at = this.history.position(id);
    const trueId = [...this.history.standsFor].find(([, landmark]) => landmark === id)?.[0] ?? id;
    const truth = this.data.truth.landmarks.find(l => l.id === trueId);
    return at && truth ? Math.hypot(...at.map((v, d) => v - truth.at[d])) : null;
  }
  private jump(id: Id) { return link(String(id), () => this.state.set({ landmark: id })); }
  private go(k: number) { return link(String(k), () => this.state.set({ keyframe: k }), 'go to this keyframe'); }

  private probabilities(id: Id): HTMLElement | string {
    const landmark = this.history.landmarks.get(id);
    if (!landmark || !landmark.p.length) return '';
    const bars = el('div', { class: 'bars', role: 'list', 'aria-label': 'Class probabilities' });
    landmark.p.forEach((p, c) => bars.append(el('div', { role: 'listitem' },
        el('span', {}, this.data.classes[c]),
        el('span', { class: 'track' }, el('span', { style: `width:${100 * p}%;background:${classColor(c)}` })),
        el('span', { class: 'number', 'data-p': p }, percent(p)))));
    return el('section', {}, el('h3', {}, 'Class'), bars);
  }

  private beliefs(id: Id): HTMLElement | string {
    const list = this.history.beliefsOf.get(id) ?? [];
    if (list.length < 2) return '';
    const { k, p } = this.data.beliefs;
    const news: number[] = [], rows: number[][] = [];  // the last of a keyframe counts
    for (const b of list) {
      if (news.length && news[news.length - 1] === k[b]) rows[rows.length - 1] = p[b];
      else { news.push(k[b]); rows.push(p[b]); }
    }
    if (rows.length < 2) return '';
    const used = this.data.classes.map((_, c) => c).filter(c => rows.some(r => r[c] > 0.005));
    used.sort((a, b) => rows[rows.length - 1][b] - rows[rows.length - 1][a]);
    // Stacked: every class on top of those before; the largest sums are drawn first.
    const series: Series[] = [];
    const sums = rows.map(() => 0);
    const stacked = used.map(c => rows.map((r, i) => (sums[i] += r[c])));
    for (let i = used.length - 1; i >= 0; --i) {
      series.push({ label: this.data.classes[used[i]], values: stacked[i], shown: rows.map(r => r[used[i]]), color: classColor(used[i]), fill: true, steps: true, width: 0.5 });
    }
    const plot = new Plot('Class probabilities over its sightings, stacked', 'sighting', rows.map((_, i) => i), series,
        { height: 140, max: 1, press: at => this.state.set({ keyframe: news[at] }) });
    this.plots.push([plot, keyframe => news.filter(at => at <= keyframe).length - 1]);
    return plot.root;
  }

  private innovations(id: Id): HTMLElement | string {
    const list = (this.history.sightingsOf.get(id) ?? []).filter(i => this.data.sightings.nis[i] !== null || this.data.sightings.chi[i] !== null);
    if (list.length < 2) return '';
    const s = this.data.sightings;
    return this.add(new Plot('Squared sigmas of its sightings', 'keyframe', list.map(i => s.k[i]), [
      { label: 'innovation, when it came (NIS)', values: list.map(i => s.nis[i]), color: 'estimate', points: true, width: 0.6 },
      { label: 'residual, at the end', values: list.map(i => s.chi[i]), color: 'truth', points: true, width: 0.6 },
    ], { height: 150, press: at => this.state.set({ keyframe: at }), note: `expected on average: ${this.data.dimension} for an innovation` }));
  }
  private add(plot: Plot): HTMLElement {
    this.plots.push([plot, keyframe => keyframe]);
    return plot.root;
  }

  private sightings(id: Id): HTMLElement | string {
    const list = this.history.sightingsOf.get(id) ?? [];
    if (!list.length) return '';
    const s = this.data.sightings;
    const scores = s.scores.some(x => x.length > 0);
    const table = new Table([
      { title: 'keyframe', width: '5.2rem', number: true, text: i => String(s.k[i]), by: i => s.k[i] },
      { title: 'range', width: '4.5rem', number: true, text: i => show(s.range[i]), by: i => s.range[i] },
      ...(scores ? [{ title: 'detector', width: '1fr', text: (i: number) => s.scores[i].length
          ? `${s.names[s.sensor[i]][mostProbable(s.scores[i])]} ${percent(Math.max(...s.scores[i]))}` : '–' }] : []),
      { title: 'NIS', width: '4.8rem', number: true, text: i => show(s.nis[i], '', 3), by: i => s.nis[i] },
      { title: 'r²', width: '4.8rem', number: true, hint: 'squared sigmas of the residual at the end', text: i => show(s.chi[i], '', 3), by: i => s.chi[i] },
    ], i => { this.state.set({ keyframe: s.k[i], sighting: i }); }, i => (this.history.wrong(i) ? 'wrong' : ''), 'Sightings');
    table.set([...list]);
    return el('section', {}, el('h3', {}, `Its ${list.length} sightings`),
        el('p', { class: 'quiet' }, 'Press one to see it on the map; ',
            link('why was it given to this landmark?', () => this.explain(this.state.view.sighting ?? list[0]))),
        table.root);
  }
}
