// People: the points that were tracked, the lines between them, and around each point how far it may be from there.

import { CylinderGeometry, Group, Mesh, MeshStandardMaterial, SphereGeometry, Vector3 } from 'three';
import { below } from './data.js';
import { cssVar } from './dom.js';

const STRIDE = 4;
const POINT = 0.05;
const LINK = 0.025;
// An uncertainty below this is within the point itself.
const VISIBLE = 0.01;
const Y = new Vector3(0, 1, 0);

/** Positions that are near a box, for the camera: people come from afar. */
export function near(people, box, distance, out) {
  const point = new Vector3();
  const around = box.clone().expandByScalar(distance);
  people.forEach(({ data }) => {
    for (let at = 0; at + STRIDE <= data.length; at += STRIDE) {
      point.fromArray(data, at);
      if (around.containsPoint(point)) out.expandByPoint(point);
    }
  });
}

/** Each person is as wide as its points; `show` places them, and hides those that nobody knew of. */
export function createPeople(people, times, scene) {
  const body = new MeshStandardMaterial({ roughness: 0.6 });
  const shell = new MeshStandardMaterial({ transparent: true, opacity: 0.18, depthWrite: false, roughness: 0.9 });
  const ball = new SphereGeometry(1, 24, 16);
  const rod = new CylinderGeometry(LINK, LINK, 1, 16);
  const nodes = people.map((person) => {
    const group = new Group();
    const points = person.points.map(() => {
      const point = new Mesh(ball, body);
      point.scale.setScalar(POINT);
      point.castShadow = true;
      const around = new Mesh(ball, shell);
      around.renderOrder = 2;
      group.add(point, around);
      return { point, around };
    });
    const links = person.links.map((ends) => {
      const link = new Mesh(rod, body);
      link.castShadow = true;
      group.add(link);
      return { link, ends };
    });
    scene.add(group);
    return { node: group, label: points[0].point, name: person.name, points, links, data: person.data, frames: Math.floor(person.data.length / (STRIDE * points.length)) };
  });

  function place(person, t) {
    const { points, links, data, frames } = person;
    const i = Math.min(below(times, t), frames - 1);
    const j = Math.min(i + 1, frames - 1, times.length - 1);
    const u = times[j] > times[i] ? Math.min(1, Math.max(0, (t - times[i]) / (times[j] - times[i]))) : 0;
    points.forEach(({ point, around }, k) => {
      const at = (i * points.length + k) * STRIDE;
      const after = (j * points.length + k) * STRIDE;
      const next = Number.isFinite(data[after]) ? after : at;
      const value = (n) => data[at + n] + (data[next + n] - data[at + n]) * u;
      point.visible = Number.isFinite(data[at] + data[at + 1] + data[at + 2]);
      if (point.visible) point.position.set(value(0), value(1), value(2));
      const radius = value(3);
      around.visible = point.visible && radius > VISIBLE;
      around.position.copy(point.position);
      if (around.visible) around.scale.setScalar(radius + POINT);
    });
    links.forEach(({ link, ends: [a, b] }) => {
      const [from, to] = [points[a].point, points[b].point];
      const way = to.position.clone().sub(from.position);
      link.visible = from.visible && to.visible && way.length() > 1e-6;
      if (!link.visible) return;
      link.position.copy(from.position).add(to.position).multiplyScalar(0.5);
      link.scale.set(1, way.length(), 1);
      link.quaternion.setFromUnitVectors(Y, way.normalize());
    });
    return points.some(({ point }) => point.visible);
  }

  return {
    nodes,
    recolor() {
      body.color.set(cssVar('--scene-person'));
      shell.color.set(cssVar('--scene-person'));
    },
    show: (t, on) => nodes.forEach((n) => { n.node.visible = place(n, t) && on; }),
  };
}
