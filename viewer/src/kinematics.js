/**
 * Where every frame of a robot is at given joint positions.
 *
 * A robot is what `schemas/page.schema.json` says. A state maps the names of joints to positions: a number (rad or m)
 * for a joint with one coordinate; [x, y, angle] for a planar, [x, y, z, qx, qy, qz, qw] for a floating one, the
 * quaternion alone for a ball. Joints that it does not name are at zero.
 */

import { IDENTITY, about, along, inverse, ofPose, ofQuaternion, then } from "./transform.js";

const SEVERAL = { planar: [0, 0, 0], floating: [0, 0, 0, 0, 0, 0, 1], ball: [0, 0, 0, 1] };

/** Say whether a joint moves on its own, so that a person can move it. */
export function isFree(joint) {
  return joint.type !== "fixed" && !joint.mimic;
}

/** Return where a joint is that a state does not name. */
export function zero(joint) {
  return SEVERAL[joint.type] ?? 0;
}

/** Return the position of a joint with one coordinate, through its leaders where it mimics another one. */
export function position(joint, state, byName) {
  let factor = 1;
  let offset = 0;
  let leader = joint;
  while (leader.mimic) {
    offset += factor * leader.mimic.offset;
    factor *= leader.mimic.multiplier;
    leader = byName.get(leader.mimic.joint);
  }
  return factor * (state[leader.name] ?? 0) + offset;
}

/** Return the child in the frame of a joint at a position. */
export function motion(joint, at) {
  switch (joint.type) {
    case "revolute":
    case "continuous":
      return about(joint.axis, at);
    case "prismatic":
      return along(joint.axis, at);
    case "planar":
      return planar(joint.axis, at);
    case "floating":
      return ofQuaternion(at.slice(0, 3), at.slice(3));
    case "ball":
      return ofQuaternion([0, 0, 0], at);
    default:
      return IDENTITY;
  }
}

function planar(normal, [x, y, angle]) {
  const [first, second] = planeAxes(normal);
  const p = [0, 1, 2].map((i) => first[i] * x + second[i] * y);
  return { r: about(normal, angle).r, p };
}

/**
 * Return the axes x and y of the plane of a planar joint: those of the frame of the joint, turned the shortest way that
 * brings z to the normal.
 */
export function planeAxes(normal) {
  const length = Math.hypot(...normal);
  const [x, y, z] = normal.map((value) => value / length);
  const across = Math.hypot(x, y);
  if (across === 0) return [[1, 0, 0], [0, Math.sign(z), 0]];
  const { r } = about([-y / across, x / across, 0], Math.atan2(across, z));
  return [[r[0], r[3], r[6]], [r[1], r[4], r[7]]];
}

/** The tree of a robot, made once: joints from the root down, each with its origin. */
export class Kinematics {
  constructor(robot) {
    this.root = robot.root;
    this.byName = new Map(robot.joints.map((joint) => [joint.name, joint]));
    this.steps = downwards(robot).map((joint) => ({ joint, origin: ofPose(joint.xyz, joint.rpy) }));
  }

  /** Return every link in the root frame, by name. */
  places(state) {
    const places = new Map([[this.root, IDENTITY]]);
    for (const { joint, origin } of this.steps) {
      const above = then(places.get(joint.parent), origin);
      places.set(joint.child, joint.type === "fixed" ? above : then(above, motion(joint, this.#at(joint, state))));
    }
    return places;
  }

  /** Return where the frame `target` sits in the frame `source`, as tf2_echo SOURCE TARGET does. */
  between(source, target, state) {
    const places = this.places(state);
    return then(inverse(places.get(source)), places.get(target));
  }

  #at(joint, state) {
    return joint.type in SEVERAL ? (state[joint.name] ?? zero(joint)) : position(joint, state, this.byName);
  }
}

function downwards(robot) {
  const from = new Map();
  for (const joint of robot.joints) {
    if (!from.has(joint.parent)) from.set(joint.parent, []);
    from.get(joint.parent).push(joint);
  }
  const ordered = [];
  const waiting = [robot.root];
  while (waiting.length) {
    for (const joint of from.get(waiting.pop()) ?? []) {
      ordered.push(joint);
      waiting.push(joint.child);
    }
  }
  return ordered;
}
