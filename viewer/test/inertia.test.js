import assert from "node:assert/strict";
import test from "node:test";
import { ellipsoid, principal } from "../src/inertia.js";

const BALL = { ixx: 0.4, iyy: 0.4, izz: 0.4, ixy: 0, ixz: 0, iyz: 0 };

test("a ball of radius 1 and mass 1 is an ellipsoid of radius 1", () => {
  for (const radius of ellipsoid({ ...BALL, mass: 1 }).radii) assert.ok(Math.abs(radius - 1) < 1e-12);
});

test("principal moments and axes give the inertia back", () => {
  const inertia = { ixx: 3, iyy: 4, izz: 5, ixy: 0.7, ixz: -0.4, iyz: 0.2 };
  const { moments, axes: v } = principal(inertia);
  const at = (i, j) => [0, 1, 2].reduce((sum, k) => sum + v[3 * i + k] * moments[k] * v[3 * j + k], 0);
  const back = { ixx: at(0, 0), iyy: at(1, 1), izz: at(2, 2), ixy: at(0, 1), ixz: at(0, 2), iyz: at(1, 2) };
  for (const [key, value] of Object.entries(inertia)) assert.ok(Math.abs(back[key] - value) < 1e-12, key);
});

test("moments that no body has are no ellipsoid", () => {
  assert.equal(ellipsoid({ ...BALL, ixx: 5, mass: 1 }), null);
  assert.equal(ellipsoid({ ...BALL, mass: 0 }), null);
});
