// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

import { Id, MapData, Photograph } from './data';
import { el } from './dom';
import { History } from './history';

/** The photograph that shows a landmark, with what it shows there: nearest in time to a sighting of it. */
export interface Shown { photograph: Photograph; sighting: number }

/** The photograph nearest to a keyframe; of several as near, the first. */
function nearest(list: Photograph[], keyframe: number): Photograph {
  return list.reduce((best, p) => (Math.abs(p.k - keyframe) < Math.abs(best.k - keyframe) ? p : best));
}

/** That of a sighting: the one asked for, or else the sighting nearest to the keyframe. */
export function shownOf(data: MapData, history: History, id: Id, keyframe: number, sighting: number | null): Shown | null {
  const list = history.sightingsOf.get(id) ?? [];
  if (!data.photographs.list.length || !list.length) return null;
  const { k } = data.sightings;
  const near = list.reduce((best, i) => (Math.abs(k[i] - keyframe) < Math.abs(k[best] - keyframe) ? i : best));
  const chosen = sighting !== null && list.includes(sighting) ? sighting : near;
  return { photograph: nearest(data.photographs.list, k[chosen]), sighting: chosen };
}

/** The inverse of a rigid motion, given by its rotation in rows and its translation. */
function toLocal(R: number[], t: number[], p: number[]): number[] {
  const d = p.map((v, i) => v - t[i]);
  return [0, 1, 2].map(j => R[j] * d[0] + R[3 + j] * d[1] + R[6 + j] * d[2]);
}

function rotation(yaw: number, pitch: number, roll: number): number[] {
  const [cy, sy, cp, sp, cr, sr] = [yaw, pitch, roll].flatMap(a => [Math.cos(a), Math.sin(a)]);
  return [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr, sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr,
    -sp, cp * sr, cp * cr];
}

/**
 * Where the estimate of a point of the map is in a photograph [pixels]; null behind the camera and where that is unknown. In the
 * plane, heights are unknown: the point is put at that of the camera. Distortion of the lens is left out.
 */
export function project(data: MapData, photograph: Photograph, at: number[]): [number, number] | null {
  const { camera, k } = photograph, { poses } = data;
  if (!camera) return null;
  const T = camera.T, R = [0, 1, 2, 4, 5, 6, 8, 9, 10].map(i => T[i]), t = [T[3], T[7], T[11]];
  const turn = rotation(poses.yaw[k], poses.pitch?.[k] ?? 0, poses.roll?.[k] ?? 0);
  const robot = toLocal(turn, [poses.x[k], poses.y[k], poses.z?.[k] ?? 0], [at[0], at[1], at[2] ?? 0]);
  if (at.length < 3) robot[2] = t[2];
  const [x, y, z] = toLocal(R, t, robot);
  return z > 0 ? [camera.c[0] + camera.f[0] * x / z, camera.c[1] + camera.f[1] * y / z] : null;
}

/** The picture, with a ring around the place of the landmark, or a line through it where its height is unknown. */
export function figureOf(data: MapData, shown: Shown, at: number[] | undefined, go: (k: number) => HTMLElement): HTMLElement {
  const { photograph, sighting } = shown, [width, height] = photograph.size;
  const place = at ? project(data, photograph, at) : null;
  const inside = place !== null && place[0] >= 0 && place[0] <= width && (at!.length < 3 || (place[1] >= 0 && place[1] <= height));
  const frame = el('div', { class: 'photograph', style: `aspect-ratio:${width}/${height}` },
      el('img', { src: `data:image/jpeg;base64,${photograph.jpeg}`, alt: `What ${photograph.sensor || 'the camera'} saw at keyframe ${photograph.k}` }));
  if (inside) {
    const flat = at!.length < 3;
    frame.append(el('span', { class: flat ? 'line' : 'ring', 'data-u': place![0].toFixed(1), 'data-v': place![1].toFixed(1),
      style: `left:${100 * place![0] / width}%` + (flat ? '' : `;top:${100 * place![1] / height}%`) }));
  }
  const k = data.sightings.k[sighting];
  const where = !photograph.camera ? 'the place of the camera is unknown' : !inside ? 'its estimate is outside of this picture'
      : `the ${at!.length < 3 ? 'line' : 'ring'} is where its estimate is seen`;
  return el('section', {}, el('h3', {}, 'Photograph'), frame, el('p', { class: 'quiet' },
      `${photograph.sensor || 'Camera'} at keyframe `, go(photograph.k), photograph.k === k ? ', a sighting' : ', the nearest to the sighting at ',
      photograph.k === k ? '' : go(k), `; ${where}.`));
}
