/** The stage: light, floor, camera and the loop that draws when something has changed. */

import * as THREE from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { RoomEnvironment } from "three/addons/environments/RoomEnvironment.js";
import { THEMES } from "./colours.js";

// From where a view looks: directions in the frame of the robot, x ahead, y left, z up.
export const VIEWS = {
  iso: [1.0, -1.15, 0.75],
  front: [1, 0, 0.06],
  side: [0, -1, 0.06],
  top: [0, -0.001, 1],
};
const SHADOWS = 2048;
const SLOW = 90; // ms from one picture to the next from which on fewer pixels are drawn while something moves
const REST = 180; // ms without a change until the full picture is drawn
const COARSE = 0.5; // pixels along a side of those that there are

/** Return the grid of the floor: lines a decimetre and a metre apart that fade with the distance. */
function floor() {
  const material = new THREE.ShaderMaterial({
    transparent: true,
    depthWrite: false,
    uniforms: {
      ground: { value: new THREE.Color() },
      line: { value: new THREE.Color() },
      radius: { value: 1 },
      step: { value: 0.1 },
    },
    vertexShader: `varying vec2 at;
      void main() { at = position.xy; gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0); }`,
    fragmentShader: `varying vec2 at; uniform vec3 ground; uniform vec3 line; uniform float radius; uniform float step;
      float lines(float apart) {
        vec2 there = at / apart; vec2 wide = max(fwidth(there), 1e-6);
        vec2 off = abs(fract(there - 0.5) - 0.5) / wide;
        return 1.0 - min(min(off.x, off.y), 1.0);
      }
      void main() {
        float fade = 1.0 - smoothstep(0.25 * radius, radius, length(at));
        float drawn = max(0.35 * lines(step), 0.8 * lines(10.0 * step));
        gl_FragColor = vec4(mix(ground, line, drawn), fade);
        #include <colorspace_fragment>
      }`,
  });
  const mesh = new THREE.Mesh(new THREE.PlaneGeometry(2, 2), material);
  mesh.renderOrder = -2;
  return mesh;
}

/** Return a renderer for a canvas, or null if the browser has no WebGL 2 or cannot start it. */
function rendererFor(canvas) {
  if (!document.createElement("canvas").getContext("webgl2")) return null;
  let renderer;
  try {
    renderer = new THREE.WebGLRenderer({ canvas, antialias: true, preserveDrawingBuffer: true });
  } catch {
    return null;
  }
  renderer.shadowMap.enabled = true;
  renderer.shadowMap.type = THREE.PCFShadowMap;
  renderer.shadowMap.autoUpdate = false; // a camera that moves changes no shadow
  renderer.toneMapping = THREE.NeutralToneMapping;
  return renderer;
}

/** What a robot stands on and is seen through. Without a renderer everything but the picture works. */
export class Stage {
  constructor(canvas) {
    this.canvas = canvas;
    this.renderer = rendererFor(canvas);
    this.ratio = Math.min(window.devicePixelRatio, 2);
    this.scene = new THREE.Scene();
    this.camera = new THREE.PerspectiveCamera(28, 1, 0.001, 100);
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.enableDamping = !window.matchMedia("(prefers-reduced-motion: reduce)").matches;
    this.controls.addEventListener("change", () => this.touch());
    this.#light();
    this.#ground();
    this.before = [];
    this.offset = [0, 0]; // pixels from the middle of the canvas to that of the picture
    this.frames = { count: 0, last: 0, mean: 0, slow: 0 };
    this.coarse = false;
    new ResizeObserver(() => this.resize()).observe(canvas.parentElement);
    this.dirty = true;
    this.renderer?.setPixelRatio(this.ratio);
    this.renderer?.setAnimationLoop((now) => this.#draw(now));
  }

  #light() {
    if (this.renderer) this.scene.environment = new THREE.PMREMGenerator(this.renderer).fromScene(new RoomEnvironment(), 0.04).texture;
    this.scene.environmentRotation.set(Math.PI / 2, 0, 0); // its ceiling is along y
    this.scene.environmentIntensity = 0.42;
    this.sun = new THREE.DirectionalLight(0xfff6ea, 2.2);
    this.sun.castShadow = true;
    this.sun.shadow.mapSize.set(SHADOWS, SHADOWS);
    this.sun.shadow.radius = 4;
    this.sun.shadow.bias = -0.0005;
    this.scene.add(this.sun, this.sun.target, new THREE.HemisphereLight(0xffffff, 0xa8b0bc, 0.35));
  }

  #ground() {
    this.floor = floor();
    this.shade = new THREE.Mesh(new THREE.PlaneGeometry(2, 2), new THREE.ShadowMaterial({ opacity: 0.22 }));
    this.shade.receiveShadow = true;
    this.shade.renderOrder = -1;
    this.scene.add(this.floor, this.shade);
  }

  /** Use the colours of a theme. */
  theme(name) {
    const colours = THEMES[name];
    this.scene.background = new THREE.Color(colours.sky);
    this.floor.material.uniforms.ground.value.set(colours.ground);
    this.floor.material.uniforms.line.value.set(colours.grid);
    this.shade.material.opacity = name === "dark" ? 0.45 : 0.22;
    this.touch();
  }

  /** Fit floor, light and clipping to the box around a robot (m, in its root frame). */
  fit(box) {
    const size = Math.max(box.getSize(new THREE.Vector3()).length(), 0.05);
    const centre = box.getCenter(new THREE.Vector3());
    const ground = Math.min(box.min.z, centre.z);
    const reach = 6 * size;
    for (const plane of [this.floor, this.shade]) {
      plane.position.set(centre.x, centre.y, ground - size * 1e-4);
      plane.scale.set(1, 1, 1);
      plane.geometry.dispose();
      plane.geometry = new THREE.PlaneGeometry(2 * reach, 2 * reach);
    }
    const { radius, step } = this.floor.material.uniforms;
    radius.value = reach;
    step.value = 10 ** Math.round(Math.log10(size / 8));
    this.sun.target.position.copy(centre);
    this.sun.position.copy(centre).add(new THREE.Vector3(0.25, 0.75, 1).multiplyScalar(2.5 * size));
    const { camera } = this.sun.shadow;
    Object.assign(camera, { left: -size, right: size, top: size, bottom: -size, near: 0.1 * size, far: 6 * size });
    camera.updateProjectionMatrix();
    Object.assign(this.camera, { near: size / 500, far: 60 * size });
    this.controls.minDistance = size / 100;
    this.controls.maxDistance = 20 * size;
    this.touch(true);
  }

  /**
   * Look at a box from a direction, by default from where the camera is. `room` is the part of the canvas (pixels) in whose
   * middle the box is seen; by default all of it.
   */
  look(box, direction = this.direction, room = null) {
    const { clientWidth, clientHeight } = this.canvas.parentElement;
    const { left, top, width, height } = room ?? { left: 0, top: 0, width: clientWidth, height: clientHeight };
    this.offset = [clientWidth / 2 - left - width / 2, clientHeight / 2 - top - height / 2];
    this.resize();
    const sphere = box.getBoundingSphere(new THREE.Sphere());
    const radius = Math.max(sphere.radius, 0.02);
    const share = Math.min(width, height) / clientHeight || 1; // without a height, nothing is drawn
    const distance = radius / Math.sin(THREE.MathUtils.degToRad(this.camera.fov / 2)) / share;
    this.controls.target.copy(sphere.center);
    this.camera.position.copy(sphere.center).addScaledVector(new THREE.Vector3(...direction).normalize(), distance * 1.06);
    this.camera.updateProjectionMatrix();
    this.controls.update();
    this.camera.updateMatrixWorld(); // so that positions on the screen are right before the next picture
    this.touch();
  }

  /** The direction from what is looked at to the camera. */
  get direction() {
    return this.camera.position.clone().sub(this.controls.target);
  }

  /** Where the camera is, to be brought back by ``resume``. */
  get place() {
    return { position: this.camera.position.toArray(), target: this.controls.target.toArray() };
  }

  resume({ position, target }) {
    this.camera.position.fromArray(position);
    this.controls.target.fromArray(target);
    this.controls.update();
    this.touch();
  }

  /** Return the pixel of the window at which a point (m, in the root frame) is seen. */
  pixel(point) {
    const { left, top, width, height } = this.canvas.getBoundingClientRect();
    const { x, y } = new THREE.Vector3(...point).project(this.camera);
    return [left + ((x + 1) / 2) * width, top + ((1 - y) / 2) * height];
  }

  resize() {
    const { clientWidth, clientHeight } = this.canvas.parentElement;
    if (!clientWidth || !clientHeight) return;
    this.renderer?.setSize(clientWidth, clientHeight, false);
    this.camera.setViewOffset(clientWidth, clientHeight, ...this.offset, clientWidth, clientHeight);
    this.touch();
  }

  /** Ask for a new picture; ``moved``: something else than the camera has moved, and so have the shadows. */
  touch(moved = false) {
    this.dirty = true;
    if (this.renderer) this.renderer.shadowMap.needsUpdate ||= moved;
  }

  #draw(now) {
    this.controls.update();
    if (!this.dirty) {
      this.frames.last = 0;
      this.frames.slow = 0;
      if (this.coarse && now - this.drawnAt > REST) this.#sharpen(false);
      return;
    }
    this.dirty = false;
    this.drawnAt = now;
    if (!this.coarse && this.frames.slow >= 3) this.#sharpen(true);
    for (const step of this.before) step(this.camera);
    if (this.coarse) this.renderer.shadowMap.needsUpdate = false;
    this.renderer.render(this.scene, this.camera);
    this.#count(now);
  }

  /** Draw fewer pixels and no new shadows while something moves on a slow machine; all of them when it rests. */
  #sharpen(coarse) {
    this.coarse = coarse;
    this.frames.slow = 0;
    this.renderer.setPixelRatio(this.ratio * (coarse ? COARSE : 1));
    this.touch(true);
  }

  /** Measure the time between pictures (ms) while they follow one another. */
  #count(now) {
    const { frames } = this;
    if (frames.last) frames.slow = now - frames.last > SLOW ? frames.slow + 1 : 0;
    if (frames.last) frames.mean = frames.mean ? 0.9 * frames.mean + 0.1 * (now - frames.last) : now - frames.last;
    frames.last = now;
    frames.count += 1;
  }
}
