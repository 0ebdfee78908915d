/** The page: one robot, what is chosen and shown of it, and the panels that follow. */

import { element } from "./dom.js";
import { Ghost } from "./ghost.js";
import { Kinematics } from "./kinematics.js";
import { follow, touching } from "./live.js";
import { Meshes } from "./meshes.js";
import { Frames, JointAxis, Markers, Masses, Sensors } from "./overlays.js";
import { Card } from "./panels/card.js";
import { Problem, Warnings } from "./panels/banner.js";
import { Changes } from "./panels/changes.js";
import { Joints } from "./panels/joints.js";
import { Look, PAGE_THEMES, onKey } from "./panels/look.js";
import { Tree, situationFor } from "./panels/tree.js";
import { RobotView } from "./robot_view.js";
import { Stage, VIEWS } from "./stage.js";
import { UNITS } from "./units.js";
import * as THREE from "three";

const CLICK = 5; // pixels that a pointer may move between down and up
const NEAR = 8; // pixels from a click to the marker that it means
const REMEMBER = 150; // ms after a change until the address has it
const POINTED = 40; // ms between two searches for the part under the pointer
const ASK_AGAIN = 120; // ms after a move before it is asked what touches
const NARROW = window.matchMedia("(max-width: 820px), (max-height: 480px)"); // as page.css has it
const WIDTHS = [160, 800, 290]; // pixels of the panel of the tree: at least, at most, at first
const ROOM = 300 + 240; // pixels for the right panel and the picture
const SIDES = [0, 1, -1, 2].map((quarters) => (quarters * Math.PI) / 2); // turns of the camera around a part
const LAYERS = ["visual", "collision", "sensors", "masses"];
const LAYERS_AT_FIRST = { visual: true, collision: false, sensors: false, masses: false, frames: "none", before: true };
const PANELS = { tree: Tree, joints: Joints, look: Look };

/** Return in words how many parts touch others. */
function said(pairs) {
  const parts = new Set(pairs.flat()).size;
  return parts ? `${parts} parts touch others, and are red` : "no parts touch that are not adjacent";
}

/** Return positions by joint as a text of the address, and such a text as positions; joints of several numbers too. */
function joined(state) {
  const number = (value) => Number(value.toPrecision(7));
  return Object.entries(state).filter(([, at]) => [at].flat().some(Boolean)).map(([name, at]) => `${encodeURIComponent(name)}:${[at].flat().map(number).join(" ")}`).join(",");
}

/** Return a decoded part of the address, or the part itself if its percent signs are no code. */
function decoded(text) {
  try {
    return decodeURIComponent(text);
  } catch {
    return text;
  }
}

function positionsOf(text) {
  const parts = text.split(",").filter((part) => part.includes(":")).map((part) => part.split(":"));
  const numbers = parts.map(([name, at]) => [decoded(name), at.split(" ").map(Number)]);
  return numbers.filter(([, at]) => at.every(Number.isFinite)).map(([name, at]) => [name, at.length === 1 ? at[0] : at]);
}

/** Everything that the page knows. Panels read it and call its methods. */
export class App {
  constructor(root, data) {
    this.selected = "";
    this.hovered = "";
    this.touching = new Set();
    this.modes = {};
    this.state = {};
    this.questions = 0; // how often the server was asked which parts touch
    this.units = "mm, deg";
    this.theme = "auto";
    this.shown = { ...LAYERS_AT_FIRST };
    this.ray = new THREE.Raycaster();
    this.#layout(root);
    this.stage = new Stage(this.canvas);
    this.canvas.hidden = !this.stage.renderer;
    if (!this.stage.renderer) root.classList.remove("no-left"); // the tree is all there is
    this.#explainNoPicture();
    this.stage.before.push((camera) => this.frames.label(camera, this.canvas.parentElement));
    this.frames = new Frames(this.labels);
    this.stage.scene.add(this.frames.lines);
    this.#colours();
    this.#listen();
    if (data.robot) this.load(data, true);
    follow({ onrobot: (next) => this.load(next, !this.robot), onproblem: (said) => this.fail(said), onstate: (said) => this.say(said) });
  }

  #layout(root) {
    this.canvas = element("canvas", { "aria-label": "the robot", tabindex: "0" });
    this.labels = element("div", { class: "labels" });
    this.pointed = element("div", { class: "pointed", hidden: true }); // the name of the part under the pointer
    this.noPicture = element("p", { class: "nopicture", role: "status", hidden: true });
    this.grip = element("div", { class: "grip", role: "separator", tabindex: "0", "aria-orientation": "vertical", "aria-label": "width of the tree", "aria-valuemin": WIDTHS[0], "aria-valuemax": WIDTHS[1] });
    this.title = element("h1", {});
    this.status = element("small", { class: "status" });
    this.panels = Object.fromEntries(Object.entries(PANELS).map(([name, Panel]) => [name, new Panel(this)]));
    this.card = new Card(this);
    this.problem = new Problem();
    this.warnings = new Warnings(this);
    this.changesPanel = new Changes(this);
    const fold = (side) => element("button", { class: `fold ${side}`, "aria-label": `show or hide the ${side} panel`, title: `show or hide the ${side} panel`, onclick: () => this.#fold(side) }, "☰");
    this.root = root;
    root.replaceChildren(
      element("nav", { class: "side left", "aria-label": "frames" }, element("header", {}, this.title, this.status, this.warnings.list), this.changesPanel.root, this.panels.tree.root),
      element("main", {}, this.canvas, this.labels, this.pointed, this.noPicture, this.grip, fold("left"), fold("right"), element("div", { class: "banner" }, this.problem.root, this.warnings.root), this.card.root),
      element("nav", { class: "side right", "aria-label": "controls" }, this.panels.look.root, this.panels.joints.root),
    );
    if (NARROW.matches) root.classList.add("no-left", "no-right");
    this.widen(WIDTHS[2]);
    window.addEventListener("resize", () => this.widen(this.requestedWidth));
    const leaveRoom = () => NARROW.matches && !root.classList.contains("no-left") && root.classList.add("no-right");
    NARROW.addEventListener("change", leaveRoom);
    this.grip.addEventListener("pointerdown", (event) => this.grip.setPointerCapture(event.pointerId));
    this.grip.addEventListener("pointermove", (event) => this.grip.hasPointerCapture(event.pointerId) && this.widen(event.clientX));
    this.grip.addEventListener("keydown", ({ key }) => this.widen(this.wide + ({ ArrowLeft: -20, ArrowRight: 20 }[key] ?? 0)));
  }

  /** Make the panel of the tree so wide (pixels), as far as the window has room; it grows again with the window. */
  widen(pixels) {
    this.requestedWidth = pixels;
    this.wide = Math.round(Math.max(Math.min(pixels, WIDTHS[1], window.innerWidth - ROOM), WIDTHS[0]));
    this.root.style.setProperty("--left", `${this.wide}px`);
    this.grip.setAttribute("aria-valuenow", this.wide);
  }

  /** Show or hide a panel; where there is room for one alone, the other one goes. */
  #fold(side) {
    const isHidden = this.root.classList.toggle(`no-${side}`);
    if (NARROW.matches && !isHidden) this.root.classList.add(side === "left" ? "no-right" : "no-left");
  }

  /** Show a robot: the first one, or what became of it; then camera, joints and toggles stay. */
  load(data, first) {
    const { robot, before, changes } = data;
    Object.assign(this, { robot, before, changes: changes ?? null, became: data.moved ?? {}, said: data.said, notes: data.notes });
    this.coloured = new Map((changes ?? []).filter((one) => one.colours).map((one) => [one.frame, one.colours]));
    this.kinematics = new Kinematics(robot);
    this.meshes = new Meshes(robot, this.meshes);
    this.view = this.#replaced(this.view, new RobotView(robot, this.meshes));
    this.ghost = this.#replaced(this.ghost, before ? new Ghost(data, this.view) : null);
    this.view.recolour(this.coloured);
    if (first && !this.view.hasVisuals) Object.assign(this.shown, { visual: false, collision: true });
    this.state = Object.fromEntries(Object.entries(this.state).filter(([name]) => this.kinematics.byName.has(name)));
    this.modes = Object.fromEntries(robot.modes.map((mode) => [mode, this.modes[mode] ?? false]));
    this.touching = new Set();
    this.#place();
    this.#measure();
    if (!this.places.has(this.selected) && !this.edgesTo(this.selected).length) this.selected = "";
    this.title.textContent = robot.name;
    document.title = robot.name;
    this.problem.show("");
    this.warnings.show(robot);
    this.root.classList.remove("dimmed");
    this.#redraw();
    if (first) this.#begin();
    Promise.all([this.view.ready, this.ghost?.ready]).then(() => this.#settle(first));
  }

  /** The meshes are there: what was measured without them is measured again. */
  #settle(first) {
    this.#place();
    this.#measure();
    if (first && !this.moved) this.lookFrom(this.from ?? "iso");
    if (first && this.asked) this.changesPanel.fly(this.asked);
    this.show({});
    this.#touch();
    document.body.dataset.ready = "yes";
  }

  /**
   * Take what the address asks for: #pose=tuck&from=front&frames=all&show=collision&theme=dark&panels=off&change=FRAME, and
   * what `#remember` writes there.
   */
  #begin() {
    const asked = new URLSearchParams(window.location.hash.slice(1));
    const pose = this.robot.poses.find((one) => one.name === asked.get("pose"));
    this.from = asked.get("from") ?? "iso";
    this.asked = asked.get("change");
    const settings = {};
    if (Object.hasOwn(PAGE_THEMES, asked.get("theme"))) settings.theme = asked.get("theme");
    if (Object.hasOwn(UNITS, asked.get("units"))) settings.units = asked.get("units");
    const named = (key) => (asked.get(key) ?? "").split(",").filter(Boolean);
    this.modes = Object.fromEntries(this.robot.modes.map((mode) => [mode, this.modes[mode] || named("modes").includes(mode)]));
    this.use(settings);
    if (asked.get("panels") === "off") this.root.classList.add("no-left", "no-right");
    const layers = Object.fromEntries(named("show").map((name) => [name, true]));
    for (const layer of asked.has("layers") ? LAYERS : []) layers[layer] = named("layers").includes(layer);
    this.show({ ...layers, ...(asked.has("frames") ? { frames: asked.get("frames") } : {}) });
    if (pose) this.take(pose);
    const moved = positionsOf(asked.get("joints") ?? "").filter(([name]) => this.kinematics.byName.has(name));
    if (moved.length) this.move(Object.fromEntries(moved));
    this.lookFrom(this.from);
    this.begun = true;
    if (asked.has("select")) this.select(asked.get("select"));
  }

  /** Show what a new address of the same page holds, as if the page had been opened with it. */
  #beginAgain() {
    Object.assign(this, { modes: {}, units: "mm, deg", theme: "auto" });
    this.show({ ...LAYERS_AT_FIRST, visual: this.view.hasVisuals, collision: !this.view.hasVisuals });
    this.take({ positions: {} });
    this.select("");
    this.#begin();
  }

  /** Return the address of this page as it is now: joints, what is chosen, layers, modes, units and theme. */
  address() {
    const { hash, href } = window.location;
    const kept = new URLSearchParams(hash.slice(1));
    for (const key of ["pose", "joints", "select", "layers", "show", "frames", "modes", "units", "theme"]) kept.delete(key);
    const on = (names) => Object.entries(names).filter(([, is]) => is).map(([name]) => name).join(",");
    const layers = LAYERS.filter((layer) => this.shown[layer]).join(",");
    const written = { joints: joined(this.state), select: this.selected, layers: layers === "visual" ? "" : layers || "none", frames: this.shown.frames === "none" ? "" : this.shown.frames, modes: on(this.modes), units: this.units === "mm, deg" ? "" : this.units, theme: this.theme === "auto" ? "" : this.theme };
    for (const [key, value] of Object.entries(written)) if (value) kept.set(key, value);
    return `${href.slice(0, href.length - hash.length).replace(/#$/, "")}#${kept}`;
  }

  /** Write into the address what it holds, soon. */
  #remember() {
    if (!this.begun) return;
    clearTimeout(this.remembering);
    this.remembering = setTimeout(() => window.history.replaceState(null, "", this.address()), REMEMBER);
  }

  #replaced(old, next) {
    if (old) {
      this.stage.scene.remove(old.group);
      old.dispose();
    }
    if (next) this.stage.scene.add(next.group);
    return next;
  }

  /** Fit floor, light and overlays to the size of the robot. */
  #measure() {
    const box = this.view.bounds();
    this.size = Math.max(box.getSize(new THREE.Vector3()).length(), 0.05);
    this.stage.fit(box);
    this.sensors = this.#replacedGroup(this.sensors, new Sensors(this.robot, this.size));
    this.masses = this.#replacedGroup(this.masses, new Masses(this.robot, this.size));
    this.markers = this.#replacedGroup(this.markers, new Markers(this.robot));
    if (this.axis) this.stage.scene.remove(this.axis.arrow);
    this.axis = new JointAxis(this.size);
    this.stage.scene.add(this.axis.arrow);
    this.show({});
  }

  #replacedGroup(old, next) {
    if (old) this.stage.scene.remove(old.group);
    this.stage.scene.add(next.group);
    return next;
  }

  /** Put everything where the joints say. */
  #place() {
    this.places = this.kinematics.places(this.state);
    this.view.place(this.places);
    this.ghost?.place(this.state, this.places);
    for (const overlay of [this.sensors, this.masses, this.markers]) if (overlay?.group.visible) overlay.place(this.places);
    if (this.frames.names.every((name) => this.places.has(name))) this.frames.place(this.places);
    this.stage.touch(true);
  }

  #redraw() {
    for (const panel of Object.values(this.panels)) panel.draw();
    this.changesPanel.draw();
    this.card.draw();
  }

  /** Move joints: positions by name. */
  move(positions) {
    Object.assign(this.state, positions);
    this.#place();
    this.panels.joints.show(new Set(Object.keys(positions)));
    this.card.update();
    clearTimeout(this.asking);
    this.asking = setTimeout(() => this.#touch(), ASK_AGAIN);
    this.#remember();
  }

  async #touch() {
    clearTimeout(this.asking);
    const question = ++this.questions;
    const pairs = await touching(this.state);
    if (question !== this.questions) return; // a newer question is on its way
    this.touching = new Set(Array.isArray(pairs) ? pairs.flat() : []);
    this.touchingSaid = Array.isArray(pairs) ? said(pairs) : pairs;
    this.panels.look.tell();
    this.#mark();
  }

  /** Take a named pose; what it does not name goes to zero. */
  take(pose) {
    this.state = {};
    this.move({ ...pose.positions });
    this.panels.joints.show();
  }

  switchMode(mode, on) {
    this.modes[mode] = on;
    this.#remember();
    this.panels.tree.draw();
    this.show({});
    this.card.draw();
  }

  /** Return the edges to a frame in the current modes; a frame can have several parents. */
  edgesTo(frame) {
    return situationFor(this.robot, this.modes)?.edges.filter((edge) => edge.child === frame) ?? [];
  }

  select(name) {
    this.selected = name;
    this.#remember();
    this.#mark();
    this.panels.tree.reveal();
    this.panels.joints.reveal();
    this.show({});
    this.card.draw();
  }

  hover(name) {
    if (name === this.hovered) return;
    this.hovered = name;
    this.hoverJoint(this.robot.joints.find((joint) => joint.child === name) ?? null);
    this.#mark();
  }

  hoverJoint(joint) {
    this.axis.show(joint, joint && this.places.get(joint.child));
    this.stage.touch();
  }

  #mark() {
    this.view.mark({ selected: this.selected, hovered: this.hovered, touching: this.touching });
    this.panels.tree.mark();
    this.stage.touch();
  }

  /** Show or hide layers of the picture. */
  show(layers) {
    Object.assign(this.shown, layers);
    this.#remember();
    const { shown } = this;
    this.view.show(shown);
    this.#explainNoPicture();
    this.ghost?.show(shown);
    this.view.fade(this.ghost && shown.before ? Math.max(0, this.ghost.strength - 1) : 0);
    this.sensors.group.visible = shown.sensors;
    this.masses.group.visible = shown.masses;
    this.frames.show(this.#frameNames(), 0.07 * this.size);
    this.#place();
    if (Object.keys(layers).length) this.panels.look.draw();
  }

  /** Show the reason why the picture is empty, if it is. */
  #explainNoPicture() {
    const { renderer } = this.stage;
    const drawn = this.view?.group.children ?? [];
    const isHidden = drawn.length > 0 && drawn.every((mesh) => !mesh.visible);
    const hint = isHidden ? "The shapes of this robot are hidden: show visuals (key v) or collision shapes (key c)." : "";
    const text = renderer ? hint : "There is no picture, because this browser has no WebGL 2 or cannot start it; the tree, the numbers and the messages are complete. ☰ shows and hides them.";
    this.noPicture.hidden = !text;
    if (text !== this.noPicture.textContent) this.noPicture.textContent = text; // a screen reader reads each change
  }

  #frameNames() {
    const edges = situationFor(this.robot, this.modes)?.edges ?? [];
    const published = new Set(edges.filter((edge) => edge.published).flatMap((edge) => [edge.parent, edge.child]));
    const names = { none: [], all: [...this.places.keys()], chosen: [this.selected], published: [...published] };
    return (names[this.shown.frames] ?? []).filter((name) => this.places.has(name));
  }

  lookFrom(view) {
    this.stage.look(this.view.bounds(), VIEWS[view], this.#room());
  }

  /** Draw the robot before as strongly: 0 is not at all, 1 as it is meant, 2 as if it were there, its colours as well. */
  fade(strength) {
    this.ghost.fade(strength);
    this.show({ before: true });
  }

  /** Choose a frame and look at it from nearby. */
  fly(name) {
    const box = this.ghost?.boundsOf(name) ?? new THREE.Box3();
    if (this.places.has(name)) box.union(this.view.boundsOf(name));
    this.select(this.places.has(name) || this.edgesTo(name).length ? name : "");
    if (box.isEmpty()) return; // only another node knows where it is
    const isPoint = box.min.equals(box.max); // a frame without shapes is seen among what is near it
    box.expandByScalar((isPoint ? 0.3 : 0.08) * this.size);
    this.stage.look(box, this.#directionTo(name, box), this.#room());
  }

  /** Return the direction to look at a link from: that of the camera, or else of the nearest side where nothing hides it. */
  #directionTo(link, box) {
    const centre = box.getCenter(new THREE.Vector3());
    const now = this.stage.direction;
    const isSeen = (direction) => {
      this.ray.set(centre.clone().addScaledVector(direction, (2 * this.size) / direction.length()), direction.clone().negate().normalize());
      return this.#hit()?.link === link;
    };
    const sides = SIDES.map((turn) => now.clone().applyAxisAngle(this.stage.camera.up, turn));
    return sides.find(isSeen) ?? now;
  }

  /** Return the piece that the ray meets first. */
  #hit() {
    const [first] = this.ray.intersectObjects(this.view.group.children.filter((mesh) => mesh.visible), false);
    return first && this.view.pieceAt(first);
  }

  /** Return the part of the canvas (pixels) that the card leaves free: above it or to the right, where there is more. */
  #room() {
    const { offsetLeft, offsetTop, offsetWidth } = this.card.root;
    const { clientWidth, clientHeight } = this.canvas.parentElement;
    if (!offsetWidth) return null;
    const above = { left: 0, top: 0, width: clientWidth, height: offsetTop };
    const besides = { left: offsetLeft + offsetWidth, top: 0, width: clientWidth - offsetLeft - offsetWidth, height: clientHeight };
    const free = ({ width, height }) => Math.min(width, height);
    return free(above) > free(besides) ? above : besides;
  }

  find() {
    this.root.classList.remove("no-left");
    this.panels.tree.search.focus();
  }

  /** Use other units or another theme. */
  use(settings) {
    Object.assign(this, settings);
    this.#remember();
    this.#colours();
    if (this.robot) this.#redraw();
  }

  #colours() {
    const dark = window.matchMedia("(prefers-color-scheme: dark)").matches;
    const theme = this.theme === "auto" ? (dark ? "dark" : "light") : this.theme;
    document.documentElement.dataset.theme = theme;
    this.stage.theme(theme);
  }

  /** The description has a mistake: the last good robot stays, dimmed. */
  fail({ text }) {
    this.problem.show(text, !this.robot);
    this.root.classList.add("dimmed");
  }

  say(text) {
    this.status.textContent = text;
  }

  #listen() {
    const markerAt = ({ clientX, clientY }) => {
      const far = (name) => Math.hypot(...this.stage.pixel(this.places.get(name).p).map((at, index) => at - [clientX, clientY][index]));
      const [nearest] = this.markers.names.filter((name) => this.places.has(name)).map((name) => [far(name), name]).sort(([one], [other]) => one - other);
      return nearest?.[0] < NEAR ? nearest[1] : "";
    };
    const pieceAt = (event) => {
      if (!this.view) return null;
      const { left, top, width, height } = this.canvas.getBoundingClientRect();
      const at = new THREE.Vector2(((event.clientX - left) / width) * 2 - 1, 1 - ((event.clientY - top) / height) * 2);
      this.ray.setFromCamera(at, this.stage.camera);
      return this.#hit();
    };
    let down = null;
    this.canvas.addEventListener("pointerdown", (event) => {
      this.moved = true;
      down = [event.clientX, event.clientY];
    });
    this.canvas.addEventListener("wheel", () => (this.moved = true), { passive: true });
    this.canvas.addEventListener("pointerup", (event) => {
      if (this.robot && down && Math.hypot(event.clientX - down[0], event.clientY - down[1]) < CLICK) this.select(markerAt(event) || (pieceAt(event)?.link ?? ""));
      down = null;
    });
    const point = (event) => {
      const name = event ? markerAt(event) || (pieceAt(event)?.link ?? "") : "";
      this.hover(name);
      this.pointed.hidden = !name;
      if (!name) return;
      this.pointed.textContent = name;
      const { left, top, width } = this.canvas.getBoundingClientRect();
      const x = Math.min(event.clientX - left + 14, width - this.pointed.offsetWidth - 4);
      this.pointed.style.transform = `translate(${x}px, ${event.clientY - top + 16}px)`;
    };
    let waiting = null;
    let last = null; // the last event, or null while the pointer is elsewhere or drags
    const later = (event) => {
      last = event;
      waiting ??= setTimeout(() => {
        waiting = null;
        if (this.robot) point(last);
      }, POINTED);
    };
    this.canvas.addEventListener("pointermove", (event) => later(event.buttons || event.pointerType === "touch" ? null : event));
    this.canvas.addEventListener("pointerleave", () => {
      clearTimeout(waiting); // at once, because the pointer may move to a row of the tree
      waiting = null;
      point(null);
    });
    window.addEventListener("hashchange", () => this.robot && this.#beginAgain());
    window.addEventListener("keydown", (event) => this.robot && onKey(this, event));
    window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.#colours());
  }
}
