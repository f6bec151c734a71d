// Colours of the series. Seven hues that stay apart under the three kinds of colour blindness; red is
// kept for limits and faults. More series than hues: a series and its mirror image (left, right) share
// a hue and differ in the dash.

import { cssVar } from './dom.js';

const HUES = 7;
const DASHES = [[], [7, 3, 1.5, 3], [1.5, 3], [9, 3], [3, 3]];

const SIDE = /(^|[^a-z])(left|right|l|r)(?=$|[^a-z])/i;

/** 'left', 'right' or null, read from a name such as `left_elbow`, `arm_r_3` or `leftHand`. */
export function sideOf(name) {
  const found = SIDE.exec(name) ?? /(left|right)/i.exec(name);
  if (!found) return null;
  return found[found.length - 1].toLowerCase().startsWith('l') ? 'left' : 'right';
}

/** For each name the index of a hue and a dash: `[{ hue, dash }]`. */
export function assign(names) {
  if (names.length <= HUES) return names.map((_, i) => ({ hue: i, dash: [] }));
  const stems = new Map();
  return names.map((name) => {
    const side = sideOf(name);
    const stem = side ? name.replace(/left|right/i, '').replace(SIDE, '$1') : name;
    if (!stems.has(stem)) stems.set(stem, { index: stems.size, used: 0 });
    const entry = stems.get(stem);
    const round = Math.floor(entry.index / HUES) * 2 + entry.used;
    entry.used += 1;
    return { hue: entry.index % HUES, dash: DASHES[round % DASHES.length] };
  });
}

/** The colour of a hue in the present theme. */
export const hueColor = (hue) => cssVar(`--series-${hue}`);
