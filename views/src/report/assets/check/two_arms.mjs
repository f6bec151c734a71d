// An invented run of 50 s: two arms of seven joints on a torso, moving beside a wall over the base.
// Plots and replay come from the same kinematics, so that they must agree with each other.

const T = 50;
const SAMPLES = 2000;
const FRAMES = 500;

// Rotation matrices as rows, and poses { R, p }.
const mul = (A, B) => A.map((r) => [0, 1, 2].map((j) => r[0] * B[0][j] + r[1] * B[1][j] + r[2] * B[2][j]));
const apply = (R, v) => R.map((r) => r[0] * v[0] + r[1] * v[1] + r[2] * v[2]);
const add = (a, b) => a.map((x, i) => x + b[i]);
const sub = (a, b) => a.map((x, i) => x - b[i]);
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const norm = (a) => Math.sqrt(dot(a, a));
const rx = (a) => [[1, 0, 0], [0, Math.cos(a), -Math.sin(a)], [0, Math.sin(a), Math.cos(a)]];
const ry = (a) => [[Math.cos(a), 0, Math.sin(a)], [0, 1, 0], [-Math.sin(a), 0, Math.cos(a)]];
const rz = (a) => [[Math.cos(a), -Math.sin(a), 0], [Math.sin(a), Math.cos(a), 0], [0, 0, 1]];
const compose = (X, Y) => ({ R: mul(X.R, Y.R), p: add(X.p, apply(X.R, Y.p)) });
const I = rz(0);

function quaternion(R) {
  const w = Math.sqrt(Math.max(0, 1 + R[0][0] + R[1][1] + R[2][2])) / 2;
  const x = Math.sqrt(Math.max(0, 1 + R[0][0] - R[1][1] - R[2][2])) / 2;
  const y = Math.sqrt(Math.max(0, 1 - R[0][0] + R[1][1] - R[2][2])) / 2;
  const z = Math.sqrt(Math.max(0, 1 - R[0][0] - R[1][1] + R[2][2])) / 2;
  if (w > 1e-6) return [w, Math.sign(R[2][1] - R[1][2]) * x, Math.sign(R[0][2] - R[2][0]) * y, Math.sign(R[1][0] - R[0][1]) * z];
  return [0, x, y, z];
}

const SEGMENTS = [0.12, 0.14, 0.14, 0.14, 0.14, 0.12, 0.1];
const LIMITS = [2.9, 1.8, 2.9, 2.1, 2.9, 1.9, 2.9];

function angle(side, k, t) {
  const s = side === 'left' ? 1 : -1;
  const middle = [0.5 * s, -0.95 * s, 0, -1.25 * s, 0, -0.5 * s, 0][k];
  const swing = [0.5, 0.28, 0.6, 0.45, 0.8, 0.4, 1.2][k];
  const rise = Math.min(1, t / 4);
  return middle + swing * rise * rise * (3 - 2 * rise) * Math.sin((0.28 + 0.05 * k) * t + k + (s > 0 ? 0 : 1.1));
}

function robot(t) {
  const base = { R: I, p: [0, 0, 0] };
  const torso = { R: rz(0.12 * Math.sin(0.2 * t)), p: [0, 0, 0.42] };
  const head = compose(torso, { R: rz(0.3 * Math.sin(0.5 * t)), p: [0.02, 0, 0.92] });
  const poses = [base, torso, head];
  for (const side of ['left', 'right']) {
    const s = side === 'left' ? 1 : -1;
    let X = compose(torso, { R: rx((-Math.PI / 2) * s), p: [0, 0.2 * s, 0.62] });
    SEGMENTS.forEach((length, k) => {
      const q = angle(side, k, t);
      X = compose(X, { R: k % 2 ? rx(q * 1) : rz(q), p: [0, 0, k ? SEGMENTS[k - 1] : 0] });
      poses.push(X);
    });
  }
  return poses;
}

const at = (pose, xyz) => add(pose.p, apply(pose.R, xyz));
function toSegment(p, a, b) {
  const d = sub(b, a);
  const l = dot(d, d);
  const u = l > 0 ? Math.min(1, Math.max(0, dot(sub(p, a), d) / l)) : 0;
  return norm(sub(p, add(a, d.map((x) => x * u))));
}

const LEFT = 3;
const RIGHT = 10;
const POINTS = [
  ['left_elbow', LEFT + 3, [0, 0, 0]], ['left_wrist', LEFT + 5, [0, 0, 0]], ['left_tool', LEFT + 6, [0, 0, 0.1]],
  ['right_elbow', RIGHT + 3, [0, 0, 0]], ['right_wrist', RIGHT + 5, [0, 0, 0]], ['right_tool', RIGHT + 6, [0, 0, 0.1]],
];
const DECK = 0.3;

// A person who passes in front, and is out of sight for a third of the way: the uncertainty grows, and then nobody knows.
function walker(t) {
  const hidden = t - 0.4 * T;
  if (hidden > 0.15 * T && hidden < 0.3 * T) return Array(8).fill(null);
  const uncertainty = hidden > 0 && hidden < 0.15 * T ? 0.05 * hidden : 0;
  const y = -1.5 + (3 * t) / T;
  return [1, y, 1.3, uncertainty, 0.8, y + 0.3, 1, uncertainty];
}

function visuals() {
  const box = (size, xyz = [0, 0, 0], color = null) => ({ type: 'box', size, xyz, wxyz: [1, 0, 0, 0], color });
  const capsule = (radius, length, xyz) => ({ type: 'capsule', radius, length, xyz, wxyz: [1, 0, 0, 0], color: null });
  const links = [
    { name: 'base', visuals: [box([0.62, 0.5, 0.26], [0, 0, 0.17]), { type: 'cylinder', radius: 0.1, length: 0.2, xyz: [0, 0, 0.36], wxyz: [1, 0, 0, 0], color: null }] },
    { name: 'torso', visuals: [capsule(0.11, 0.5, [0, 0, 0.32]), { type: 'capsule', radius: 0.075, length: 0.24, xyz: [0, 0, 0.62], wxyz: [Math.SQRT1_2, Math.SQRT1_2, 0, 0], color: null }] },
    { name: 'head', visuals: [{ type: 'sphere', radius: 0.11, xyz: [0, 0, 0], wxyz: [1, 0, 0, 0], color: [0.93, 0.94, 0.95, 1] }, box([0.03, 0.15, 0.05], [0.1, 0, 0.01], [0.13, 0.16, 0.2, 1])] },
  ];
  for (const side of ['left', 'right']) {
    SEGMENTS.forEach((length, k) => links.push({
      name: `arm_${side}_${k + 1}_link`,
      visuals: k < 6 ? [capsule(0.06 - 0.004 * k, length, [0, 0, length / 2])] : [capsule(0.035, 0.05, [0, 0, 0.02]), box([0.09, 0.03, 0.03], [0, 0, 0.07], [0.2, 0.22, 0.25, 1])],
    }));
  }
  return links;
}

function scene() {
  const times = Array.from({ length: FRAMES }, (_, i) => (i * T) / (FRAMES - 1));
  const round = (x) => Math.round(x * 1e5) / 1e5;
  const poseData = (pose) => [...pose.p, ...quaternion(pose.R)].map(round);
  const all = times.map(robot);
  const target = (link) => all.map((poses, i) => {
    const pose = poses[link];
    const lag = 0.03 * Math.exp(-times[i] / 6);
    return poseData({ R: pose.R, p: add(at(pose, [0, 0, 0.1]), [lag, 0, lag]) });
  }).flat();
  return {
    up: 'z', links: visuals(),
    poses: { stride: 7, frames: FRAMES, times, data: all.flatMap((poses) => poses.flatMap(poseData)) },
    planes: [{ name: 'deck', point: [0.35, 0, DECK], normal: [0, 0, 1], size: 1.5, distance: 0.06 }],
    points: POINTS.map(([name, link, xyz]) => ({ name, link, xyz })),
    keep_out: [{ name: 'torso', link: 1, from: [0, 0, 0], to: [0, 0, 0.62], radius: 0.15 }, { name: 'head', link: 2, from: [0, 0, 0], to: [0, 0, 0], radius: 0.22 }],
    people: [{ name: 'walker', points: ['chest', 'wrist'], links: [[0, 1]], data: times.flatMap(walker) }],
    targets: [{ name: 'left target', data: target(LEFT + 6) }, { name: 'right target', data: target(RIGHT + 6) }],
    traces: [{ name: 'left_tool path', link: LEFT + 6, xyz: [0, 0, 0.1] }, { name: 'right_tool path', link: RIGHT + 6, xyz: [0, 0, 0.1] }],
  };
}

/** The data of the run, as `hierarq run` would write them. */
export function twoArms() {
  const time = Array.from({ length: SAMPLES }, (_, i) => Math.round(((i * T) / SAMPLES) * 1000) / 1000);
  const states = time.map(robot);
  const noise = (k, t) => Math.sin(57.1 * t + 13 * k) * Math.sin(91.3 * t + 7 * k);
  const point = ([, link, xyz]) => states.map((poses) => at(poses[link], xyz));
  const paths = POINTS.map(point);
  const series = (list, f) => list.map(([name], i) => ({ name, y: f(i) }));
  const minimum = (value) => [{ name: 'minimum', value, side: 'lower' }];
  const deck = series(POINTS, (i) => paths[i].map((p) => p[2] - DECK));
  const body = series(POINTS, (i) => states.map((poses, n) => toSegment(paths[i][n], poses[1].p, at(poses[1], [0, 0, 0.62]))));
  const head = series(POINTS, (i) => states.map((poses, n) => norm(sub(paths[i][n], poses[2].p))));
  const arms = [[0, 3], [1, 4], [2, 5]].map(([a, b]) => ({ name: `${POINTS[a][0]} – ${POINTS[b][0]}`, y: paths[a].map((p, n) => norm(sub(p, paths[b][n]))) }));
  const decay = (scale, rate, k, floor) => time.map((t) => scale * Math.exp(-t / rate) + floor * (1 + 0.6 * noise(k, t)));
  const joints = ['left', 'right'].flatMap((side) => SEGMENTS.map((_, k) => [`arm_${side}_${k + 1}_joint`, side, k]));
  const rate = (side, k, t) => (angle(side, k, t + 1e-4) - angle(side, k, t - 1e-4)) / 2e-4;
  const plot = (id, group, title, unit, list, limits = [], task = id) => ({ id, group, title, unit, task, series: list, limits });
  const least = (list) => {
    let best = [Infinity, 0];
    list.forEach((s) => s.y.forEach((v, n) => { if (v < best[0]) best = [v, time[n]]; }));
    return best;
  };
  const margin = (task, kind, list, limit, share, rows) => {
    const [value, when] = least(list);
    return { task, kind, level: 'collision', measures: [{ name: 'margin', unit: 'm', smallest: value - limit, final: Math.min(...list.map((s) => s.y.at(-1))) - limit, at: when }], active_share: share, active_rows: rows };
  };
  const both = (value, name) => [{ name, value: -value, side: 'lower' }, { name, value, side: 'upper' }];
  return {
    version: 1, title: '3.A safety tasks', program: 'safety_tasks', spec: 'examples/safety_tasks.hq', generated_by: 'hierarq 0.1.0',
    duration: T, period: 0.01, ticks: 5000,
    verdict: { ok: true, text: `No limit or distance was passed; smallest margin ${((least(deck)[0] - 0.06) * 1000).toFixed(1)} mm (deck).` },
    summary_rows: [
      { task: 'limits', kind: 'joint_limits', level: 'limits', measures: [{ name: 'position', unit: 'rad', smallest: 0.0214, final: 0.31, at: 17.42 }, { name: 'velocity', unit: 'rad/s', smallest: 0.93, final: 1.1, at: 6.2 }], active_share: 0.034, active_rows: ['arm_left_4_joint', 'arm_right_6_joint'] },
      margin('deck', 'virtual_wall', deck, 0.06, 0.12, ['left_tool', 'right_tool', 'left_wrist']),
      margin('torso', 'self_collision', body, 0.15, 0.07, ['left_tool']),
      margin('head', 'self_collision', head, 0.22, 0, []),
      margin('arms', 'self_collision', arms, 0.1, 0.0004, ['left_tool – right_tool']),
      { task: 'reach', kind: 'frame_pose', level: 'motion', measures: [{ name: 'position', unit: 'm', largest: 0.104, final: 2.3e-6, at: 0 }, { name: 'orientation', unit: 'rad', largest: 0.21, final: 3.4e-4, at: 0.01 }], active_share: null },
      { task: 'swivel', kind: 'swivel_angle', level: 'posture', measures: [{ name: 'angle', unit: 'rad', largest: 0.785, final: 0.0021, at: 0 }], active_share: null },
    ],
    levels: [
      { name: 'limits', hard: true, rows: 28, freedom: 14, saturated_share: 0.034, worst_violation: 0 },
      { name: 'collision', hard: true, rows: 21, freedom: 14, saturated_share: 0.19, worst_violation: 3e-15 },
      { name: 'motion', hard: false, rows: 12, freedom: 2, saturated_share: 0.31, worst_violation: 0.0231 },
      { name: 'posture', hard: false, rows: 2, freedom: 0, saturated_share: 0.02, worst_violation: 0.41 },
    ],
    tick_us: { median: 98, p99: 312, max: 911 }, faults: [], time,
    plots: [
      plot('deck', 'Safety margins', 'deck: distance to the wall', 'm', deck, minimum(0.06)),
      plot('torso', 'Safety margins', 'torso: distance to the axis', 'm', body, minimum(0.15)),
      plot('head', 'Safety margins', 'head: distance to the centre', 'm', head, minimum(0.22)),
      plot('arms', 'Safety margins', 'arms: distance between the arms', 'm', arms, minimum(0.1)),
      plot('reach', 'Task errors', 'reach: position error', 'm', ['x', 'y', 'z'].map((name, k) => ({ name, y: decay([0.08, -0.05, 0.04][k], 2 + k, k, 8e-6) }))),
      plot('reach_o', 'Task errors', 'reach: orientation error', 'rad', ['x', 'y', 'z'].map((name, k) => ({ name, y: decay([0.2, -0.12, 0.07][k], 3 + k, k + 4, 4e-5) })), [], 'reach'),
      plot('swivel', 'Task errors', 'swivel: angle error', 'rad', ['left', 'right'].map((name, k) => ({ name, y: decay([0.78, -0.6][k], 5, k + 9, 1e-4) })), [{ name: 'funnel', y: time.map((t) => 0.9 * Math.exp(-t / 6) + 0.05), side: 'upper' }, { name: 'funnel', y: time.map((t) => -0.9 * Math.exp(-t / 6) - 0.05), side: 'lower' }]),
      plot('q', 'Joint positions', 'joint positions, normalised', '', joints.map(([name, side, k]) => ({ name, y: time.map((t) => angle(side, k, t) / LIMITS[k]) })), both(1, 'limit'), 'limits'),
      plot('dq', 'Joint velocities', 'joint velocities', 'rad/s', joints.map(([name, side, k]) => ({ name, y: time.map((t) => rate(side, k, t)) })), both(1.2, 'limit'), 'limits'),
      plot('violation', 'Hierarchy', 'violation per level', '', ['motion', 'posture'].map((name, k) => ({ name, y: time.map((t) => Math.max(0, 0.02 * Math.sin(0.4 * t + 2 * k) - 0.012) * (1 + k)) })), [], ''),
      plot('active', 'Hierarchy', 'active rows per level', '', ['limits', 'collision'].map((name, k) => ({ name, y: time.map((t) => Math.max(0, Math.round(2.4 * Math.sin(0.31 * t + k) - 0.6 + k))) })), [], ''),
      plot('tick', 'Timing', 'time of a tick', 'us', [{ name: 'tick', y: time.map((t, n) => 96 + 8 * noise(3, t) + (n % 311 === 17 ? 380 : 0) + (n === 940 ? 800 : 0)) }], [], ''),
    ],
    scene: scene(),
  };
}
