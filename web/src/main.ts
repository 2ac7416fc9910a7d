// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

import { load, unpack } from './data';
import { el } from './dom';
import { graphPage } from './graph_page';
import { mapPage } from './map_page';
import { runOfPage } from './other_run';
import { trialsPage } from './trials_page';

async function main() {
  const waiting = document.getElementById('waiting')!;
  try {
    const data = await load();
    waiting.remove();
    document.title = data.title || document.title;
    if (data.kind === 'map') {
      const compare = mapPage(data);
      for (const script of document.querySelectorAll<HTMLElement>('script.other')) {
        const other = await unpack(script.textContent!);
        if (other.kind === 'map') compare.add(runOfPage(other, data.start, script.dataset.name));
      }
    } else if (data.kind === 'graph') graphPage(data);
    else trialsPage(data);
    document.body.dataset.ready = 'yes';
  } catch (error) {
    waiting.replaceChildren(el('p', { class: 'bad' }, `This page cannot be shown: ${error}`));
    throw error;
  }
}

void main();
