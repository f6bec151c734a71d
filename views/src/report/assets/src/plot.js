// One plot: series against time, limits, legend with live values. It is drawn when it comes near the
// window, and follows the clock's time and zoom.

import uPlot from 'uplot';
import { h, cssVar } from './dom.js';
import { axisUnit, quantity } from './format.js';
import { assign, hueColor } from './palette.js';
import { createLegend } from './legend.js';
import { drawFaults, drawForbidden, drawLines, groupLimits, limitRange } from './limits.js';
import { below, nearest } from './data.js';

const HEIGHT = 230;
const FONT = '11px system-ui, -apple-system, "Segoe UI", sans-serif';

const decimals = (step) => Math.min(12, Math.max(0, -Math.floor(Math.log10(step) + 1e-9)));
const tickText = (v, step) => v.toFixed(decimals(step)).replace(/^-(?=0\.?0*$)/, '').replace('-', '−');

function largest(plot) {
  let size = 0;
  const see = (v) => { if (v !== null && Math.abs(v) > size) size = Math.abs(v); };
  plot.series.forEach((s) => s.y.forEach(see));
  plot.limits.forEach((l) => (l.y === null ? see(l.value) : l.y.forEach(see)));
  return size;
}

// Counts (active rows) are steps, not slopes.
function isCount(plot, series) {
  return plot.group === 'Hierarchy' && series.y.every((v) => v === null || Number.isInteger(v)) && series.y.some((v) => v !== null);
}

// A sample between two gaps has no line; it is drawn as a dot.
function alonePoints(y, fill) {
  const has = (i) => y[i] !== null && y[i] !== undefined;
  const alone = y.flatMap((_, i) => (has(i) && !has(i - 1) && !has(i + 1) ? [i] : []));
  return alone.length ? { show: true, size: 6, fill, filter: () => alone } : { show: false };
}

function padded(low, high) {
  if (low > high) return [0, 1];
  const span = high - low;
  if (span < 1e-12 * Math.max(1e-6, Math.abs(high))) {
    const room = Math.abs(high) * 0.1 || 1;
    return [low === 0 ? -0.05 : low - room, high + room];
  }
  return [low - span * 0.07, high + span * 0.07];
}

/** `context`: `{ time, clock, faults }`. Returns `{ node, setVisible, redraw, relayout, destroy }`. */
export function createPlot(plot, context) {
  const { time, clock, faults } = context;
  const { factor, label } = axisUnit(plot.unit, largest(plot));
  const styles = assign(plot.series.map((s) => s.name));
  const groups = groupLimits(plot.limits);
  const shown = plot.series.map(() => true);
  const host = h('div', { class: 'plot-host' });
  const line = h('div', { class: 'cursor-line' });
  const counts = plot.series.every((s) => isCount(plot, s));
  const empty = time.length === 0 || plot.series.length === 0;
  let u = null;
  let visible = false;
  let stale = { time: true, zoom: true, draw: true };
  let fixedWidth = null;

  const show = (i, on) => {
    shown[i] = on;
    legend.setShown(i, on);
    u?.setSeries(i + 1, { show: on });
  };
  const legend = createLegend(plot.series.map((s, i) => ({ name: s.name, ...styles[i] })), groups, {
    toggle: (i) => show(i, !shown[i]),
    only: (i) => {
      const others = shown.some((on, j) => on && j !== i);
      shown.forEach((_, j) => show(j, j === i || !others));
    },
    focus: (i) => u?.setSeries(i === null ? null : i + 1, { focus: true }),
    toggleLimit: (group) => { group.show = !group.show; applyZoom(); },
  });
  const node = h('figure', { class: 'plot', 'data-plot': plot.id, 'data-task': plot.task, tabindex: '-1' },
    h('figcaption', {}, h('span', { class: 'plot-title', title: plot.title }, plot.title), label && h('span', { class: 'plot-unit' }, label)),
    empty ? h('p', { class: 'quiet' }, 'No samples were recorded.') : host,
    legend.node);

  const whole = () => (time.length > 1 ? [time[0], time.at(-1)] : [time[0] - 0.5, time[0] + 0.5]);

  function create() {
    const axis = { stroke: () => cssVar('--muted'), font: FONT, grid: { stroke: () => cssVar('--grid'), width: 1 }, ticks: { show: false } };
    u = new uPlot({
      width: fixedWidth ?? Math.max(120, host.clientWidth), height: HEIGHT,
      legend: { show: false },
      focus: { alpha: 0.18 },
      padding: [8, 18, 0, 0],
      cursor: {
        x: false, y: false, points: { show: false },
        focus: { prox: 14 },
        drag: { x: true, y: false, dist: 6, setScale: false },
        bind: { dblclick: () => () => { clock.setZoom(null); return null; } },
      },
      scales: {
        x: { time: false, range: () => clock.zoom ?? whole() },
        y: { range: (_, low, high) => {
          const [from, to] = clock.zoom ?? whole();
          const [a, b] = limitRange(groups, below(time, from), Math.min(time.length - 1, below(time, to) + 1));
          return padded(Math.min(low ?? Infinity, a * factor), Math.max(high ?? -Infinity, b * factor));
        } },
      },
      axes: [
        { ...axis, size: 26, gap: 6, space: 70, values: (_, splits, i, space, step) => splits.map((v, k) => (k === splits.length - 1 ? `${tickText(v, step)} s` : tickText(v, step))) },
        { ...axis, size: 58, gap: 6, space: 34, values: (_, splits, i, space, step) => splits.map((v) => tickText(v, step)) },
      ],
      series: [{}, ...plot.series.map((s, i) => ({
        label: s.name, show: shown[i], stroke: () => hueColor(styles[i].hue), width: 1.5, dash: styles[i].dash, spanGaps: false,
        points: alonePoints(s.y, () => hueColor(styles[i].hue)),
        ...(isCount(plot, s) ? { paths: uPlot.paths.stepped({ align: 1 }) } : {}),
      }))],
      hooks: {
        drawAxes: [(self) => drawForbidden(self, groups, factor)],
        draw: [(self) => { drawLines(self, groups, factor); drawFaults(self, faults); queueMicrotask(placeLine); }],
        setSelect: [(self) => {
          const { left, width } = self.select;
          if (width < 4) return;
          self.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
          clock.setZoom([self.posToVal(left, 'x'), self.posToVal(left + width, 'x')]);
        }],
        setSeries: [(self, i, options) => { if (options.focus !== undefined) legend.setFocus(i === null ? null : i - 1); }],
      },
    }, [time, ...plot.series.map((s) => s.y.map((v) => (v === null ? null : v * factor)))], host);
    u.over.append(line);
    const timeAt = (event) => u.posToVal(event.clientX - u.over.getBoundingClientRect().left, 'x');
    u.over.addEventListener('mousemove', (event) => { if (!clock.playing && event.buttons === 0) clock.seek(timeAt(event)); });
    u.over.addEventListener('click', (event) => clock.seek(timeAt(event)));
    stale = { time: true, zoom: false, draw: false };
  }

  function applyTime() {
    if (!visible) { stale.time = true; return; }
    stale.time = false;
    const i = nearest(time, clock.time);
    legend.setValues(plot.series.map((s) => quantity(i < 0 ? null : s.y[i], plot.unit, 3, !counts)));
    legend.setLimitValues(groups.map((g) => (g.members.length === 1 ? quantity(g.members[0].y ? g.members[0].y[i] ?? null : g.members[0].value, plot.unit) : '')));
    placeLine();
  }

  // Also after every drawing: only then does uPlot know its scales.
  function placeLine() {
    if (!u) return;
    const x = u.valToPos(clock.time, 'x');
    const inside = x >= -0.5 && x <= u.over.clientWidth + 0.5;
    line.style.display = inside ? '' : 'none';
    if (inside) line.style.transform = `translateX(${x.toFixed(2)}px)`;
  }

  function applyZoom() {
    if (!u || !visible) { stale.zoom = true; return; }
    stale.zoom = false;
    // The range functions know the zoom; any change of the x scale makes them run.
    const [min, max] = clock.zoom ?? whole();
    u.batch(() => { u.setScale('x', { min, max }); u.redraw(false, true); });
    applyTime();
  }

  function relayout(width = null) {
    fixedWidth = width;
    if (!u) return;
    u.setSize({ width: width ?? Math.max(120, host.clientWidth), height: HEIGHT });
    applyTime();
  }

  return {
    node, applyTime, applyZoom,
    setVisible(on) {
      visible = on;
      if (!on) return;
      if (!u && !empty) create();
      if (u && Math.abs(u.width - host.clientWidth) > 1 && fixedWidth === null) relayout();
      if (stale.zoom) applyZoom();
      if (stale.draw) { stale.draw = false; u?.redraw(); }
      if (stale.time) applyTime();
    },
    /** Draws again in the colours of the present theme. */
    redraw() { if (u && visible) u.redraw(false); else stale.draw = true; },
    relayout: (width) => { if (visible || width) relayout(width); },
    destroy() { u?.destroy(); u = null; },
  };
}
