// Bundles src/ into report.html, one file that loads nothing. Run by hand: `npm ci && node build.mjs`.
// The output depends only on src/ and package-lock.json, so that a second build changes no byte.

import { readFile, writeFile } from 'node:fs/promises';
import { build } from 'esbuild';

const PLACEHOLDER = '@@HIERARQ_DATA@@';
const BUDGET_BYTES = 1_200_000;
const here = (path) => new URL(path, import.meta.url);

const common = { bundle: true, write: false, minify: true, legalComments: 'none', charset: 'utf8', logLevel: 'warning' };
const [js, css] = await Promise.all([
  build({ ...common, entryPoints: [here('src/main.js').pathname], format: 'iife', target: ['es2022'] }),
  build({ ...common, entryPoints: [here('src/style.css').pathname] }),
]);

const licences = (await Promise.all(['three', 'uplot'].map(async (name) => {
  const { version } = JSON.parse(await readFile(here(`node_modules/${name}/package.json`), 'utf8'));
  const text = await readFile(here(`node_modules/${name}/LICENSE`), 'utf8');
  return `${name} ${version}\n\n${text.trim()}`;
}))).join('\n\n----\n\n');

const parts = { css: css.outputFiles[0].text.trim(), js: js.outputFiles[0].text.trim(), licences };
for (const bad of ['</script', '<!--', PLACEHOLDER]) {
  if (parts.js.includes(bad)) throw new Error(`the script contains ${bad}, which would end it early`);
}
if (parts.css.includes('</style')) throw new Error('the style sheet contains </style');
if (licences.includes('--' + '>')) throw new Error('a licence text would end its comment early');

let page = await readFile(here('src/index.html'), 'utf8');
for (const [name, text] of Object.entries(parts)) page = page.replace(`/*{{${name}}}*/`, () => text);

if (page.split(PLACEHOLDER).length !== 2) throw new Error(`${PLACEHOLDER} must occur exactly once`);
const size = Buffer.byteLength(page);
if (size > BUDGET_BYTES) throw new Error(`report.html has ${size} bytes, more than ${BUDGET_BYTES}`);
await writeFile(here('report.html'), page);
console.log(`report.html: ${(size / 1000).toFixed(0)} kB`);
