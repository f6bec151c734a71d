// The legend under a plot: one button per series with its value at the shown time. A click hides or
// shows the series, a double click shows it alone; pointing at it makes it stand out.

import { h, svg } from './dom.js';

function swatch(dash) {
  const line = svg('line', { x1: 1, y1: 5, x2: 21, y2: 5, 'stroke-width': 2, 'stroke-dasharray': dash.length ? dash.join(' ') : null });
  return svg('svg', { viewBox: '0 0 22 10', width: 22, height: 10, 'aria-hidden': 'true', class: 'swatch' }, line);
}

// What all names begin or end with, up to an underscore, tells nothing and takes the room of the rest.
function shorten(names) {
  if (names.length < 3 || !names.every((n) => /^\w+$/.test(n)) || Math.max(...names.map((n) => n.length)) < 14) return names;
  const words = names.map((n) => n.split('_'));
  const least = Math.min(...words.map((w) => w.length)) - 1;
  const shared = (pick) => {
    let n = 0;
    while (n < least && words.every((w) => pick(w, n) === pick(words[0], n))) n += 1;
    return n;
  };
  const front = shared((w, n) => w[n]);
  const back = Math.min(shared((w, n) => w[w.length - 1 - n]), least - front);
  return words.map((w) => w.slice(front, w.length - back).join('_'));
}

function entry(name, dash, color, onToggle, extra = {}, label = name) {
  const value = h('span', { class: 'legend-value' });
  const button = h('button', { type: 'button', class: 'legend-entry', title: name, 'aria-pressed': 'true', style: { color }, onclick: onToggle, ...extra },
    swatch(dash), h('span', { class: 'legend-name' }, label || '(no name)'), value);
  return { button, value };
}

/**
 * `series`: `[{ name, dash, hue }]`; `limits`: groups from limits.js. `actions`: `toggle(i)`, `only(i)`,
 * `focus(i or null)`, `toggleLimit(group)`.
 */
export function createLegend(series, limits, actions) {
  const labels = shorten(series.map((s) => s.name));
  const entries = series.map((s, i) => entry(s.name, s.dash, `var(--series-${s.hue})`, () => actions.toggle(i), {
    ondblclick: () => actions.only(i),
    onmouseenter: () => actions.focus(i),
    onmouseleave: () => actions.focus(null),
  }, labels[i]));
  const limitEntries = limits.map((group) => {
    const made = entry(group.name, [6, 4], 'var(--limit)', () => {
      actions.toggleLimit(group);
      made.button.setAttribute('aria-pressed', String(group.show));
    });
    made.button.classList.add('legend-limit');
    return made;
  });
  const node = h('div', { class: `legend${series.length > 8 ? ' legend-many' : ''}` }, [...entries, ...limitEntries].map((e) => e.button));
  return {
    node,
    /** The texts beside the names, one per series. */
    setValues(texts) { texts.forEach((t, i) => { if (entries[i].value.textContent !== t) entries[i].value.textContent = t; }); },
    setLimitValues(texts) { texts.forEach((t, i) => { if (limitEntries[i].value.textContent !== t) limitEntries[i].value.textContent = t; }); },
    setShown(i, shown) { entries[i].button.setAttribute('aria-pressed', String(shown)); },
    setFocus(i) { entries.forEach((e, j) => e.button.classList.toggle('focused', i === j)); },
  };
}
