// Draws limits on a plot: a dashed red line, and a faint red on the side where the values must not go.

import { cssVar } from './dom.js';

/** Limits with one name share one entry in the legend; equal ones are drawn once. */
export function groupLimits(limits) {
  const groups = new Map();
  const seen = new Set();
  for (const limit of limits) {
    if (limit.y === null) {
      const key = `${limit.name}\u0000${limit.side}\u0000${limit.value}`;
      if (seen.has(key)) continue;
      seen.add(key);
    }
    if (!groups.has(limit.name)) groups.set(limit.name, { name: limit.name, show: true, members: [] });
    groups.get(limit.name).members.push(limit);
  }
  return [...groups.values()];
}

/** Smallest and largest value of the shown limits between the samples `from` and `to`. */
export function limitRange(groups, from, to) {
  let low = Infinity;
  let high = -Infinity;
  for (const group of groups) {
    if (!group.show) continue;
    for (const { value, y } of group.members) {
      const values = y === null ? [value] : y.slice(from, to + 1);
      for (const v of values) {
        if (v === null) continue;
        low = Math.min(low, v);
        high = Math.max(high, v);
      }
    }
  }
  return [low, high];
}

// The line of a limit as runs of canvas points; a gap in the values ends a run.
function runs(u, limit, factor) {
  const { left, width } = u.bbox;
  if (limit.y === null) {
    const y = u.valToPos(limit.value * factor, 'y', true);
    return [[[left, y], [left + width, y]]];
  }
  const out = [];
  let run = [];
  limit.y.forEach((v, i) => {
    if (v !== null) run.push([u.valToPos(u.data[0][i], 'x', true), u.valToPos(v * factor, 'y', true)]);
    else if (run.length) { out.push(run); run = []; }
  });
  if (run.length) out.push(run);
  return out;
}

function each(u, groups, factor, draw) {
  const { ctx, bbox } = u;
  ctx.save();
  ctx.beginPath();
  ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
  ctx.clip();
  for (const group of groups) {
    if (!group.show) continue;
    for (const limit of group.members) for (const run of runs(u, limit, factor)) draw(ctx, bbox, limit, run);
  }
  ctx.restore();
}

/** The forbidden sides; drawn under the series. */
export function drawForbidden(u, groups, factor) {
  // Many limits on one plot would add up to a solid red.
  const members = groups.reduce((n, g) => n + (g.show ? g.members.length : 0), 0);
  const alpha = 0.09 / Math.max(1, members / 4);
  const color = cssVar('--limit');
  each(u, groups, factor, (ctx, bbox, limit, run) => {
    const edge = limit.side === 'upper' ? bbox.top : bbox.top + bbox.height;
    ctx.globalAlpha = alpha;
    ctx.fillStyle = color;
    ctx.beginPath();
    run.forEach(([x, y], i) => (i ? ctx.lineTo(x, y) : ctx.moveTo(x, y)));
    ctx.lineTo(run.at(-1)[0], edge);
    ctx.lineTo(run[0][0], edge);
    ctx.fill();
  });
}

/** The lines themselves; drawn over the series. */
export function drawLines(u, groups, factor) {
  const color = cssVar('--limit');
  each(u, groups, factor, (ctx, bbox, limit, run) => {
    ctx.strokeStyle = color;
    ctx.lineWidth = 1.25 * devicePixelRatio;
    ctx.setLineDash([6 * devicePixelRatio, 4 * devicePixelRatio]);
    ctx.beginPath();
    run.forEach(([x, y], i) => (i ? ctx.lineTo(x, y) : ctx.moveTo(x, y)));
    ctx.stroke();
  });
}

/** Thin vertical lines where a fault was raised. */
export function drawFaults(u, times) {
  const { ctx, bbox } = u;
  ctx.save();
  ctx.fillStyle = cssVar('--bad');
  ctx.globalAlpha = 0.55;
  for (const t of times) {
    const x = u.valToPos(t, 'x', true);
    if (x >= bbox.left && x <= bbox.left + bbox.width) ctx.fillRect(x, bbox.top, devicePixelRatio, bbox.height);
  }
  ctx.restore();
}
