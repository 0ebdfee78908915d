/** A robot as it is drawn: its shapes, placed by the kinematics. Primitives of one kind are drawn all at once. */

import * as THREE from "three";
import { COLLISION, GHOST, SELECTED, TOUCHING, ofLink } from "./colours.js";
import { UNIT, heightMap, matrix, pieces } from "./geometry.js";
import { ofPose } from "./transform.js";

const PURPOSES = ["visual", "collision"];
const GHOSTLY = 0.28;
const OVERLAY = 0.35;
const SCRATCH = new THREE.Matrix4();

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
    Object.assign(this, { link, shape, purpose, local, colour, mesh: null, instance: -1 });
  }

  place(ofLinkInRoot) {
    SCRATCH.multiplyMatrices(ofLinkInRoot, this.local);
    if (this.instance < 0) this.mesh.matrix.copy(SCRATCH);
    else this.mesh.setMatrixAt(this.instance, SCRATCH);
  }

  paint(colour) {
    if (this.instance < 0) this.mesh.material.color.copy(colour);
    else this.mesh.setColorAt(this.instance, colour);
  }
}

/** The robot of a page. As a ghost it is one translucent colour, and nothing of it can be picked. */
export class RobotView {
  constructor(robot, meshes, { ghost = false } = {}) {
    this.group = new THREE.Group();
    this.ghost = ghost;
    this.pieces = [];
    this.links = new Map(robot.links.map((link) => [link.name, new THREE.Matrix4()]));
    this.hasVisuals = robot.links.some((link) => link.visual.length);
    this.marks = { selected: "", hovered: "", touching: new Set() };
    this.shown = { visual: true, collision: false };
    robot.links.forEach((link, index) => this.#build(link, index, meshes));
    this.#pool();
    this.ready = Promise.all(this.waiting ?? []);
  }

  #build(link, index, meshes) {
    const own = new THREE.Color(ofLink(index));
    for (const purpose of PURPOSES) {
      for (const shape of link[purpose]) {
        const place = matrix(ofPose(shape.xyz, shape.rpy));
        const colour = shape.rgba ? new THREE.Color().setRGB(...shape.rgba.slice(0, 3), THREE.SRGBColorSpace) : own;
        const add = (local, solid) => {
          const piece = new Piece(link.name, shape, purpose, local, colour);
          piece.solid = solid;
          piece.opacity = shape.rgba?.[3] ?? 1;
          this.pieces.push(piece);
          return piece;
        };
        for (const { solid, scale, z } of pieces(shape)) {
          add(place.clone().multiply(new THREE.Matrix4().makeTranslation(0, 0, z)).scale(new THREE.Vector3(...scale)), solid);
        }
        if (shape.kind === "height_map") this.#single(add(place, ""), heightMap(shape));
        if (shape.kind === "mesh") this.#mesh(shape, place, add, meshes);
      }
    }
  }

  #mesh(shape, place, add, meshes) {
    const local = place.clone().scale(new THREE.Vector3(...shape.scale));
    const loading = meshes.surfaces(shape.mesh).then((surfaces) => {
      for (const { geometry, colour } of surfaces) {
        const piece = add(local, "");
        if (colour && !shape.rgba) piece.colour = colour;
        this.#single(piece, geometry);
      }
      this.#paint();
    });
    (this.waiting ??= []).push(loading.catch((problem) => console.warn(`${shape.mesh}: ${problem.message}`)));
  }

  /** Draw a piece as a mesh of its own. */
  #single(piece, geometry) {
    piece.mesh = new THREE.Mesh(geometry, this.#material(piece));
    piece.mesh.matrixAutoUpdate = false;
    this.#add(piece.mesh, [piece]);
    piece.place(this.links.get(piece.link));
  }

  /** Draw all primitives of one kind, purpose and opacity as instances of one mesh. */
  #pool() {
    const pools = new Map();
    for (const piece of this.pieces.filter((one) => one.solid)) {
      const key = `${piece.solid} ${piece.purpose} ${piece.opacity}`;
      if (!pools.has(key)) pools.set(key, []);
      pools.get(key).push(piece);
    }
    for (const pool of pools.values()) {
      const mesh = new THREE.InstancedMesh(UNIT[pool[0].solid], this.#material(pool[0]), pool.length);
      mesh.frustumCulled = false; // its pieces move
      pool.forEach((piece, index) => Object.assign(piece, { mesh, instance: index }));
      this.#add(mesh, pool);
    }
    this.#paint();
  }

  #material({ opacity, purpose, solid }) {
    const see = this.ghost ? GHOSTLY : opacity;
    const made = new THREE.MeshStandardMaterial({ roughness: 0.62, metalness: 0.08, transparent: see < 1, opacity: see });
    made.depthWrite = see >= 1;
    made.userData = { purpose, opacity: see };
    return solid === "box" ? outlined(made) : made;
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
      if (mesh.isInstancedMesh) {
        mesh.instanceMatrix.needsUpdate = true;
        mesh.boundingSphere = null;
      }
    }
  }

  /** Choose what is drawn; shapes of collision are a veil where the visuals are drawn as well. */
  show({ visual, collision }) {
    this.shown = { visual, collision };
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
    if (piece.link === this.marks.selected) return base.lerp(new THREE.Color(SELECTED), 0.6);
    if (piece.link === this.marks.hovered) return base.lerp(new THREE.Color(0xffffff), 0.35);
    return base;
  }

  /** Return the piece that a ray met. */
  pieceAt({ object, instanceId }) {
    const drawn = object.userData.pieces ?? [];
    return instanceId === undefined ? drawn[0] : drawn[instanceId];
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

  dispose() {
    for (const mesh of this.group.children) {
      mesh.material.dispose();
      if (!Object.values(UNIT).includes(mesh.geometry)) mesh.geometry.dispose();
      mesh.dispose?.();
    }
  }
}
