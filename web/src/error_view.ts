// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

import { keyframeAt, MapData, PathErrors } from './data';
import { el, facts, percent, show } from './dom';
import { chiSquareShares, histogramPlot } from './histogram';
import { robotColor } from './palette';
import { Plot, Series } from './plots';
import { relativeErrors } from './relative_error';
import { State } from './state';

/** Errors against the truth. */
export class ErrorView {
  readonly root = el('div', { class: 'pane' });
  private plots: Plot[] = [];
  private overTime: Plot[] = [];

  constructor(private data: MapData, private state: State) {
    const truth = data.summary.truth;
    if (!truth) {
      this.root.append(el('p', { class: 'hint' }, 'No truth is known for this log.'));
      this.addSightings();
      return;
    }
    const rows: [string, string][] = [];
    const path = truth.trajectory;
    if (path) {
      rows.push(['path, rmse', `${show(path.rmse_m)} m (${show(path.aligned?.rmse_m)} m aligned)`]);
      rows.push(['path, greatest', `${show(path.max_m)} m (${show(path.aligned?.max_m)} m aligned)`]);
    }
    if (truth.dead_reckoning) rows.push(['dead reckoning, rmse', `${show(truth.dead_reckoning.rmse_m)} m`]);
    for (const robot of data.errors.length > 1 ? data.summary.robots : []) {
      const own = robot.truth?.trajectory;
      if (own) rows.push([`path of ${robot.name}, rmse`, `${show(own.rmse_m)} m (${show(own.aligned?.rmse_m)} m aligned)`]);
    }
    if (truth.landmarks) {
      rows.push(['landmarks', `${truth.landmarks.matched} right, ${truth.landmarks.spurious} spurious, ${truth.landmarks.missed} missed`]);
      rows.push(['landmarks, mean error', `${show(truth.landmarks.mean_m)} m`]);
    }
    if (truth.class_accuracy !== undefined) rows.push(['classes right', percent(truth.class_accuracy)]);
    if (truth.association_accuracy !== undefined) rows.push(['associations right', percent(truth.association_accuracy)]);
    if (truth.nees_pose !== undefined) rows.push(['NEES of poses (1 is consistent)', show(truth.nees_pose)]);
    if (truth.nees_landmark !== undefined) rows.push(['NEES of landmarks (1 is consistent)', show(truth.nees_landmark)]);
    this.root.append(facts(rows));
    this.addSightings();
    if (!data.errors.length) return;
    const add = (title: string, t: number[], series: Series[], log = false) => {
      const plot = new Plot(title, 'time', t, series,
          { log, height: 200, press: time => this.state.set({ keyframe: keyframeAt(data, time) }) });
      this.plots.push(plot);
      this.overTime.push(plot);
      this.root.append(plot.root);
    };
    if (data.errors.length > 1) {
      this.addRobots(data.errors, add);
    } else {
      const { t, estimate, aligned, reckoned } = data.errors[0];
      for (const log of [false, true]) {
        add(log ? 'The same, logarithmic' : 'Error of position [m] over time [s]', t, [
          { label: 'estimate', values: estimate, color: 'estimate' },
          { label: 'estimate, aligned', values: aligned, color: 'truth', dash: [6, 3] },
          { label: 'dead reckoning', values: reckoned, color: 'odometry', dash: [2, 3] }], log);
      }
    }
    for (const errors of data.errors) this.addRelative(errors);
    state.listen((view, changed) => {
      if (changed.has('keyframe')) for (const plot of this.overTime) plot.mark(this.data.poses.t[view.keyframe]);
    });
  }
  /** How the error grows with the way between two poses. */
  private addRelative(errors: PathErrors) {
    const { way, median, most } = relativeErrors(errors);
    if (way.length < 2) return;
    const whose = this.data.errors.length > 1 ? ` of ${errors.robot}` : '';
    const plot = new Plot(`Error of the way between two poses${whose} [m] over the way driven between them [m]`, 'way', way, [
      { label: 'median', values: median, color: 'estimate', points: true },
      { label: '95 % stay below', values: most, color: 'odometry', dash: [3, 3] }],
      { height: 180, note: 'In the frame of the truth. What stays small over short ways and grows over long ones is drift; what is large over short ways is noise, or a jump.' });
    this.plots.push(plot);
    this.root.append(plot.root);
  }
  /** A curve for each robot, over the times of all. */
  private addRobots(all: PathErrors[], add: (title: string, t: number[], series: Series[], log?: boolean) => void) {
    const t = [...new Set(all.flatMap(e => e.t))].sort((a, b) => a - b);
    const place = new Map(t.map((time, i) => [time, i]));
    const series = (of: 'estimate' | 'aligned' | 'reckoned'): Series[] => all.map(errors => {
      const values: (number | null)[] = t.map(() => null);
      errors.t.forEach((time, i) => values[place.get(time)!] = errors[of][i] ?? null);
      return { label: errors.robot, values, color: robotColor(this.data.robots.names.indexOf(errors.robot)), gaps: true };
    });
    add('Error of position [m] over time [s]', t, series('estimate'));
    add('The same, logarithmic', t, series('estimate'), true);
    add('After the best rigid motion of all paths onto the truth', t, series('aligned'));
    add('By dead reckoning', t, series('reckoned'));
  }
  /** How far sightings are from where they were expected: of those accepted, since a gate cuts the others. */
  private addSightings() {
    const { nis, chi } = this.data.sightings, width = 0.5, bins = 24;
    const some = (values: (number | null)[]) => values.some(v => v !== null);
    const groups = [{ label: 'when it came (NIS)', color: 'estimate', values: nis },
      { label: 'at the end (chi-square)', color: 'odometry', values: chi, dash: [3, 3] }].filter(g => some(g.values));
    if (!groups.length) return;
    const freedom = this.data.dimension === 3 ? 3 : 2;
    const plot = histogramPlot('Shares of the sightings by squared sigmas', 'squared sigmas', width, bins, groups,
        [{ label: `expected (${freedom} numbers each)`, color: 'truth', dash: [6, 3], values: chiSquareShares(freedom, width, bins) }],
        'The last bin has all beyond. Only accepted sightings are here: a gate cuts what is too far, so that noise stated too small hardly shows; what misfits becomes copies, movers and clutter instead, which the tab Health counts. More to the left than expected is usual.');
    this.plots.unshift(plot);
    this.root.append(plot.root);
  }
  restyle() { for (const plot of this.plots) plot.restyle(); }
}
