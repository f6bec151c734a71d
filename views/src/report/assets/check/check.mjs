// Opens the pages of sample.mjs in Chromium and acts as a reader would. Run by hand after a build:
// `node check/check.mjs` (needs `chromium` on the path, or its path in CHROMIUM).

import { mkdtemp, readFile, rm, stat, writeFile } from 'node:fs/promises';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { pathToFileURL } from 'node:url';
import { cases, page as fill } from '../sample.mjs';
import { launch } from './browser.mjs';

const template = await readFile(new URL('../report.html', import.meta.url), 'utf8');
const folder = await mkdtemp(join(tmpdir(), 'hierarq-report-'));
let failures = 0;
function check(name, got, want = true) {
  const ok = JSON.stringify(got) === JSON.stringify(want);
  if (!ok) failures += 1;
  console.log(`${ok ? 'ok  ' : 'FAIL'} ${name}${ok ? '' : `: got ${JSON.stringify(got)}, want ${JSON.stringify(want)}`}`);
}
const near = (a, b, tolerance) => Math.abs(a - b) <= tolerance;

async function write(name, text) {
  const path = join(folder, `${name}.html`);
  await writeFile(path, text);
  return pathToFileURL(path).href;
}
const url = async (name) => write(name, fill(template, cases[name]()));
const readout = (page) => page.evaluate(`parseFloat(document.querySelector('.readout').textContent)`);
const over = (page, i) => page.evaluate(`(() => { const r = document.querySelectorAll('.u-over')[${i}].getBoundingClientRect(); return { x: r.x, y: r.y, w: r.width, h: r.height }; })()`);
const lines = (page) => page.evaluate(`[...document.querySelectorAll('.cursor-line')].slice(0, 4).map((l) => l.style.display === 'none' ? null : new DOMMatrix(l.style.transform).e / l.parentNode.clientWidth)`);
const axis = (page, i) => page.evaluate(`document.querySelectorAll('.zoom-reset')[0].hidden ? null : document.querySelector('.zoom-reset').textContent`);

const browser = await launch();
try {
  // every page: no error, no request but itself, nothing wider than the window, not a byte of HTML from the data
  const plots = { normal: 12, machine: 13, failed: 12, empty: 0, single: 1, hostile: 6, many: 6 };
  for (const name of Object.keys(cases)) {
    for (const [width, dark] of [[1600, false], [1100, true], [420, false]]) {
      const address = await url(name);
      const page = await browser.open(address, { width, dark });
      const label = `${name}, ${width} px, ${dark ? 'dark' : 'light'}`;
      await page.sleep(name === 'many' ? 800 : 200);
      check(`${label}: console`, page.problems, []);
      check(`${label}: requests`, page.requests.filter((r) => r !== address && !r.startsWith('data:')), []);
      check(`${label}: fits`, await page.evaluate('document.documentElement.scrollWidth <= innerWidth'));
      check(`${label}: plots`, await page.evaluate(`document.querySelectorAll('.plot').length`), plots[name]);
      check(`${label}: no markup from data`, await page.evaluate(`document.querySelectorAll('#report img[onerror], #report script').length + (document.title === 'broken' ? 1 : 0)`), 0);
      await page.close();
    }
  }

  // the shared time
  const page = await browser.open(await url('normal'), { width: 1600, height: 3000 });
  check('starts at zero', await readout(page), 0);
  const a = await over(page, 0);
  await page.mouse('mouseMoved', a.x + a.w / 2, a.y + a.h / 2);
  await page.sleep(200);
  const half = await readout(page);
  check('pointing at the middle of a plot shows half the run', near(half, 49.975 / 2, 0.1));
  check('every plot shows that time', (await lines(page)).every((x) => near(x, 0.5, 0.005)));
  check('the legend shows the sample of that time', await page.evaluate(`(() => {
    const data = JSON.parse(document.getElementById('hierarq-data').textContent);
    const i = data.time.findIndex((t) => t >= ${half} - 0.0126);
    const shown = parseFloat(document.querySelector('.legend-value').textContent);
    return Math.abs(shown - data.plots[0].series[0].y[i]) < 6e-3;
  })()`));
  await page.key('ArrowRight');
  check('an arrow key moves one sample', near(await readout(page) - half, 0.025, 0.0101));
  await page.key('Home');
  check('Home goes to the start', await readout(page), 0);
  await page.key(' ');
  check('space plays', await page.until(`parseFloat(document.querySelector('.readout').textContent) > 0.1`));
  await page.key(' ');
  check('and pauses', await page.evaluate(`document.querySelector('.play').getAttribute('aria-label')`), 'Play');
  const played = await readout(page);
  await page.sleep(200);
  check('a paused run stands still', await readout(page), played);

  // the replay follows: the picture at one time differs from the picture at another, and comes back
  const shot = () => page.evaluate(`new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => { dispatchEvent(new Event('beforeprint')); const s = document.querySelector('.still').src; dispatchEvent(new Event('afterprint')); done(s); })))`);
  const at = async (t) => { await page.evaluate(`location.hash = '#t=${t}'`); await page.sleep(150); return shot(); };
  const [first, second, again] = [await at(10), await at(30), await at(10)];
  check('the replay shows another pose at another time', first !== second && first.length > 5000);
  check('the replay shows the same picture at the same time', first === again);
  const flip = (name) => page.evaluate(`[...document.querySelectorAll('.chip')].find((b) => b.textContent === '${name}').click()`);
  await flip('Volumes');
  check('a switch hides the volumes', (await at(10)) !== first);
  const [known, unknown] = [await at(20), await at(30)];
  await flip('People');
  check('a switch hides the person', (await at(20)) !== known);
  check('who is not drawn while nobody knows where', (await at(30)) === unknown);
  await flip('People');

  // the shared zoom
  await page.mouse('mousePressed', a.x + a.w * 0.2, a.y + 60, { button: 'left', buttons: 1, clickCount: 1 });
  await page.mouse('mouseMoved', a.x + a.w * 0.3, a.y + 60, { button: 'left', buttons: 1 });
  await page.mouse('mouseMoved', a.x + a.w * 0.4, a.y + 60, { button: 'left', buttons: 1 });
  await page.mouse('mouseReleased', a.x + a.w * 0.4, a.y + 60, { button: 'left', clickCount: 1 });
  await page.sleep(200);
  const zoom = ((await axis(page)) ?? '').match(/[0-9.]+/g)?.map(Number) ?? [];
  check('dragging zooms to the dragged part', near(zoom[0], 10, 0.15) && near(zoom[1], 20, 0.15));
  const d = await over(page, 3);
  await page.mouse('mouseMoved', d.x + d.w / 2, d.y + 60);
  await page.sleep(200);
  check('another plot has the same zoom', near(await readout(page), (zoom[0] + zoom[1]) / 2, 0.1));
  check('its line stands under the pointer', near((await lines(page))[3], 0.5, 0.005));
  for (const clickCount of [1, 2]) {
    await page.mouse('mousePressed', d.x + d.w / 2, d.y + 60, { button: 'left', buttons: 1, clickCount });
    await page.mouse('mouseReleased', d.x + d.w / 2, d.y + 60, { button: 'left', clickCount });
  }
  await page.sleep(200);
  check('a double click shows the whole run', await axis(page), null);
  await page.mouse('mouseMoved', a.x + a.w - 1, a.y + 60);
  await page.sleep(200);
  check('the right end of a plot is the end of the run', near(await readout(page), 49.975, 0.2));

  // expectations and states
  const run = await browser.open(await url('machine'), { width: 1600, height: 3000 });
  check('a row for each expectation', await run.evaluate(`[...document.querySelectorAll('.expectations .mark')].map((m) => m.textContent)`), ['holds', 'fails', 'holds', 'undecided']);
  await run.evaluate(`document.querySelectorAll('.expectations .at')[1].click()`);
  check('its instant is shown everywhere', await readout(run), 8);
  check('how often each state was entered', await run.evaluate(`document.querySelector('.entries').textContent`), 'Entries: pick.ask 2, pick.look 2, <b> 1');
  check('also by the states', await run.evaluate(`document.querySelector('[data-plot=states] .plot-unit').textContent`), 'pick.look');
  check('a lane for each depth, without that of the machine', await run.evaluate(`[...document.querySelectorAll('.band-lane')].map((l) => l.children.length)`), [6, 3]);
  const bands = await run.evaluate(`(() => { const r = document.querySelector('.bands').getBoundingClientRect(); return { x: r.x, y: r.y, w: r.width, h: r.height }; })()`);
  const under = await over(run, 0);
  await run.mouse('mouseMoved', bands.x + bands.w / 2, bands.y + bands.h / 2);
  await run.sleep(200);
  check('pointing at the middle of the bands shows half the run', near(await readout(run), 25, 0.1));
  check('a band is as wide as its stay', near(await run.evaluate(`document.querySelectorAll('.band')[2].getBoundingClientRect().width`), bands.w * 20.5 / 50, 1));
  check('bands begin where the plots do', near(bands.x, under.x, 2));
  await run.mouse('mousePressed', under.x + under.w * 0.2, under.y + 60, { button: 'left', buttons: 1, clickCount: 1 });
  await run.mouse('mouseMoved', under.x + under.w * 0.3, under.y + 60, { button: 'left', buttons: 1 });
  await run.mouse('mouseMoved', under.x + under.w * 0.4, under.y + 60, { button: 'left', buttons: 1 });
  await run.mouse('mouseReleased', under.x + under.w * 0.4, under.y + 60, { button: 'left', clickCount: 1 });
  await run.sleep(200);
  check('the bands follow the zoom', await run.evaluate(`[...document.querySelectorAll('.band-lane')[0].children].filter((b) => !b.hidden).map((b) => b.textContent)`).then((t) => t[0] === 'look' || t[0] === 'work'));
  check('console after this', run.problems, []);
  await run.close();

  // legend, units, docking
  const ink = (i) => page.evaluate(`(() => { const from = document.querySelectorAll('.plot canvas')[${i}]; const c = new OffscreenCanvas(from.width, from.height); const g = c.getContext('2d', { willReadFrequently: true }); g.drawImage(from, 0, 0); const d = g.getImageData(0, 0, c.width, c.height).data; let n = 0; for (let k = 3; k < d.length; k += 4) n += d[k] > 0; return n; })()`);
  const before = await ink(0);
  await page.evaluate(`document.querySelector('.legend-entry').click()`);
  await page.sleep(100);
  check('a click on the legend hides the series', (await ink(0)) < before && (await page.evaluate(`document.querySelector('.legend-entry').getAttribute('aria-pressed')`)) === 'false');
  const cell = () => page.evaluate(`[...document.querySelectorAll('.tasks td.num')].map((c) => c.textContent.replaceAll('\\u00a0', ' ')).find((t) => /12°|0.21 rad/.test(t)) ?? ''`);
  check('angles in degrees', (await cell()).trim(), 'max 12°');
  await page.evaluate(`[...document.querySelectorAll('.angles .chip')].find((b) => b.textContent === 'rad').click()`);
  check('angles in radians', (await cell()).trim(), 'max 0.21 rad');
  check('the plots follow', await page.evaluate(`document.querySelector('[data-plot=dq] .plot-unit').textContent`), 'rad/s');
  await page.on('Emulation.setDeviceMetricsOverride', { width: 1600, height: 900, deviceScaleFactor: 1, mobile: false });
  const docks = (want) => page.until(`document.querySelector('.viewer').classList.contains('docked') === ${want}`);
  await page.evaluate('scrollTo(0, 1800)');
  check('the replay docks beside the plots', await docks(true));
  await page.evaluate('scrollTo(0, 0)');
  check('and returns', await docks(false));
  check('console after all this', page.problems, []);
  const pdf = join(folder, 'normal.pdf');
  await page.pdf(pdf);
  check('it prints', (await stat(pdf)).size > 30000);
  check('and shows no controls on paper', await page.paper(`[...document.querySelectorAll('.transport, .viewer, .plot-nav')].every((e) => getComputedStyle(e).display === 'none')`));
  check('tables fit the paper', await page.paper(`[...document.querySelectorAll('table')].every((t) => t.getBoundingClientRect().right <= innerWidth)`));
  await page.close();

  // the policy forbids every connection: code put into the page cannot reach out
  const spy = await browser.open(await url('single'));
  check('fetch is refused', await spy.evaluate(`fetch('http://127.0.0.1:9/').then(() => 'reached', () => 'refused')`), 'refused');
  check('by the policy', spy.problems.some((p) => /Content Security Policy/.test(p)));
  await spy.close();

  const bare = await browser.open(await write('template', template));
  check('the template without data says so', await bare.evaluate(`/empty template/.test(document.querySelector('#report').textContent)`));
  await bare.close();
  const torn = await browser.open(await write('torn', template.replace('@@HIERARQ_DATA@@', '{"version":1,')));
  check('torn data are reported', await torn.evaluate(`/cannot be read/.test(document.querySelector('#report').textContent)`));
  check('without an exception', torn.problems, []);
  await torn.close();
} finally {
  await browser.close();
}

const blind = await launch(['--disable-3d-apis']);
try {
  const page = await blind.open(await url('normal'));
  check('without WebGL a sentence says so', await page.evaluate(`/needs WebGL/.test(document.querySelector('.replay-missing')?.textContent)`));
  check('and the plots are there', await page.evaluate(`document.querySelectorAll('.plot canvas').length > 0`));
  check('and the time can still be moved', (await page.key('End'), near(await readout(page), 50, 0.1)));
} finally {
  await blind.close();
}
await rm(folder, { recursive: true, force: true });
console.log(failures ? `${failures} failed` : 'all passed');
process.exitCode = failures ? 1 : 0;
