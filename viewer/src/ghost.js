/** The robot before, translucent under the robot of now: what is elsewhere, its edges, and the way that it went. */

import * as THREE from "three";
import { GHOST, SELECTED } from "./colours.js";
import { matrix } from "./geometry.js";
import { Kinematics } from "./kinematics.js";
import { Meshes } from "./meshes.js";
import { RobotView } from "./robot_view.js";
import { ofPose, then } from "./transform.js";

const LOOKS = { own: { face: 0.42, edge: 0.95 }, carried: { face: 0.16, edge: 0.3 } };
const MOST_EDGES = 800; // pieces whose edges are drawn
const LARGEST = 30000; // corners of a mesh whose edges are drawn
const CREASE = 28; // degrees between faces with an edge
const SCRATCH = new THREE.Matrix4();

const EDGES = new Map();

function edgesOf(geometry) {
  if (!EDGES.has(geometry)) {
    const known = geometry.getAttribute("position").count <= LARGEST;
    EDGES.set(geometry, known ? new THREE.EdgesGeometry(geometry, CREASE) : null);
  }
  return EDGES.get(geometry);
}

/** Return a robot that has the shapes of some links alone. */
function only(robot, wanted) {
  const links = robot.links.map((link) => (wanted(link.name) ? link : { ...link, visual: [], collision: [] }));
  return { ...robot, links };
}

/** What was before; what moved itself is told apart from what was carried with it. */
export class Ghost {
  constructor({ robot, before, moved }, view) {
    this.before = before;
    this.moved = moved ?? {};
    this.kinematics = new Kinematics(before);
    this.base = ofPose(before.at?.xyz ?? [0, 0, 0], before.at?.rpy ?? [0, 0, 0]);
    this.group = new THREE.Group();
    this.strength = 1;
    const meshes = new Meshes({ meshes: { ...robot.meshes, ...before.meshes } });
    const carried = (name) => this.moved[name] === "carried";
    this.layers = [
      { look: LOOKS.own, view: new RobotView(only(before, (name) => !carried(name)), meshes, { ghost: true }), edges: [] },
      { look: LOOKS.carried, view: new RobotView(only(before, carried), meshes, { ghost: true }), edges: [] },
    ];
    for (const layer of this.layers) this.group.add(layer.view.group);
    // What moved or is new is outlined where it is now as well: it may be hidden by something else.
    this.now = { view, edges: [], colour: SELECTED, wanted: ({ link }) => ["moved", "new"].includes(this.moved[link]) };
    this.ways = this.#ways();
    this.#dress();
    this.ready = Promise.all([view.ready, ...this.layers.map((layer) => layer.view.ready)]).then(() => this.#dress());
  }

  /** Lines from where frames were to where they are. */
  #ways() {
    this.gone = Object.keys(this.moved).filter((name) => this.moved[name] === "moved");
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(this.gone.length * 6), 3));
    const look = { color: GHOST, transparent: true, depthTest: false };
    const lines = new THREE.LineSegments(geometry, new THREE.LineBasicMaterial(look));
    const points = new THREE.Points(geometry, new THREE.PointsMaterial({ ...look, size: 5, sizeAttenuation: false }));
    for (const drawn of [lines, points]) {
      drawn.renderOrder = 6;
      drawn.frustumCulled = false;
      this.group.add(drawn);
    }
    return lines;
  }

  /** Give faces and edges their looks; meshes get theirs when they are read. */
  #dress() {
    let count = 0;
    for (const layer of [...this.layers, this.now]) {
      const material = new THREE.LineBasicMaterial({ color: layer.colour ?? GHOST, transparent: true, depthTest: false });
      for (const { line } of layer.edges) this.group.remove(line);
      layer.edges = [];
      for (const piece of layer.view.pieces.filter(layer.wanted ?? Boolean)) {
        const geometry = piece.mesh && count < MOST_EDGES && edgesOf(piece.geometry);
        if (!geometry) continue;
        const line = new THREE.LineSegments(geometry, material);
        line.matrixAutoUpdate = false;
        line.frustumCulled = false;
        line.renderOrder = 4;
        this.group.add(line);
        layer.edges.push({ line, piece });
        count += 1;
      }
      layer.lines = material;
    }
    this.fade(this.strength);
  }

  /** Draw the robot before as strongly: 0 is not at all, 1 as it is meant, 2 as if it were there. */
  fade(strength) {
    this.strength = strength;
    for (const { look, view, lines } of this.layers) {
      const face = strength <= 1 ? look.face * strength : look.face + (1 - look.face) * (strength - 1);
      for (const { material } of view.group.children) {
        Object.assign(material, { opacity: face, polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 2 });
        material.userData.opacity = face;
      }
      lines.opacity = Math.min(1, look.edge * strength);
    }
    this.now.lines.opacity = 0.75 * Math.min(1, strength);
    this.ways.material.opacity = Math.min(1, strength);
  }

  /** Put everything where joints say; `places` are those of the robot of now. */
  place(state, places) {
    const found = this.kinematics.places(state);
    this.places = new Map([...found].map(([name, at]) => [name, then(this.base, at)]));
    for (const { view, edges } of this.layers) {
      view.place(this.places);
      for (const { line, piece } of edges) line.matrix.multiplyMatrices(view.links.get(piece.link), piece.local);
    }
    for (const { line, piece } of this.now.edges) line.matrix.multiplyMatrices(this.now.view.links.get(piece.link), piece.local);
    const positions = this.ways.geometry.getAttribute("position");
    this.gone.forEach((name, index) => {
      const [was, is] = [this.places.get(name), places.get(name)];
      if (was && is) positions.array.set([...was.p, ...is.p], index * 6);
    });
    positions.needsUpdate = true;
  }

  /** Choose what is drawn. A robot of a format without visuals is drawn by its collision shapes. */
  show({ visual, collision, before }) {
    const shown = { visual, collision: collision || (visual && this.before.collision_only) };
    for (const { view, edges } of this.layers) {
      view.show(shown);
      for (const { line, piece } of edges) line.visible = Boolean(shown[piece.purpose]);
    }
    for (const { line, piece } of this.now.edges) line.visible = Boolean({ visual, collision }[piece.purpose]);
    this.group.visible = before;
  }

  /** Return the box around a link as it was; empty where there was none. */
  boundsOf(link) {
    const box = new THREE.Box3();
    if (!this.places?.has(link)) return box;
    const layer = this.layers[this.moved[link] === "carried" ? 1 : 0];
    for (const piece of layer.view.pieces.filter((one) => one.link === link && one.mesh)) {
      piece.mesh.geometry.boundingBox ?? piece.mesh.geometry.computeBoundingBox();
      SCRATCH.multiplyMatrices(matrix(this.places.get(link)), piece.local);
      box.union(piece.mesh.geometry.boundingBox.clone().applyMatrix4(SCRATCH));
    }
    return box.isEmpty() ? box.expandByPoint(new THREE.Vector3(...this.places.get(link).p)) : box;
  }

  dispose() {
    for (const { view, lines } of this.layers) {
      view.dispose();
      lines.dispose();
    }
    this.now.lines.dispose();
  }
}
