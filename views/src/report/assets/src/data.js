// Reads the data of the report (format version 1) and makes it regular: every list is a list, every
// number finite or null, every series as long as the time. What is missing becomes empty, never an error.

const VERSION = 1;

export const list = (x) => (Array.isArray(x) ? x : []);
export const num = (x) => (typeof x === 'number' && Number.isFinite(x) ? x : null);
const text = (x, otherwise = '') => (x === null || x === undefined ? otherwise : String(x));
const object = (x) => (x !== null && typeof x === 'object' && !Array.isArray(x) ? x : {});
const flat = (x) => (Array.isArray(list(x)[0]) ? x.flat(Infinity) : list(x));
const vector = (x, n, otherwise) => (list(x).length >= n && x.slice(0, n).every((v) => num(v) !== null) ? x.slice(0, n) : otherwise);

/** The parsed and regular data, or `{ error }` with a sentence for the reader. */
export function readData(source) {
  if (source.trim().startsWith('@@')) return { error: 'This is the empty template: no run has been written into it.' };
  let raw;
  try {
    raw = JSON.parse(source);
  } catch (problem) {
    return { error: `The data of this report cannot be read: ${problem.message}` };
  }
  if (raw === null || typeof raw !== 'object' || Array.isArray(raw)) return { error: 'The data of this report is not an object.' };
  return regular(raw);
}

function regular(raw) {
  const notes = [];
  if (raw.version !== VERSION) notes.push(`This page reads data of version ${VERSION}; the file says ${text(raw.version, 'nothing')}. Some parts may be missing.`);
  const keep = increasing(list(raw.time));
  const time = keep.map((i) => raw.time[i]);
  if (keep.length < list(raw.time).length) notes.push(`${raw.time.length - keep.length} samples without a valid time were left out.`);
  const pick = (y) => keep.map((i) => num(list(y)[i]));
  const tick = object(raw.tick_us);
  const verdict = object(raw.verdict);
  return {
    notes,
    title: text(raw.title) || text(raw.program) || 'Run',
    program: text(raw.program),
    spec: text(raw.spec),
    generatedBy: text(raw.generated_by),
    duration: num(raw.duration) ?? (time.at(-1) ?? null),
    period: num(raw.period),
    ticks: num(raw.ticks),
    verdict: { ok: typeof verdict.ok === 'boolean' ? verdict.ok : null, text: text(verdict.text) },
    tick: { median: num(tick.median), p99: num(tick.p99), max: num(tick.max) },
    faults: list(raw.faults).map(object).map((f) => ({ time: num(f.time), kind: text(f.kind, 'fault'), text: text(f.text) })),
    expectations: list(raw.expectations).map(object).map((e) => ({
      label: text(e.label), text: text(e.text), verdict: text(e.verdict, 'undecided'), margin: num(e.margin), unit: text(e.unit), at: num(e.at), undefinedAt: num(e.undefined_at),
    })),
    states: stays(list(raw.states).map(object)),
    entries: list(raw.entries).map(object).map((e) => ({ state: text(e.state), count: num(e.count) })).filter((e) => e.state && e.count !== null),
    tasks: list(raw.summary_rows).map(object).map(taskRow),
    levels: list(raw.levels).map(object).map((l) => ({
      name: text(l.name), hard: l.hard === true, rows: num(l.rows), freedom: num(l.freedom),
      saturated: num(l.saturated_share), violation: num(l.worst_violation),
    })),
    heldBack: list(raw.held_back).map(object).map((b) => ({
      level: text(b.level), by: text(b.by_task), row: text(b.by_row), share: num(b.share), at: num(b.at_s),
    })),
    joints: list(raw.joints).map(object).map((j) => ({
      joint: text(j.joint), unit: text(j.unit), acceleration: num(j.acceleration), at: num(j.at),
      reversals: num(j.reversals), firstReversal: num(j.first_reversal), jumps: num(j.jumps), firstJump: num(j.first_jump),
    })),
    stopping: list(raw.stopping).map(object).map((s) => ({
      stack: text(s.stack), states: list(s.states).map((x) => text(x)), time: num(s.time),
      links: list(s.links).map(object).map((l) => ({ link: text(l.link), way: num(l.way) })),
    })),
    time,
    plots: list(raw.plots).map(object).map((p, i) => plot(p, i, pick)),
    scene: scene(raw.scene),
  };
}

// In order of time; those without a time are left out.
function stays(all) {
  const timed = all.map((s) => ({ state: text(s.state), from: num(s.from), to: num(s.to) ?? num(s.from) }));
  return timed.filter((s) => s.from !== null && s.state !== '').sort((a, b) => a.from - b.from);
}

function increasing(time) {
  const keep = [];
  let last = -Infinity;
  time.forEach((t, i) => {
    if (num(t) === null || t <= last) return;
    keep.push(i);
    last = t;
  });
  return keep;
}

const taskRow = (r) => ({
  task: text(r.task), kind: text(r.kind), level: text(r.level),
  active: num(r.active_share), activeRows: list(r.active_rows).map((x) => text(x)),
  measures: list(r.measures).map(object).map((m) => ({
    name: text(m.name), unit: text(m.unit), smallest: num(m.smallest), largest: num(m.largest), final: num(m.final), at: num(m.at),
  })),
});

const plot = (p, i, pick) => ({
  id: text(p.id, `plot-${i}`), group: text(p.group) || 'Plots', title: text(p.title) || text(p.id) || 'Plot',
  unit: text(p.unit), task: text(p.task),
  series: list(p.series).map(object).map((s) => ({ name: text(s.name), y: pick(s.y) })),
  limits: list(p.limits).map(object)
    .map((l) => ({ name: text(l.name) || 'limit', side: l.side === 'upper' ? 'upper' : 'lower', value: num(l.value), y: Array.isArray(l.y) ? pick(l.y) : null }))
    .filter((l) => l.value !== null || l.y !== null),
});

function scene(raw) {
  if (raw === null || raw === undefined || typeof raw !== 'object') return null;
  const links = list(raw.links).map(object).map((l) => ({ name: text(l.name), visuals: list(l.visuals).map(object).map(visual) }));
  const poses = object(raw.poses);
  const stride = num(poses.stride) ?? 7;
  const data = flat(poses.data);
  const times = flat(poses.times);
  const width = links.length * stride;
  const frames = width > 0 && stride >= 7 ? Math.min(num(poses.frames) ?? Infinity, times.length, Math.floor(data.length / width)) : 0;
  const onLink = (item) => Number.isInteger(item.link) && item.link >= 0 && item.link < links.length;
  return {
    up: raw.up === 'y' ? 'y' : 'z',
    links,
    poses: { stride, frames, times: times.slice(0, frames), data },
    planes: list(raw.planes).map(object).map((p) => ({
      name: text(p.name), point: vector(p.point, 3, [0, 0, 0]), normal: vector(p.normal, 3, [0, 0, 1]),
      size: num(p.size) ?? 2, distance: num(p.distance) ?? 0,
    })),
    points: list(raw.points).map(object).filter(onLink).map(anchor),
    traces: list(raw.traces).map(object).filter(onLink).map(anchor),
    keepOut: list(raw.keep_out).map(object).filter(onLink).map((k) => {
      const from = vector(k.from, 3, [0, 0, 0]);
      return { name: text(k.name), link: k.link, from, to: vector(k.to, 3, from), radius: num(k.radius) ?? 0 };
    }).filter((k) => k.radius > 0),
    obstacles: list(raw.obstacles).map(object).map((o) => ({
      name: text(o.name), link: onLink(o) ? o.link : null, visual: visual(object(o.visual)), data: flat(o.data),
      truth: o.truth === 'absent' ? 'absent' : vector(o.truth, 7, null),
    })).filter((o) => o.data.length >= 7),
    people: list(raw.people).map(object).map((p) => {
      const points = list(p.points).map((n) => text(n));
      const ends = (l) => list(l).length === 2 && l.every((i) => Number.isInteger(i) && i >= 0 && i < points.length);
      return { name: text(p.name), points, links: list(p.links).filter(ends), data: flat(p.data) };
    }).filter((p) => p.points.length > 0 && p.data.length >= 4 * p.points.length),
    targets: list(raw.targets).map(object).map((t) => ({ name: text(t.name), data: flat(t.data) })).filter((t) => t.data.length >= 7),
  };
}

const anchor = (a) => ({ name: text(a.name), link: a.link, xyz: vector(a.xyz, 3, [0, 0, 0]) });

const visual = (v) => ({
  type: text(v.type), size: vector(v.size, 3, null), radius: num(v.radius), length: num(v.length),
  xyz: vector(v.xyz, 3, [0, 0, 0]), wxyz: vector(v.wxyz, 4, [1, 0, 0, 0]), color: vector(v.color, 3, null),
  opacity: list(v.color).length >= 4 ? num(v.color[3]) ?? 1 : 1,
  vertices: flat(v.vertices), faces: flat(v.faces),
});

/** The index of the sample nearest to `t` in an increasing list, or -1 if the list is empty. */
export function nearest(times, t) {
  if (times.length === 0) return -1;
  const i = below(times, t);
  return i + 1 < times.length && times[i + 1] - t < t - times[i] ? i + 1 : i;
}

/** The index of the last sample at or before `t`; 0 if `t` is before all of them. */
export function below(times, t) {
  let low = 0;
  let high = times.length - 1;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (times[middle] <= t) low = middle;
    else high = middle - 1;
  }
  return low;
}
