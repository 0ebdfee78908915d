/**
 * Mesh files: STL, OBJ, DAE and glTF, each read once, from the page itself or from where it is served; and the images that
 * they or the materials of a robot name. Nothing is asked from anywhere else.
 */

import * as THREE from "three";
import { ColladaLoader } from "three/addons/loaders/ColladaLoader.js";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";
import { MTLLoader } from "three/addons/loaders/MTLLoader.js";
import { OBJLoader } from "three/addons/loaders/OBJLoader.js";
import { STLLoader } from "three/addons/loaders/STLLoader.js";

const MATERIALS = ".mtl";

/** Reads the meshes and images of a robot by the names that its description has for them. */
export class Meshes {
  /** `old` are the meshes of the robot before: what has not changed is not read again. */
  constructor({ meshes, textures }, old = null) {
    this.table = { ...meshes, ...textures };
    const same = [...(old?.read ?? [])].filter(([name]) => isSame(this.table[name], old.table[name]));
    this.read = new Map(same);
  }

  /** Return the surfaces of a mesh: geometries, each with the colour or the image that its file gives it, or null. */
  surfaces(name) {
    return this.#once(name, async (entry) => parse(entry, entry.data ? decoded(entry.data) : await fetched(entry.url)));
  }

  /** Return an image as a texture; null where there is none. */
  async image(name) {
    return (await this.#once(name, pictured)) ?? null;
  }

  #once(name, read) {
    const entry = this.table[name];
    if (!this.read.has(name)) this.read.set(name, !entry || entry.missing ? Promise.resolve([]) : read(entry));
    return this.read.get(name);
  }
}

function isSame(entry, other) {
  return Boolean(entry) && JSON.stringify(entry) === JSON.stringify(other);
}

function decoded(text) {
  const letters = atob(text);
  const bytes = new Uint8Array(letters.length);
  for (let i = 0; i < letters.length; i += 1) bytes[i] = letters.charCodeAt(i);
  return bytes.buffer;
}

async function fetched(url) {
  const answer = await fetch(url);
  if (!answer.ok) throw new Error(`${url}: ${answer.status}`);
  return answer.arrayBuffer();
}

/** Return the address of a file that is in the page or served with it. */
function addressOf({ data, url, type }) {
  return data ? `data:${type};base64,${data}` : url;
}

async function pictured(entry) {
  const texture = await new THREE.TextureLoader().loadAsync(addressOf(entry)).catch(() => null);
  if (texture) Object.assign(texture, { colorSpace: THREE.SRGBColorSpace, wrapS: THREE.RepeatWrapping, wrapT: THREE.RepeatWrapping });
  return texture;
}

/** Names of files beside a mesh lead to those of the page; any other one leads nowhere. */
class Beside extends THREE.LoadingManager {
  constructor(files = {}) {
    super();
    this.begun = false;
    this.onStart = () => (this.begun = true);
    this.done = new Promise((done) => (this.onLoad = done));
    this.setURLModifier((name) => (files[name] ? addressOf(files[name]) : name.startsWith("blob:") ? name : NOTHING));
  }

  /** Wait for the images that have been asked for. */
  async settle() {
    if (this.begun) await this.done;
  }
}

const NOTHING = "data:,";

async function parse({ format, files }, bytes) {
  const text = () => new TextDecoder().decode(bytes);
  const beside = new Beside(files);
  let scene = null;
  let isTold = (name) => name !== THREE.Loader.DEFAULT_MATERIAL_NAME;
  if (format === "stl") return [{ geometry: new STLLoader().parse(bytes), colour: null, map: null }];
  if (format === "obj") {
    const made = await materials(files, beside);
    scene = new OBJLoader().setMaterials(made).parse(text());
    isTold = (name) => name in made.materialsInfo;
  } else if (format === "dae") scene = collada(text(), beside);
  else if (format === "glb" || format === "gltf") scene = (await new GLTFLoader().parseAsync(bytes, "")).scene;
  if (!scene) return [];
  await beside.settle();
  return flattened(scene, isTold);
}

/** Return what gives an OBJ its materials: all files of materials beside it as one. */
async function materials(files = {}, manager) {
  const named = Object.entries(files).filter(([name]) => name.toLowerCase().endsWith(MATERIALS));
  const read = async ([, entry]) => new TextDecoder().decode(entry.data ? decoded(entry.data) : await fetched(entry.url));
  const made = new MTLLoader(manager).parse((await Promise.all(named.map(read))).join("\n"), "");
  made.preload();
  return made;
}

/** Return the scene of a COLLADA file without its turn to another axis that is up, which ROS does not make either. */
function collada(text, manager) {
  return new ColladaLoader(manager).parse(text.replace(/<up_axis>[^<]*<\/up_axis>/, ""), "").scene;
}

function flattened(scene, isTold) {
  const found = [];
  scene.updateMatrixWorld(true);
  scene.traverse((node) => {
    if (!node.isMesh) return;
    const whole = node.geometry.clone().applyMatrix4(node.matrixWorld);
    if (!whole.getAttribute("normal")) whole.computeVertexNormals();
    const several = Array.isArray(node.material);
    const parts = several ? whole.groups.map((group) => [cut(whole, group), node.material[group.materialIndex]]) : [[whole, node.material]];
    for (const [geometry, material] of parts) found.push({ geometry, ...looks(material, isTold) });
  });
  return found;
}

/** Return what a file says of the looks of a surface; some materials are made up by who reads it. */
function looks(material, isTold) {
  const map = material?.map?.image?.width ? material.map : null;
  const told = material?.color && isTold(material.name);
  return { map, colour: told && !map ? material.color.clone() : null };
}

/** Return the part of a geometry that one material is for. */
function cut(whole, { start, count }) {
  const made = new THREE.BufferGeometry();
  const end = Math.min(start + count, (whole.index ?? whole.getAttribute("position")).count);
  const corners = Array.from({ length: end - start }, (_, i) => (whole.index ? whole.index.getX(start + i) : start + i));
  for (const [name, { array, itemSize, normalized }] of Object.entries(whole.attributes)) {
    const values = new array.constructor(corners.length * itemSize);
    corners.forEach((corner, index) => {
      for (let i = 0; i < itemSize; i += 1) values[index * itemSize + i] = array[corner * itemSize + i];
    });
    made.setAttribute(name, new THREE.BufferAttribute(values, itemSize, normalized));
  }
  return made;
}
