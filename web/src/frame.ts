// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

import { el } from './dom';

export interface Tab { name: string; root: HTMLElement; shown?: () => void }

/** Panes behind tabs; keys 1 .. 9 choose. Arrows step time wherever the focus is, so the tab key goes through them. */
export class Tabs {
  readonly root: HTMLElement;
  private bar = el('div', { class: 'tabs', role: 'tablist' });
  private panes = el('div', { class: 'panes' });
  private buttons: HTMLButtonElement[] = [];

  constructor(private tabs: Tab[]) {
    tabs.forEach((tab, i) => {
      const button = el('button', { type: 'button', role: 'tab', id: `tab-${i}`, 'aria-controls': `pane-${i}`,
        title: `key ${i + 1}`, click: () => this.open(i) }, tab.name);
      this.buttons.push(button);
      this.bar.append(button);
      tab.root.id = `pane-${i}`;
      tab.root.setAttribute('role', 'tabpanel');
      tab.root.setAttribute('aria-labelledby', `tab-${i}`);
      this.panes.append(tab.root);
    });
    this.root = el('aside', { class: 'side' }, this.bar, this.panes);
    this.open(0);
  }
  open(index: number) {
    if (index < 0 || index >= this.tabs.length) return;
    this.tabs.forEach((tab, i) => { tab.root.hidden = i !== index; });
    this.buttons.forEach((button, i) => {
      button.setAttribute('aria-selected', String(i === index));
    });
    this.tabs[index].shown?.();
  }
  openNamed(name: string) { this.open(this.tabs.findIndex(t => t.name === name)); }
}

/** Dark or light: as the system says, until a choice is made. */
export function theme(changed: () => void): HTMLButtonElement {
  const system = matchMedia('(prefers-color-scheme: dark)');
  const root = document.documentElement;
  let chosen = false;
  const button = el('button', { type: 'button', class: 'small', title: 'dark or light (d)', 'aria-label': 'Dark or light', id: 'theme' });
  const set = (dark: boolean) => {
    root.dataset.theme = dark ? 'dark' : 'light';
    button.textContent = dark ? '☀' : '☾';
    changed();
  };
  button.addEventListener('click', () => {
    chosen = true;
    set(root.dataset.theme !== 'dark');
  });
  system.addEventListener('change', e => { if (!chosen) set(e.matches); });
  set(system.matches);
  return button;
}

/** Whether a key is meant for what has the focus. */
export const isTyping = (e: KeyboardEvent) => {
  const target = e.target as HTMLElement;
  return target instanceof HTMLSelectElement ||
      (target instanceof HTMLInputElement && !['range', 'checkbox'].includes(target.type));
};
