// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

import { el } from './dom';
import { themed } from './palette';
import { State } from './state';

export interface Mark { k: number; color: string }

/** The slider over the keyframes, with marks of what happened, and play. */
export class Timeline {
  readonly root: HTMLElement;
  private slider = el('input', { type: 'range', min: 0, step: 1, 'aria-label': 'Keyframe', id: 'keyframe' });
  private text = el('output', { for: 'keyframe', class: 'now' });
  private strip = el('canvas', { class: 'strip', 'aria-hidden': true });
  private button = el('button', { type: 'button', title: 'play (space)', 'aria-label': 'Play' }, '▶');
  private timer = 0;

  constructor(private state: State, private marks: Mark[], private describe: (k: number) => string) {
    this.slider.max = String(state.last);
    this.slider.addEventListener('input', () => {
      this.stop();
      state.set({ keyframe: Number(this.slider.value) });
    });
    this.button.addEventListener('click', () => this.toggle());
    const rail = el('div', { class: 'rail' }, this.strip, this.slider);
    this.root = el('div', { class: 'timeline' }, this.button, rail, this.text);
    new ResizeObserver(() => this.drawStrip()).observe(rail);
    state.listen((_, changed) => { if (changed.has('keyframe')) this.show(); });
    this.show();
  }

  private show() {
    const k = this.state.view.keyframe;
    this.slider.value = String(k);
    this.text.textContent = this.describe(k);
    this.slider.setAttribute('aria-valuetext', this.describe(k));
  }

  toggle() {
    if (this.timer) { this.stop(); return; }
    this.button.textContent = '❚❚';
    this.button.setAttribute('aria-label', 'Pause');
    const { last, view } = this.state;
    let at = view.keyframe >= last ? 0 : view.keyframe;
    let before = performance.now();
    const seconds = Math.min(30, Math.max(6, last / 25));
    const tick = (now: number) => {
      at += ((now - before) / 1000) * (last / seconds);
      before = now;
      this.state.set({ keyframe: Math.min(last, at) });
      if (at >= last) this.stop(); else this.timer = requestAnimationFrame(tick);
    };
    this.timer = requestAnimationFrame(tick);
  }
  private stop() {
    if (this.timer) cancelAnimationFrame(this.timer);
    this.timer = 0;
    this.button.textContent = '▶';
    this.button.setAttribute('aria-label', 'Play');
  }

  drawStrip() {
    const ratio = window.devicePixelRatio || 1;
    const w = this.strip.clientWidth, h = this.strip.clientHeight;
    this.strip.width = Math.round(w * ratio);
    this.strip.height = Math.round(h * ratio);
    const c = this.strip.getContext('2d')!;
    c.setTransform(ratio, 0, 0, ratio, 0, 0);
    const pad = 8;  // of the thumb of the slider
    for (const mark of this.marks) {
      c.fillStyle = themed(mark.color);
      c.fillRect(pad + ((w - 2 * pad) * mark.k) / Math.max(1, this.state.last), 0, 1.5, h);
    }
  }
}
