// The robot from primitives. Axes as in a URDF: cylinders and capsules lie along z of their own frame.

import { BoxGeometry, BufferGeometry, CapsuleGeometry, Color, CylinderGeometry, Float32BufferAttribute, Group, Mesh, MeshStandardMaterial, PlaneGeometry, SphereGeometry, SRGBColorSpace } from 'three';
import { cssVar } from './dom.js';
import { sideOf } from './palette.js';

const THINNEST = 0.004;

/** A capsule from `from` to `to`, or a sphere if they are one point. */
export function capsuleGeometry(radius, length) {
  if (length < 1e-9) return new SphereGeometry(radius, 32, 20);
  return new CapsuleGeometry(radius, length, 12, 32).rotateX(Math.PI / 2);
}

/** The geometry of a form; `null` if a number of it is missing. */
export function geometry(v) {
  // A wall of no thickness has two faces in one place, which flicker.
  if (v.type === 'box' && v.size) return new BoxGeometry(...v.size.map((s) => Math.max(s, THINNEST)));
  if (v.type === 'sphere' && v.radius > 0) return new SphereGeometry(v.radius, 32, 20);
  if (v.type === 'cylinder' && v.radius > 0 && v.length > 0) return new CylinderGeometry(v.radius, v.radius, v.length, 40).rotateX(Math.PI / 2);
  if (v.type === 'capsule' && v.radius > 0) return capsuleGeometry(v.radius, v.length ?? 0);
  if (v.type === 'plane' && v.size) return new PlaneGeometry(v.size[0], v.size[1]);
  if (v.type === 'mesh' && v.vertices.length > 0) return meshGeometry(v);
  return null;
}

// Corners are not shared between triangles, so that faces stay flat.
function meshGeometry(v) {
  const corners = v.faces.flatMap((i) => v.vertices.slice(3 * i, 3 * i + 3));
  const shape = new BufferGeometry().setAttribute('position', new Float32BufferAttribute(corners, 3));
  shape.computeVertexNormals();
  return shape;
}

function linkColor(name, order) {
  const side = sideOf(name);
  const color = new Color(cssVar(side === 'left' ? '--robot-left' : side === 'right' ? '--robot-right' : '--robot-body'));
  // Neighbouring links differ a little, so that the joints can be seen.
  return color.offsetHSL(0, 0, order % 2 ? -0.05 : 0.04);
}

/** `[{ name, group }]` in the order of the links; `recolor()` follows a change of theme. */
export function createRobot(links) {
  const plain = [];
  const bare = links.every((l) => l.visuals.length === 0);
  const groups = links.map((link, order) => {
    const group = new Group();
    group.name = link.name;
    const visuals = bare ? [{ type: 'sphere', radius: 0.03, xyz: [0, 0, 0], wxyz: [1, 0, 0, 0], color: null, opacity: 1 }] : link.visuals;
    for (const v of visuals) {
      const shape = geometry(v);
      if (!shape) continue;
      const material = new MeshStandardMaterial({ roughness: 0.55, metalness: 0.05, transparent: v.opacity < 1, opacity: v.opacity });
      if (v.color) material.color.setRGB(...v.color, SRGBColorSpace);
      else plain.push({ material, name: link.name, order });
      const mesh = new Mesh(shape, material);
      mesh.position.fromArray(v.xyz);
      mesh.quaternion.set(v.wxyz[1], v.wxyz[2], v.wxyz[3], v.wxyz[0]).normalize();
      mesh.castShadow = mesh.receiveShadow = v.opacity >= 1;
      group.add(mesh);
    }
    return group;
  });
  const recolor = () => plain.forEach((p) => p.material.color.copy(linkColor(p.name, p.order)));
  recolor();
  return { groups, recolor };
}
