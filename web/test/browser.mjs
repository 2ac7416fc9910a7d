// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// A page in Debian's chromium, which fails on any request and any word on the console.

import { existsSync } from 'node:fs';
import { chromium } from 'playwright-core';

export const kBrowser = '/usr/bin/chromium';
export const hasBrowser = () => existsSync(kBrowser);

let launched = null;

/** The browser of this process, which is started once: each page has a context of its own in it. */
function browser() {
  launched ??= chromium.launch({
    executablePath: kBrowser,
    headless: true,
    args: ['--no-sandbox', '--disable-gpu', '--disable-background-networking', '--enable-unsafe-swiftshader'],
  });
  return launched;
}

/** Ends the browser, which otherwise keeps the process alive. */
export async function closeBrowser() {
  await (await launched)?.close();
  launched = null;
}

/** Runs use(page, faults) on a file; faults fill up with what must not happen. */
export async function withPage(file, options, use) {
  const context = await (await browser()).newContext({ deviceScaleFactor: 1, ...options });
  try {
    const page = await context.newPage();
    const faults = [];
    page.on('console', message => {
      // What the driver of software rendering says of itself is not the page's.
      if (!/GPU stall due to ReadPixels|GL Driver Message/.test(message.text())) faults.push(`console: ${message.text()}`);
    });
    page.on('pageerror', error => faults.push(`error: ${error}`));
    page.on('request', request => {
      if (!request.url().startsWith('file://') && !request.url().startsWith('data:')) faults.push(`request: ${request.url()}`);
    });
    const start = performance.now();
    await page.goto(`file://${file}`);
    await page.waitForSelector('body[data-ready=yes]', { timeout: 60000 });
    await use(page, faults, (performance.now() - start) / 1000);
  } finally {
    await context.close();
  }
}
