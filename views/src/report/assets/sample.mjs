// Makes report pages from invented runs, to look at and to check the template with:
// `node sample.mjs [--out DIR] [CASE...]`, cases: normal, machine, failed, empty, single, hostile, many.

import { mkdir, readFile, writeFile } from 'node:fs/promises';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { twoArms } from './check/two_arms.mjs';

const empty = () => ({
  version: 1, title: 'Nothing', program: 'nothing', spec: 'nothing.hq', generated_by: 'hierarq 0.1.0', duration: 0, period: 0.01, ticks: 0,
  verdict: { ok: true, text: '' }, summary_rows: [], levels: [], tick_us: { median: null, p99: null, max: null }, faults: [], time: [], plots: [], scene: null,
});

function single() {
  return {
    ...empty(), title: 'One sample', time: [0], ticks: 1,
    plots: [{ id: 'p', group: 'Task errors', title: 'One sample', unit: 'm', task: 't', series: [{ name: 'x', y: [0.2] }], limits: [{ name: 'minimum', value: 0, side: 'lower' }] }],
    scene: { up: 'y', links: [{ name: 'a', visuals: [] }], poses: { stride: 7, frames: 1, times: [0], data: [0, 1, 0, 1, 0, 0, 0] }, planes: [], points: [], keep_out: [], targets: [], traces: [] },
  };
}

// Text that would run if it were taken for HTML, names without end, holes everywhere, wrong types.
function hostile() {
  const html = '<img src=x onerror="document.title=\'broken\'"></script><script>document.title="broken"</script>';
  const long = 'a_very_long_name_without_any_place_to_break_it_'.repeat(6);
  return {
    ...empty(), version: 2, title: `${html} ${long}`, program: long, spec: html, verdict: { ok: null, text: `${html} ${long}` },
    duration: 1, faults: [{ time: 0.5, kind: html, text: long }, { time: null, kind: 'late', text: 'without a time' }, null],
    summary_rows: [
      { task: long, kind: html, level: long, active_share: 0.00001, active_rows: Array.from({ length: 40 }, () => long), measures: [{ name: long, unit: html, smallest: -1e-9, final: null, at: 0.5 }] },
      { task: 'nothing', active_share: null }, null,
      { task: 't', measures: [{ name: 'a', unit: 'rad', largest: 1e-7, final: 1e-18, at: null }, { name: 'b', unit: 'm', largest: 0.99996e-3, final: 0, at: 2 }] },
    ],
    states: [{ state: html, from: 0.2 }, { state: long, from: 0.6, to: null }, { state: '..', from: 0.1, to: 'x' }, null, { state: 'a' }],
    expectations: [{ label: html, text: long, verdict: html, margin: -1e-9, unit: html, at: 0.5 }, { text: 'x', verdict: 'holds', margin: 0, at: null }, {}, null],
    levels: [{ name: long, hard: true, rows: null, freedom: null, saturated_share: null, worst_violation: 1e-3 }, {}],
    joints: [{ joint: long, unit: html, acceleration: 1e9, at: 0.5, reversals: 455, first_reversal: 0.25, jumps: 'x', first_jump: null }, { joint: html }, null],
    stopping: [{ stack: long, states: [html, long, null], time: 'x', links: [{ link: html, way: null }, { link: long, way: 1e-9 }, null] }, {}, null],
    time: [0, 0.25, 0.25, null, 0.5, 1],
    plots: [
      { id: 'a', group: html, title: long, unit: html, series: [{ name: html, y: [1, null, 3, 4, null, 6] }, { name: long, y: [] }, {}], limits: [{ name: long, y: [0, 1, null, null, 2, 3], side: 'upper' }, { name: 'bad' }] },
      { id: 'b', group: 'Empty', title: 'no series', series: [], limits: [] },
      { id: 'c', group: 'Empty', title: 'constant zero', unit: '1', series: [{ name: 'z', y: [0, 0, 0, 0, 0, 0] }] },
      { id: 'd', group: 'Empty', title: 'tiny', unit: 'rad', series: [{ name: 'z', y: [1e-9, 2e-9, 0, 0, 3e-9, 1e-9] }] }, null,
    ],
    scene: {
      up: 'z', links: [{ name: long, visuals: [{ type: 'mesh' }, { type: 'box', size: [1, 1, null] }, { type: 'sphere', radius: 0.2, color: [1, 0, 0, 0.5] }] }, null],
      poses: { stride: 7, frames: 9, times: [0, 1], data: [0, 0, 1, 1, 0, 0, 0, null, 0, 0, 1, 0, 0, 0, 1, 0, 1, 0, 1, 0, 0, 0, 0, 0, 1, 0, 0, 0] },
      planes: [{ name: html, point: [0, 0, 0], normal: [0, 0, 0] }], points: [{ name: html, link: 7, xyz: [0, 0, 0] }], keep_out: [{ name: 'k', link: 0, from: [0, 0, 0], radius: null }],
      people: [{ name: html, points: [1, html], links: [[0, 9], 'x', [0, 1]], data: [null, 0, 0, 0, 1, 1, 1, 'x'] }, { name: 'k', points: [] }, null],
      targets: [{ name: html, data: [] }], traces: [{ name: html, link: 0, xyz: null }],
    },
  };
}

function many() {
  const time = Array.from({ length: 2000 }, (_, i) => i * 0.025);
  const series = (n, f) => Array.from({ length: n }, (_, k) => ({ name: `joint_${k + 1}`, y: time.map((t) => f(t, k)) }));
  return {
    ...empty(), title: 'A hundred series', duration: 50, ticks: 5000, time,
    plots: Array.from({ length: 6 }, (_, i) => ({ id: `p${i}`, group: 'Joint positions', title: `plot ${i + 1}`, unit: i % 2 ? 'rad/s' : '', task: '', series: series(100, (t, k) => 0.9 * Math.sin(t * 0.2 + k + i)), limits: [{ name: 'limit', value: -1, side: 'lower' }, { name: 'limit', value: 1, side: 'upper' }] })),
  };
}

function failed() {
  const run = twoArms();
  return {
    ...run, verdict: { ok: false, text: 'The smallest distance of `left_tool` to the deck was −4.2 mm at 23.41 s.' },
    faults: [{ time: 23.41, kind: 'limit passed', text: 'deck: left_tool is 4.2 mm beyond the wall' }, { time: 31.02, kind: 'late tick', text: 'the tick took 11.3 ms of a period of 10 ms' }],
  };
}

// A machine with states inside each other, and expectations of every kind.
function machine() {
  const run = twoArms();
  const paths = ['pick.ask', 'pick.look', 'pick.work.reach', 'pick.work.grasp', 'pick.work.lift', 'pick.ask', 'pick.look', 'pick.done'];
  const starts = [0, 4, 9.5, 21, 21.02, 30, 31, 44];
  return {
    ...run, title: 'found at second sight', faults: [{ time: 33.3, kind: 'stale', text: 'signal `bunch` is 0.52 s old' }],
    verdict: { ok: false, text: '1 of 4 expectations fails, 1 is undecided.' },
    states: paths.map((state, i) => ({ state, from: starts[i], to: (starts[i + 1] ?? T) - 0.01 })),
    stopping: [
      { stack: 'looking', states: ['pick.ask', 'pick.look'], time: 0.12, links: [{ link: 'tool', way: 0.03 }] },
      { stack: 'working', states: ['pick.work.reach', 'pick.work.grasp', 'pick.work.lift'], time: 0.22, links: [{ link: 'tool', way: 0.451 }] },
    ],
    entries: [{ state: 'pick.ask', count: 2 }, { state: 'pick.look', count: 2 }, { state: '<b>', count: 1 }, { state: 'bad', count: 'x' }, null],
    expectations: [
      { label: 'the arms stay apart', text: 'always margin(arms_apart) >= 0 m', verdict: 'holds', margin: 0.0312, unit: 'm', at: 17.2, undefined_at: null },
      { label: null, text: 'after in(look) : within 4 s : in(work) or in(ask)', verdict: 'fails', margin: -1.5, unit: 's', at: 8, undefined_at: null },
      { label: 'it turns', text: 'eventually joint(wrist) > 40 deg', verdict: 'holds', margin: 0.21, unit: 'rad', at: 40.5, undefined_at: null },
      { label: null, text: 'always within 5 s : in(done)', verdict: 'undecided', margin: null, unit: null, at: null, undefined_at: 33.3 },
    ],
  };
}

const T = 50;

/** The invented runs by name. */
export const cases = { normal: twoArms, machine, failed, empty, single, hostile, many };

/** The template with data in it, as the Rust side writes it. */
export function page(template, data) {
  return template.replace('@@HIERARQ_DATA@@', () => JSON.stringify(data).replace(/</g, '\\u003c'));
}

if (import.meta.url === `file://${process.argv[1]}`) {
  const args = process.argv.slice(2);
  const at = args.indexOf('--out');
  const out = at >= 0 ? args.splice(at, 2)[1] : join(tmpdir(), 'hierarq-report');
  const template = await readFile(new URL('report.html', import.meta.url), 'utf8');
  await mkdir(out, { recursive: true });
  for (const name of args.length ? args : Object.keys(cases)) {
    await writeFile(join(out, `${name}.html`), page(template, cases[name]()));
    console.log(join(out, `${name}.html`));
  }
}
