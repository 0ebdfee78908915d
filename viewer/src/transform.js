/**
 * Rigid transforms as plain numbers: `r` is the 3x3 rotation row by row, `p` the translation in metres.
 *
 * Conventions are those of URDF and REP 103: right-handed axes, metres, radians; roll, pitch and yaw turn about the
 * fixed axes X, Y, Z in this order, so R = Rz(yaw) Ry(pitch) Rx(roll).
 *
 * @typedef {{r: number[], p: number[]}} Transform
 */

/** @type {Transform} */
export const IDENTITY = { r: [1, 0, 0, 0, 1, 0, 0, 0, 1], p: [0, 0, 0] };

/** Return the transform of a position (m) and fixed-axis angles (rad). */
export function ofPose(xyz = [0, 0, 0], rpy = [0, 0, 0]) {
  const [sr, sp, sy] = rpy.map(Math.sin);
  const [cr, cp, cy] = rpy.map(Math.cos);
  const r = [
    cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr,
    sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr,
    -sp, cp * sr, cp * cr,
  ];
  return { r, p: [...xyz] };
}

/** Return the transform of a position (m) and a quaternion (x, y, z, w) of any length but zero. */
export function ofQuaternion(xyz, quaternion) {
  const length = Math.hypot(...quaternion);
  const [x, y, z, w] = quaternion.map((value) => value / length);
  const r = [
    1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y),
    2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
    2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y),
  ];
  return { r, p: [...xyz] };
}

/** Return the transform that turns by an angle (rad) about an axis, which need not be of unit length (Rodrigues). */
export function about(axis, angle) {
  const length = Math.hypot(...axis);
  const [x, y, z] = axis.map((value) => value / length);
  const s = Math.sin(angle);
  const c = Math.cos(angle);
  const t = 1 - c;
  const r = [
    c + x * x * t, x * y * t - z * s, x * z * t + y * s,
    y * x * t + z * s, c + y * y * t, y * z * t - x * s,
    z * x * t - y * s, z * y * t + x * s, c + z * z * t,
  ];
  return { r, p: [0, 0, 0] };
}

/** Return a transform that only moves (m). */
export function along(axis, distance) {
  const length = Math.hypot(...axis);
  return { r: IDENTITY.r, p: axis.map((value) => (value / length) * distance) };
}

/** Return a direction of the child frame in the parent frame. */
export function rotate({ r }, [x, y, z]) {
  return [r[0] * x + r[1] * y + r[2] * z, r[3] * x + r[4] * y + r[5] * z, r[6] * x + r[7] * y + r[8] * z];
}

/** Return a point of the child frame in the parent frame (m). */
export function apply(transform, point) {
  return rotate(transform, point).map((value, index) => value + transform.p[index]);
}

/** Return a transform followed by another one: parent -> a -> b. */
export function then(a, b) {
  const r = [];
  for (let row = 0; row < 9; row += 3) {
    for (let column = 0; column < 3; column += 1) {
      r.push(a.r[row] * b.r[column] + a.r[row + 1] * b.r[column + 3] + a.r[row + 2] * b.r[column + 6]);
    }
  }
  return { r, p: apply(a, b.p) };
}

/** Return the transform from child to parent. */
export function inverse({ r, p }) {
  const back = { r: [r[0], r[3], r[6], r[1], r[4], r[7], r[2], r[5], r[8]], p: [0, 0, 0] };
  return { r: back.r, p: rotate(back, p).map((value) => 0 - value) };
}

/** Return fixed-axis roll, pitch and yaw (rad); at a pitch of +-90 degrees the yaw is zero. */
export function rpy({ r }) {
  const [a, , , d, e, f, g, h, i] = r;
  const horizontal = Math.hypot(h, i);
  if (horizontal < 1e-12) {
    return [Math.atan2(g < 0 ? -f : f, e) * (g < 0 ? 1 : -1), Math.atan2(-g, horizontal), 0];
  }
  return [Math.atan2(h, i), Math.atan2(-g, horizontal), Math.atan2(d, a)];
}

/** Return the rotation as a unit quaternion (x, y, z, w) with w >= 0 (Shepperd's method, 1978). */
export function quaternion({ r }) {
  const [a, b, c, d, e, f, g, h, i] = r;
  const trace = a + e + i;
  const largest = Math.max(trace, a, e, i);
  let q;
  if (largest === trace) q = [h - f, c - g, d - b, 1 + trace];
  else if (largest === a) q = [1 + a - e - i, d + b, c + g, h - f];
  else if (largest === e) q = [d + b, 1 + e - a - i, h + f, c - g];
  else q = [c + g, h + f, 1 + i - a - e, d - b];
  const length = Math.hypot(...q) * (q[3] < 0 ? -1 : 1);
  return q.map((value) => value / length);
}

/** Return the transform as the 16 numbers of a matrix, column by column, as WebGL wants them. */
export function columns({ r, p }) {
  return [r[0], r[3], r[6], 0, r[1], r[4], r[7], 0, r[2], r[5], r[8], 0, p[0], p[1], p[2], 1];
}
