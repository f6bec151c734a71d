// The tables: what each task achieved, what each level of the hierarchy had to give up, and to which limit.

import { h } from './dom.js';
import { count, number, percent, quantity, timeText } from './format.js';

const SHOWN_ROWS = 4;
const SHOWN_BLOCKING = 8;

// A margin below zero by less than this is what rounding leaves of zero: the run did not count it as passed either.
const TOLERANCE = 1e-9;

// A name that may break behind its underscores and points, and nowhere else unless a part is wider than its column.
const breakable = (name) => String(name).split(/(?<=[_.])/).flatMap((part, i) => (i ? [h('wbr'), part] : [part]));

// Three lines at most; the whole name when pointed at.
const clamp = (name) => h('span', { class: 'clamp', title: name }, breakable(name));

// A number and its unit stay together; only `m/s or rad/s` may break, before the `or`.
const glued = (text) => text.replace(/ /g, '\u00a0').replace(/\u00a0or\u00a0/g, ' or\u00a0');

function shareBar(share) {
  if (share === null) return h('span', { class: 'quiet' }, '–');
  return h('span', { class: 'share' },
    h('span', { class: 'share-track', 'aria-hidden': 'true' }, h('span', { class: 'share-fill', style: { width: `${Math.min(1, Math.max(0, share)) * 100}%` } })),
    h('span', { class: 'share-text' }, percent(share)));
}

// Smallest margin for what must not be passed, largest error for what is followed.
function worst(measure) {
  const tidy = (x) => (Math.abs(x) < TOLERANCE ? 0 : x);
  if (measure.smallest !== null) return ['min', tidy(measure.smallest), measure.smallest < -TOLERANCE];
  if (measure.largest !== null) return ['max', measure.largest, false];
  return ['', null, false];
}

function measureCells(measure, clock, decimals) {
  const [kind, value, bad] = worst(measure);
  const exact = (v) => (v === null ? null : `${v} ${measure.unit}`.trim());
  return [
    h('td', { class: 'measure' }, clamp(measure.name)),
    h('td', { class: `num ${bad ? 'bad' : ''}`, title: exact(value) }, kind && h('span', { class: 'kind' }, kind), ` ${glued(quantity(value, measure.unit))}`),
    h('td', { class: 'num' }, measure.at === null ? '' : h('button', { type: 'button', class: 'at', title: 'Show this time', onclick: () => clock.seek(measure.at) }, timeText(measure.at, decimals))),
    h('td', { class: 'num', title: exact(measure.final) }, glued(quantity(measure.final, measure.unit))),
  ];
}

function activeCell(row, span) {
  const rest = row.activeRows.length - SHOWN_ROWS;
  const names = row.activeRows.slice(0, SHOWN_ROWS).join(', ') + (rest > 0 ? ` and ${rest} more` : '');
  return h('td', { class: 'active', rowspan: span }, shareBar(row.active), names && h('span', { class: 'active-rows clamp', title: row.activeRows.join(', ') }, breakable(names)));
}

/** `link(task)`: a function that shows the task's plots, or null if it has none. */
export function createTasks(data, clock, decimals, link) {
  if (data.tasks.length === 0) return null;
  const bodies = data.tasks.map((row) => {
    const span = Math.max(1, row.measures.length);
    const action = link(row.task);
    const name = action ? h('button', { type: 'button', class: 'link', onclick: action, title: 'Go to the plots' }, breakable(row.task)) : breakable(row.task);
    const first = row.measures.length ? measureCells(row.measures[0], clock, decimals) : [h('td', { colspan: 4, class: 'quiet' }, 'no measure')];
    return h('tbody', {},
      h('tr', {}, h('th', { scope: 'rowgroup', rowspan: span }, h('span', { class: 'name clamp', title: row.task }, name), h('span', { class: 'sub clamp' }, breakable([row.kind !== row.task && row.kind, row.level].filter(Boolean).join(' · ')))), first, activeCell(row, span)),
      row.measures.slice(1).map((m) => h('tr', {}, measureCells(m, clock, decimals))));
  });
  const head = [['Task'], ['Measure'], ['Worst', 'num', 'Smallest margin or largest error'], ['At', 'num'], ['Final', 'num'],
    ['Active', 'active', 'Share of the ticks at which a row of the task was at its bound']];
  return h('section', { class: 'tasks' }, h('h2', {}, 'Tasks'),
    h('div', { class: 'table-wrap' }, h('table', {}, h('thead', {}, h('tr', {}, head.map(([t, c, title]) => h('th', { scope: 'col', class: c ?? '', title }, t)))), bodies)));
}

/** The levels, the most important first. */
export function createLevels(data) {
  if (data.levels.length === 0) return null;
  const rows = data.levels.map((l, i) => h('tr', {},
    h('td', { class: 'num rank' }, String(i + 1)),
    h('th', { scope: 'row' }, h('span', { class: 'name clamp', title: l.name }, breakable(l.name))),
    h('td', {}, l.hard ? 'hard' : 'soft'),
    h('td', { class: 'num' }, count(l.rows)),
    h('td', { class: 'num' }, count(l.freedom)),
    h('td', { class: 'active' }, shareBar(l.saturated)),
    h('td', { class: `num ${l.hard && l.violation > 1e-6 ? 'bad' : ''}`, title: l.violation }, number(l.violation !== null && Math.abs(l.violation) < 1e-12 ? 0 : l.violation))));
  const head = [['', 'num'], ['Level'], ['Kind'], ['Rows', 'num'], ['Freedom', 'num', 'Degrees of freedom'], ['Saturated', 'active', 'Share of the ticks at which a row of the level was at its bound'],
    ['Violation', 'num', 'The worst violation of a row, in the unit of that row']];
  return h('section', { class: 'levels' }, h('h2', {}, 'Hierarchy'),
    h('div', { class: 'table-wrap' }, h('table', {}, h('thead', {}, h('tr', {}, head.map(([t, c, title]) => h('th', { scope: 'col', class: c ?? '', title }, t)))), h('tbody', {}, rows))));
}

/** Joints whose velocity jumped or reversed; none if no joint did. */
export function createJoints(data, clock, decimals) {
  if (data.joints.length === 0) return null;
  const at = (t) => h('td', { class: 'num' }, t === null ? '' : h('button', { type: 'button', class: 'at', title: 'Show this time', onclick: () => clock.seek(t) }, timeText(t, decimals)));
  const rows = data.joints.map((j) => h('tr', {},
    h('th', { scope: 'row' }, h('span', { class: 'name clamp', title: j.joint }, breakable(j.joint))),
    h('td', { class: 'num', title: j.acceleration === null ? null : `${j.acceleration} ${j.unit}`.trim() }, glued(quantity(j.acceleration, j.unit))), at(j.at),
    h('td', { class: 'num' }, count(j.reversals)), at(j.firstReversal),
    h('td', { class: 'num' }, count(j.jumps)), at(j.firstJump)));
  const head = [['Joint'], ['Acceleration', 'num', 'The largest change of its velocity from a tick to the next, over the period'], ['At', 'num'],
    ['Reversals', 'num', 'How often it turned round and back within 0.2 s'], ['First at', 'num'],
    ['Jumps', 'num', 'Ticks at which its velocity jumped'], ['First at', 'num']];
  return h('section', { class: 'levels joints' }, h('h2', {}, 'Rough joints'),
    h('div', { class: 'table-wrap' }, h('table', {}, h('thead', {}, h('tr', {}, head.map(([t, c, title]) => h('th', { scope: 'col', class: c ?? '', title }, t)))), h('tbody', {}, rows))));
}

/** How long and how far the robot moves on when it is stopped at full speed. */
export function createStopping(data) {
  if (data.stopping.length === 0) return null;
  const bound = (x, unit) => (x === null ? 'unbounded' : glued(quantity(x, unit)));
  const rows = data.stopping.map((s) => h('tr', {},
    h('th', { scope: 'row' }, h('span', { class: 'name clamp', title: s.stack }, breakable(s.stack)),
      s.states.length > 0 && h('span', { class: 'sub clamp', title: s.states.join(', ') }, breakable(s.states.join(', ')))),
    h('td', { class: 'num', title: s.time }, bound(s.time, 's')),
    h('td', {}, s.links.map((l, i) => [i > 0 && ', ', breakable(l.link), ' ', bound(l.way, 'm')]))));
  const head = [['Stack'], ['Time', 'num', 'The longest time to rest from the largest speeds of the stack'], ['Ways', '', 'The longest ways of links to rest']];
  return h('section', { class: 'levels stopping' }, h('h2', {}, 'To rest from full speed'),
    h('div', { class: 'table-wrap' }, h('table', {}, h('thead', {}, h('tr', {}, head.map(([t, c, title]) => h('th', { scope: 'col', class: c ?? '', title }, t)))), h('tbody', {}, rows))));
}

/** Which limit held which level back; the ones that did so longest. */
export function createHeldBack(data, clock, decimals) {
  if (data.heldBack.length === 0) return null;
  const rows = data.heldBack.slice(0, SHOWN_BLOCKING).map((b) => h('tr', {},
    h('th', { scope: 'row' }, h('span', { class: 'name clamp', title: b.level }, breakable(b.level))),
    h('td', {}, h('span', { class: 'clamp', title: `${b.by}, ${b.row}` }, breakable(b.by), ', ', breakable(b.row))),
    h('td', { class: 'num' }, b.at === null ? '' : h('button', { type: 'button', class: 'at', title: 'Show this time', onclick: () => clock.seek(b.at) }, timeText(b.at, decimals))),
    h('td', { class: 'active' }, shareBar(b.share))));
  const rest = data.heldBack.length - SHOWN_BLOCKING;
  const head = [['Level'], ['gave way to'], ['Most at', 'num', 'When the limit cost the level most'], ['Share', 'active', 'Share of the ticks at which the level would have come closer to its targets without this limit']];
  return h('section', { class: 'levels' }, h('h2', {}, 'Held back'),
    h('div', { class: 'table-wrap' }, h('table', {}, h('thead', {}, h('tr', {}, head.map(([t, c, title]) => h('th', { scope: 'col', class: c ?? '', title }, t)))), h('tbody', {}, rows))),
    rest > 0 && h('p', { class: 'quiet' }, `and ${rest} more, in summary.json`));
}
