// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// Opens reports in a browser as a user would: node test/page_test.mjs BIN SCRATCH
// BIN has the programs, SCRATCH is an empty folder.

import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { readFileSync, statSync, writeFileSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { gunzipSync, gzipSync } from 'node:zlib';
import { closeBrowser, withPage } from './browser.mjs';

const [bin, scratch] = process.argv.slice(2);
const source = join(dirname(fileURLToPath(import.meta.url)), '../..');
const run = (program, ...args) => execFileSync(join(bin, program), args, { stdio: ['ignore', 'ignore', 'pipe'] });
const json = path => JSON.parse(readFileSync(path, 'utf8'));

let failed = 0;
async function test(name, body) {
  try {
    await body();
    console.log(`ok      ${name}`);
  } catch (error) {
    ++failed;
    console.log(`FAILED  ${name}\n${error.stack}`);
  }
}
const desktop = { viewport: { width: 1400, height: 900 } };
const phone = { viewport: { width: 390, height: 844 }, hasTouch: true };
const clean = faults => assert.deepEqual(faults, []);

const classed = join(scratch, 'classed'), unknown = join(scratch, 'unknown'), space = join(scratch, 'space');
run('hybrid-replay', '-c', join(source, 'config/classed_demo.ini'), '-o', classed, '--no-pictures', '--report');
const ini = join(scratch, 'unknown.ini');
writeFileSync(ini, `[log]\nrawlog = ${source}/rawlogs/classed_demo.rawlog\n[sensor]\nids = none\n[plugins]\nclasses = BearingRangeAssociation\n`);
run('hybrid-replay', '-c', ini, '-o', unknown, '--no-pictures', '--report');
run('hybrid-replay', '-c', join(source, 'config/classed_demo_3d.ini'), '-o', space, '--no-pictures', '--report');
const page = folder => join(folder, 'report.html');

run('hybrid-simulate', '-c', join(source, 'config/simulate_team_demo.ini'), '-o', join(scratch, 'team.rawlog'));
const team = join(scratch, 'team'), robots = ['anna', 'bert', 'carl'];
const teamIni = join(scratch, 'team.ini');
writeFileSync(teamIni, '[plugins]\nclasses = BearingRangeKnownIds\n' + robots.map((name, i) =>
    `[robot.${name}]\nid = ${-101 - i}\nrawlog = team_${name}.rawlog\ntruth_path = team_${name}_ground_truth_robot_path.txt\n`).join(''));
run('hybrid-replay', '-c', teamIni, '-o', team, '--no-pictures', '--report');
run('hybrid-simulate', '-c', join(source, 'config/simulate_rooms.ini'), '-o', join(scratch, 'rooms.rawlog'));
const rooms = join(scratch, 'rooms');
run('hybrid-replay', join(scratch, 'rooms.rawlog'), '-o', rooms, '--no-pictures', '--report');
const measured = join(scratch, 'measured');
run('hybrid-replay', '-c', ini, '--set', 'sensor.noise=measured', '-o', measured, '--no-pictures', '--report');
await test('the page without data holds at most 300 kB', () => {
  assert.ok(statSync(join(source, 'web/report_template.html')).size <= 300e3);
});

await test('the tab Health tells what is stated, measured and used of the noise', () =>
  withPage(page(measured), desktop, async (p, faults) => {
    await p.click('.tabs button:has-text("Health")');
    const noise = json(join(measured, 'summary.json')).noise;
    assert.ok(noise.some(record => record.measured !== null));
    assert.equal(await p.locator('.noise tbody tr').count(), noise.length);
    const first = await p.locator('.noise tbody tr').first().textContent();
    assert.ok(first.includes(noise[0].kind), first);
    clean(faults);
  }));

await test('fixes are shown by their modes, with probabilities in the tip', () => {
  const rows = [...Array(60).keys()];
  writeFileSync(join(scratch, 'odometry.csv'), `time,x,y,yaw\n${rows.map(t => `${t},${2 * t},0,0\n`).join('')}`);
  // One is false, a hundred metres off.
  writeFileSync(join(scratch, 'fixes.csv'), `time,x,y,sigma\n${rows.map(t => `${t},${2 * t},${t === 30 ? 100 : 0},1\n`).join('')}`);
  run('hybrid-import', 'csv', '--odometry', join(scratch, 'odometry.csv'), '--fixes', join(scratch, 'fixes.csv'), '-o', join(scratch, 'fixes.rawlog'));
  const fixes = join(scratch, 'fixes');
  run('hybrid-replay', join(scratch, 'fixes.rawlog'), '-o', fixes, '--no-pictures', '--report');
  const told = json(join(fixes, 'summary.json')).fixes;
  return withPage(page(fixes), desktop, async (p, faults) => {
    const legend = await p.textContent('.legend');
    assert.equal(told.false, 1);
    for (const mode of ['good', 'false']) assert.ok(legend.includes(`fix ${mode} (${told[mode]})`), legend);
    const [at, k] = await p.evaluate(() => {
      const { data, view } = window.report, i = data.fixes.mode.indexOf(0);
      return [[view.map.px(data.fixes.x[i]), view.map.py(data.fixes.y[i])], data.fixes.k[i]];
    });
    const box = await p.locator('.map > canvas').boundingBox();
    const hover = (dx) => p.mouse.move(box.x + at[0] + dx, box.y + at[1]);
    await hover(1);
    assert.match(await p.textContent('.tip'), /^fix good, .* m off: good .* %, biased .* %, false .* %$/);
    assert.ok(await p.locator('.tip').isVisible());
    if (k > 0) {
      await p.evaluate(before => window.report.state.set({ keyframe: before }), k - 1);  // it was not there yet
      await hover(0);
      assert.ok(await p.locator('.tip').isHidden());
      await p.keyboard.press('End');
    }
    await p.locator('.bar label:text-is("fixes") input').uncheck();
    await hover(2);
    assert.ok(await p.locator('.tip').isHidden());
    clean(faults);
  });
});

await test('opens without a request and without a word on the console, and shows its title', () =>
  withPage(page(classed), desktop, async (p, faults) => {
    assert.match(await p.textContent('h1'), /classed/);
    for (const tab of ['Why', 'Closures', 'Solver', 'Errors', 'Compare', 'About', 'Landmark']) {
      await p.click(`.tabs button:has-text("${tab}")`);
      await p.waitForTimeout(80);
    }
    clean(faults);
  }));

await test('scans of the keyframe are shown, and closures by keyframe with their probability', () =>
  withPage(page(rooms), desktop, async (p, faults) => {
    const loops = readFileSync(join(rooms, 'loops.csv'), 'utf8').trim().split('\n').slice(1).map(row => row.split(','));
    assert.ok(loops.length > 0);
    for (const layer of ['scans', 'closures']) assert.equal(await p.locator(`.bar label:text-is("${layer}")`).count(), 1);
    for (const layer of ['landmarks', 'ellipses', 'rays', 'ids', 'fixes']) assert.equal(await p.locator(`.bar label:text-is("${layer}")`).count(), 0);
    for (const tab of ['Landmark', 'Why']) assert.equal(await p.locator(`.tabs button:text-is("${tab}")`).count(), 0);
    assert.ok(!(await p.textContent('header')).includes('landmarks'));
    const colors = await p.evaluate(() => ['odometry', 'rejected', 'accepted', 'truth', 'estimate'].map(
        name => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim()));
    assert.equal(new Set(colors).size, colors.length);
    const { scans, scan_closures: all } = await p.evaluate(() => window.report.data);
    assert.deepEqual(all.i, loops.map(row => Number(row[0])));
    assert.deepEqual(all.j, loops.map(row => Number(row[1])));
    all.probability.forEach((probability, e) => assert.ok(Math.abs(probability - Number(loops[e][3])) < 1e-5));
    assert.ok(scans.list.length > 10 && scans.list.every(s => s.x.length === s.y.length && s.x.length > 0));
    await p.click('.tabs button:has-text("Closures")');
    assert.match(await p.textContent('.scan-closures .bar'), new RegExp(`${loops.length} of ${loops.length}`));
    await p.selectOption('.scan-closures select', 'this keyframe');
    await p.evaluate(k => window.report.state.set({ keyframe: k }), all.j[0]);
    const here = all.j.filter((j, e) => j === all.j[0] || all.i[e] === all.j[0]).length;
    assert.match(await p.textContent('.scan-closures .bar'), new RegExp(`${here} of ${loops.length}`));
    await p.click('.scan-closures .row >> nth=0');
    assert.match(await p.textContent('.scan-closures .why'), /probability that it is right/);
    assert.equal(await p.evaluate(() => window.report.state.view.keyframe), all.j[0]);
    const ink = () => p.evaluate(() => {
      const { canvas } = window.report.view.map, copy = new OffscreenCanvas(canvas.width, canvas.height);
      const context = copy.getContext('2d', { willReadFrequently: true });
      context.drawImage(canvas, 0, 0);
      const { data } = context.getImageData(0, 0, copy.width, copy.height);
      let count = 0;
      for (let i = 3; i < data.length; i += 4) count += data[i] > 0 ? 1 : 0;
      return count;
    });
    await p.waitForTimeout(80);
    const shown = await ink();
    await p.click('.bar label:text-is("scans")');
    await p.waitForTimeout(80);
    assert.ok(await ink() < shown);
    await p.keyboard.press('Escape');
    clean(faults);
  }));

await test('several robots have a colour, a box and a curve each', () =>
  withPage(page(team), desktop, async (p, faults) => {
    assert.match(await p.textContent('.head-line'), /^3 robots, /);
    assert.deepEqual(await p.$$eval('.bar label[data-robot]', all => all.map(l => l.textContent)), robots);
    const colors = await p.$$eval('.legend i.line:not(.dashed)', all => all.map(l => l.style.color));
    assert.equal(new Set(colors).size, 3);
    const { robots: of, poses } = await p.evaluate(() => window.report.data);
    for (const [i, name] of robots.entries()) {
      const rows = readFileSync(join(team, name, 'trajectory.tum'), 'utf8').split('\n').filter(l => l && l[0] !== '#');
      const own = poses.x.filter((_, k) => of.of[k] === i);
      assert.equal(own.length, rows.length);
      assert.ok(Math.abs(own.at(-1) - Number(rows.at(-1).split(' ')[1])) < 1e-3);
    }
    await p.click('.tabs button:has-text("Errors")');
    await p.waitForTimeout(80);
    const labels = await p.$$eval('.u-legend', all => all.map(l => l.textContent));
    assert.equal(labels.filter(l => robots.every(name => l.includes(name))).length, 4);
    await p.click('.bar label[data-robot="1"]');
    for (const k of [0, 40, 80]) await p.evaluate(n => window.report.state.set({ keyframe: n }), k);
    clean(faults);
  }));

await test('a landmark that is pressed shows the probabilities of landmarks.json', () =>
  withPage(page(classed), desktop, async (p, faults) => {
    const landmark = json(join(classed, 'landmarks.json')).landmarks.find(l => l.id === 14);
    const at = await p.evaluate(() => window.report.view.screen(14));
    await p.click('.map canvas', { position: { x: at[0], y: at[1] } });
    assert.equal(await p.textContent('#pane-1 h2'), 'Landmark 14');
    const shown = await p.$$eval('#pane-1 .bars > div', rows => rows.map(r => [r.children[0].textContent, Number(r.children[2].dataset.p)]));
    assert.equal(shown.length, Object.keys(landmark.class_probabilities).length);
    for (const [name, value] of shown) assert.ok(Math.abs(value - landmark.class_probabilities[name]) <= 5e-7, name);
    const facts = await p.textContent('#pane-1 .facts');
    assert.ok(facts.includes(String(landmark.sightings)));
    assert.ok(facts.includes(String(Number(landmark.position[0].toPrecision(4)))));
    clean(faults);
  }));

await test('a landmark tells its extent, which the map shows as a circle', async () => {
  const coarse = join(scratch, 'coarse');
  run('hybrid-replay', '-c', ini, '--set', 'BearingRangeAssociation.method=jcbb', '--set', 'BearingRangeAssociation.extent=0.75',
      '-o', coarse, '--no-pictures', '--report');
  const boxOfExtents = '.bar label:has-text("extents") input';
  await withPage(page(coarse), desktop, async (p, faults) => {
    const { id, things } = json(join(coarse, 'landmarks.json')).landmarks[0];
    await p.evaluate(id => window.report.state.set({ landmark: id }), id);
    const facts = await p.textContent('#pane-1 .facts');
    assert.match(facts, /extent0\.75 m/);
    assert.equal(facts.includes('things in one place'), things > 1);
    const pixels = () => p.evaluate(() => document.querySelector('.map canvas').toDataURL());
    const before = await pixels();
    await p.uncheck(boxOfExtents);
    await p.waitForTimeout(200);
    assert.notEqual(await pixels(), before);
    clean(faults);
  });
  await withPage(page(unknown), desktop, async p => assert.equal(await p.locator(boxOfExtents).count(), 0));
});

await test('a landmark shows what a camera saw, with a ring where its estimate is seen', async () => {
  const unphotographed = readFileSync(page(classed), 'utf8'), file = join(scratch, 'photographs.html');
  const [, packed] = /<script[^>]*id="?data"?[^>]*>([\s\S]*?)<\/script>/.exec(unphotographed);
  const data = JSON.parse(gunzipSync(Buffer.from(packed.trim(), 'base64')));
  assert.deepEqual(data.photographs.list, []);  // the log has no images
  // A camera at the height of the landmarks that looks ahead: u = c - f y / x by the estimate, seen from the robot.
  const { sightings: s, poses, landmarks } = data;
  const one = s.k.findIndex((at, i) => at > 20 && s.now[i] !== null && Math.abs(s.yaw[i]) < 0.4);
  const k = s.k[one], f = 150, c = 160, jpeg = await blank();
  data.photographs.list = [k, k + 100].map(at => ({ k: at, sensor: 'left', size: [320, 240], jpeg,
    camera: { f: [f, f], c: [c, 120], T: [0, 0, 1, 0, -1, 0, 0, 0, 0, -1, 0, 0] } }));
  writeFileSync(file, unphotographed.replace(packed, () => gzipSync(JSON.stringify(data)).toString('base64')));
  const mark = landmarks.find(l => l.id === s.now[one]);
  const [dx, dy] = [mark.at[0] - poses.x[k], mark.at[1] - poses.y[k]], [cos, sin] = [Math.cos(poses.yaw[k]), Math.sin(poses.yaw[k])];
  const u = c - f * (-sin * dx + cos * dy) / (cos * dx + sin * dy);
  await withPage(file, desktop, async (p, faults) => {
    await p.evaluate(([id, at]) => window.report.state.set({ landmark: id, keyframe: at }), [mark.id, k]);
    assert.ok((await p.textContent('#pane-1 section:has(.photograph)')).includes(`left at keyframe ${k}, a sighting`));
    const line = p.locator('.photograph .line');  // heights are unknown in the plane
    assert.ok(Math.abs(Number(await line.getAttribute('data-u')) - u) < 0.2);
    const box = await p.locator('.photograph').boundingBox(), at = await line.boundingBox();
    assert.ok(Math.abs(at.x + at.width / 2 - box.x - box.width * u / 320) < 2);
    assert.ok(await p.locator('.photograph img').evaluate(i => i.complete && i.naturalWidth === 320));
    clean(faults);
  });
  await withPage(page(classed), desktop, async p => {
    await p.evaluate(id => window.report.state.set({ landmark: id }), mark.id);
    assert.equal(await p.locator('.photograph').count(), 0);
  });
});

/** A JPEG of 320 x 240 pixels, in base 64. */
async function blank() {
  let text = '';
  await withPage(page(classed), desktop, async p => {
    text = await p.evaluate(() => {
      const canvas = Object.assign(document.createElement('canvas'), { width: 320, height: 240 }), pen = canvas.getContext('2d');
      pen.fillStyle = '#7aa37a';
      pen.fillRect(0, 0, 320, 240);
      return canvas.toDataURL('image/jpeg').split(',')[1];
    });
  });
  return text;
}

await test('drag moves the map, the wheel zooms about the mouse, a double click shows all', () =>
  withPage(page(classed), desktop, async (p, faults) => {
    const where = () => p.evaluate(() => [...window.report.view.screen(3), window.report.view.map.scale]);
    const box = await (await p.$('.map canvas')).boundingBox();
    const middle = [box.x + box.width / 2, box.y + box.height / 2];
    const start = await where();
    await p.mouse.move(...middle);
    await p.mouse.down();
    await p.mouse.move(middle[0] + 70, middle[1] - 40, { steps: 4 });
    await p.mouse.up();
    const dragged = await where();
    assert.ok(Math.abs(dragged[0] - start[0] - 70) < 1 && Math.abs(dragged[1] - start[1] + 40) < 1);
    await p.mouse.wheel(0, -400);
    await p.waitForTimeout(200);
    assert.ok((await where())[2] > 1.3 * start[2]);
    await p.dblclick('.map canvas', { position: { x: 5, y: box.height - 60 } });
    await p.waitForTimeout(100);
    assert.ok(Math.abs((await where())[2] - start[2]) < 1e-6 * start[2]);
    clean(faults);
  }));

await test('a map that is moved looks as if drawn anew', () =>
  withPage(page(classed), desktop, async (p, faults) => {
    const share = await p.evaluate(async () => {
      const { map } = window.report.view;
      const frame = () => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)));
      const copy = Object.assign(document.createElement('canvas'), { width: map.canvas.width, height: map.canvas.height });
      const pixels = () => {
        const context = copy.getContext('2d', { willReadFrequently: true });
        context.clearRect(0, 0, copy.width, copy.height);
        context.drawImage(map.canvas, 0, 0);
        return context.getImageData(0, 0, copy.width, copy.height).data;
      };
      const shares = [];
      for (const [dx, dy] of [[37, -21], [-160, 90], [-260, -40], [300, 120]]) {  // the third leaves the layer
        map.panBy(dx, dy);
        await frame();
        const moved = pixels();
        map.redraw();
        await frame();
        map.panBy(1, 0);
        await frame();
        map.panBy(-1, 0);
        await frame();
        const layer = pixels();
        map.redraw();
        await frame();
        const anew = pixels();
        for (const other of [moved, layer]) {
          let differ = 0;
          for (let i = 0; i < anew.length; ++i) differ += Math.abs(other[i] - anew[i]) > 16;
          shares.push(differ / anew.length);
        }
      }
      return Math.max(...shares);
    });
    assert.ok(share < 1e-3, String(share));
    clean(faults);
  }));

await test('the slider shows the estimate as it then was', () =>
  withPage(page(unknown), desktop, async (p, faults) => {
    const count = () => p.evaluate(() => window.report.view.tree.size());
    const all = await count();
    assert.equal(all, json(join(unknown, 'landmarks.json')).landmarks.length);
    await p.focus('#keyframe');
    await p.keyboard.press('Home');
    assert.match(await p.textContent('.now'), /^keyframe 0 of/);
    assert.ok((await count()) < all);
    await p.keyboard.press('ArrowRight');
    assert.match(await p.textContent('.now'), /^keyframe 1 of/);
    await p.keyboard.press('End');
    assert.equal(await count(), all);
    clean(faults);
  }));

await test('the table answers why a sighting was given to its landmark', () =>
  withPage(page(unknown), desktop, async (p, faults) => {
    await p.keyboard.press('3');
    const lines = readFileSync(join(unknown, 'events.jsonl'), 'utf8').trim().split('\n').map(l => JSON.parse(l));
    const sightings = lines.filter(l => l.event === 'sighting');
    assert.ok((await p.textContent('#pane-2 .bar')).includes(sightings.length.toLocaleString('en')));
    const one = sightings.find(s => s.landmark !== null && s.candidates?.length > 1 && s.candidates[0].landmark === s.landmark);
    await p.evaluate(n => window.report.state.set({ sighting: n }), one.sighting);
    const text = await p.textContent('#pane-2 .why');
    assert.ok(text.startsWith(`Sighting ${one.sighting}`));
    const rows = await p.$$eval('#pane-2 .small-table tbody tr', all => all.map(r => [...r.children].map(c => c.textContent)));
    assert.equal(parseInt(rows[0][0]), one.candidates[0].landmark);
    assert.ok(Math.abs(Number(rows[0][1]) - one.candidates[0].nis) <= 1e-3 * one.candidates[0].nis + 1e-3);
    await p.selectOption('#pane-2 select', 'new');
    const births = await p.textContent('#pane-2 .bar .quiet');
    assert.ok(parseInt(births) > 0 && parseInt(births) < sightings.length);
    clean(faults);
  }));

await test('arrows step time wherever the focus is', () =>
  withPage(page(classed), desktop, async (p, faults) => {
    const last = json(join(classed, 'summary.json')).keyframes - 1;
    for (const place of ['.tabs button >> nth=2', '#theme', '.bar input[type=checkbox] >> nth=0', '.bar .slider input', '#keyframe']) {
      await p.evaluate(() => window.report.state.set({ keyframe: window.report.state.last }));
      await p.focus(place);
      await p.keyboard.press('ArrowLeft');
      assert.match(await p.textContent('.now'), new RegExp(`^keyframe ${last - 1} of`), place);
      await p.keyboard.press('Shift+ArrowLeft');
      assert.match(await p.textContent('.now'), new RegExp(`^keyframe ${last - 11} of`), place);
    }
    await p.focus('.tabs button >> nth=0');
    await p.keyboard.press('Tab');
    assert.equal(await p.evaluate(() => document.activeElement.id), 'tab-1');
    clean(faults);
  }));

await test('the bar of the map and the tabs are one line each at 1400 pixels', async () => {
  for (const folder of [classed, unknown, space, rooms]) {
    await withPage(page(folder), desktop, async p => {
      const tops = await p.$$eval('.map-room > .bar > *', all => all.map(e => e.getBoundingClientRect()).map(r => (r.top + r.bottom) / 2));
      assert.ok(Math.max(...tops) - Math.min(...tops) < 8, `${folder}: ${tops}`);
      assert.ok(await p.$eval('.tabs', tabs => tabs.scrollWidth <= tabs.clientWidth), 'tabs');
    });
  }
});

await test('an empty run says why in sight', async () => {
  const log = join(scratch, 'bare.rawlog'), out = join(scratch, 'bare');
  writeFileSync(join(scratch, 'bare.csv'), 'time,x,y,yaw\n' + [0, 1, 2, 3].map(t => `${t},${t},0,0\n`).join(''));
  writeFileSync(join(scratch, 'seen.csv'), 'time,range,yaw\n1,900000,0\n2,900000,0\n');
  run('hybrid-import', 'csv', '--odometry', join(scratch, 'bare.csv'), '--detections', join(scratch, 'seen.csv'), '-o', log);
  try { run('hybrid-replay', log, '-o', out, '--no-pictures', '--report'); } catch (error) { assert.equal(error.status, 2); }
  await withPage(page(out), desktop, async (p, faults) => {
    assert.ok(await p.locator('.banner').isVisible());
    assert.match(await p.textContent('.banner'), /^empty: no landmark was mapped: .+/);
    clean(faults);
  });
  await withPage(page(classed), desktop, async p => assert.equal(await p.locator('.banner').count(), 0));
});

await test('the path is coloured by its error', () =>
  withPage(page(classed), desktop, async (p, faults) => {
    assert.ok(await p.locator('.legend .scale').isHidden());
    await p.click('.bar label:text-is("error")');
    assert.ok(await p.locator('.legend .scale').isVisible());
    const found = await p.evaluate(() => {
      const { paint } = window.report.view, { data } = window.report, [errors] = data.errors;
      const place = k => errors.t.findIndex(t => Math.abs(t - data.poses.t[k]) < 1e-3);
      const sorted = errors.aligned.map((e, i) => [e, i]).sort((a, b) => a[0] - b[0]);
      const at = i => data.poses.t.findIndex(t => Math.abs(t - errors.t[i]) < 1e-3);
      return { least: paint.color(at(sorted[0][1])), most: paint.color(at(sorted.at(-1)[1])), known: data.poses.t.filter((_, k) => place(k) >= 0 && paint.color(k)).length, all: errors.t.length };
    });
    assert.equal(found.least, '#00336f');
    assert.equal(found.most, '#fde737');
    assert.equal(found.known, found.all);
    clean(faults);
  }));

await test('curves are saved as tables, errors over the way driven among them', () =>
  withPage(page(classed), desktop, async (p, faults) => {
    await p.click('.tabs button:has-text("Errors")');
    const table = async title => {
      const [download] = await Promise.all([p.waitForEvent('download'), p.click(`#pane-5 figure:has-text("${title}") .csv`)]);
      return { name: download.suggestedFilename(), rows: readFileSync(await download.path(), 'utf8').trim().split('\n').map(r => r.split(',')) };
    };
    const errors = await p.evaluate(() => window.report.data.errors[0]);
    const time = await table('Error of position');
    assert.equal(time.name, 'error_of_position_over_time.csv');
    assert.deepEqual(time.rows[0], ['time', 'estimate', '"estimate', ' aligned"', 'dead reckoning']);
    assert.deepEqual(time.rows.slice(1).map(r => Number(r[1])), errors.estimate);
    const relative = await table('Error of the way');
    assert.deepEqual(relative.rows[0], ['way', 'median', '95 % stay below']);
    const ways = relative.rows.slice(1).map(r => r.map(Number));
    assert.ok(ways.length > 5 && ways.every(([, median, most]) => median <= most));
    // The median over all pairs of poses that are a way apart, by a plain loop.
    const [way, median] = ways[5], found = [];
    for (let i = 0; i < errors.way.length; ++i) {
      const j = errors.way.findIndex(w => w - errors.way[i] >= way);
      if (j < 0) break;
      found.push(Math.hypot(...[0, 1, 2].map(d => errors.off[j][d] - errors.off[i][d])));
    }
    found.sort((a, b) => a - b);
    assert.ok(Math.abs(median - found[Math.floor(found.length / 2)]) < 1e-9);
    // All are rounded to 1e-4 m.
    for (const [i, [x, y, z]] of errors.off.entries()) assert.ok(Math.abs(Math.hypot(x, y, z) - errors.aligned[i]) < 1.4e-4);
    clean(faults.filter(f => !f.startsWith('request: blob:')));
  }));

/** Rows of a path in TUM's form. */
const rowsOf = file => readFileSync(file, 'utf8').split('\n').filter(l => l && l[0] !== '#').map(l => l.split(' ').map(Number));
/** The root mean square of the distances at the same times, by a plain loop. */
const apart = (a, b) => {
  const at = new Map(b.map(row => [row[0].toFixed(3), row])), squares = [];
  for (const [t, x, y] of a) {
    const other = at.get(t.toFixed(3));
    if (other) squares.push((x - other[1]) ** 2 + (y - other[2]) ** 2);
  }
  assert.ok(squares.length > 50);
  return Math.sqrt(squares.reduce((sum, s) => sum + s, 0) / squares.length);
};
/** The cells of the tables of tab Compare, by the first one of each row. */
const compared = async p => new Map((await p.$$eval('.runs-table tr', all => all.map(r => [...r.children].map(c => c.textContent)))).map(r => [r[0], r.slice(1)]));

await test('another run in the same page: figures, settings, curves, landmarks', () =>
  withPage(page(classed), desktop, async (p, faults) => {
    await p.setInputFiles('#other-files', page(unknown));
    await p.waitForSelector('.runs-table');
    assert.equal(await p.getAttribute('#tab-6', 'aria-selected'), 'true');
    const rows = await compared(p), mine = json(join(classed, 'summary.json')), other = json(join(unknown, 'summary.json'));
    assert.deepEqual(rows.get('landmarks'), [mine.landmarks, other.landmarks].map(String));
    const wanted = apart(rowsOf(join(classed, 'trajectory.tum')), rowsOf(join(unknown, 'trajectory.tum')));
    assert.ok(Math.abs(parseFloat(rows.get('distance of the paths, rms')[1]) - wanted) < 1e-3 * wanted + 1e-4);
    assert.ok(parseFloat(rows.get('the same, aligned')[1]) <= wanted + 1e-4);
    assert.deepEqual(rows.get('sensor.ids'), [mine, other].map(s => String(s.configuration.sensor.ids)));
    assert.ok(!rows.has('log.rawlog') || mine.configuration.log.rawlog !== other.configuration.log.rawlog);
    const common = Number(rows.get('landmarks in both')[1]);
    assert.ok(common > 0.8 * mine.landmarks && common <= other.landmarks, String(common));
    assert.ok(parseFloat(rows.get('their distance, median')[1]) < 0.2);
    assert.match(await p.textContent('.legend .runs'), /unknown/);
    await p.click('.runs-table button:text-is("×")');
    assert.equal(await p.locator('.runs-table').count(), 0);
    clean(faults);
  }));

await test('each robot is compared with its own path', () =>
  withPage(page(team), desktop, async (p, faults) => {
    await p.setInputFiles('#other-files', page(team));
    await p.waitForSelector('.runs-table');
    const rows = await compared(p);
    assert.equal(rows.get('distance of the paths, rms')[1], '0 m');
    assert.equal(rows.get('landmarks in both')[1], String(json(join(team, 'summary.json')).landmarks));
    assert.match(await p.textContent('#pane-6'), /The settings of these runs are the same/);
    const titles = await p.$$eval('#pane-6 figcaption', all => all.map(f => f.textContent));
    for (const name of robots) assert.equal(titles.filter(t => t.startsWith(`Distance from this path of ${name} `)).length, 1);
    clean(faults);
  }));

await test('errors of two runs are curves of one plot', async () => {
  const again = join(scratch, 'again');
  run('hybrid-replay', '-c', join(source, 'config/classed_demo.ini'), '--set', 'sensor.sigma_range=0.5', '-o', again, '--no-pictures', '--report');
  const text = readFileSync(page(classed), 'utf8'), file = join(scratch, 'both.html');
  const [whole, packed] = /<script[^>]*id="data"[^>]*>([^<]+)<\/script>/.exec(readFileSync(page(again), 'utf8'));
  assert.ok(whole.length > packed.length);
  writeFileSync(file, text.replace('<script type="module">', () => `<script type="application/octet-stream" class="other" data-name="wide &amp; far">${packed}</script><script type="module">`));
  await withPage(file, desktop, async (p, faults) => {
    const rows = await compared(p);
    assert.deepEqual(rows.get('').map(n => n.replace(' ×', '').trim()), [classed, 'wide & far']);
    assert.deepEqual([...rows.keys()].filter(k => k.includes('.')), ['sensor.sigma_range']);
    const { own, others } = await p.evaluate(() => ({ own: window.report.data.errors[0], others: window.report.compare.runs[0].errors[0] }));
    const [download] = await Promise.all([p.waitForEvent('download'), p.click('#pane-6 figure:has-text("Error of position [m]") .csv')]);
    const table = readFileSync(await download.path(), 'utf8').trim().split('\n').slice(1).map(r => r.split(',').map(Number));
    assert.deepEqual(table.map(r => r[1]), own.estimate);
    assert.deepEqual(table.map(r => r[2]), others.estimate);
    assert.notDeepEqual(own.estimate, others.estimate);
    const plot = p.locator('#pane-6 figure:has-text("Error of position [m]") .u-over'), box = await plot.boundingBox();
    await plot.click({ position: { x: box.width / 4, y: box.height / 2 } });
    const keyframe = await p.evaluate(() => window.report.state.view.keyframe);
    assert.ok(Math.abs(keyframe - own.t.length / 4) < own.t.length / 10, String(keyframe));  // some way from the end, where it was
    clean(faults.filter(f => !f.startsWith('request: blob:')));
  });
});

await test('the path of any program is compared, as it is and aligned; a file that is none says so', () =>
  withPage(page(classed), desktop, async (p, faults) => {
    const path = rowsOf(join(classed, 'trajectory.tum')), file = join(scratch, 'turned.tum'), [c, s] = [Math.cos(0.5), Math.sin(0.5)];
    writeFileSync(file, '# stamp x y z\n' + path.map(([t, x, y]) => `${t} ${c * x - s * y + 3} ${s * x + c * y - 2} 0 0 0 0 1`).join('\n'));
    const reckoned = join(classed, 'trajectory_dead_reckoning.tum');
    await p.setInputFiles('#other-files', [file]);
    await p.setInputFiles('#other-files', [reckoned, join(unknown, 'landmarks.json')]);
    await p.waitForFunction(() => window.report.compare.runs.length === 2);
    const rows = await compared(p), far = rows.get('distance of the paths, rms').slice(1).map(parseFloat);
    assert.ok(Math.abs(far[0] - apart(path, rowsOf(file))) < 1e-3 * far[0]);
    assert.ok(Math.abs(far[1] - apart(path, rowsOf(reckoned))) < 1e-3 * far[1]);
    assert.ok(parseFloat(rows.get('the same, aligned')[1]) < 2e-3);
    assert.equal(rows.get('landmarks')[2], String(json(join(unknown, 'landmarks.json')).landmarks.length));
    await p.check('#aligned');
    const [x, y] = await p.evaluate(() => window.report.compare.layer.strands()[0].points);
    path.forEach((row, i) => assert.ok(Math.hypot(x[i] - row[1], y[i] - row[2]) < 2e-3));
    writeFileSync(join(scratch, 'no_path.tum'), '1 2 three 4\n');
    await p.setInputFiles('#other-files', join(scratch, 'no_path.tum'));
    await p.waitForSelector('#pane-6 [role=alert]:not([hidden])');
    assert.match(await p.textContent('#pane-6 .bad'), /^no_path\.tum, line 1: a path has rows of time, x, y, z/);
    const alert = text => p.waitForFunction(t => document.querySelector('#pane-6 [role=alert]').textContent.startsWith(t), text);
    writeFileSync(join(scratch, 'half.json'), '{"landmarks": [');
    await p.setInputFiles('#other-files', join(scratch, 'half.json'));
    await alert('half.json is no JSON: ');
    await p.setInputFiles('#other-files', [file, reckoned, join(unknown, 'landmarks.json')]);
    await alert('several paths, and no way to tell');
    await p.setInputFiles('#other-files', [file, reckoned]);
    await p.waitForFunction(() => window.report.compare.runs.length === 4);
    assert.deepEqual((await compared(p)).get('').slice(3).map(n => n.replace(' ×', '').trim()), ['turned.tum (2)', 'trajectory_dead_reckoning.tum (2)']);
    const dropped = await p.evaluateHandle(() => {
      const all = new DataTransfer();
      all.items.add(new File(['<html></html>'], 'page.html'));
      return all;
    });
    await p.dispatchEvent('.map canvas', 'drop', { dataTransfer: dropped });
    await p.waitForFunction(() => /page.html is no report/.test(document.querySelector('#pane-6 .bad').textContent));
    assert.equal(await p.evaluate(() => window.report.compare.runs.length), 4);
    clean(faults);
  }));

await test('everything can be done with keys alone', () =>
  withPage(page(classed), desktop, async (p, faults) => {
    await p.keyboard.press('/');
    await p.keyboard.type('3');
    await p.keyboard.press('Enter');
    assert.equal(await p.textContent('#pane-1 h2'), 'Landmark 3');
    await p.keyboard.press('Escape');
    await p.keyboard.press('n');
    assert.equal(await p.textContent('#pane-1 h2'), 'Landmark 4');
    await p.keyboard.press('Shift+ArrowLeft');
    const last = json(join(classed, 'summary.json')).keyframes - 1;
    assert.match(await p.textContent('.now'), new RegExp(`^keyframe ${last - 10} of`));
    for (const key of ['2', '3', '4', '5', '6', '7', '8']) {
      await p.keyboard.press(key);
      assert.equal(await p.getAttribute(`#tab-${Number(key) - 1}`, 'aria-selected'), 'true');
    }
    const theme = () => p.evaluate(() => document.documentElement.dataset.theme);
    const before = await theme();
    await p.keyboard.press('d');
    assert.notEqual(await theme(), before);
    clean(faults);
  }));

await test('the objective is told half-step by half-step', () =>
  withPage(page(classed), desktop, async (p, faults) => {
    const lines = readFileSync(join(classed, 'events.jsonl'), 'utf8').trim().split('\n').map(l => JSON.parse(l));
    const flipped = lines.find(l => l.event === 'change' && l.flips.length);
    await p.keyboard.press('5');
    await p.evaluate(k => window.report.state.set({ keyframe: k }), flipped.keyframe);
    const text = await p.textContent('#pane-4');
    assert.match(text, /the objective never rose/);
    assert.ok(text.includes(flipped.flips[0].variable));
    clean(faults);
  }));

await test('shares of the sightings add up, and are those that honest noise expects', () =>
  withPage(page(unknown), desktop, async (p, faults) => {
    await p.click('.tabs button:has-text("Errors")');
    await p.waitForSelector('#pane-5 figure:has-text("squared sigmas") canvas');
    const { all, first, expected } = await p.evaluate(() => {
      const { shares, chiSquareShares } = window.report.histogram, sum = list => list.reduce((a, b) => a + b, 0);
      const nis = shares(window.report.data.sightings.nis, 0.5, 24), honest = chiSquareShares(2, 0.5, 24);
      return { all: [sum(nis), sum(honest), sum(chiSquareShares(3, 0.5, 24))], first: nis[0], expected: honest[0] };
    });
    for (const sum of all) assert.ok(Math.abs(sum - 1) < 1e-6, String(sum));
    assert.ok(Math.abs(expected - (1 - Math.exp(-0.25))) < 1e-9);
    assert.ok(Math.abs(first - expected) < 0.1, `${first} ${expected}`);
    clean(faults);
  }));

const spiral = join(scratch, 'spiral');
writeFileSync(`${spiral}.g2o`, Array.from({ length: 12 }, (_, k) =>
    `EDGE_SE3:QUAT ${k} ${k + 1} 1 0 0.5 0 0 0.2588 0.9659 1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1\n`).join(''));
run('hybrid-pgo', `${spiral}.g2o`, '-o', spiral, '--no-pictures', '--report');
for (const [what, folder] of [['map', space], ['pose graph', spiral]]) await test(`a ${what} in space turns`, () =>
  withPage(page(folder), desktop, async (p, faults) => {
    await p.click('#space');
    await p.waitForTimeout(500);
    const shot = () => p.locator('.orbit').screenshot();
    const before = await shot();
    const box = await (await p.$('.orbit')).boundingBox();
    await p.mouse.move(box.x + 200, box.y + 200);
    await p.mouse.down();
    await p.mouse.move(box.x + 320, box.y + 240, { steps: 5 });
    await p.mouse.up();
    await p.waitForTimeout(400);
    assert.ok(!before.equals(await shot()));
    clean(faults);
  }));

await test('a screen of 390 pixels is enough', () =>
  withPage(page(unknown), phone, async (p, faults) => {
    for (const tab of ['Health', 'Landmark', 'Why', 'Closures', 'Solver', 'Errors', 'Compare', 'About']) {
      await p.click(`.tabs button:has-text("${tab}")`);
      await p.waitForTimeout(80);
      assert.ok((await p.evaluate(() => document.documentElement.scrollWidth)) <= 390, tab);
    }
    clean(faults);
  }));

await test('texts and lines stand out from the ground, light and dark', () =>
  withPage(page(classed), desktop, async p => {
    for (const theme of ['light', 'dark']) {
      const colors = await p.evaluate(name => {
        document.documentElement.dataset.theme = name;
        const style = getComputedStyle(document.documentElement);
        const names = ['panel', 'text', 'quiet', 'accent', 'wrong', 'good', 'estimate', 'odometry', 'truth', 'ray', 'select', 'accepted', 'rejected', 'undecided'];
        return Object.fromEntries(names.map(n => [n, style.getPropertyValue(`--${n}`).trim()]));
      }, theme);
      const light = hex => {
        const c = [1, 3, 5].map(i => parseInt(hex.slice(i, i + 2), 16) / 255).map(v => (v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4));
        return 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2];
      };
      for (const [name, color] of Object.entries(colors)) {
        if (name === 'panel') continue;
        const [a, b] = [light(color), light(colors.panel)].sort((x, y) => y - x);
        const least = ['text', 'quiet', 'accent', 'wrong', 'good'].includes(name) ? 4.5 : 3;  // WCAG 2.1, level AA
        assert.ok((a + 0.05) / (b + 0.05) >= least, `${theme}: ${name}`);
      }
    }
  }));

await test('a pose graph: before, after, closures', async () => {
  const graph = join(scratch, 'graph.g2o'), out = join(scratch, 'graph');
  writeFileSync(graph, square());
  run('hybrid-pgo', graph, '--method', 'selection', '-o', out, '--report');
  await withPage(page(out), desktop, async (p, faults) => {
    const rows = readFileSync(join(out, 'loops.csv'), 'utf8').trim().split('\n').slice(1);
    await p.click('.tabs button:has-text("Closures")');
    assert.ok((await p.textContent('#pane-1 .bar')).includes(`${rows.length} of ${rows.length}`));
    const rejected = rows.filter(r => r.includes('rejected')).length;
    assert.ok(rejected > 0);
    await p.selectOption('#pane-1 select', 'rejected');
    assert.ok((await p.textContent('#pane-1 .bar .quiet')).startsWith(`${rejected} of`));
    await p.click('#pane-1 .row');
    assert.match(await p.textContent('#pane-1 .why'), /rejected/);
    await p.waitForSelector('#pane-1 figure:has-text("probability that they are right") canvas');
    await p.keyboard.press('b');
    assert.equal(await p.textContent('#before'), 'before');
    clean(faults);
  });
});

await test('a pose graph online: when a closure was decided', async () => {
  const graph = join(scratch, 'graph.g2o'), out = join(scratch, 'online');
  run('hybrid-pgo', graph, '--online', '--trusted', 'odometry', '-o', out, '--report');
  await withPage(page(out), desktop, async (p, faults) => {
    await p.click('.tabs button:has-text("Closures")');
    await p.selectOption('#pane-1 select', 'accepted');
    await p.click('#pane-1 .row');
    const { i, history } = await p.evaluate(() => window.report.data.closures);
    assert.ok(history.length === i.length && history.every(h => h.length > 0));
    assert.match(await p.textContent('#pane-1 .why'), /accepted at pose \d+/);
    clean(faults);
  });
});

await test('another solution of a pose graph in the same page', async () => {
  const out = join(scratch, 'graph'), all = join(scratch, 'trusting');
  run('hybrid-pgo', join(scratch, 'graph.g2o'), '--method', 'lm', '-o', all, '--report');
  const decisions = folder => new Map(readFileSync(join(folder, 'loops.csv'), 'utf8').trim().split('\n').slice(1)
      .map(row => row.split(',')).map(row => [row.slice(0, 2).join(' '), row[2]]));
  await withPage(page(out), desktop, async (p, faults) => {
    await p.setInputFiles('#other-files', page(all));
    await p.waitForSelector('.runs-table');
    const rows = await compared(p), mine = decisions(out), other = decisions(all);
    assert.deepEqual(rows.get('method'), ['selection', 'lm']);
    const differing = [...mine.keys()].filter(k => mine.get(k).startsWith('rejected') !== other.get(k).startsWith('rejected'));
    assert.ok(differing.length > 0);
    assert.match(await p.textContent('#pane-3'), new RegExp(`decided differently: ${differing.length} of ${mine.size}`));
    const shown = await p.$$eval('#pane-3 .row', all => all.map(r => [...r.children].map(c => c.textContent)));
    assert.deepEqual(shown.map(r => r.slice(0, 2).join(' ')), differing);
    assert.deepEqual(shown.map(r => r.slice(2)), differing.map(k => [mine.get(k), other.get(k)]));
    const [a, b] = [out, all].map(folder => rowsOf(join(folder, 'trajectory.tum')));
    const squares = a.map((row, i) => (row[1] - b[i][1]) ** 2 + (row[2] - b[i][2]) ** 2);
    const wanted = Math.sqrt(squares.reduce((sum, s) => sum + s, 0) / a.length);
    assert.ok(wanted > 0.01 && Math.abs(parseFloat(rows.get('distance of the paths, rms')[1]) - wanted) < 1e-3 * wanted);
    assert.match(await p.textContent('.map .legend'), /trusting/);
    await p.setInputFiles('#other-files', page(classed));
    await p.waitForSelector('#pane-3 [role=alert]:not([hidden])');
    assert.match(await p.textContent('#pane-3 [role=alert]'), /is the report of a replay, and this page that of a pose graph/);
    clean(faults);
  });
});

/** A square of 40 poses driven twice, with true closures and one false. */
function square() {
  const lines = [];
  const edge = (i, j, x, y, a) => lines.push(`EDGE_SE2 ${i} ${j} ${x} ${y} ${a} 100 0 0 100 0 400`);
  for (let i = 0; i < 80; ++i) edge(i, i + 1, 1, 0, i % 10 === 9 ? Math.PI / 2 : 0);
  for (let i = 0; i < 40; i += 4) edge(i, i + 40, 0, 0, 0);
  edge(3, 25, 0.2, 0.1, 0.3);
  return lines.join('\n') + '\n';
}

await closeBrowser();
process.exit(failed ? 1 : 0);
