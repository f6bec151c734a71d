// The head of the page: title, verdict, facts, faults.

import { h, icon, prose } from './dom.js';
import { count, number, percent, quantity, timeText } from './format.js';

const TICK = 'M3.2 8.6 6.4 11.8 12.8 4.6';
const CROSS = 'M4 4 12 12 M12 4 4 12';
const DASH = 'M4 8 H12';

function verdictLine({ ok, text }) {
  const [state, word, path] = ok === null ? ['unknown', 'No verdict', DASH] : ok ? ['ok', 'Passed', TICK] : ['bad', 'Failed', CROSS];
  return h('div', { class: `verdict ${state}`, role: 'status' },
    h('span', { class: 'verdict-mark' }, icon(path)), h('p', {}, h('strong', {}, word), text && [' ', prose(text)]));
}

function fact(name, value, note, state) {
  return h('div', { class: `fact ${state ?? ''}` }, h('dt', {}, name), h('dd', {}, value), note && h('dd', { class: 'fact-note' }, note));
}

function facts(data) {
  const { duration, period, ticks, tick, faults } = data;
  const share = tick.max !== null && period ? (tick.max * 1e-6) / period : null;
  const rate = period ? quantity(1 / period, 'Hz') : '–';
  return h('dl', { class: 'facts' },
    fact('Duration', quantity(duration, 's', 4)),
    fact('Rate', rate, period ? `${quantity(period, 's')} a tick` : null),
    fact('Ticks', count(ticks)),
    fact('Tick time', quantity(tick.median, 'us'), tick.median === null ? 'not measured' : 'median'),
    tick.max !== null && fact('Slowest tick', quantity(tick.max, 'us'),
      [tick.p99 !== null && `p99 ${quantity(tick.p99, 'us')}`, share !== null && `${percent(share)} of the period`].filter(Boolean).join(' · '), share !== null && share > 1 ? 'bad' : ''),
    fact('Faults', number(faults.length), faults.length ? 'see below' : 'none raised', faults.length ? 'bad' : ''));
}

function faultList(faults, clock, decimals) {
  if (faults.length === 0) return null;
  const rows = faults.map((f) => h('li', {},
    f.time === null ? h('span', {}, '–') : h('button', { type: 'button', class: 'at', onclick: () => clock.seek(f.time), title: 'Show this time' }, timeText(f.time, decimals)),
    h('strong', {}, f.kind), h('span', {}, prose(f.text))));
  return h('section', { class: 'faults', 'aria-label': 'Faults' },
    h('h2', {}, faults.length === 1 ? 'One fault was raised' : `${count(faults.length)} faults were raised`), h('ol', {}, rows));
}

/** The header of a run. */
export function createHeader(data, clock, decimals) {
  const where = [data.program, data.spec].filter(Boolean);
  return h('header', {},
    where.length > 0 && h('p', { class: 'eyebrow' }, where.map((part, i) => [i > 0 && h('span', { class: 'dot' }, '·'), h('span', {}, part)])),
    h('h1', {}, data.title),
    data.notes.map((note) => h('p', { class: 'note' }, note)),
    verdictLine(data.verdict),
    facts(data),
    faultList(data.faults, clock, decimals));
}
