/** A robot as it is drawn: its shapes, placed by the kinematics. What has one geometry is drawn all at once. */

import * as THREE from "three";
import { COLLISION, GHOST, SELECTED, TOUCHING } from "./colours.js";
import { UNIT, heightMap, matrix, pieces } from "./geometry.js";
import { ofPose } from "./transform.js";

const PURPOSES = ["visual", "collision"];
const GHOSTLY = 0.28;
const OVERLAY = 0.35;
const SCRATCH = new THREE.Matrix4();
const MIRROR = new THREE.Matrix4().makeScale(-1, 1, 1);
const WHITE = new THREE.Color(1, 1, 1);
const SAME = 1e-4; // of two colours, each part from 0 to 1

function colourOf(rgba) {
  return new THREE.Color().setRGB(...rgba.slice(0, 3), THREE.SRGBColorSpace);
}

/** Darken the edges of faces whose corners say where they are on the face: boxes are told apart by them. */
function outlined(material) {
  material.defines = { ...material.defines, USE_UV: "" };
  material.onBeforeCompile = (shader) => {
    shader.fragmentShader = shader.fragmentShader.replace(
      "#include <color_fragment>",
      `#include <color_fragment>
      vec2 toEdge = min(vUv, 1.0 - vUv) / max(fwidth(vUv), vec2(1e-6));
      diffuseColor.rgb *= mix(0.62, 1.0, smoothstep(0.4, 1.4, min(toEdge.x, toEdge.y)));`,
    );
  };
  return material;
}

/** One drawn piece of a shape: where it is in its link, and which instance of which mesh draws it. */
class Piece {
  constructor(link, shape, purpose, local, colour) {
    Object.assign(this, { link, shape, purpose, local, colour, was: null, map: null, mesh: null, instance: -1 });
    this.opacity = shape.rgba?.[3] ?? 1;
    this.mirrored = local.determinant() < 0;
  }

  place(ofLinkInRoot) {
    SCRATCH.multiplyMatrices(ofLinkInRoot, this.local);
    this.mesh.setMatrixAt(this.instance, this.mirrored ? SCRATCH.premultiply(MIRROR) : SCRATCH);
  }

  paint(colour) {
    this.mesh.setColorAt(this.instance, colour);
  }
}

/** Return the colour of a piece of a mesh or of a solid: an image has its own ones. */
function looked(piece, shape, surface, image) {
  const map = image ?? (shape.rgba ? null : surface.map);
  piece.map = map && surface.geometry.getAttribute("uv") ? map : null;
  if (piece.map) piece.colour = image && shape.rgba ? piece.colour : WHITE;
  else if (surface.colour && !shape.rgba) piece.colour = surface.colour;
}

/** The robot of a page. As a ghost it is one translucent colour, and nothing of it can be picked. */
export class RobotView {
  constructor(robot, meshes, { ghost = false } = {}) {
    this.group = new THREE.Group();
    this.ghost = ghost;
    this.pieces = [];
    this.links = new Map(robot.links.map((link) => [link.name, new THREE.Matrix4()]));
    const isThere = (shape) => shape.kind !== "mesh" || (meshes.table[shape.mesh] && !meshes.table[shape.mesh].missing);
    this.hasVisuals = !robot.collision_only && robot.links.some((link) => link.visual.some(isThere));
    this.marks = { selected: "", hovered: "", touching: new Set() };
    this.shown = { visual: true, collision: false };
    this.faded = 0;
    this.waiting = [];
    for (const link of robot.links) this.#build(link, meshes);
    this.#pool(this.pieces.filter((piece) => piece.geometry));
    this.ready = Promise.all(this.waiting);
  }

  #build(link, meshes) {
    const own = new THREE.Color(link.colour ?? GHOST); // what was before has no colours of its own
    for (const purpose of PURPOSES) {
      for (const shape of link[purpose]) {
        const place = matrix(ofPose(shape.xyz, shape.rpy));
        const colour = shape.rgba ? colourOf(shape.rgba) : own;
        const add = (local, geometry) => {
          const piece = new Piece(link.name, shape, purpose, local, colour);
          piece.geometry = geometry;
          this.pieces.push(piece);
          return piece;
        };
        const made = pieces(shape).map(({ solid, scale, z }) =>
          add(place.clone().multiply(new THREE.Matrix4().makeTranslation(0, 0, z)).scale(new THREE.Vector3(...scale)), UNIT[solid]),
        );
        if (shape.kind === "height_map") made.push(add(place, heightMap(shape)));
        if (shape.kind === "mesh") this.#mesh(shape, place, add, meshes);
        else if (shape.texture && !this.ghost) this.#dress(made, meshes);
      }
    }
  }

  /** Read a mesh; what other shapes have of it already is drawn with theirs. */
  #mesh(shape, place, add, meshes) {
    const local = place.clone().scale(new THREE.Vector3(...shape.scale));
    const image = shape.texture && !this.ghost ? meshes.image(shape.texture) : null;
    this.#wait(
      shape.mesh,
      Promise.all([meshes.surfaces(shape.mesh), image]).then(([surfaces, map]) => {
        for (const surface of surfaces) looked(add(local, surface.geometry), shape, surface, map);
      }),
    );
  }

  /** Put an image on solids. */
  #dress(made, meshes) {
    const [{ shape }] = made;
    const put = (map) => made.forEach((piece) => looked(piece, shape, piece, map));
    this.#wait(shape.texture, meshes.image(shape.texture).then((map) => map && put(map)));
  }

  /** Draw anew what is there when something has been read. */
  #wait(name, loading) {
    const told = loading.catch((problem) => console.warn(`${name}: ${problem.message}`));
    this.waiting.push(told);
    this.pending = (this.pending ?? 0) + 1;
    told.then(() => {
      this.pending -= 1;
      if (!this.pending) this.#pool(this.pieces);
    });
  }

  /** Draw all pieces of one geometry, purpose, opacity and image as instances of one mesh. */
  #pool(pieces) {
    this.#clear();
    const pools = new Map();
    const number = new Map();
    const numberOf = (thing) => number.get(thing) ?? number.set(thing, number.size).get(thing);
    for (const piece of pieces) {
      const key = [numberOf(piece.geometry), piece.purpose, piece.opacity, piece.mirrored, numberOf(piece.map)].join(" ");
      if (!pools.has(key)) pools.set(key, []);
      pools.get(key).push(piece);
    }
    for (const pool of pools.values()) {
      const mesh = new THREE.InstancedMesh(pool[0].geometry, this.#material(pool[0]), pool.length);
      mesh.frustumCulled = false; // its pieces move
      mesh.matrixAutoUpdate = false;
      if (pool[0].mirrored) mesh.matrix.copy(MIRROR); // twice is not at all; it says which side of a face is outside
      pool.forEach((piece, index) => {
        Object.assign(piece, { mesh, instance: index });
        piece.place(this.links.get(piece.link));
      });
      this.#add(mesh, pool);
    }
    this.#remember();
    this.#paint();
  }

  #material({ opacity, purpose, geometry, map }) {
    const see = this.ghost ? GHOSTLY : opacity;
    const made = new THREE.MeshStandardMaterial({ roughness: 0.62, metalness: 0.08, transparent: see < 1, opacity: see, map });
    made.depthWrite = see >= 1;
    made.userData = { purpose, opacity: see };
    return geometry === UNIT.box && !map ? outlined(made) : made;
  }

  #add(mesh, drawn) {
    mesh.userData = { pieces: drawn, purpose: drawn[0].purpose };
    mesh.castShadow = !this.ghost;
    mesh.receiveShadow = !this.ghost;
    this.group.add(mesh);
  }

  /** Put every link where it is, by name in the root frame. */
  place(places) {
    for (const [name, transform] of places) matrix(transform, this.links.get(name));
    for (const piece of this.pieces) if (piece.mesh) piece.place(this.links.get(piece.link));
    for (const mesh of this.group.children) {
      mesh.instanceMatrix.needsUpdate = true;
      mesh.boundingSphere = null;
    }
  }

  /** Choose what is drawn; shapes of collision are a veil where the visuals are drawn as well. */
  show({ visual, collision }) {
    this.shown = { visual, collision };
    this.#paint();
  }

  /** Give links the colours that they had: `colours` has what was and what is, by link, each a colour or null. */
  recolour(colours) {
    this.colours = colours;
    this.#remember();
  }

  #remember() {
    for (const piece of this.pieces) {
      const { was, is } = this.colours?.get(piece.link) ?? {};
      const own = piece.shape.rgba ?? null;
      const same = own && is ? own.every((part, index) => Math.abs(part - is[index]) < SAME) : !own && !is;
      piece.was = piece.purpose === "visual" && was && same ? colourOf(was) : null;
    }
  }

  /** Draw what has another colour than before: from 0, in that of now, to 1, in the old one. */
  fade(share) {
    if (share === this.faded) return;
    this.faded = share;
    this.#paint();
  }

  /** Mark what is chosen, what the pointer is on, and what touches. */
  mark(marks) {
    Object.assign(this.marks, marks);
    this.#paint();
  }

  #paint() {
    const veil = this.shown.visual && this.shown.collision && this.hasVisuals;
    for (const mesh of this.group.children) {
      const { purpose } = mesh.userData;
      mesh.visible = this.shown[purpose];
      const veiled = veil && purpose === "collision";
      const opacity = veiled ? Math.min(OVERLAY, mesh.material.userData.opacity) : mesh.material.userData.opacity;
      if (mesh.material.opacity !== opacity) {
        Object.assign(mesh.material, { opacity, transparent: opacity < 1, depthWrite: opacity >= 1, needsUpdate: true });
      }
      mesh.castShadow = !this.ghost && !veiled;
      for (const piece of mesh.userData.pieces) piece.paint(this.#colour(piece, veiled));
      if (mesh.instanceColor) mesh.instanceColor.needsUpdate = true;
    }
  }

  #colour(piece, veiled) {
    if (this.ghost) return new THREE.Color(GHOST);
    if (this.marks.touching.has(piece.link)) return new THREE.Color(TOUCHING);
    const base = veiled ? new THREE.Color(COLLISION) : piece.colour.clone();
    if (piece.was && !veiled) base.lerp(piece.was, this.faded);
    if (piece.link === this.marks.selected) return base.lerp(new THREE.Color(SELECTED), piece.was ? 0.1 : 0.6); // a colour that is another one is seen
    if (piece.link === this.marks.hovered) return base.lerp(new THREE.Color(0xffffff), 0.35);
    return base;
  }

  /** Return the piece that a ray met. */
  pieceAt({ object, instanceId }) {
    const drawn = object.userData.pieces ?? [];
    return drawn[instanceId];
  }

  /** Return the box around all that is drawn, in the root frame (m); empty for a robot of mere frames. */
  bounds() {
    const box = new THREE.Box3();
    const one = new THREE.Box3();
    for (const piece of this.pieces) {
      if (!piece.mesh) continue;
      piece.mesh.geometry.boundingBox ?? piece.mesh.geometry.computeBoundingBox();
      SCRATCH.multiplyMatrices(this.links.get(piece.link), piece.local);
      box.union(one.copy(piece.mesh.geometry.boundingBox).applyMatrix4(SCRATCH));
    }
    if (box.isEmpty()) {
      for (const place of this.links.values()) box.expandByPoint(new THREE.Vector3().setFromMatrixPosition(place));
    }
    return box;
  }

  /** Return the box around one link, or its origin if it has no shape. */
  boundsOf(link) {
    const box = new THREE.Box3();
    for (const piece of this.pieces.filter((one) => one.link === link && one.mesh)) {
      SCRATCH.multiplyMatrices(this.links.get(link), piece.local);
      box.union(piece.mesh.geometry.boundingBox.clone().applyMatrix4(SCRATCH));
    }
    return box.isEmpty() ? box.expandByPoint(new THREE.Vector3().setFromMatrixPosition(this.links.get(link))) : box;
  }

  #clear() {
    for (const mesh of [...this.group.children]) {
      mesh.material.dispose();
      mesh.dispose();
      this.group.remove(mesh);
    }
  }

  dispose() {
    const solids = Object.values(UNIT);
    for (const { geometry } of this.group.children) if (!solids.includes(geometry)) geometry.dispose();
    this.#clear();
  }
}
