// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// How fast a page with many sightings opens and pans: node test/many_sightings.mjs [SIGHTINGS]. The world is made up.

import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { gzipSync } from 'node:zlib';
import { closeBrowser, withPage } from './browser.mjs';

const count = Number(process.argv[2] ?? 100000), landmarks = 2000, keyframes = count / 10;
let seed = 1;
const random = () => (seed = (seed * 48271) % 2147483647) / 2147483647;
const round = (v, d = 4) => Number(v.toFixed(d));
const angle = k => (2 * Math.PI * k) / 2000, radius = k => 100 + k / 100;
const columns = of => Array.from({ length: keyframes }, (_, k) => round(of(k)));
const poses = { t: columns(k => k / 2), x: columns(k => radius(k) * Math.cos(angle(k))), y: columns(k => radius(k) * Math.sin(angle(k))), yaw: columns(k => angle(k) + 1.57) };
const marks = Array.from({ length: landmarks }, (_, id) => ({ id, at: [round(400 * random() - 200), round(400 * random() - 200)], covariance: [0.01, 0, 0.02], class: id % 4, p: [0.25, 0.25, 0.25, 0.25], sightings: count / landmarks }));
const each = of => Array.from({ length: count }, (_, i) => of(i));
const id = i => (i * 7919) % landmarks;
const sightings = { k: each(i => Math.floor(i / 10)), sensor: each(() => 0), sensors: ['laser'], names: [['a', 'b', 'c', 'd']], range: each(() => round(30 * random(), 3)), yaw: each(() => round(6 * random() - 3)), first: each(id), now: each(id), nis: each(() => round(5 * random())), chi: each(() => round(5 * random())), dr: each(() => round(random())), dyaw: each(() => round(random())), id: each(() => null), true: each(id), moving: each(() => 0), scores: each(() => [0.7, 0.1, 0.1, 0.1]), candidates: each(i => [[id(i), round(random()), round(9 * random()), 0.5], [id(i + 1), 40, null, -0.5]]) };
const step = columns(() => random());
const data = { schema: 1, kind: 'map', title: `${count} sightings`, dimension: 2, classes: ['a', 'b', 'c', 'd'], poses, reckoned: poses, landmarks: marks,
  truth: { path: { x: poses.x, y: poses.y }, landmarks: [] }, steps: { solver_ms: step, plugin_ms: step, objective: step, cost: step, flips: step, rounds: step, landmarks: step, relinearized: step },
  robots: { names: [], of: [] }, errors: [{ robot: '', t: poses.t, estimate: step, aligned: step, reckoned: step }], modes: { names: [], of: [] }, summary: { status: 'ok', keyframes, landmarks },
  sightings, associations: [], decisions: [], merges: [], changes: { k: columns(k => k), objectives: step.map(v => [v + 1, v]), flips: step.map(() => []), refusals: [] },
  beliefs: { k: sightings.k, id: sightings.now, p: each(() => [0.7, 0.1, 0.1, 0.1]) }, lives: marks.map(m => [0, m.id, 1]), snapshots: { origin: [0, 0], unit: 1, list: [] },
  photographs: { list: [], every: 1, unreadable: 0 }, scans: { unit: 1, list: [] },
  scan_closures: { i: [], j: [], decision: [], probability: [], residual: [], redundancy: [], checkable: [], margin: [], inliers: [], modes: [] } };

const folder = mkdtempSync(join(tmpdir(), 'hybrid-'));
const file = join(folder, 'report.html');
const template = readFileSync(join(dirname(fileURLToPath(import.meta.url)), '../report_template.html'), 'utf8');
const packed = gzipSync(JSON.stringify(data), { level: 9 }).toString('base64');
writeFileSync(file, template.replace('<!-- data -->', () => packed));
await withPage(file, { viewport: { width: 1400, height: 900 } }, async (page, faults, seconds) => {
  const frames = await page.evaluate(() => new Promise(done => {
    const map = window.report.view.map, start = performance.now();
    const times = [];
    let n = 0, before = start;
    const frame = now => {
      times.push(now - before);
      before = now;
      map.panBy(12 * Math.cos(n / 50), 12 * Math.sin(n / 50));  // a circle of 1200 pixels
      ++n;
      if (now - start < 5000) requestAnimationFrame(frame); else done(times.sort((a, b) => a - b));
    };
    requestAnimationFrame(frame);
  }));
  console.log(`${count} sightings, ${(packed.length / 1e6).toFixed(1)} MB: open after ${seconds.toFixed(2)} s, a frame of panning takes ${frames[Math.floor(frames.length / 2)].toFixed(0)} ms (median), ${frames[Math.floor(0.95 * frames.length)].toFixed(0)} ms (95 %), ${frames[frames.length - 1].toFixed(0)} ms (longest), ${(frames.length / 5).toFixed(0)} frames a second`, ...faults);
});
await closeBrowser();
rmSync(folder, { recursive: true });
