// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// Whether the committed page is what its sources give: node test/build_test.mjs SCRATCH

import { execFileSync } from 'node:child_process';
import { readFileSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';

const web = join(dirname(fileURLToPath(import.meta.url)), '..');
const built = join(process.argv[2], 'report_template.html');
execFileSync(process.execPath, [join(web, 'build.mjs'), built], { stdio: 'inherit' });
execFileSync(process.execPath, [join(web, 'node_modules/typescript/bin/tsc'), '--noEmit', '-p', web], { stdio: 'inherit' });
if (!readFileSync(built).equals(readFileSync(join(web, 'report_template.html')))) {
  console.log('web/report_template.html is not what web/src gives: run `npm ci && npm run build` in web/');
  process.exit(1);
}
