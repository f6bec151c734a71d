// Pictures of the server on a page: fetched, with moving marks, and places picked on a map.

import { byId, el, say, tell } from './common.js';

const SVG = 'http://www.w3.org/2000/svg';

/** Fetches a picture into the element of its name; only SVG is shown. */
export async function fetchPicture(id) {
  const text = await fetch(`${id}.svg`).then((answer) => (answer.ok ? answer.text() : ''), () => '');
  const root = new DOMParser().parseFromString(text, 'image/svg+xml').documentElement;
  if (root.namespaceURI !== SVG || root.querySelector('parsererror')) return;
  byId(id).replaceChildren(document.importNode(root, true));
}

/** Moves the marks of the map to these positions in metres. */
export function moveMarks(positions) {
  const frame = byId('map').querySelector('g.robots');
  positions.forEach((at, index) => {
    const mark = frame?.children[index];
    if (!mark) return;
    const { x, y, scale } = frame.dataset;
    mark.setAttribute('transform', `translate(${(Number(x) + at[0] * scale).toFixed(1)} ${(y - at[1] * scale).toFixed(1)})`);
  });
}

/** The form `point` with its fields `x` and `y`, which a press on the map fills: for buttons that need a place. */
export function placePicker() {
  let pointing = null;
  const done = () => {
    pointing = null;
    byId('point').hidden = true;
    byId('map').classList.remove('picking');
    mark();
  };
  const mark = () => {
    const svg = byId('map').querySelector('svg');
    svg?.querySelector('.picked')?.remove();
    const frame = svg?.querySelector('g.robots');
    const at = [byId('x').valueAsNumber, byId('y').valueAsNumber];
    if (!pointing || !frame || !at.every(Number.isFinite)) return;
    const { x, y, scale } = frame.dataset;
    const cross = document.createElementNS(SVG, 'path');
    cross.setAttribute('class', 'picked');
    cross.setAttribute('d', `M${Number(x) + at[0] * scale} ${y - at[1] * scale} m-9 0 h18 m-9 -9 v18`);
    svg.append(cross);
  };
  byId('cancel').addEventListener('click', done);
  for (const id of ['x', 'y']) byId(id).addEventListener('input', mark);
  byId('point').addEventListener('submit', (event) => {
    event.preventDefault();
    const point = [byId('x').valueAsNumber, byId('y').valueAsNumber];
    const current = pointing?.();
    if (!current || !point.every(Number.isFinite)) return say('Two numbers are needed.', true);
    tell({ ...current.request, [current.point.key]: point }).then((reply) => { if (reply) done(); });
  });
  byId('map').addEventListener('click', (event) => {
    const svg = byId('map').querySelector('svg');
    const frame = svg?.querySelector('g.robots');
    if (pointing === null || !frame) return;
    const at = new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());
    const { x, y, scale } = frame.dataset;
    byId('x').value = ((at.x - x) / scale).toFixed(2);
    byId('y').value = ((y - at.y) / scale).toFixed(2);
    mark();
  });
  /** Asks for the place of a button; `find` returns the button as the page has it when the place is sent. */
  return (find) => {
    pointing = find;
    byId('prompt').textContent = find().point.prompt;
    byId('point').hidden = false;
    byId('map').classList.add('picking');
    byId('x').value = '';
    byId('y').value = '';
    mark();
    byId('map').scrollIntoView({ block: 'nearest' });
  };
}

/** The form of a place, with the fields that `placePicker` uses. */
export const pointForm = () => el('form', { class: 'row', id: 'point', hidden: true },
  el('span', { id: 'prompt' }),
  el('label', {}, 'x ', el('input', { type: 'number', step: 'any', id: 'x', required: true }), ' m'),
  el('label', {}, 'y ', el('input', { type: 'number', step: 'any', id: 'y', required: true }), ' m'),
  el('button', { class: 'small main', type: 'submit' }, 'Send'),
  el('button', { class: 'small', type: 'button', id: 'cancel' }, 'Cancel'),
  el('span', { class: 'quiet' }, 'press on the map, or type'));
