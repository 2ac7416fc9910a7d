// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

import { Id } from './data';

/** What is looked at; everything on the page follows it. */
export interface View {
  keyframe: number;
  landmark: Id | null;
  sighting: number | null;
  closure: number | null;
}

type Listener = (view: View, changed: Set<keyof View>) => void;

export class State {
  readonly view: View;
  private listeners: Listener[] = [];
  constructor(readonly last: number) {
    this.view = { keyframe: last, landmark: null, sighting: null, closure: null };
  }
  listen(listener: Listener) { this.listeners.push(listener); }
  set(change: Partial<View>) {
    const changed = new Set<keyof View>();
    for (const name of Object.keys(change) as (keyof View)[]) {
      let value = change[name] as any;
      if (name === 'keyframe') value = Math.max(0, Math.min(this.last, Math.round(value)));
      if (this.view[name] === value) continue;
      (this.view as any)[name] = value;
      changed.add(name);
    }
    if (changed.size > 0) for (const listener of this.listeners) listener(this.view, changed);
  }
}
