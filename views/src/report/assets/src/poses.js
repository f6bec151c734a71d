// Where every link is at a time, between the recorded frames: positions linearly, rotations by slerp.

import { Quaternion, Vector3 } from 'three';
import { below } from './data.js';

const a = new Quaternion();
const b = new Quaternion();

/** Writes the pose at `offset` of the flat list `data` (x, y, z, qw, qx, qy, qz) into an object. */
function blend(data, at, next, u, position, quaternion) {
  position.set(
    data[at] + (data[next] - data[at]) * u,
    data[at + 1] + (data[next + 1] - data[at + 1]) * u,
    data[at + 2] + (data[next + 2] - data[at + 2]) * u,
  );
  a.set(data[at + 4], data[at + 5], data[at + 6], data[at + 3]);
  b.set(data[next + 4], data[next + 5], data[next + 6], data[next + 3]);
  quaternion.slerpQuaternions(a, b, u).normalize();
}

const complete = (data, at) => {
  for (let k = 0; k < 7; k += 1) if (!Number.isFinite(data[at + k])) return false;
  return true;
};

/** Reads poses of `width` entries per frame, each `stride` numbers long. */
export function createPoses(times, data, width, stride) {
  const frames = Math.min(times.length, Math.floor(data.length / (width * stride)));
  const between = (t) => {
    const i = below(times, t);
    const j = Math.min(frames - 1, i + 1);
    const gap = times[j] - times[i];
    return [i, j, gap > 0 ? Math.min(1, Math.max(0, (t - times[i]) / gap)) : 0];
  };
  return {
    frames,
    between,
    /** Places `object` as entry `k` at time `t`; false if the pose was not recorded. */
    place(object, k, t) {
      if (frames === 0) return false;
      const [i, j, u] = between(t);
      const at = (i * width + k) * stride;
      const next = (j * width + k) * stride;
      if (!complete(data, at)) return false;
      blend(data, at, complete(data, next) ? next : at, u, object.position, object.quaternion);
      return true;
    },
    /** The position of a point fixed on entry `k`, at frame `i`. */
    point(i, k, xyz, out = new Vector3()) {
      const at = (i * width + k) * stride;
      a.set(data[at + 4], data[at + 5], data[at + 6], data[at + 3]);
      return out.fromArray(xyz).applyQuaternion(a).add({ x: data[at], y: data[at + 1], z: data[at + 2] });
    },
  };
}
