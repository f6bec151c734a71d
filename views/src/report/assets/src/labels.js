// Names beside the things of the scene, as text over the picture.

import { Vector3 } from 'three';
import { h } from './dom.js';

/** `items`: `[{ node, name }]` of the scene; `shown(item)` says whether its kind is switched on. */
export function createLabels(items) {
  const labels = items.filter((i) => i.name).map((item) => ({ item, tag: h('span', { class: 'scene-label' }, item.name) }));
  const layer = h('div', { class: 'scene-labels', 'aria-hidden': 'true', hidden: true }, labels.map((l) => l.tag));
  const point = new Vector3();
  return {
    layer,
    update(camera, width, height) {
      if (layer.hidden) return;
      for (const { item, tag } of labels) {
        point.setFromMatrixPosition((item.label ?? item.node).matrixWorld).project(camera);
        const seen = item.node.visible && point.z < 1 && Math.abs(point.x) < 1 && Math.abs(point.y) < 1;
        tag.style.display = seen ? '' : 'none';
        if (seen) tag.style.transform = `translate(${(((point.x + 1) * width) / 2).toFixed(1)}px, ${(((1 - point.y) * height) / 2).toFixed(1)}px)`;
      }
    },
  };
}
