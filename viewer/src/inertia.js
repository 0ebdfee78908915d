/** The ellipsoid of uniform density that has the mass and the inertia of a link. */

import { IDENTITY } from "./transform.js";

const SWEEPS = 32;

/**
 * Return the principal moments (kg m^2) and axes (columns of a rotation) of a symmetric inertia, by Jacobi's method.
 *
 * @param {{ixx: number, iyy: number, izz: number, ixy: number, ixz: number, iyz: number}} inertia
 */
export function principal({ ixx, iyy, izz, ixy, ixz, iyz }) {
  const m = [[ixx, ixy, ixz], [ixy, iyy, iyz], [ixz, iyz, izz]];
  const v = [[1, 0, 0], [0, 1, 0], [0, 0, 1]];
  for (let sweep = 0; sweep < SWEEPS; sweep += 1) {
    for (const [p, q] of [[0, 1], [0, 2], [1, 2]]) turnAway(m, v, p, q);
  }
  return { moments: [m[0][0], m[1][1], m[2][2]], axes: rightHanded(v.flat()) };
}

/** Turn about one axis so that the element p, q vanishes. */
function turnAway(m, v, p, q) {
  if (m[p][q] === 0) return;
  const theta = (m[q][q] - m[p][p]) / (2 * m[p][q]);
  const t = (theta < 0 ? -1 : 1) / (Math.abs(theta) + Math.hypot(theta, 1));
  const c = 1 / Math.hypot(t, 1);
  const s = t * c;
  for (let k = 0; k < 3; k += 1) [m[k][p], m[k][q]] = [c * m[k][p] - s * m[k][q], s * m[k][p] + c * m[k][q]];
  for (let k = 0; k < 3; k += 1) [m[p][k], m[q][k]] = [c * m[p][k] - s * m[q][k], s * m[p][k] + c * m[q][k]];
  for (let k = 0; k < 3; k += 1) [v[k][p], v[k][q]] = [c * v[k][p] - s * v[k][q], s * v[k][p] + c * v[k][q]];
}

function rightHanded(r) {
  const [a, b, c, d, e, f, g, h, i] = r;
  const determinant = a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g);
  return determinant < 0 ? [a, b, -c, d, e, -f, g, h, -i] : r;
}

/** Return half axes (m) and rotation of the ellipsoid; null where no body can have such moments. */
export function ellipsoid(inertial) {
  const { moments, axes } = principal(inertial);
  const [a, b, c] = moments;
  const squares = [b + c - a, a + c - b, a + b - c].map((value) => (2.5 * value) / inertial.mass);
  if (!(inertial.mass > 0) || squares.some((value) => !(value > 0))) return null;
  return { radii: squares.map(Math.sqrt), transform: { r: axes, p: IDENTITY.p } };
}
