/** Shapes of a robot as geometry of three.js: unit solids that are scaled, and surfaces of height maps. */

import * as THREE from "three";

const ROUND = 40;

function upright(geometry) {
  return geometry.rotateX(Math.PI / 2); // three's cylinders stand along y, ours along z
}

/** Solids of size 1: a box of edge 1, a sphere of radius 1, a cylinder of radius 1 and length 1. */
export const UNIT = {
  box: new THREE.BoxGeometry(1, 1, 1),
  sphere: new THREE.SphereGeometry(1, ROUND, ROUND / 2),
  cylinder: upright(new THREE.CylinderGeometry(1, 1, 1, ROUND)),
};

/**
 * Return the pieces that a shape is drawn of: a unit solid, its scale and its place on the z axis of the shape.
 * Meshes and height maps have none.
 */
export function pieces(shape) {
  switch (shape.kind) {
    case "box":
      return [{ solid: "box", scale: shape.size, z: 0 }];
    case "sphere":
      return [{ solid: "sphere", scale: [shape.radius, shape.radius, shape.radius], z: 0 }];
    case "ellipsoid":
      return [{ solid: "sphere", scale: shape.radii, z: 0 }];
    case "cylinder":
      return [{ solid: "cylinder", scale: [shape.radius, shape.radius, shape.length], z: 0 }];
    case "capsule": {
      const ball = [shape.radius, shape.radius, shape.radius];
      return [
        { solid: "cylinder", scale: [shape.radius, shape.radius, shape.length], z: 0 },
        { solid: "sphere", scale: ball, z: shape.length / 2 },
        { solid: "sphere", scale: ball, z: -shape.length / 2 },
      ];
    }
    default:
      return [];
  }
}

/**
 * Return the body under a height map as a closed surface of steps: the top of each cell, and walls where cells differ.
 * `heights[i][j]` is the height (m) of the cell from x = origin[0] + i * cell, y = origin[1] + j * cell; 0 is no body.
 */
export function heightMap({ origin, cell, heights }) {
  const corners = [];
  const faces = []; // where each corner is on its face, for the lines along edges
  const at = (i, j) => heights[i]?.[j] ?? 0;
  const quad = (a, b, c, d) => {
    corners.push(...a, ...b, ...c, ...a, ...c, ...d);
    faces.push(0, 0, 1, 0, 1, 1, 0, 0, 1, 1, 0, 1);
  };
  for (let i = 0; i < heights.length; i += 1) {
    for (let j = 0; j < heights[i].length; j += 1) {
      const h = at(i, j);
      if (!(h > 0)) continue;
      const [x, y] = [origin[0] + i * cell, origin[1] + j * cell];
      const [X, Y] = [x + cell, y + cell];
      quad([x, y, h], [X, y, h], [X, Y, h], [x, Y, h]);
      quad([x, Y, 0], [X, Y, 0], [X, y, 0], [x, y, 0]);
      const low = (other) => Math.min(other, h);
      const walls = [
        [at(i - 1, j), [x, Y], [x, y]],
        [at(i + 1, j), [X, y], [X, Y]],
        [at(i, j - 1), [x, y], [X, y]],
        [at(i, j + 1), [X, Y], [x, Y]],
      ];
      for (const [other, a, b] of walls) {
        const z = low(other);
        if (z < h) quad([...a, z], [...b, z], [...b, h], [...a, h]);
      }
    }
  }
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.Float32BufferAttribute(corners, 3));
  geometry.setAttribute("uv", new THREE.Float32BufferAttribute(faces, 2));
  geometry.computeVertexNormals();
  return geometry;
}

/** Return a transform of ours as a matrix of three.js. */
export function matrix(transform, out = new THREE.Matrix4()) {
  const { r, p } = transform;
  return out.set(r[0], r[1], r[2], p[0], r[3], r[4], r[5], p[1], r[6], r[7], r[8], p[2], 0, 0, 0, 1);
}
