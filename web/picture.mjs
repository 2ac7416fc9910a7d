// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// The picture of the documentation: node picture.mjs REPORT.html PICTURE.png [KEYFRAME LANDMARK]

import { closeBrowser, withPage } from './test/browser.mjs';

const [report, picture, keyframe, landmark] = process.argv.slice(2);
await withPage(report, { viewport: { width: 1280, height: 800 }, colorScheme: 'light' }, async page => {
  await page.evaluate(([k, id]) => {
    if (k !== undefined) window.report.state.set({ keyframe: Number(k) });
    if (id !== undefined) window.report.state.set({ landmark: Number(id) });
  }, [keyframe, landmark]);
  await page.waitForTimeout(1000);
  await page.screenshot({ path: picture });
});
await closeBrowser();
