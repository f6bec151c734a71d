// The states of the machine as bands along the time axis: one lane for the outermost states, one for each depth inside
// them. The bands follow the clock's zoom, stand above the plots' time, and move the time as the plots do.

import { h } from './dom.js';
import { timeText } from './format.js';

const HUES = 7;
// The room of the plots' axis on the left, and theirs on the right, in px.
const LEFT = 58;
const RIGHT = 18;

/** `[{ name, path, from, to }]` for a depth: neighbours that are the same state there are one. */
function lane(stays, depth) {
  const spans = [];
  stays.forEach((s) => {
    const names = s.state.split('.');
    if (names.length <= depth) return;
    const path = names.slice(0, depth + 1).join('.');
    const last = spans.at(-1);
    if (last && last.path === path && s.from - last.to < 1e-9) last.to = s.to;
    else spans.push({ name: names[depth], path, from: s.from, to: s.to });
  });
  return spans;
}

/** Round steps of time, about so many. */
function steps(from, to, wanted) {
  const rough = (to - from) / wanted;
  if (!(rough > 0)) return [];
  const unit = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((k) => k * unit).find((s) => s >= rough);
  const all = [];
  for (let k = Math.ceil(from / step - 1e-9); k * step <= to + step * 1e-9; k += 1) all.push(k * step);
  const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  return all.map((t) => [t, t.toFixed(digits).replace('-', '−')]);
}

/** `{ node, name }`, or null for a run without a machine. */
export function createStates(data, clock, faults, decimals) {
  const stays = data.states.map((s, i) => ({ ...s, to: data.states[i + 1]?.from ?? Math.max(s.to, clock.end) }));
  if (stays.length === 0) return null;
  const depth = Math.min(6, Math.max(...stays.map((s) => s.state.split('.').length)));
  const lanes = Array.from({ length: depth }, (_, d) => lane(stays, d));
  // The machine itself is the outermost state of every path where it has a name there.
  const shown = lanes.length > 1 && lanes[0].length === 1 ? lanes.slice(1) : lanes;
  const hues = new Map();
  shown.flat().forEach((s) => { if (!hues.has(s.path)) hues.set(s.path, hues.size % HUES); });

  const line = h('div', { class: 'cursor-line' });
  const now = h('span', { class: 'plot-unit' });
  const spans = [];
  const span = (s) => {
    const text = `${s.path}, ${timeText(s.from, decimals)} to ${timeText(s.to, decimals)}`;
    const node = h('div', { class: 'band', title: text, style: { '--hue': `var(--series-${hues.get(s.path)})` } }, h('span', { class: 'band-name' }, s.name));
    spans.push({ node, ...s });
    return node;
  };
  const marks = faults.map((t) => ({ t, node: h('div', { class: 'band-fault', title: `fault at ${timeText(t, decimals)}` }) }));
  const axis = h('div', { class: 'band-axis', 'aria-hidden': 'true' });
  const host = h('div', { class: 'bands' }, shown.map((l) => h('div', { class: 'band-lane' }, l.map(span))), marks.map((m) => m.node), line);
  const words = `states in order: ${stays.map((s) => `${s.state} from ${timeText(s.from, decimals)}`).join(', ')}`;
  const figure = h('figure', { class: 'plot', 'data-plot': 'states' },
    h('figcaption', {}, h('span', { class: 'plot-title' }, 'State'), now),
    h('div', { class: 'band-frame', role: 'img', 'aria-label': words, style: { 'padding-left': `${LEFT}px`, 'padding-right': `${RIGHT}px` } }, host, axis));
  const counts = data.entries.map((e) => `${e.state} ${e.count}`).join(', ');
  const entries = counts ? h('p', { class: 'entries' }, `Entries: ${counts}`) : null;
  const node = h('section', { class: 'group' }, h('h2', {}, 'Machine'), h('div', { class: 'plot-grid' }, figure), entries);

  const range = () => clock.zoom ?? (clock.end > clock.start ? [clock.start, clock.end] : [clock.start - 0.5, clock.start + 0.5]);
  const share = (t) => { const [a, b] = range(); return (t - a) / (b - a); };
  const percent = (x) => `${(100 * x).toFixed(4)}%`;

  function applyTime() {
    const current = stays.findLast((s) => s.from <= clock.time + 1e-9);
    const text = current ? current.state : '';
    if (now.textContent !== text) now.textContent = text;
    const x = share(clock.time);
    line.style.display = x >= -1e-6 && x <= 1 + 1e-6 ? '' : 'none';
    line.style.left = percent(x);
  }

  function applyZoom() {
    const [a, b] = range();
    spans.forEach((s) => {
      const [from, to] = [Math.max(0, share(s.from)), Math.min(1, share(s.to))];
      s.node.hidden = to <= from;
      s.node.style.left = percent(from);
      s.node.style.width = percent(to - from);
    });
    marks.forEach((m) => {
      const x = share(m.t);
      m.node.hidden = x < 0 || x > 1;
      m.node.style.left = percent(x);
    });
    axis.replaceChildren(...steps(a, b, 8).map(([t, text], i, all) => h('span', { style: { left: percent(share(t)) } }, i === all.length - 1 ? `${text} s` : text)));
    applyTime();
  }

  const timeAt = (event) => {
    const box = host.getBoundingClientRect();
    const [a, b] = range();
    return a + ((event.clientX - box.left) / box.width) * (b - a);
  };
  host.addEventListener('mousemove', (event) => { if (!clock.playing && event.buttons === 0) clock.seek(timeAt(event)); });
  host.addEventListener('click', (event) => clock.seek(timeAt(event)));
  host.addEventListener('dblclick', () => clock.setZoom(null));
  clock.on('time', applyTime);
  clock.on('zoom', applyZoom);
  applyZoom();
  return { node, name: 'Machine' };
}
