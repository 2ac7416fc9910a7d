// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

import { groupBy, Id, Landmark, MapData, Snapshot, snapshotOf } from './data';

/** What was known when: answers about a run that several parts of the page ask for. */
export class History {
  readonly landmarks = new Map<Id, Landmark>();
  readonly sightingsAt: Map<number, number[]>;
  readonly sightingsOf: Map<Id, number[]>;  // in the end
  readonly firstOf: Map<Id, number[]>;      // when they came
  readonly beliefsOf: Map<Id, number[]>;
  readonly decisionOf = new Map<number, [number, Id | null, boolean]>();
  readonly associationOf = new Map<number, number>();
  readonly standsFor: Map<Id, Id>;  // true id -> landmark
  readonly mergedInto = new Map<Id, [Id, number]>();
  private cache = new Map<number, Snapshot>();

  constructor(readonly data: MapData) {
    for (const l of data.landmarks) this.landmarks.set(l.id, l);
    const s = data.sightings;
    this.sightingsAt = groupBy(s.k);
    this.sightingsOf = groupBy(s.now);
    this.firstOf = groupBy(s.first);
    this.beliefsOf = groupBy(data.beliefs.id);
    for (const [k, sighting, landmark, revised] of data.decisions) {
      this.decisionOf.set(sighting, [k, landmark, revised === 1]);
    }
    data.associations.forEach((a, i) => a.sightings.forEach(n => this.associationOf.set(n, i)));
    for (const m of data.merges) {
      if (m.undone) continue;
      for (const [from, into] of m.pairs) this.mergedInto.set(from, [into, m.k]);
    }
    this.standsFor = this.matchTruth();
  }

  get last() { return this.data.poses.x.length - 1; }
  position(id: Id): number[] | undefined { return this.landmarks.get(id)?.at; }

  /** The estimate soon after a keyframe: of the next snapshot; null at the end, which is exact. */
  snapshot(keyframe: number): Snapshot | null {
    const list = this.data.snapshots.list;
    if (keyframe >= this.last || list.length === 0) return null;
    let low = 0, high = list.length - 1;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (list[middle].k >= keyframe) high = middle; else low = middle + 1;
    }
    if (list[low].k < keyframe) return null;
    if (!this.cache.has(low)) {
      if (this.cache.size > 40) this.cache.clear();
      this.cache.set(low, snapshotOf(this.data, low));
    }
    return this.cache.get(low)!;
  }
  /** How many poses apart those of a snapshot are. */
  every(keyframe: number): number {
    return this.data.snapshots.list.find(s => s.k >= keyframe)?.every ?? 1;
  }

  /** p(class) of a landmark by the news until a keyframe. */
  belief(id: Id, keyframe: number): number[] | null {
    const landmark = this.landmarks.get(id);
    if (keyframe >= this.last) return landmark && landmark.p.length ? landmark.p : null;
    const list = this.beliefsOf.get(id) ?? [];
    let p: number[] | null = null;
    for (const b of list) {
      if (this.data.beliefs.k[b] > keyframe) break;
      p = this.data.beliefs.p[b];
    }
    return p;
  }

  /** true id -> landmark that stands for it, one to one, those with most sightings first. */
  private matchTruth(): Map<Id, Id> {
    const counts = new Map<string, [Id, Id, number]>();
    const s = this.data.sightings;
    for (let i = 0; i < s.k.length; ++i) {
      const truth = s.true[i], now = s.now[i];
      if (truth === null || now === null) continue;
      const key = `${truth} ${now}`, entry = counts.get(key);
      if (entry) ++entry[2]; else counts.set(key, [truth, now, 1]);
    }
    const out = new Map<Id, Id>(), used = new Set<Id>();
    for (const [truth, now] of [...counts.values()].sort((a, b) => b[2] - a[2])) {
      if (out.has(truth) || used.has(now)) continue;
      out.set(truth, now);
      used.add(now);
    }
    return out;
  }
  /** Whether a sighting belongs to the wrong landmark; null: nobody knows. */
  wrong(sighting: number): boolean | null {
    const truth = this.data.sightings.true[sighting];
    if (truth === null || this.standsFor.size === 0) return null;
    return this.standsFor.get(truth) !== this.data.sightings.now[sighting];
  }
}

export function mostProbable(p: number[]): number {
  let best = 0;
  for (let i = 1; i < p.length; ++i) if (p[i] > p[best]) best = i;
  return best;
}
