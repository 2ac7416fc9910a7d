// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

import { Data, GraphData, MapData, PathErrors, placesOf, robotsOf, unpack } from './data';

/** The path of a robot; times [s] from the first keyframe of the run that the page is about, or ids of the poses of a graph. */
export interface Track { robot: string; t: number[]; x: number[]; y: number[]; z: number[] }

/** What is compared of a run. */
export interface Run {
  name: string;
  tracks: Track[];
  landmarks: { at: number[]; class: string | null }[];
  errors: PathErrors[];
  summary: any;  // null where it is not known
  decisions?: Map<string, string>;  // about closures, by the ids of their poses
}

export type Compared = MapData | GraphData;

/** A stamp [s], where it is known. */
type Origin = number | null | undefined;

export interface NamedText { name: string; text: string }

/** The folder that its command names, or else its title. */
function nameOf(data: Compared): string {
  const words: string[] = data.summary.command ?? [];
  const at = words.findIndex(w => w === '-o' || w === '--output');
  return (at >= 0 && words[at + 1]) || data.title || 'run';
}

/** A run by the data of its page, with times from the stamp `origin` on. */
export function runOfPage(data: Compared, origin: Origin, name = nameOf(data)): Run {
  return data.kind === 'map' ? runOfMap(data, origin, name) : runOfGraph(data, name);
}

function runOfGraph({ ids, after, closures, landmarks, summary }: GraphData, name: string): Run {
  const decisions = new Map(closures.decision.map((d, e) => [`${ids[closures.i[e]]} ${ids[closures.j[e]]}`, d]));
  const track = { robot: '', t: ids.slice(0, after.x.length), x: after.x, y: after.y, z: after.z ?? after.x.map(() => 0) };
  return { name, tracks: [track], errors: [], summary, decisions,
    landmarks: landmarks.x.map((x, i) => ({ at: [x, landmarks.y[i], landmarks.z?.[i] ?? 0], class: null })) };
}

function runOfMap(data: MapData, origin: Origin, name: string): Run {
  const shift = (data.start ?? origin ?? 0) - (origin ?? data.start ?? 0);
  const { poses } = data;
  const tracks = robotsOf(data).map(robot => {
    const places = placesOf(data, robot, poses.x.length), own = (c: number[]) => places.map(i => c[i]);
    return { robot: data.robots.names[robot] ?? '', t: own(poses.t).map(t => t + shift), x: own(poses.x), y: own(poses.y),
      z: poses.z ? own(poses.z) : places.map(() => 0) };
  });
  return { name, tracks, summary: data.summary, errors: data.errors.map(e => ({ ...e, t: e.t.map(t => t + shift) })),
    landmarks: data.landmarks.map(l => ({ at: l.at, class: l.class === null ? null : data.classes[l.class] })) };
}

const kNames: Record<Data['kind'], string> = { map: 'a replay', graph: 'a pose graph', trials: 'an experiment' };

/** The data inside of a page report.html. */
export async function dataOfPage({ name, text }: NamedText, kind: Compared['kind']): Promise<Compared> {
  const packed = /<script[^>]*\bid="data"[^>]*>([^<]+)<\/script>/.exec(text)?.[1];
  if (!packed) throw new Error(`${name} is no report.html`);
  const data = await unpack(packed);
  if (data.kind !== kind) throw new Error(`${name} is the report of ${kNames[data.kind]}, and this page that of ${kNames[kind]}`);
  return data as Compared;
}

/** Rows of stamp, x, y, z and what follows, as in TUM's files. */
function trackOf({ name, text }: NamedText, origin: number): Track {
  const track: Track = { robot: '', t: [], x: [], y: [], z: [] };
  text.split('\n').forEach((line, i) => {
    if (!line.trim() || line.startsWith('#')) return;
    const row = line.trim().split(/[\s,]+/).map(Number);
    if (row.length < 4 || row.slice(0, 4).some(v => !Number.isFinite(v))) {
      throw new Error(`${name}, line ${i + 1}: a path has rows of time, x, y, z, qx, qy, qz, qw`);
    }
    track.t.push(row[0] - origin);
    track.x.push(row[1]);
    track.y.push(row[2]);
    track.z.push(row[3]);
  });
  return track;
}

const isJson = (file: NamedText) => file.name.endsWith('.json');

function contentOf({ name, text }: NamedText): any {
  try {
    return JSON.parse(text);
  } catch (error) {
    throw new Error(`${name} is no JSON: ${error instanceof Error ? error.message : error}`);
  }
}

/** A run by its files: a path in TUM's form, landmarks.json, summary.json. */
export function runOfFiles(files: NamedText[], origin: Origin): Run {
  const run: Run = { name: files.find(f => !isJson(f))?.name ?? files[0].name, tracks: [], landmarks: [], errors: [], summary: null };
  for (const file of files) {
    const content = isJson(file) ? contentOf(file) : null;
    if (content?.landmarks?.map) {
      run.landmarks = content.landmarks.map((l: any) => ({ at: l.position, class: l.class ?? null }));
    } else if (content) {
      run.summary = content;
    } else if (origin === undefined || origin === null) {
      throw new Error('this page is of a former version and does not know when its log begins; compare it with a report.html');
    } else {
      run.tracks.push(trackOf(file, origin));
    }
  }
  return run;
}

/** The runs in files that were chosen together: one for each page and each path; landmarks.json and summary.json are of the one path. */
export async function runsOf(files: File[], kind: Compared['kind'], origin: Origin): Promise<Run[]> {
  const texts = await Promise.all(files.map(async f => ({ name: f.name, text: await f.text() })));
  const isPage = (f: NamedText) => /\.html?$/.test(f.name), parts = texts.filter(f => !isPage(f));
  const runs = await Promise.all(texts.filter(isPage).map(async f => runOfPage(await dataOfPage(f, kind), origin)));
  const paths = parts.filter(f => !isJson(f));
  if (paths.length > 1 && paths.length < parts.length) throw new Error('several paths, and no way to tell of which the .json files are: choose them one after the other');
  const groups = paths.length > 1 ? paths.map(f => [f]) : parts.length ? [parts] : [];
  return [...runs, ...groups.map(files => runOfFiles(files, origin))];
}
