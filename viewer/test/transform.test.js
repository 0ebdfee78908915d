import assert from "node:assert/strict";
import test from "node:test";
import { about, inverse, ofPose, ofQuaternion, quaternion, rpy, then } from "../src/transform.js";

const NEAR = 1e-12;

function near(one, other) {
  assert.equal(one.length, other.length);
  one.forEach((value, index) => assert.ok(Math.abs(value - other[index]) < NEAR, `${one} is not ${other}`));
}

test("a turn about z takes x to y", () => {
  near(then(about([0, 0, 2], Math.PI / 2), { r: ofPose().r, p: [1, 0, 0] }).p, [0, 1, 0]);
});

test("a transform and its inverse are nothing", () => {
  const way = ofPose([1, 2, 3], [0.1, -0.7, 2.9]);
  const back = then(way, inverse(way));
  near(back.p, [0, 0, 0]);
  near(back.r, [1, 0, 0, 0, 1, 0, 0, 0, 1]);
});

test("angles and quaternions come back", () => {
  for (const angles of [[0.3, -0.2, 1], [3, 1.2, -3], [0, Math.PI / 2, 0], [0.5, -Math.PI / 2, 0]]) {
    const { r } = ofPose([0, 0, 0], angles);
    near(ofPose([0, 0, 0], rpy({ r })).r, r);
    near(ofQuaternion([0, 0, 0], quaternion({ r })).r, r);
  }
});
