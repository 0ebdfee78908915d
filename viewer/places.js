/** Read a robot and states from standard input, and print where every link is: `{link: [x, y, z, qx, qy, qz, qw]}`. */

import { readFileSync } from "node:fs";
import { Kinematics } from "./src/kinematics.js";
import { quaternion } from "./src/transform.js";

const { robot, states } = JSON.parse(readFileSync(0, "utf8"));
const kinematics = new Kinematics(robot);
const places = states.map((state) =>
  Object.fromEntries([...kinematics.places(state)].map(([name, at]) => [name, [...at.p, ...quaternion(at)]])),
);
process.stdout.write(JSON.stringify(places));
