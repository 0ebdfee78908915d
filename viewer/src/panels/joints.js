/** Sliders for the joints, buttons for the named poses, switches for the modes. */

import { copy, element, section, toggle } from "../dom.js";
import { isFree, zero } from "../kinematics.js";
import { ofQuaternion, rpy } from "../transform.js";
import { UNITS, digits, kindOf, plain } from "../units.js";
import { rollersByWheel } from "./tree.js";

const TURN = [-Math.PI, Math.PI];
const STEPS = 1000;

/** Return the coordinates of a joint as people move them; the turn of a floating or ball joint as three angles. */
function coordinates({ type }) {
  if (type === "planar") return ["x", "y", "angle"];
  if (type === "floating") return ["x", "y", "z", "roll", "pitch", "yaw"];
  if (type === "ball") return ["roll", "pitch", "yaw"];
  return ["position"];
}

/** Return a quaternion (x, y, z, w) of fixed-axis angles (rad). */
function turned([roll, pitch, yaw]) {
  const [a, b, c] = [roll / 2, pitch / 2, yaw / 2];
  const [sa, sb, sc] = [a, b, c].map(Math.sin);
  const [ca, cb, cc] = [a, b, c].map(Math.cos);
  return [sa * cb * cc - ca * sb * sc, ca * sb * cc + sa * cb * sc, ca * cb * sc - sa * sb * cc, ca * cb * cc + sa * sb * sc];
}

/** Return how far a coordinate without limits goes here: about as far as the robot is large, in round numbers. */
function reach(kind, size) {
  const step = 10 ** Math.floor(Math.log10(size));
  const far = Math.ceil(size / step) * step;
  return kind === "angle" ? TURN : [-far, far];
}

/** Return the servo pulse nearest to a position; null where a joint has no servo, or no pulse gives it. */
export function pulse(servo, value) {
  if (!servo) return null;
  const exact = (value / servo.rad_per_pulse) * (servo.flipped ? -1 : 1) + servo.zero;
  const nearest = Math.round(exact);
  return nearest >= servo.range[0] && nearest <= servo.range[1] ? nearest : null;
}

/** One joint that a person can move. */
class Mover {
  constructor(app, joint) {
    Object.assign(this, { app, joint });
    this.values = coordinates(joint).map(() => 0);
    this.sliders = coordinates(joint).map((name, index) => this.#slider(name, index));
    const leave = () => app.hoverJoint(null);
    const enter = () => app.hoverJoint(joint);
    const name = element("div", { class: "name", title: "double click: back to zero", onclick: () => app.select(joint.child) }, joint.name);
    this.note = element("small", { class: "note", role: "status" });
    const reset = ({ target }) => target.matches("input[type=number]") || app.move({ [joint.name]: zero(joint) }); // there, a double click selects the digits
    this.root = element("div", { class: "joint", "data-joint": joint.name, onmouseenter: enter, onmouseleave: leave, ondblclick: reset }, name, ...this.sliders.map((one) => one.row), this.note);
  }

  #slider(name, index) {
    const kind = kindOf(this.joint.type, name);
    const { lower, upper } = this.joint.limit ?? {};
    const limited = name === "position" && Number.isFinite(lower) && Number.isFinite(upper) && this.joint.type !== "continuous";
    const [low, high] = limited ? [lower, upper] : reach(kind, this.app.size);
    const range = element("input", { type: "range", min: low, max: high, step: (high - low) / STEPS || 1e-6, "aria-label": `${this.joint.name} ${name}` });
    const number = element("input", { type: "number", step: "any", "aria-label": `${this.joint.name} ${name}, as a number` });
    const unit = element("small", {});
    range.addEventListener("input", () => this.#moved(index, Number(range.value)));
    number.addEventListener("change", () => {
      const measure = UNITS[this.app.units][kind];
      const value = number.value === "" ? this.values[index] : Number(number.value) / measure[1]; // "": empty, or not a number
      const held = limited && number.value !== "" ? Math.min(Math.max(value, low), high) : value;
      this.#moved(index, held);
      this.fit();
      if (plain(held, measure) !== plain(value, measure)) this.note.textContent = `the limit is ${plain(held, measure)}`;
    });
    const label = name === "position" ? null : element("small", { class: "coordinate" }, name);
    return { kind, low, high, range, number, unit, row: element("div", { class: "slider" }, label, range, number, unit) };
  }

  #moved(index, value) {
    this.values[index] = value;
    this.app.move({ [this.joint.name]: this.position });
  }

  /** The position as the kinematics take it. */
  get position() {
    if (this.joint.type === "floating") return [...this.values.slice(0, 3), ...turned(this.values.slice(3))];
    if (this.joint.type === "ball") return turned(this.values);
    return this.joint.type === "planar" ? [...this.values] : this.values[0];
  }

  /** Make each box wide enough for its value and its range; a drag of the slider does not change the width. */
  fit() {
    for (const { kind, low, high, number, unit } of this.sliders) {
      const [word, factor, places] = UNITS[this.app.units][kind];
      const texts = [number.value, ...[low, high].map((value) => (value * factor).toFixed(places))];
      number.style.width = `${Math.max(...texts.map((text) => text.length + 4), 8)}ch`;
      const { servo } = this.joint;
      if (servo) unit.style.width = `${word.length + String(servo.range[1]).length + 6}ch`;
    }
  }

  /** Show where the joint is. */
  show(state) {
    const at = state[this.joint.name] ?? zero(this.joint);
    if (this.joint.type === "planar") this.values = [...at];
    else if (!["floating", "ball"].includes(this.joint.type)) this.values = [at];
    else if (at.some((part, index) => Math.abs(part - this.position[index]) > 1e-9)) {
      this.values = [...at.slice(0, -4), ...rpy(ofQuaternion([0, 0, 0], at.slice(-4)))];
    }
    this.sliders.forEach(({ kind, range, number, unit }, index) => {
      const measure = UNITS[this.app.units][kind];
      range.value = this.values[index];
      number.value = digits(this.values[index], measure);
      const servo = pulse(this.joint.servo, this.values[index]);
      unit.textContent = servo === null ? measure[0] : `${measure[0]} · pulse ${servo}`;
    });
    const { lower, upper } = this.joint.limit ?? {};
    const beyond = this.sliders.length === 1 && (this.values[0] < lower - 1e-9 || this.values[0] > upper + 1e-9);
    this.root.classList.toggle("beyond", beyond);
    const unit = UNITS[this.app.units][this.sliders[0].kind];
    this.note.textContent = beyond ? `beyond its limits, ${plain(lower, unit)} to ${plain(upper, unit)}` : "";
  }
}

/** Return a name as a key of YAML. */
function key(name) {
  return /^[A-Za-z_][\w.-]*$/.test(name) && !/^(?:y|n|yes|no|on|off|true|false|null)$/i.test(name) ? name : JSON.stringify(name);
}

/** The panel of what can be moved. */
export class Joints {
  constructor(app) {
    this.app = app;
    this.root = element("div", { class: "pane" });
    this.unfolded = new Set(); // wheels whose rollers are shown
  }

  draw() {
    const { app } = this;
    const { robot } = app;
    this.movers = robot.joints.filter(isFree).map((joint) => new Mover(app, joint));
    const poses = [{ name: "zero", positions: {} }, ...robot.poses.filter((pose) => pose.name !== "zero")];
    const buttons = poses.map((pose) =>
      element("button", { class: "pose", "data-pose": pose.name, title: pose.about, onclick: () => app.take(pose) }, pose.name),
    );
    const switches = robot.modes.map((mode) => toggle(mode, app.modes[mode], (on) => app.switchMode(mode, on), { id: `mode-${mode}` }));
    this.root.replaceChildren(
      section("Poses", element("div", { class: "buttons" }, ...buttons), element("div", { class: "buttons" }, element("button", { id: "copy-pose", title: "paste it below poses:", onclick: (event) => copy(this.yaml(), event.currentTarget) }, "copy this pose as YAML"))),
      ...(switches.length ? [section("Modes", ...switches)] : []),
      section("Joints", ...(this.movers.length ? this.#list() : [element("p", { class: "quiet" }, "nothing moves")])),
    );
    this.show();
  }

  /** Return the joints in the order of the list: the rollers of a wheel are folded into one entry. */
  #list() {
    const wheelOf = new Map([...rollersByWheel(this.app.robot)].flatMap(([wheel, joints]) => joints.map(({ name }) => [name, wheel])));
    const folds = new Map();
    const listed = new Set();
    for (const { joint, root } of this.movers) {
      const wheel = wheelOf.get(joint.name);
      if (wheel && !folds.has(wheel)) folds.set(wheel, this.#fold(wheel));
      folds.get(wheel)?.append(root);
      listed.add(folds.get(wheel) ?? root);
    }
    for (const fold of folds.values()) fold.firstChild.append(`, ${fold.children.length - 1} rollers`);
    return listed;
  }

  #fold(wheel) {
    const toggled = ({ target }) => this.unfolded[target.open ? "add" : "delete"](wheel);
    return element("details", { class: "rollers", "data-wheel": wheel, open: this.unfolded.has(wheel), ontoggle: toggled }, element("summary", {}, wheel));
  }

  /** If the joint of the selected frame is folded, unfold it and scroll to it. */
  reveal() {
    const root = this.movers.find(({ joint }) => joint.child === this.app.selected)?.root;
    const fold = root?.closest("details.rollers:not([open])");
    if (!fold) return;
    fold.open = true;
    root.scrollIntoView({ block: "nearest" });
  }

  /** Return the current pose as an entry of `poses:`; joints at zero are left out. */
  yaml() {
    const moved = this.movers.filter(({ joint, position }) => [position].flat().some((value, index) => Number(value.toPrecision(9)) !== [zero(joint)].flat()[index]));
    const several = moved.filter(({ position }) => Array.isArray(position)).map(({ joint }) => joint.name);
    const positions = moved.filter(({ position }) => !Array.isArray(position)).map(({ joint, position }) => `      ${key(joint.name)}: ${Number(position.toPrecision(9))} ${joint.type === "prismatic" ? "m" : "rad"}`);
    const comment = several.length ? `    # a pose cannot hold the position of ${several.join(", ")}\n` : "";
    return `  new_pose:\n${comment}    positions:${positions.length ? `\n${positions.join("\n")}` : " {}"}\n`;
  }

  /** Show where joints are: those of these names, or all. */
  show(names = null) {
    for (const mover of this.movers) if (!names || names.has(mover.joint.name)) mover.show(this.app.state);
    if (!names) for (const mover of this.movers) mover.fit();
  }
}
