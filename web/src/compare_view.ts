// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

import { CompareLayer, runColor } from './compare_layer';
import { alignment, commonLandmarks, differingSettings, distances, kNoMotion, Motion, moved, pairsOf, Point, pointOf, rootMeanSquare } from './comparison';
import { PathErrors } from './data';
import { el, link, percent, show } from './dom';
import { healthHeadline } from './health_view';
import { Compared, Run, runOfPage, runsOf } from './other_run';
import { decisionColor } from './palette';
import { Plot, Series } from './plots';
import { relativeErrors } from './relative_error';
import { Table } from './table';

type Row = [string, (run: Run) => string];

const truth = (run: Run) => run.summary?.truth ?? {};
const metres = (value: number | undefined | null) => show(value, 'm');
const kFigures: Row[] = [
  ['status', r => r.summary?.status ?? '–'],
  ['health', r => (r.summary?.health?.length ? healthHeadline(r.summary.health) : '–')],
  ['keyframes, or poses', r => String(r.summary?.keyframes ?? r.summary?.poses ?? r.tracks.reduce((sum, t) => sum + t.t.length, 0))],
  ['method', r => r.summary?.method ?? '–'],
  ['closures accepted, rejected', r => [r.summary?.inliers ?? '–', r.summary?.outliers ?? '–'].join(', ')],
  ['cost', r => show(r.summary?.cost)],
  ['landmarks', r => String(r.landmarks.length || '–')],
  ['objective', r => show(r.summary?.objective)],
  ['time of the solver', r => show(r.summary?.steps?.total_s, 's', 3)],
  ['path, rmse', r => metres(truth(r).trajectory?.rmse_m)],
  ['path aligned, rmse', r => metres(truth(r).trajectory?.aligned?.rmse_m)],
  ['landmarks right, spurious, missed', r => ['matched', 'spurious', 'missed'].map(n => truth(r).landmarks?.[n] ?? '–').join(', ')],
  ['landmarks, mean error', r => metres(truth(r).landmarks?.mean_m)],
  ['classes right', r => percent(truth(r).class_accuracy)],
  ['associations right', r => percent(truth(r).association_accuracy)],
  ['NEES of poses', r => show(truth(r).nees_pose)],
  ['NEES of landmarks', r => show(truth(r).nees_landmark)],
];

/** Curves of several runs over the union of their x. */
function joined(curves: { x: number[]; values: (number | null)[]; style: Omit<Series, 'values'> }[]): { x: number[]; series: Series[] } {
  const x = [...new Set(curves.flatMap(c => c.x))].sort((a, b) => a - b), place = new Map(x.map((v, i) => [v, i]));
  return { x, series: curves.map(c => {
    const values: (number | null)[] = x.map(() => null);
    c.x.forEach((v, i) => { values[place.get(v)!] = c.values[i] ?? null; });
    return { ...c.style, values, gaps: true };
  }) };
}

/** This run and others side by side: figures, settings, curves; their paths and landmarks on the map. */
export class CompareView {
  readonly root = el('div', { class: 'pane' });
  readonly runs: Run[] = [];
  motions: Motion[] = [];
  private readonly own: Run;
  private readonly origin: number | null | undefined;
  private aligned = el('input', { type: 'checkbox', id: 'aligned', change: () => this.update() });
  private result = el('div', {});
  private message = el('p', { class: 'bad', role: 'alert', hidden: true });

  constructor(private data: Compared, private layer: CompareLayer, private changed: (added: boolean) => void,
              private press?: (time: number) => void) {
    this.origin = data.kind === 'map' ? data.start : 0;
    this.own = runOfPage(data, this.origin, document.getElementById('data')!.dataset.name);
    const input = el('input', { type: 'file', multiple: true, hidden: true, id: 'other-files', accept: '.html,.json,.tum,.txt,.csv',
      change: () => { void this.addFiles([...(input.files ?? [])]).then(() => { input.value = ''; }); } });
    this.root.append(
        el('div', { class: 'bar' }, el('button', { type: 'button', click: () => input.click() }, 'Add a run …'), input,
            el('label', { title: 'moves other runs by a turn and a shift, so that their paths are nearest to that of this one' }, this.aligned, 'aligned')),
        el('p', { class: 'hint' }, 'The report.html of another run of this log or graph; or of any program a path in TUM\'s form, as trajectory.tum, with landmarks.json and summary.json where there are such. Files can be dropped on the page.'),
        this.message, this.result);
    document.addEventListener('dragover', e => e.preventDefault());
    document.addEventListener('drop', e => {
      e.preventDefault();
      if (e.dataTransfer?.files.length) void this.addFiles([...e.dataTransfer.files]);
    });
  }

  async addFiles(files: File[]) {
    this.message.hidden = true;
    try {
      for (const run of await runsOf(files, this.data.kind, this.origin)) this.add(run);
    } catch (error) {
      this.message.textContent = error instanceof Error ? error.message : String(error);
      this.message.hidden = false;
    }
  }
  /** The data of another page that this one holds. */
  addData(data: Compared, name?: string) { this.add(runOfPage(data, this.origin, name)); }
  add(run: Run) {
    const taken = [this.own, ...this.runs].filter(r => r.name.replace(/ \(\d+\)$/, '') === run.name).length;
    this.runs.push(taken ? { ...run, name: `${run.name} (${taken + 1})` } : run);
    this.update(true);
  }
  restyle() {
    if (this.runs.length) this.update();
  }

  private update(added = false) {
    const pairs = this.runs.map(run => pairsOf(this.own, run, this.data.kind === 'map')), best = pairs.map(alignment);
    this.motions = this.runs.map((_, i) => (this.aligned.checked ? best[i] : kNoMotion));
    this.layer.set(this.runs, this.motions);
    this.changed(added);
    this.result.replaceChildren();
    if (!this.runs.length) return;
    const common = this.runs.map((run, i) => commonLandmarks(this.own.landmarks.map(l => pointOf(l.at)),
        run.landmarks.map((l): Point => moved(this.motions[i], pointOf(l.at)))));
    const distance = (motions: Motion[]) => pairs.map((all, i) => metres(rootMeanSquare(all.flatMap(p => distances(p, motions[i])))));
    this.result.append(this.table('', [
      ...kFigures.map(([name, of]): [string, string[]] => [name, [this.own, ...this.runs].map(of)]).filter(([, v]) => v.some(t => /[^–, ]/.test(t))),
      ['distance of the paths, rms', ['', ...distance(this.runs.map(() => kNoMotion))]],
      ['the same, aligned', ['', ...distance(best)]],
      ...(common.some(c => c.length) ? [
        ['landmarks in both', ['', ...common.map(c => String(c.length))]],
        ['their distance, median', ['', ...common.map(c => metres(c[Math.floor(c.length / 2)]))]]] as [string, string[]][] : []),
    ], true));
    const settings = differingSettings([this.own, ...this.runs].filter(r => r.summary).map(r => r.summary));
    const known = [this.own, ...this.runs].filter(r => r.summary);
    if (known.length > 1) {
      this.result.append(settings.length ? this.table('Settings that differ', settings, false, known)
          : el('p', { class: 'hint' }, 'The settings of these runs are the same.'));
    }
    pairs[0].forEach((own, robot) => this.addDistances(own.t, robot, pairs.map(p => p[robot]), best));
    for (const errors of this.own.errors) this.addErrors(errors.robot);
    this.addDecisions();
  }

  private table(title: string, rows: [string, string[]][], removable: boolean, runs = [this.own, ...this.runs]): HTMLElement {
    const head = runs.map(run => {
      const i = this.runs.indexOf(run);
      const remove = link('×', () => { this.runs.splice(i, 1); this.update(); }, `remove ${run.name}`);
      return el('th', { style: i < 0 ? 'color: var(--estimate)' : `color: ${runColor(i)}` }, run.name, ' ', removable && i >= 0 ? remove : null);
    });
    const body = rows.map(([name, values]) => el('tr', {}, el('td', { class: 'quiet' }, name), ...values.map(v => el('td', {}, v))));
    return el('section', { class: 'runs-table' }, title ? el('h3', {}, title) : null,
        el('table', { class: 'small-table' }, el('thead', {}, el('tr', {}, el('th', {}), ...head)), el('tbody', {}, ...body)));
  }
  private addPlot(title: string, axis: string, curves: Parameters<typeof joined>[0], note = '') {
    if (!curves.some(c => c.values.some(v => v !== null))) return;
    const { x, series } = joined(curves);
    this.result.append(new Plot(title, axis, x, series, { height: 180, note, press: axis === 'time' ? this.press : undefined }).root);
  }
  private addDistances(t: number[], robot: number, pairs: ReturnType<typeof pairsOf>, best: Motion[]) {
    const name = this.own.tracks[robot].robot;
    const graph = this.data.kind === 'graph';
    this.addPlot(graph ? 'Distance from the poses of this result [m]' : `Distance from this path${name ? ` of ${name}` : ''} [m] over time [s]`, graph ? 'pose' : 'time', pairs.flatMap((p, i) => [
      { x: t, values: distances(p, kNoMotion), style: { label: this.runs[i].name, color: runColor(i) } },
      { x: t, values: distances(p, best[i]), style: { label: `${this.runs[i].name}, aligned`, color: runColor(i), dash: [4, 3] } }]));
  }
  /** Closures about which the runs do not decide alike. */
  private addDecisions() {
    const all = [this.own, ...this.runs].filter(r => r.decisions);
    if (all.length < 2) return;
    const names = [...this.own.decisions!.keys()].filter(n => new Set(all.map(r => decisionColor(r.decisions!.get(n) ?? ''))).size > 1);
    const of = (run: Run, row: number) => run.decisions!.get(names[row]) ?? '–';
    const table = new Table([
      { title: 'from', width: '4rem', number: true, text: row => names[row].split(' ')[0], by: row => Number(names[row].split(' ')[0]) },
      { title: 'to', width: '4rem', number: true, text: row => names[row].split(' ')[1], by: row => Number(names[row].split(' ')[1]) },
      ...all.map(run => ({ title: run.name, width: '1fr', text: (row: number) => of(run, row), by: (row: number) => of(run, row) })),
    ], () => {}, () => '', 'Closures that are decided differently');
    table.set(names.map((_, row) => row));
    this.result.append(el('h3', {}, `Closures that are decided differently: ${names.length} of ${this.own.decisions!.size}`), names.length ? table.root : '');
  }
  /** Errors of all runs, where the truth is known to them. */
  private addErrors(robot: string) {
    const whose = robot ? ` of ${robot}` : '';
    const found: { name: string; color: string; errors: PathErrors }[] = [];
    [this.own, ...this.runs].forEach((run, i) => {
      const errors = run.errors.find(e => e.robot === robot) ?? (run.errors.length === 1 ? run.errors[0] : undefined);
      if (errors) found.push({ name: run.name, color: i ? runColor(i - 1) : 'estimate', errors });
    });
    if (found.length < 2) return;
    const curves = (of: (e: PathErrors) => { x: number[]; values: (number | null)[] }) =>
        found.map(({ name, color, errors }) => ({ ...of(errors), style: { label: name, color } }));
    this.addPlot(`Error of position${whose} [m] over time [s]`, 'time', curves(e => ({ x: e.t, values: e.estimate })));
    this.addPlot(`Error of position${whose}, each aligned with the truth [m]`, 'time', curves(e => ({ x: e.t, values: e.aligned })));
    this.addPlot(`Error of the way between two poses${whose} [m], median`, 'way', curves(e => {
      const { way, median } = relativeErrors(e);
      return { x: way, values: median };
    }), 'Over the way driven between them [m].');
  }
}
