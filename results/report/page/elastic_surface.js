// The surface of an elastic body, between the corners of its cells.
import * as THREE from "three";
import {shade_of} from "./leaf_solid.js";

export class ElasticSurface {
  constructor(body) {
    this.body = body;
    this.geometry = new THREE.BufferGeometry();
    for (const name of ["position", "color"])
      this.geometry.setAttribute(name, new THREE.BufferAttribute(new Float32Array(3 * body.points), 3));
    this.geometry.setIndex([...body.corners]);
    this.mesh = new THREE.Mesh(this.geometry, new THREE.MeshLambertMaterial({vertexColors: true, flatShading: true, side: THREE.DoubleSide}));
    this.mesh.userData = {kind: "elastic", name: body.name, solid: this};
  }

  /// As LeafSolid's.
  update(design, top, plain) {
    const {first, points} = this.body, {position, color} = this.geometry.attributes;
    position.array.set(design.positions.subarray(3 * first, 3 * (first + points)));
    this.stress = design.shown_stress.subarray(first, first + points);
    for (let k = 0; k < points; ++k) {
      const c = top ? shade_of(this.stress[k] / top) : plain;
      color.setXYZ(k, c.r, c.g, c.b);
    }
    position.needsUpdate = color.needsUpdate = true;
    this.geometry.computeBoundingSphere();
  }
}
