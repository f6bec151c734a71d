// What the tasks know about space: control points, walls, keep-out volumes, targets, traces.

import { BufferGeometry, Color, DoubleSide, EdgesGeometry, Float32BufferAttribute, Group, Line, LineBasicMaterial, LineDashedMaterial, LineLoop, LineSegments, Mesh, MeshBasicMaterial, MeshStandardMaterial, PlaneGeometry, SphereGeometry, Vector3 } from 'three';
import { Line2 } from 'three/addons/lines/Line2.js';
import { LineGeometry } from 'three/addons/lines/LineGeometry.js';
import { LineMaterial } from 'three/addons/lines/LineMaterial.js';
import { cssVar } from './dom.js';
import { hueColor } from './palette.js';
import { capsuleGeometry, geometry } from './robot.js';
import { createPoses } from './poses.js';

const Z = new Vector3(0, 0, 1);
const direction = (v) => { const n = new Vector3().fromArray(v); return n.lengthSq() > 0 ? n.normalize() : Z.clone(); };

/** Control points: small spheres fixed on links. */
export function createPoints(points, links) {
  const material = new MeshStandardMaterial({ roughness: 0.3 });
  const shape = new SphereGeometry(0.025, 20, 14);
  const nodes = points.map((p) => {
    const mesh = new Mesh(shape, material);
    mesh.position.fromArray(p.xyz);
    links[p.link].add(mesh);
    return { node: mesh, name: p.name };
  });
  return { nodes, recolor: () => material.color.set(cssVar('--scene-point')) };
}

/** Keep-out volumes: capsules or spheres fixed on links. */
export function createVolumes(volumes, links) {
  const material = new MeshStandardMaterial({ transparent: true, opacity: 0.16, depthWrite: false, roughness: 0.9 });
  const nodes = volumes.map((k) => {
    const from = new Vector3().fromArray(k.from);
    const to = new Vector3().fromArray(k.to);
    const length = from.distanceTo(to);
    const mesh = new Mesh(capsuleGeometry(k.radius, length), material);
    mesh.position.copy(from).add(to).multiplyScalar(0.5);
    if (length > 1e-9) mesh.quaternion.setFromUnitVectors(Z, to.sub(from).normalize());
    mesh.renderOrder = 2;
    links[k.link].add(mesh);
    return { node: mesh, name: k.name };
  });
  return { nodes, recolor: () => material.color.set(cssVar('--limit')) };
}

/** Walls: the plane, a dashed frame at the distance to be kept, and the normal towards the free side. */
export function createPlanes(planes, scene) {
  const fill = new MeshBasicMaterial({ transparent: true, opacity: 0.14, side: DoubleSide, depthWrite: false, polygonOffset: true, polygonOffsetFactor: -1, polygonOffsetUnits: -2 });
  const edge = new LineBasicMaterial({ transparent: true, opacity: 0.7 });
  const dashed = new LineDashedMaterial({ dashSize: 0.05, gapSize: 0.035 });
  const nodes = planes.map((p) => {
    const group = new Group();
    group.position.fromArray(p.point);
    group.quaternion.setFromUnitVectors(Z, direction(p.normal));
    const half = p.size / 2;
    const corners = (z) => [[-half, -half, z], [half, -half, z], [half, half, z], [-half, half, z]].map((c) => new Vector3(...c));
    const sheet = new Mesh(new PlaneGeometry(p.size, p.size), fill);
    sheet.renderOrder = 1;
    group.add(sheet, new LineLoop(new BufferGeometry().setFromPoints(corners(0)), edge));
    if (p.distance !== 0) {
      const frame = new Line(new BufferGeometry().setFromPoints([...corners(p.distance), corners(p.distance)[0]]), dashed);
      frame.computeLineDistances();
      group.add(frame);
    }
    const tip = Math.max(0.12, p.distance);
    const arrow = [[0, 0, 0], [0, 0, tip], [0, 0, tip], [0.03, 0, tip - 0.05], [0, 0, tip], [-0.03, 0, tip - 0.05]];
    group.add(new LineSegments(new BufferGeometry().setFromPoints(arrow.map((c) => new Vector3(...c))), edge));
    scene.add(group);
    return { node: group, name: p.name };
  });
  return {
    nodes,
    recolor() {
      fill.color.set(cssVar('--scene-plane'));
      edge.color.set(cssVar('--scene-plane'));
      dashed.color.set(cssVar('--limit'));
    },
  };
}

/** Obstacles: solid bodies in the room or on a link, which may move or be absent. */
export function createObstacles(obstacles, times, links, scene) {
  const material = new MeshStandardMaterial({ roughness: 0.8, transparent: true, opacity: 0.8 });
  // Walls and planes are looked through: the robot is behind them from most sides.
  const sheet = new MeshStandardMaterial({ roughness: 0.9, transparent: true, opacity: 0.22, side: DoubleSide, depthWrite: false });
  const isFlat = (v) => v.type === 'plane' || (v.type === 'box' && Math.min(...v.size) < 0.01);
  const nodes = obstacles.flatMap((o) => {
    const shape = geometry(o.visual);
    if (!shape) return [];
    const group = new Group();
    const mesh = new Mesh(shape, isFlat(o.visual) ? sheet : material);
    mesh.position.fromArray(o.visual.xyz);
    mesh.quaternion.set(...o.visual.wxyz.slice(1), o.visual.wxyz[0]);
    if (isFlat(o.visual)) mesh.renderOrder = 1;
    group.add(mesh);
    (o.link === null ? scene : links[o.link]).add(group);
    const frames = Math.min(times.length, Math.floor(o.data.length / 7));
    const name = o.truth === 'absent' ? `${o.name}, not there` : o.name;
    return [{ node: group, name, poses: createPoses(times.slice(0, frames), o.data, 1, 7) }];
  });
  return {
    nodes,
    recolor() {
      material.color.set(cssVar('--scene-obstacle'));
      sheet.color.set(cssVar('--scene-obstacle'));
    },
    show: (t, on) => nodes.forEach((n) => { n.node.visible = n.poses.place(n.node, 0, t) && on; }),
  };
}

/** True places of obstacles that the controller takes to be elsewhere: a shadow with dashed edges. */
export function createTruePlaces(obstacles, links, scene) {
  const dashed = new LineDashedMaterial({ dashSize: 0.04, gapSize: 0.025 });
  const shadow = new MeshBasicMaterial({ transparent: true, opacity: 0.2, depthWrite: false });
  const nodes = obstacles.filter((o) => Array.isArray(o.truth)).flatMap((o) => {
    const shape = geometry(o.visual);
    if (!shape) return [];
    const edges = new LineSegments(new EdgesGeometry(shape, 20), dashed);
    edges.computeLineDistances();
    const fill = new Mesh(shape, shadow);
    fill.renderOrder = 2;
    [edges, fill].forEach((part) => {
      part.position.fromArray(o.visual.xyz);
      part.quaternion.set(...o.visual.wxyz.slice(1), o.visual.wxyz[0]);
    });
    const group = new Group();
    group.position.fromArray(o.truth);
    group.quaternion.set(...o.truth.slice(4), o.truth[3]);
    group.add(edges, fill);
    (o.link === null ? scene : links[o.link]).add(group);
    return [{ node: group, name: `${o.name}, true place` }];
  });
  return { nodes, recolor: () => [dashed, shadow].forEach((m) => m.color.set(cssVar('--ink'))) };
}

const AXES = ['--axis-x', '--axis-y', '--axis-z'];

/** Targets: three axes where a frame should be. */
export function createTargets(targets, times, scene) {
  const materials = AXES.map(() => new LineMaterial({ linewidth: 3 }));
  const nodes = targets.map((target) => {
    const group = new Group();
    materials.forEach((material, k) => {
      const tip = [0, 0, 0];
      tip[k] = 0.16;
      group.add(new Line2(new LineGeometry().setPositions([0, 0, 0, ...tip]), material));
    });
    scene.add(group);
    const poses = createPoses(times, target.data, 1, 7);
    return { node: group, name: target.name, poses };
  });
  return {
    nodes,
    recolor: () => materials.forEach((m, k) => m.color.set(cssVar(AXES[k]))),
    show: (t, on) => nodes.forEach((n) => { n.node.visible = n.poses.place(n.node, 0, t) && on; }),
  };
}

/** Traces: the whole path faintly, the part already travelled clearly. */
export function createTraces(traces, poses, scene) {
  const nodes = traces.map((trace, index) => {
    const path = [];
    const point = new Vector3();
    for (let i = 0; i < poses.frames; i += 1) path.push(...poses.point(i, trace.link, trace.xyz, point).toArray());
    for (let k = 0; k < path.length; k += 1) if (!Number.isFinite(path[k])) path[k] = path[k - 3] ?? 0;
    const group = new Group();
    const whole = new LineBasicMaterial({ transparent: true, opacity: 0.35 });
    const past = new LineMaterial({ linewidth: 2.5 });
    group.add(new Line(new BufferGeometry().setAttribute('position', new Float32BufferAttribute(path, 3)), whole));
    const travelled = path.length > 3 ? new Line2(new LineGeometry().setPositions(path), past) : null;
    if (travelled) { travelled.frustumCulled = false; group.add(travelled); }
    scene.add(group);
    const end = new Group();
    group.add(end);
    return { node: group, label: end, name: trace.name, whole, past, travelled, index, at: (i) => end.position.fromArray(path, i * 3) };
  });
  return {
    nodes,
    recolor: () => nodes.forEach((n) => {
      const color = new Color(hueColor(n.index % 7));
      n.whole.color.copy(color);
      n.past.color.copy(color);
    }),
    show(t) {
      if (poses.frames === 0) return;
      const [i] = poses.between(t);
      nodes.forEach((n) => {
        if (n.travelled) { n.travelled.geometry.instanceCount = i; n.travelled.visible = i > 0; }
        n.at(i);
      });
    },
  };
}

