// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// The data of a page, as mrpt_plugins/report writes them.

export type Id = number;
type Num = number | null;

export interface Coordinates { x: number[]; y: number[]; z?: number[] }
/** null: a gap. */
export interface Path { x: Num[]; y: Num[]; z?: Num[] }
/** What is drawn between keyframes: n points to each, from the one before of its robot; and of each robot after its last one. */
export interface Curves extends Coordinates { n: number[]; after: Coordinates[] }
export interface Poses extends Coordinates { t: number[]; yaw: number[]; pitch?: number[]; roll?: number[] }

export interface Landmark {
  id: Id;
  at: number[];
  covariance: Num[];  // xx, xy, yy, then xz, yz, zz
  class: number | null;
  p: number[];
  sightings: number;
  extent?: number;  // how far from it the things that it stands for are, a standard deviation [m]; 0 if missing
  things?: number;  // that it stands for; 1 if missing
}

/** [landmark, NIS, log odds (null: not admitted), log odds of the class]. */
export type Candidate = [Id, Num, Num, Num];

/** Columns: what detection s was is at place s of each. */
export interface Sightings {
  k: number[];
  sensor: number[];
  sensors: string[];
  names: string[][];  // of the classes of each sensor, for the scores
  range: number[];
  yaw: number[];
  first: (Id | null)[];
  now: (Id | null)[];
  nis: Num[];
  chi: Num[];
  dr: Num[];
  dyaw: Num[];
  id: (Id | null)[];
  true: (Id | null)[];
  moving: number[];
  scores: number[][];
  candidates: Candidate[][];
}

export interface Association {
  k: number;
  sightings: number[];
  open: boolean;
  hypotheses: [(Id | null)[], Num][];
}

export interface Merge {
  k: number;
  pairs: [Id, Id][];
  loop: boolean;
  undone: boolean;
  evidence: Num;
  chi_square: Num;
  allowed_rise: Num;
}

export type FlipEntry = [string, number, number, number];

export interface Changes {
  k: number[];
  objectives: number[][];
  flips: FlipEntry[][];
  refusals: [number, string][];
}

export interface RawSnapshot {
  k: number;
  every: number;
  path: number[][];
  ids: number[];
  landmarks: number[][];
}

/** What a camera saw at a keyframe, in base 64; T is the 3x4 pose of the camera on the robot, in rows. */
export interface Photograph {
  k: number;
  sensor: string;
  size: [number, number];  // pixels
  camera: { f: [number, number]; c: [number, number]; T: number[] } | null;
  jpeg: string;
}
/** What lasers saw at a keyframe, or clouds from it on, in the frame of the robot, of clouds without tilt: whole multiples of a unit,
 * each less the one before. */
export interface KeyframeScan { k: number; x: number[]; y: number[]; z?: number[] }
/** Closures by scans, as columns; i and j are keyframes. */
export interface ScanClosures {
  i: number[]; j: number[]; decision: string[]; probability: Num[]; residual: Num[]; redundancy: Num[];
  checkable: number[]; margin: Num[]; inliers: Num[]; modes: number[];
}
/** Fixes of satellite receivers, as columns: keyframe, where they are and where the map says that the antenna is; mode 0: good,
 * 1: biased, 2: false, 3: not in the map; probabilities of the first three, where they are known. */
export interface Fixes {
  k: number[]; x: number[]; y: number[]; ax: number[]; ay: number[]; mode: number[]; p: number[][];
  counts: number[];  // of the modes, before any were left out
}
/** Errors of the positions of a robot over time. */
export interface PathErrors {
  robot: string; t: number[]; estimate: number[]; aligned: number[]; reckoned: number[];
  off: [number, number, number][];  // the error after alignment [m]
  way: number[];  // that was driven [m]
}

export interface MapData {
  kind: 'map';
  title: string;
  start?: number | null;  // the stamp of the first keyframe [s]; pages of former versions have none
  dimension: number;
  classes: string[];
  robots: { names: string[]; of: number[] };  // of each pose; no names where there is but one
  poses: Poses;
  reckoned: Poses;
  curves?: Curves;  // of both; none where they are straight between keyframes
  reckoned_curves?: Curves;
  landmarks: Landmark[];
  truth: { path: Path; landmarks: { id: Id; at: number[]; class: number | null }[] };
  steps: Record<string, number[]>;
  errors: PathErrors[];
  modes: { names: string[]; of: number[] };
  summary: any;
  sightings: Sightings;
  associations: Association[];
  decisions: [number, number, Id | null, number][];
  merges: Merge[];
  changes: Changes;
  beliefs: { k: number[]; id: Id[]; p: number[][] };
  lives: [number, Id, number][];
  snapshots: { origin: number[]; unit: number; list: RawSnapshot[] };
  /** One of `every` photographs of the log; `unreadable` of them could not be shown. */
  scans: { unit: number; list: KeyframeScan[] };
  scan_closures: ScanClosures;
  fixes?: Fixes;  // pages of former versions have none
  photographs: { list: Photograph[]; every: number; unreadable: number };
}

export interface GraphData {
  kind: 'graph';
  title: string;
  dimension: number;
  ids: number[];
  before: Coordinates;
  after: Coordinates;
  truth: Coordinates;
  edges: { i: number[]; j: number[] };  // of trusted measurements
  closures: {
    i: number[]; j: number[]; decision: string[]; probability: Num[]; residual: Num[];
    redundancy: Num[]; margin: Num[]; checkable: number[]; history: [number, string][][];
  };
  objectives: number[];
  steps: Record<string, number[]>;
  landmarks: Coordinates;
  summary: any;
}

export interface TrialsData {
  kind: 'trials';
  title: string;
  columns: string[];
  rows: (string | number | null)[][];
  summary: any;
}

export type Data = MapData | GraphData | TrialsData;

/** Unpacks what stands in this page. */
export const load = () => unpack(document.getElementById('data')!.textContent!);

/** Unpacks the data of a page. */
export async function unpack(text: string): Promise<Data> {
  const bytes = Uint8Array.from(atob(text.trim()), c => c.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream('gzip'));
  return JSON.parse(await new Response(stream).text());
}

/** The estimate after a keyframe. */
export interface Snapshot {
  k: number;
  path: Float64Array[];  // by axis
  places: Map<Id, number[]>;
}

/** Undoes the steps that a column is stored as. */
export function sums(steps: number[], origin: number, unit: number): Float64Array {
  const out = new Float64Array(steps.length);
  let sum = 0;
  for (let i = 0; i < steps.length; ++i) {
    sum += steps[i];
    out[i] = origin + unit * sum;
  }
  return out;
}

export function snapshotOf(data: MapData, index: number): Snapshot {
  const { origin, unit, list } = data.snapshots;
  const raw = list[index];
  const path = raw.path.map((axis, d) => sums(axis, origin[d], unit));
  const places = new Map<Id, number[]>();
  const columns = raw.landmarks.map((axis, d) => sums(axis, origin[d], unit));
  sums(raw.ids, 0, 1).forEach((id, i) => places.set(id, columns.map(c => c[i])));
  return { k: raw.k, path, places };
}

/** Whether a run had anything to do with landmarks: one of scans alone has not. */
export const hasLandmarks = (data: MapData) =>
    data.landmarks.length + data.lives.length + data.sightings.k.length + data.truth.landmarks.length > 0;

/** Of which robot a pose is. */
export const robotAt = (data: MapData, keyframe: number) => data.robots.of[keyframe] ?? 0;

/** The keyframe nearest to a time. */
export function keyframeAt(data: MapData, time: number): number {
  const { t } = data.poses;
  let best = 0;
  for (let i = 1; i < t.length; ++i) if (Math.abs(t[i] - time) < Math.abs(t[best] - time)) best = i;
  return best;
}

/** Numbers of the robots; one where they have no names. */
export const robotsOf = (data: MapData) => [...(data.robots.names.length ? data.robots.names : ['']).keys()];

/** The places of a column that are of one robot, where every n-th keyframe has one, the last one being keyframe `last`. */
export function placesOf(data: MapData, robot: number, length: number, every = 1, last = length - 1): number[] {
  const out: number[] = [];
  for (let i = 0; i < length; ++i) if (robotAt(data, Math.min(i * every, last)) === robot) out.push(i);
  return out;
}

/** Lists of numbers by an id. */
export function groupBy<K>(keys: ArrayLike<K | null>): Map<K, number[]> {
  const out = new Map<K, number[]>();
  for (let i = 0; i < keys.length; ++i) {
    const key = keys[i];
    if (key === null) continue;
    const list = out.get(key);
    if (list) list.push(i); else out.set(key, [i]);
  }
  return out;
}
