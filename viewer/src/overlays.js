/** What is drawn over a robot: frames with names, what sensors see, masses, the axis of a joint. */

import * as THREE from "three";
import { matrix } from "./geometry.js";
import { ellipsoid } from "./inertia.js";
import { ofPose, then } from "./transform.js";

export const AXES = [0xe5484d, 0x30a46c, 0x3e63dd];
const MAX_LABELS = 80; // names that are placed at once
const LINE = 13; // pixels from a name to the next one below
const LINES = 4;

/** The axes of frames as lines: one draw call, however many. */
export class Frames {
  constructor(labels) {
    this.labels = labels;
    this.lines = new THREE.LineSegments(
      new THREE.BufferGeometry(),
      new THREE.LineBasicMaterial({ vertexColors: true, depthTest: false, transparent: true, opacity: 0.95 }),
    );
    this.lines.renderOrder = 5;
    this.lines.frustumCulled = false;
    this.names = [];
    this.size = 0.1;
  }

  /** Show the frames of these names; ``size`` is the length of their axes (m). */
  show(names, size) {
    this.names = names;
    this.size = size;
    const colours = new Float32Array(names.length * 18);
    names.forEach((_, frame) => {
      AXES.forEach((axis, index) => {
        const { r, g, b } = new THREE.Color(axis);
        colours.set([r, g, b, r, g, b], frame * 18 + index * 6);
      });
    });
    this.lines.geometry.setAttribute("color", new THREE.BufferAttribute(colours, 3));
    this.lines.geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(names.length * 18), 3));
    this.labels.replaceChildren();
    this.tags = names.slice(0, MAX_LABELS).map((name) => {
      const tag = document.createElement("span");
      tag.textContent = name;
      this.labels.append(tag);
      return tag;
    });
    this.widths = this.tags.map((tag) => tag.offsetWidth);
  }

  place(places) {
    const positions = this.lines.geometry.getAttribute("position");
    if (!positions) return;
    this.places = places;
    this.names.forEach((name, frame) => {
      const { r, p } = places.get(name);
      for (let axis = 0; axis < 3; axis += 1) {
        const end = [0, 1, 2].map((row) => p[row] + this.size * r[row * 3 + axis]);
        positions.array.set([...p, ...end], frame * 18 + axis * 6);
      }
    });
    positions.needsUpdate = true;
  }

  /** Put the names where their frames are on the screen, or some lines below, so that none covers another. */
  label(camera, { clientWidth, clientHeight }) {
    const at = new THREE.Vector3();
    const taken = [];
    this.tags?.forEach((tag, index) => {
      at.fromArray(this.places.get(this.names[index]).p).project(camera);
      const hidden = at.z > 1 || Math.abs(at.x) > 1.1 || Math.abs(at.y) > 1.1;
      const x = ((at.x + 1) / 2) * clientWidth;
      const y = hidden ? null : free(taken, x, ((1 - at.y) / 2) * clientHeight, this.widths[index]);
      tag.hidden = y === null;
      if (y === null) return;
      taken.push([x, y, this.widths[index]]);
      tag.style.transform = `translate(${x.toFixed(1)}px, ${y.toFixed(1)}px)`;
    });
  }
}

/** Return where below a place there is room for a name among those that stand already; null where there is none. */
function free(taken, x, y, width) {
  for (let line = 0; line < LINES; line += 1) {
    const here = y + line * LINE;
    const covers = ([left, top, wide]) => Math.abs(top - here) < LINE - 1 && left < x + width && x < left + wide;
    if (!taken.some(covers)) return here;
  }
  return null;
}

function lines(points, colour, opacity = 0.9) {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.Float32BufferAttribute(points, 3));
  return new THREE.LineSegments(geometry, new THREE.LineBasicMaterial({ color: colour, transparent: true, opacity }));
}

function veil(corners, colour) {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.Float32BufferAttribute(corners, 3));
  const look = { color: colour, transparent: true, opacity: 0.14, side: THREE.DoubleSide, depthWrite: false };
  return new THREE.Mesh(geometry, new THREE.MeshBasicMaterial(look));
}

/** Return the pyramid that a camera sees: its frame looks along z, x right, y down. */
function frustum({ hfov, vfov }, range) {
  const [x, y] = [Math.tan(hfov / 2) * range, Math.tan(vfov / 2) * range];
  const corners = [[-x, -y, range], [x, -y, range], [x, y, range], [-x, y, range]];
  const edges = corners.flatMap((corner, i) => [0, 0, 0, ...corner, ...corner, ...corners[(i + 1) % 4]]);
  const faces = corners.flatMap((corner, i) => [0, 0, 0, ...corner, ...corners[(i + 1) % 4]]);
  return [lines(edges, 0x8e4ec6), veil(faces, 0x8e4ec6)];
}

/** Return the rays of a scanner: layers of directions around z, from ``first`` in steps (rad). */
function fan({ layers, first, step, count }, range) {
  if (count === 1 && layers.length === 1) return ray({ layers, first }, range);
  const [edges, faces] = [[], []];
  const every = Math.max(1, Math.floor(count / 180));
  for (const rise of layers) {
    const to = (index) => {
      const turn = first + index * step;
      return [Math.cos(rise) * Math.cos(turn), Math.cos(rise) * Math.sin(turn), Math.sin(rise)].map((v) => v * range);
    };
    for (let index = 0; index < count; index += every) {
      edges.push(0, 0, 0, ...to(index));
      if (index + every < count) faces.push(0, 0, 0, ...to(index), ...to(index + every));
    }
    if (Math.abs(count * step - 2 * Math.PI) < 1e-6) faces.push(0, 0, 0, ...to(count - every), ...to(0));
  }
  return [lines(edges, 0x12a594, edges.length > 720 ? 0.25 : 0.7), veil(faces, 0x12a594)];
}

/** Return the axes that an IMU or a force sensor measures along, with a ball at their root. */
function axes(_, reach) {
  const length = 0.2 * reach;
  const arrows = AXES.map((colour, index) => {
    const along = new THREE.Vector3().setComponent(index, 1);
    return new THREE.ArrowHelper(along, new THREE.Vector3(), length, colour, 0.3 * length, 0.18 * length);
  });
  for (const { line, cone } of arrows) for (const { material } of [line, cone]) material.depthTest = false;
  const ball = new THREE.SphereGeometry(0.09 * length, 16, 12);
  return [...arrows, new THREE.Mesh(ball, new THREE.MeshBasicMaterial({ color: 0xf5a524, depthTest: false }))];
}

/** Return a single ray with a ring where it ends. */
function ray({ layers: [rise], first }, range) {
  const to = new THREE.Vector3(Math.cos(rise) * Math.cos(first), Math.cos(rise) * Math.sin(first), Math.sin(rise));
  const ring = new THREE.Mesh(new THREE.RingGeometry(0.035 * range, 0.05 * range, 32), new THREE.MeshBasicMaterial({ color: 0x12a594, side: THREE.DoubleSide }));
  ring.quaternion.setFromUnitVectors(new THREE.Vector3(0, 0, 1), to);
  ring.position.copy(to).multiplyScalar(range);
  return [lines([0, 0, 0, ...ring.position], 0x12a594), ring];
}

function box({ size }) {
  const solid = new THREE.BoxGeometry(...size);
  return [new THREE.LineSegments(new THREE.EdgesGeometry(solid), new THREE.LineBasicMaterial({ color: 0xe93d82 }))];
}

export const MARKS = { sensor: [0x8e4ec6, 11], empty: [0x7d8a97, 8] }; // colour, pixels; also in rosorin_compile/viewer/picture/render.py

/** Return an image of a round spot. */
function spot() {
  const canvas = document.createElement("canvas");
  canvas.width = canvas.height = 32;
  const context = canvas.getContext("2d");
  context.arc(16, 16, 13, 0, 2 * Math.PI);
  context.fillStyle = context.strokeStyle = "#ffffff";
  context.fill();
  return new THREE.CanvasTexture(canvas);
}

/** Spots where sensors are, and where frames are that have no shape: always there, over everything, of one size. */
export class Markers {
  constructor(robot) {
    const sensors = new Set(robot.sensors.map((sensor) => sensor.frame));
    const empty = robot.links.filter((link) => !link.visual.length && !link.collision.length && !sensors.has(link.name));
    this.group = new THREE.Group();
    const image = spot();
    this.entries = Object.entries({ sensor: [...sensors], empty: empty.map((link) => link.name) }).map(([kind, names]) => {
      const [color, size] = MARKS[kind];
      const geometry = new THREE.BufferGeometry();
      geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(names.length * 3), 3));
      const look = { color, size: size * Math.min(window.devicePixelRatio, 2), sizeAttenuation: false, map: image, alphaTest: 0.5, depthTest: false, transparent: true };
      const points = new THREE.Points(geometry, new THREE.PointsMaterial(look));
      points.frustumCulled = false;
      points.renderOrder = 4;
      this.group.add(points);
      return { names, points };
    });
  }

  /** The frames that have a marker. */
  get names() {
    return this.entries.flatMap(({ names }) => names);
  }

  place(places) {
    for (const { names, points } of this.entries) {
      const positions = points.geometry.getAttribute("position");
      names.forEach((name, index) => positions.array.set(places.get(name)?.p ?? [0, 0, 0], 3 * index));
      positions.needsUpdate = true;
    }
  }
}

/** What the sensors of a robot see. Each is drawn in the frame that its data name. */
export class Sensors {
  constructor(robot, size) {
    this.group = new THREE.Group();
    this.entries = [];
    for (const sensor of robot.sensors) {
      for (const seen of sensor.sees ?? []) {
        const reach = seen.range ? Math.min(seen.range, 2.5 * size) : 0.6 * size;
        const drawn = { frustum, fan, box, axes }[seen.kind]?.(seen, reach) ?? [];
        const group = new THREE.Group();
        for (const part of drawn) group.add(part);
        group.matrixAutoUpdate = false;
        this.group.add(group);
        this.entries.push({ group, frame: seen.frame, local: ofPose(seen.xyz, seen.rpy) });
      }
    }
  }

  place(places) {
    for (const { group, frame, local } of this.entries) matrix(then(places.get(frame), local), group.matrix);
  }
}

/** The centres of mass, and the ellipsoids that have the inertia of the links. */
export class Masses {
  constructor(robot, size) {
    this.group = new THREE.Group();
    this.entries = [];
    const look = { color: 0xf5a524, transparent: true, opacity: 0.35, depthWrite: false, depthTest: false };
    const [skin, core] = [new THREE.MeshStandardMaterial(look), new THREE.MeshBasicMaterial({ color: 0x3a2a00, depthTest: false })];
    const [bodies, centres] = [[], []];
    for (const { name, inertial } of robot.links) {
      if (!inertial) continue;
      const local = ofPose(inertial.xyz, inertial.rpy);
      const shape = ellipsoid(inertial);
      if (shape) bodies.push({ link: name, local: then(local, shape.transform), scale: new THREE.Vector3(...shape.radii) });
      centres.push({ link: name, local, scale: new THREE.Vector3().setScalar(0.006 * size) });
    }
    this.#add(new THREE.SphereGeometry(1, 24, 16), skin, bodies);
    this.#add(new THREE.SphereGeometry(1, 12, 8), core, centres);
  }

  /** Draw balls of one kind all at once. */
  #add(geometry, material, entries) {
    const mesh = new THREE.InstancedMesh(geometry, material, entries.length);
    mesh.frustumCulled = false;
    mesh.renderOrder = 3;
    this.group.add(mesh);
    this.entries.push({ mesh, entries });
  }

  place(places) {
    const at = new THREE.Matrix4();
    for (const { mesh, entries } of this.entries) {
      entries.forEach(({ link, local, scale }, index) => mesh.setMatrixAt(index, matrix(then(places.get(link), local), at).scale(scale)));
      mesh.instanceMatrix.needsUpdate = true;
    }
  }
}

/** The axis that a joint turns about or moves along, as an arrow through its frame. */
export class JointAxis {
  constructor(size) {
    this.arrow = new THREE.ArrowHelper(new THREE.Vector3(1, 0, 0), new THREE.Vector3(), 0.3 * size, 0xf76b15);
    this.arrow.visible = false;
    for (const part of [this.arrow.line, this.arrow.cone]) part.material.depthTest = false;
  }

  /** Show the axis of a joint whose child is at a place; none for a joint without one. */
  show(joint, child) {
    this.arrow.visible = Boolean(joint?.axis && child && !["fixed", "floating", "ball"].includes(joint.type));
    if (!this.arrow.visible) return;
    const { r, p } = child;
    const [x, y, z] = joint.axis;
    const along = [0, 1, 2].map((row) => r[row * 3] * x + r[row * 3 + 1] * y + r[row * 3 + 2] * z);
    this.arrow.setDirection(new THREE.Vector3(...along).normalize());
    this.arrow.position.fromArray(p);
  }
}
