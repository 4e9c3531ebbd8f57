// A leaf as a solid with its true thickness: both faces and the four rims, finer than its mesh by
// cubics along the leaf. A wire is a tube.
import * as THREE from "three";
import {stress_color} from "./colors.js";
import {cubic_weights} from "./scene_data.js";

const least_along = 32, around = 14;

/// Colours of a share of the largest stress, made once.
const shades = Array.from({length: 256}, (_, k) => new THREE.Color(stress_color(k / 255)));
export const shade_of = (share) => shades[Math.max(0, Math.min(255, Math.round(255 * share)))];

export class LeafSolid {
  constructor(leaf) {
    this.leaf = leaf;
    const finer = Math.max(1, Math.ceil(least_along / (leaf.points_along - 1)));
    this.places = [];
    for (let i = 0; i + 1 < leaf.points_along; ++i)
      for (let k = 0; k < finer && leaf.along[i + 1] > leaf.along[i]; ++k)  // a fold is there twice
        this.places.push(leaf.along[i] + (leaf.along[i + 1] - leaf.along[i]) * k / finer);
    this.places.push(1);
    this.weights = this.places.map((s) => cubic_weights(leaf.along, s));
    this.half = this.weights.map((w) => w.reduce((sum, [i, v]) => sum + v * leaf.half_thickness[i], 0));
    this.nx = this.places.length;
    this.ny = leaf.points_across;
    this.middle = new Float32Array(3 * this.nx * this.ny);
    this.stress = new Float32Array(this.nx * this.ny);
    this.geometry = new THREE.BufferGeometry();
    this.point_of_vertex = [];  // on the fine mesh of the middle surface
    const index = leaf.round ? this.tube() : this.sheet(), n = this.point_of_vertex.length;
    for (const name of ["position", "normal", "color"])
      this.geometry.setAttribute(name, new THREE.BufferAttribute(new Float32Array(3 * n), 3));
    this.geometry.setIndex(index);
    this.mesh = new THREE.Mesh(this.geometry, new THREE.MeshLambertMaterial({vertexColors: true, side: THREE.DoubleSide}));
    this.mesh.userData = {kind: "leaf", name: leaf.name, solid: this};
  }

  /// Vertices of a sheet: grids of both faces, then the rims, two rows each.
  sheet() {
    const {nx, ny} = this, index = [];
    const grid = (columns, rows, flip) => {
      const first = this.point_of_vertex.length - columns * rows;
      for (let j = 0; j + 1 < rows; ++j) for (let i = 0; i + 1 < columns; ++i) {
        const a = first + j * columns + i, b = a + 1, c = a + columns, d = c + 1;
        index.push(...(flip ? [a, c, b, b, c, d] : [a, b, c, b, d, c]));
      }
    };
    for (const flip of [false, true]) {
      for (let k = 0; k < nx * ny; ++k) this.point_of_vertex.push(k);
      grid(nx, ny, flip);
    }
    const rims = [[nx, (i) => i], [nx, (i) => (ny - 1) * nx + i], [ny, (j) => j * nx], [ny, (j) => j * nx + nx - 1]];
    this.rims = rims.map(([count, point]) => {
      for (let row = 0; row < 2; ++row) for (let k = 0; k < count; ++k) this.point_of_vertex.push(point(k));
      grid(count, 2, false);
      return count;
    });
    return index;
  }

  tube() {
    const index = [];
    for (let i = 0; i < this.nx; ++i) for (let k = 0; k <= around; ++k) this.point_of_vertex.push(i);
    for (let i = 0; i + 1 < this.nx; ++i) for (let k = 0; k < around; ++k) {
      const a = i * (around + 1) + k, b = a + around + 1;
      index.push(a, b, a + 1, a + 1, b, b + 1);
    }
    return index;
  }

  /// Follows the pose of the design; `top`: the stress of the brightest colour, or null for a plain
  /// leaf.
  update(design, top, plain) {
    const {leaf, nx, ny, middle, stress} = this, na = leaf.points_along, p = design.positions, s = design.shown_stress;
    for (let j = 0; j < ny; ++j) for (let i = 0; i < nx; ++i) {
      let x = 0, y = 0, z = 0, v = 0;
      for (const [k, w] of this.weights[i]) {
        const at = leaf.first + j * na + k;
        x += w * p[3 * at]; y += w * p[3 * at + 1]; z += w * p[3 * at + 2]; v += w * s[at];
      }
      const to = j * nx + i;
      middle[3 * to] = x; middle[3 * to + 1] = y; middle[3 * to + 2] = z;
      stress[to] = Math.max(0, v);
    }
    const color = this.geometry.attributes.color;
    this.point_of_vertex.forEach((point, v) => {
      const c = top ? shade_of(stress[point] / top) : plain;
      color.setXYZ(v, c.r, c.g, c.b);
    });
    if (leaf.round) this.place_tube(); else this.place_sheet();
    for (const name of ["position", "normal", "color"]) this.geometry.attributes[name].needsUpdate = true;
    this.geometry.computeBoundingSphere();
  }

  point(k, to) { return to.set(this.middle[3 * k], this.middle[3 * k + 1], this.middle[3 * k + 2]); }

  /// Directions at a point of the fine mesh: along, across, normal.
  axes(i, j) {
    const {nx, ny} = this, a = new THREE.Vector3(), b = new THREE.Vector3();
    const along = this.point(j * nx + Math.min(i + 1, nx - 1), a).sub(this.point(j * nx + Math.max(i - 1, 0), b)).clone().normalize();
    const across = this.point(Math.min(j + 1, ny - 1) * nx + i, a).sub(this.point(Math.max(j - 1, 0) * nx + i, b)).clone().normalize();
    return {along, across, normal: new THREE.Vector3().crossVectors(along, across).normalize()};
  }

  place_sheet() {
    const {nx, ny} = this, {position, normal} = this.geometry.attributes, at = new THREE.Vector3();
    const put = (v, place, shift, by, direction) => {
      position.setXYZ(v, place.x + shift.x * by, place.y + shift.y * by, place.z + shift.z * by);
      normal.setXYZ(v, direction.x, direction.y, direction.z);
    };
    const frames = [];
    for (let j = 0; j < ny; ++j) for (let i = 0; i < nx; ++i) frames.push(this.axes(i, j));
    const n = nx * ny;
    for (let k = 0; k < n; ++k) {
      const h = this.half[k % nx], {normal: up} = frames[k];
      this.point(k, at);
      put(k, at, up, h, up);
      put(n + k, at, up, -h, up.clone().negate());
    }
    let v = 2 * n;
    this.rims.forEach((count, rim) => {
      for (const side of [1, -1]) for (let c = 0; c < count; ++c, ++v) {
        const k = this.point_of_vertex[v], frame = frames[k];
        const out = (rim < 2 ? frame.across : frame.along).clone().multiplyScalar(rim % 2 === 0 ? -1 : 1);
        put(v, this.point(k, at), frame.normal, side * this.half[k % nx], out);
      }
    });
  }

  place_tube() {
    const {nx, ny} = this, {position, normal} = this.geometry.attributes;
    const first = new THREE.Vector3(), last = new THREE.Vector3(), out = new THREE.Vector3();
    for (let i = 0; i < nx; ++i) {
      const {across, normal: up} = this.axes(i, 0);
      const center = this.point(i, first).add(this.point((ny - 1) * nx + i, last)).multiplyScalar(0.5);
      for (let k = 0; k <= around; ++k) {
        const angle = 2 * Math.PI * k / around, v = i * (around + 1) + k;
        out.copy(across).multiplyScalar(Math.cos(angle)).addScaledVector(up, Math.sin(angle));
        position.setXYZ(v, center.x + out.x * this.half[i], center.y + out.y * this.half[i], center.z + out.z * this.half[i]);
        normal.setXYZ(v, out.x, out.y, out.z);
      }
    }
  }

  /// The clamped edge (0 base, 1 tip): its middle, directions, width and half thickness, as posed.
  edge(end) {
    const i = end === 0 ? 0 : this.nx - 1, {nx, ny} = this;
    const a = this.point(i, new THREE.Vector3()), b = this.point((ny - 1) * nx + i, new THREE.Vector3());
    return {...this.axes(i, Math.floor(ny / 2)), middle: a.clone().add(b).multiplyScalar(0.5), ends: [a, b], width: this.leaf.round ? 2 * this.half[i] : a.distanceTo(b), half: this.half[i]};
  }
}
