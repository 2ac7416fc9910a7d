// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// Builds report_template.html: page, style, script and licences in one file. `node build.mjs OUT` writes elsewhere.

import { build } from 'esbuild';
import { existsSync, readFileSync, readdirSync, writeFileSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';

const here = dirname(fileURLToPath(import.meta.url));
const out = process.argv[2] ?? join(here, 'report_template.html');
const common = { bundle: true, minify: true, write: false, legalComments: 'none', logLevel: 'warning', absWorkingDir: here,
  target: 'es2022' };

const script = await build({ ...common, entryPoints: ['src/main.ts'], format: 'esm', charset: 'ascii', metafile: true });
const plots = readFileSync(join(here, 'node_modules/uplot/dist/uPlot.min.css'), 'utf8');
const style = await build({ ...common, stdin: { contents: plots + readFileSync(join(here, 'src/style.css'), 'utf8'), loader: 'css' },
  charset: 'utf8' });

/** The licence of every package that is inside; those of the same text share it. */
function licences(metafile) {
  const names = new Set();
  for (const file of Object.keys(metafile.inputs)) {
    const match = /node_modules\/((?:@[^/]+\/)?[^/]+)/.exec(file);
    if (match) names.add(match[1]);
  }
  const packages = new Map();  // by the text of their licence
  for (const name of [...names].sort()) {
    const folder = join(here, 'node_modules', name);
    const about = JSON.parse(readFileSync(join(folder, 'package.json'), 'utf8'));
    const file = readdirSync(folder).find(f => /^licen[cs]e/i.test(f));
    const text = file && existsSync(join(folder, file)) ? readFileSync(join(folder, file), 'utf8').trim() : about.license;
    packages.set(text, [...(packages.get(text) ?? []), `${name} ${about.version} (${about.license})`]);
  }
  return [...packages].map(([text, list]) => `${list.join('\n')}\n\n${text}`).join('\n\n----\n\n');
}

const own = 'The page: BSD-3-Clause, Copyright (c) 2026, the hybrid mapping authors. It holds:\n\n';
const put = (page, place, text) => page.split(place).join(text);
let page = readFileSync(join(here, 'src/page.html'), 'utf8');
page = put(page, '/* style */', style.outputFiles[0].text.trim());
page = put(page, '/* licences */', (own + licences(script.metafile)).replaceAll('<', '&lt;'));
page = put(page, '/* script */', script.outputFiles[0].text.trim().replaceAll('</script', '<\\/script'));
writeFileSync(out, page);
console.log(`${out}: ${Buffer.byteLength(page)} bytes`);
