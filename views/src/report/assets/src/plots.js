// All plots, in sections. Only plots near the window are drawn and updated.

import { h } from './dom.js';
import { createPlot } from './plot.js';

// Widths of a plot on paper, in px: half a row and a whole row of A4 or Letter.
const PRINT_HALF = 316;
const PRINT_WHOLE = 650;

/** `context`: `{ time, clock, faults }`. Returns `{ node, sections, reveal(task), redraw, destroy }`. */
export function createPlots(plots, context) {
  const groups = new Map();
  for (const plot of plots) {
    if (!groups.has(plot.group)) groups.set(plot.group, []);
    groups.get(plot.group).push(plot);
  }
  const made = new Map();
  const sections = [...groups].map(([name, members]) => {
    const items = members.map((plot) => {
      const item = createPlot(plot, context);
      made.set(item.node, item);
      return item.node;
    });
    const node = h('section', { class: 'group' }, h('h2', {}, name), h('div', { class: 'plot-grid' }, items));
    return { name, node };
  });
  const node = h('div', { class: 'plots' }, sections.map((s) => s.node));
  const all = [...made.values()];

  const near = new IntersectionObserver((entries) => entries.forEach((e) => made.get(e.target)?.setVisible(e.isIntersecting)), { rootMargin: '400px 0px' });
  const sizes = new ResizeObserver((entries) => entries.forEach((e) => made.get(e.target)?.relayout()));
  made.forEach((_, figure) => { near.observe(figure); sizes.observe(figure); });

  let live = true;
  let waiting = false;
  context.clock.on('time', () => {
    if (waiting) return;
    waiting = true;
    requestAnimationFrame(() => { waiting = false; if (live) all.forEach((p) => p.applyTime()); });
  });
  context.clock.on('zoom', () => { if (live) all.forEach((p) => p.applyZoom()); });

  return {
    node, sections,
    /** Scrolls to the first plot of a task; false if it has none. */
    reveal(task) {
      const figure = [...made.keys()].find((f) => f.dataset.task === task);
      figure?.scrollIntoView({ behavior: 'smooth', block: 'center' });
      figure?.focus({ preventScroll: true });
      return Boolean(figure);
    },
    has: (task) => plots.some((p) => p.task === task),
    redraw() { all.forEach((p) => p.redraw()); },
    /** Before printing: every plot is drawn, as wide as the paper allows. */
    print(on) {
      all.forEach((p) => {
        if (on) p.relayout(p.node.matches(':only-child') ? PRINT_WHOLE : PRINT_HALF);
        if (on) p.setVisible(true);
        else p.relayout(null);
        p.redraw();
      });
    },
    destroy() {
      live = false;
      near.disconnect();
      sizes.disconnect();
      all.forEach((p) => p.destroy());
      node.remove();
    },
  };
}
