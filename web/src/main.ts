// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

import { load, unpack } from './data';
import { el } from './dom';
import { graphPage } from './graph_page';
import { mapPage } from './map_page';
import { trialsPage } from './trials_page';

async function main() {
  const waiting = document.getElementById('waiting')!;
  try {
    const data = await load();
    waiting.remove();
    document.title = data.title || document.title;
    const compare = data.kind === 'map' ? mapPage(data) : data.kind === 'graph' ? graphPage(data) : trialsPage(data);
    for (const script of document.querySelectorAll<HTMLElement>('script.other')) {
      const other = await unpack(script.textContent!);
      if (other.kind === data.kind && other.kind !== 'trials') compare?.addData(other, script.dataset.name);
    }
    document.body.dataset.ready = 'yes';
  } catch (error) {
    waiting.replaceChildren(el('p', { class: 'bad' }, `This page cannot be shown: ${error}`));
    throw error;
  }
}

void main();
