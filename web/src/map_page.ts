// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

import { aboutView } from './about_view';
import { AssociationView } from './association_view';
import { Bends } from './bends';
import { CompareView } from './compare_view';
import { hasLandmarks, keyframeAt, MapData, Path, placesOf, robotAt, robotsOf } from './data';
import { el, show } from './dom';
import { ErrorView } from './error_view';
import { isTyping, Tab, Tabs, theme } from './frame';
import { chiSquareShares, shares } from './histogram';
import { healthView } from './health_view';
import { History } from './history';
import { LandmarkView } from './landmark_view';
import { MapView } from './map_view';
import { MergeView } from './merge_view';
import { OrbitView, spaceSwitch, Strand } from './orbit';
import { ScanClosureView } from './scan_closure_view';
import { ScanLayer } from './scan_layer';
import { SolverView } from './solver_view';
import { State } from './state';
import { robotColor } from './palette';
import { Mark, Timeline } from './timeline';

/** The report of a replay; gives the view that takes other runs. */
export function mapPage(data: MapData): CompareView {
  const history = new History(data);
  const state = new State(history.last);
  const view = new MapView(data, history, state);
  const associations = new AssociationView(data, history, state);
  const landmark = new LandmarkView(data, history, state, i => {
    tabs.openNamed('Why');
    associations.explain(i);
  });
  const solver = new SolverView(data, state);
  const errors = new ErrorView(data, state);
  const orbit = data.dimension === 3 ? inSpace(data, view.scans) : null;
  const compare = new CompareView(data, view.compare, added => {
    view.measure();
    orbit?.setOthers(view.compare.strands());
    if (added) tabs.openNamed('Compare');
  }, time => state.set({ keyframe: keyframeAt(data, time) }));
  const list: Tab[] = [
    { name: 'Health', root: healthView(data.summary.health, data.summary.noise) },
    ...(hasLandmarks(data) ? [{ name: 'Landmark', root: landmark.root },
      { name: 'Why', root: associations.root, shown: () => associations.shown() }] : []),
    ...(hasLandmarks(data) || data.scan_closures.i.length ? [{ name: 'Closures', root: closures(data, state) }] : []), { name: 'Solver', root: solver.root },
    { name: 'Errors', root: errors.root }, { name: 'Compare', root: compare.root }, { name: 'About', root: aboutView(data.summary) },
  ];
  const tabs = new Tabs(list);
  const timeline = new Timeline(state, marks(data), k => describe(data, history, k));
  const restyle = () => {
    for (const part of [view, landmark, solver, errors, compare, orbit]) part?.restyle();
    timeline.drawStrip();
  };
  const search = searchBox(data, history, state, tabs);
  const header = el('header', {}, el('h1', {}, data.title || 'Replay'), el('span', { class: 'quiet head-line' }, headline(data)),
      search, theme(restyle));
  if (orbit) {
    view.map.root.append(orbit.root);
    view.root.querySelector('.bar')!.prepend(spaceSwitch(orbit));
  }
  const message = data.summary.message ?? '';
  if (message) {
    view.root.prepend(el('p', { class: 'banner', role: 'status' }, el('strong', {}, `${data.summary.status}: `), message));
  }
  const stage = el('main', {}, view.root);
  document.body.append(el('div', { class: 'page' }, header, stage, tabs.root, timeline.root));
  state.listen((now, changed) => {
    if (changed.has('landmark') && now.landmark !== null && now.sighting === null) tabs.openNamed('Landmark');
    if (changed.has('keyframe') && orbit && data.poses.z) {
      orbit.mark(data.poses.x[now.keyframe], data.poses.y[now.keyframe], data.poses.z[now.keyframe]);
    }
  });
  document.addEventListener('keydown', e => keys(e, data, state, view, timeline, tabs, search));
  (window as any).report = { data, history, state, view, compare, histogram: { shares, chiSquareShares } };  // for those who look with the console
  return compare;
}

/** Closures by landmarks, and by scans. */
function closures(data: MapData, state: State): HTMLElement {
  const merges = new MergeView(data, state).root;
  if (!data.scan_closures.i.length) return merges;
  const scans = new ScanClosureView(data, state).root;
  return el('div', { class: 'pane' }, scans, data.merges.length ? merges : null);
}

function headline(data: MapData): string {
  const { summary } = data, truth = summary.truth?.trajectory;
  const robots = data.robots.names.length > 1 ? `${data.robots.names.length} robots, ` : '';
  return `${robots}${summary.keyframes} keyframes` + (hasLandmarks(data) ? `, ${summary.landmarks} landmarks` : '') +
      (truth ? `, path rmse ${show(truth.rmse_m)} m` : '') + (summary.status === 'ok' ? '' : `, ${summary.status}`);
}

function describe(data: MapData, history: History, k: number): string {
  const s = history.snapshot(k);
  const when = `${show(data.poses.t[k])} s`;
  const whose = data.robots.names.length > 1 ? ` of ${data.robots.names[robotAt(data, k)]}` : '';
  return `keyframe ${k} of ${history.last}${whose}, ${when}` + (s && s.k !== k ? `; map after ${s.k}` : '');
}

/** What happened when. */
function marks(data: MapData): Mark[] {
  const out: Mark[] = [];
  data.scan_closures.j.forEach((k, e) => { if (data.scan_closures.decision[e] === 'accepted') out.push({ k, color: 'loop' }); });
  for (const m of data.merges) out.push({ k: m.k, color: m.loop ? 'loop' : 'merge' });
  data.changes.flips.forEach((f, i) => { if (f.length) out.push({ k: data.changes.k[i], color: 'flip' }); });
  return out.reverse();
}

function searchBox(data: MapData, history: History, state: State, tabs: Tabs): HTMLInputElement {
  const box = el('input', { type: 'search', placeholder: hasLandmarks(data) ? 'landmark, or k120' : 'k120',
    'aria-label': 'Search a landmark or a keyframe', id: 'search' });
  const known = new Set([...history.landmarks.keys(), ...data.lives.map(l => l[1])]);
  const seek = () => {
    const text = box.value.trim().toLowerCase();
    const keyframe = /^k\s*(\d+)$/.exec(text), id = /^l?\s*(\d+)$/.exec(text);
    if (keyframe) state.set({ keyframe: Number(keyframe[1]) });
    const found = id && known.has(Number(id[1]));
    if (found) {
      state.set({ landmark: Number(id[1]), sighting: null });
      tabs.openNamed('Landmark');
    }
    box.setAttribute('aria-invalid', String(text !== '' && !keyframe && !found));
  };
  box.addEventListener('change', seek);
  box.addEventListener('keydown', e => {
    if (e.key === 'Enter') seek();
    if (e.key === 'Escape') box.blur();
    e.stopPropagation();
  });
  return box;
}

function inSpace(data: MapData, scans: ScanLayer): OrbitView {
  const { poses, reckoned, truth, landmarks } = data;
  const known = (axis: (number | null)[]) => axis.filter(v => v !== null) as number[];
  const columns = (c: Path) => [known(c.x), known(c.y), c.z ? known(c.z) : known(c.x).map(() => 0)];
  const estimate = new Bends(data.curves, poses), byOdometry = new Bends(data.reckoned_curves, reckoned);
  const own = (bends: Bends, axes: number[][], robot: number) => bends.through(placesOf(data, robot, axes[0].length), axes, robot);
  const strands: Strand[] = [
    ...robotsOf(data).flatMap((robot): Strand[] => [
      { label: data.robots.names[robot] ?? 'estimate', points: own(estimate, columns(poses), robot), color: robot ? robotColor(robot) : 'estimate', mode: 'line' },
      { label: 'dead reckoning', points: own(byOdometry, columns(reckoned), robot), color: 'odometry', mode: 'line', alpha: 0.8 }]),
  ];
  if (landmarks.length) strands.push({ label: 'landmarks', points: [0, 1, 2].map(d => landmarks.map(l => l.at[d] ?? 0)), color: 'merge', mode: 'points' });
  if (truth.path.x.length) strands.splice(2, 0, { label: 'truth', points: columns(truth.path), color: 'truth', mode: 'line' });
  const walls = scans.inSpace(), closures = data.scan_closures;
  if (walls[0].length) strands.push({ label: 'walls', points: walls, color: 'wall', mode: 'points', alpha: 0.7, size: 1.5 });
  const accepted = closures.i.map((_, e) => e).filter(e => closures.decision[e] === 'accepted');
  if (accepted.length && poses.z) {
    const ends = accepted.flatMap(e => [closures.i[e], closures.j[e]]), axes = columns(poses);
    strands.push({ label: 'closures accepted', points: axes.map(axis => ends.map(k => axis[k])), color: 'accepted', mode: 'segments' });
  }
  return new OrbitView(strands);
}

function keys(e: KeyboardEvent, data: MapData, state: State, view: MapView, timeline: Timeline, tabs: Tabs, search: HTMLInputElement) {
  if (isTyping(e) || e.ctrlKey || e.metaKey || e.altKey) return;
  const k = state.view.keyframe, step = e.shiftKey ? 10 : 1;
  const landmark = (by: number) => {
    const ids = data.landmarks.map(l => l.id);
    if (!ids.length) return;
    const at = ids.indexOf(state.view.landmark ?? NaN);
    state.set({ landmark: ids[at < 0 ? 0 : (at + by + ids.length) % ids.length], sighting: null });
  };
  const actions: Record<string, () => void> = {
    ArrowRight: () => state.set({ keyframe: k + step }), ArrowLeft: () => state.set({ keyframe: k - step }),
    Home: () => state.set({ keyframe: 0 }), End: () => state.set({ keyframe: state.last }),
    ' ': () => timeline.toggle(), '+': () => view.map.zoomBy(1.5), '=': () => view.map.zoomBy(1.5),
    '-': () => view.map.zoomBy(1 / 1.5), f: () => view.map.fit(), n: () => landmark(1), p: () => landmark(-1),
    '/': () => search.focus(), d: () => document.getElementById('theme')!.click(),
    Escape: () => state.set({ landmark: null, sighting: null, closure: null }),
  };
  for (let i = 1; i <= 8; ++i) actions[String(i)] = () => tabs.open(i - 1);
  const action = actions[e.key];
  if (!action || (e.key === ' ' && e.target instanceof HTMLButtonElement)) return;
  e.preventDefault();
  action();
}
