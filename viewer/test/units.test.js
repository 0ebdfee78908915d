import assert from "node:assert/strict";
import test from "node:test";
import { inUnits } from "../src/units.js";

const CHANGES = [
  ["lid turned 90.0 deg in arm: yaw 0 -> 1.5708 rad", "lid turned 90.0 deg in arm: yaw 0 -> 90 deg"],
  ["lid moved 20.0 mm in arm: origin x 0 -> 0.02 m, y -0.1 -> 1e-05 m", "lid moved 20.0 mm in arm: origin x 0 -> 20 mm, y -100 -> 0.01 mm"],
  ["hip limit lower -1.5 -> -1.5000001 rad (-5.7e-06 deg)", "hip limit lower -85.943669 -> -85.943675 deg (-5.7e-06 deg)"],
  ["hip limit velocity 2 -> 3.14159 rad/s (+57.1 %)", "hip limit velocity 114.59 -> 180 deg/s (+57.1 %)"],
  ["hip limit upper: new, 0.5 rad", "hip limit upper: new, 28.648 deg"],
  ["hip limit upper: removed, was 0.5 m", "hip limit upper: removed, was 500 mm"],
];
const OTHERS = ["hip stiffness 2 -> 3 N*m/rad (+50.0 %)", "arm mass 1 -> 2 kg (+1.0 kg)", "arm inertia ixx 1 -> 2 kg*m^2", "link m2 -> m rad renamed to m"];

test("a change is said in the units of the page", () => {
  for (const [said, shown] of CHANGES) assert.equal(inUnits(said, "mm, deg"), shown);
});

test("metres and radians stay as they are said", () => {
  for (const [said] of CHANGES) assert.equal(inUnits(said, "m, rad"), said);
});

test("what is neither a length nor an angle stays as it is", () => {
  for (const said of OTHERS) assert.equal(inUnits(said, "mm, deg"), said);
});
