// What was expected of a scenario, and what became of it: verdict, margin, and the instant that decides it.

import { h } from './dom.js';
import { quantity, timeText } from './format.js';

const WORDS = { holds: 'holds', fails: 'fails', undecided: 'undecided' };
// Less than this is what rounding leaves of a margin of zero.
const TOLERANCE = 1e-9;

/** The table of expectations; null where there are none. */
export function createExpectations(data, clock, decimals) {
  if (data.expectations.length === 0) return null;
  const rows = data.expectations.map((e) => {
    const margin = e.margin !== null && Math.abs(e.margin) < TOLERANCE ? 0 : e.margin;
    const undefinedAt = e.undefinedAt !== null && e.verdict !== 'holds' && `something in it has no value at ${timeText(e.undefinedAt, decimals)}, and is false there`;
    return h('tr', {},
      h('th', { scope: 'row' },
        h('span', { class: e.label ? 'name' : 'formula' }, e.label || e.text),
        e.label && h('span', { class: 'sub formula' }, e.text),
        undefinedAt && h('span', { class: 'sub' }, undefinedAt)),
      h('td', {}, h('span', { class: `mark ${e.verdict === 'holds' ? 'ok' : 'bad'}` }, WORDS[e.verdict] ?? e.verdict)),
      h('td', { class: `num ${e.verdict === 'fails' ? 'bad' : ''}`, title: e.margin === null ? null : `${e.margin} ${e.unit}`.trim() }, quantity(margin, e.unit).replace(/ /g, '\u00a0')),
      h('td', { class: 'num' }, e.at === null ? '' : h('button', { type: 'button', class: 'at', title: 'Show this time', onclick: () => clock.seek(e.at) }, timeText(e.at, decimals))));
  });
  const head = [['Expectation'], ['Verdict'], ['Margin', 'num', 'By how much at least it held, or failed: then it is zero or less'],
    ['At', 'num', 'When it came nearest to failing, or failed by most']];
  return h('section', { class: 'levels expectations' }, h('h2', {}, 'Expectations'),
    h('div', { class: 'table-wrap' }, h('table', {}, h('thead', {}, h('tr', {}, head.map(([t, c, title]) => h('th', { scope: 'col', class: c ?? '', title }, t)))), h('tbody', {}, rows))));
}
