/** Mesh files: STL, OBJ, DAE and glTF, each read once, from the page itself or from where it is served. */

import * as THREE from "three";
import { ColladaLoader } from "three/addons/loaders/ColladaLoader.js";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";
import { OBJLoader } from "three/addons/loaders/OBJLoader.js";
import { STLLoader } from "three/addons/loaders/STLLoader.js";

/** Reads the meshes of a robot by the names that its description has for them. */
export class Meshes {
  /** `old` are the meshes of the robot before: what has not changed is not read again. */
  constructor(table, old = null) {
    this.table = table ?? {};
    const same = [...(old?.read ?? [])].filter(([name]) => isSame(this.table[name], old.table[name]));
    this.read = new Map(same);
  }

  /** Return the surfaces of a mesh: geometries, each with the colour that its file gives it, or null. */
  surfaces(name) {
    if (!this.read.has(name)) this.read.set(name, this.#surfaces(name));
    return this.read.get(name);
  }

  async #surfaces(name) {
    const entry = this.table[name];
    if (!entry || entry.missing) return [];
    const bytes = entry.data ? decoded(entry.data) : await fetched(entry.url);
    return parse(entry.format, bytes);
  }
}

function isSame(entry, other) {
  return Boolean(entry) && ["url", "data", "missing"].every((key) => entry[key] === other[key]);
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

async function parse(format, bytes) {
  if (format === "stl") return [{ geometry: new STLLoader().parse(bytes), colour: null }];
  if (format === "obj") return flattened(new OBJLoader().parse(new TextDecoder().decode(bytes)), false);
  if (format === "dae") return flattened(collada(new TextDecoder().decode(bytes)), true);
  if (format === "glb" || format === "gltf") {
    const { scene } = await new GLTFLoader().parseAsync(bytes, "");
    return flattened(scene, true);
  }
  return [];
}

/** Return the scene of a COLLADA file without its turn to another axis that is up, which ROS does not make either. */
function collada(text) {
  const manager = new THREE.LoadingManager();
  manager.setURLModifier(() => "data:,"); // textures stand beside the file: nothing is asked from anywhere
  const { scene } = new ColladaLoader(manager).parse(text, "");
  scene.rotation.set(0, 0, 0);
  return scene;
}

function flattened(scene, coloured) {
  const found = [];
  scene.updateMatrixWorld(true);
  scene.traverse((node) => {
    if (!node.isMesh) return;
    const geometry = node.geometry.clone().applyMatrix4(node.matrixWorld);
    if (!geometry.getAttribute("normal")) geometry.computeVertexNormals();
    const material = Array.isArray(node.material) ? node.material[0] : node.material;
    found.push({ geometry, colour: coloured && material?.color && !material.map ? material.color.clone() : null });
  });
  return found;
}
