// Bodies, the ground, joints and springs of a mechanism.
import * as THREE from "three";
import {ConvexGeometry} from "three/addons/geometries/ConvexGeometry.js";
import {mergeVertices} from "three/addons/utils/BufferGeometryUtils.js";
import {page_color} from "./colors.js";

const vector = (list) => new THREE.Vector3(...list);

/// Diagonal lines on a light ground.
function hatching() {
  const canvas = document.createElement("canvas");
  canvas.width = canvas.height = 64;
  const draw = canvas.getContext("2d");
  draw.fillStyle = page_color("--ground");
  draw.fillRect(0, 0, 64, 64);
  draw.strokeStyle = page_color("--hatch");
  draw.lineWidth = 4;
  for (let k = -64; k <= 64; k += 16) { draw.beginPath(); draw.moveTo(k, 64); draw.lineTo(k + 64, 0); draw.stroke(); }
  const texture = new THREE.CanvasTexture(canvas);
  texture.wrapS = texture.wrapT = THREE.RepeatWrapping;
  texture.colorSpace = THREE.SRGBColorSpace;
  return texture;
}

/// A block behind each edge that the ground holds, and around what it holds of elastic bodies; where
/// blocks have one wall they lie in each other.
export function ground_blocks(solids, elastic_bodies, size) {
  const group = new THREE.Group();
  const block = (wide, high, depth) => {
    const map = hatching();
    const tile = 0.09 * size;  // one and the same hatching on every block
    map.repeat.set(Math.max(0.5, wide / tile), Math.max(0.5, high / tile));
    const mesh = new THREE.Mesh(new THREE.BoxGeometry(wide, high, depth), new THREE.MeshLambertMaterial({map}));
    mesh.userData = {kind: "ground", name: "ground"};
    group.add(mesh);
    return mesh;
  };
  for (const solid of solids) for (const end of [0, 1]) {
    if ((end === 0 ? solid.leaf.base : solid.leaf.tip) !== -1) continue;
    const {middle, along, across, normal, width, half} = solid.edge(end);
    const depth = 0.035 * size, out = along.clone().multiplyScalar(end === 0 ? -1 : 1);
    const behind = block(width + 0.03 * size, 2 * half + 0.09 * size, depth);
    behind.setRotationFromMatrix(new THREE.Matrix4().makeBasis(across, normal, new THREE.Vector3().crossVectors(across, normal)));
    behind.position.copy(middle).addScaledVector(out, 0.5 * depth);
  }
  for (const {grounds} of elastic_bodies) for (const {low, high} of grounds)
    block(...low.map((x, c) => high[c] - x + 0.02 * size)).position.copy(vector(low).add(vector(high)).multiplyScalar(0.5));
  return group;
}

/// Corners of a body: what it holds, each a little ball so that the hull is smooth.
function hull_points(design, b, solids, size) {
  const radius = 0.011 * size, balls = [];
  const ball = (place) => {
    for (let k = 0; k < 8; ++k)
      balls.push(place.clone().addScaledVector(new THREE.Vector3(k & 1 ? 1 : -1, k & 2 ? 1 : -1, k & 4 ? 1 : -1), radius / Math.sqrt(3)));
    for (let c = 0; c < 3; ++c) for (const sign of [-1, 1]) {
      const shifted = place.clone();
      shifted.setComponent(c, shifted.getComponent(c) + sign * radius);
      balls.push(shifted);
    }
  };
  for (const solid of solids) for (const end of [0, 1]) {
    if ((end === 0 ? solid.leaf.base : solid.leaf.tip) !== b) continue;
    const {ends, normal, half} = solid.edge(end);
    for (const corner of ends) for (const side of [-1, 1]) ball(corner.clone().addScaledVector(normal, side * half));
  }
  for (const tie of [...design.joints, ...design.springs])
    if (tie.body === b || tie.other === b)
      ball(vector(tie.other === b && tie.body !== b && tie.other_place ? tie.other_place : tie.place));
  return balls;
}

/// A body about its reference point, undeflected: its box, or a hull of what it holds.
export function body_mesh(design, b, solids, size) {
  const body = design.bodies[b], reference = vector(body.reference);
  let geometry;
  if (body.box) {
    const edges = body.box.half_edges.map(vector), [a, c, d] = edges;
    geometry = new THREE.BoxGeometry(2, 2, 2);
    geometry.applyMatrix4(new THREE.Matrix4().makeBasis(a, c, d).setPosition(vector(body.box.center).sub(reference)));
    if (new THREE.Matrix4().makeBasis(a, c, d).determinant() < 0) geometry.index.array.reverse();
    geometry.computeVertexNormals();
  } else {
    const points = hull_points(design, b, solids, size);
    if (points.length === 0) return null;
    const hull = new ConvexGeometry(points.map((p) => p.sub(reference)));
    hull.deleteAttribute("normal");
    hull.deleteAttribute("uv");
    geometry = mergeVertices(hull);
    geometry.computeVertexNormals();
  }
  const mesh = new THREE.Mesh(geometry, new THREE.MeshLambertMaterial({
    color: page_color(body.end_effector ? "--body" : "--body-2"), transparent: true, opacity: 0.32, side: THREE.DoubleSide, depthWrite: false}));
  mesh.userData = {kind: "body", name: body.name, body: b};
  if (body.box) mesh.add(new THREE.LineSegments(new THREE.EdgesGeometry(geometry), new THREE.LineBasicMaterial({color: page_color("--ink"), transparent: true, opacity: 0.6})));
  return mesh;
}

/// Where a body is: its reference point and its rotation vector, as posed.
export function body_pose(design, b) {
  const now = design.bodies_now.subarray(6 * b, 6 * b + 6);
  const turn = new THREE.Vector3(now[3], now[4], now[5]), angle = turn.length();
  return {
    position: vector(design.bodies[b].reference).add(new THREE.Vector3(now[0], now[1], now[2])),
    rotation: new THREE.Quaternion().setFromAxisAngle(angle > 1e-12 ? turn.clone().divideScalar(angle) : new THREE.Vector3(1, 0, 0), angle),
  };
}

/// Present place of a point of a body that is undeflected at `place`; of the ground the place itself.
export function moved(design, b, place) {
  if (b < 0) return vector(place);
  const {position, rotation} = body_pose(design, b);
  return vector(place).sub(vector(design.bodies[b].reference)).applyQuaternion(rotation).add(position);
}

/// Balls or short cylinders at the joints; update() moves them.
export function joint_marks(design, size) {
  const group = new THREE.Group();
  for (const joint of design.joints) {
    const turning = joint.type === "revolute" || joint.type === "prismatic";
    const geometry = turning ? new THREE.CylinderGeometry(0.012 * size, 0.012 * size, 0.06 * size, 20) : new THREE.SphereGeometry(0.016 * size, 20, 12);
    const mark = new THREE.Mesh(geometry, new THREE.MeshLambertMaterial({color: page_color("--ink")}));
    mark.userData = {kind: "joint", name: `${joint.type} joint ${joint.name}`, update: () => {
      mark.position.copy(moved(design, joint.body, joint.place));
      const turn = joint.body >= 0 ? body_pose(design, joint.body).rotation : new THREE.Quaternion();
      mark.quaternion.copy(turn).multiply(new THREE.Quaternion().setFromUnitVectors(new THREE.Vector3(0, 1, 0), vector(joint.axis).normalize()));
    }};
    group.add(mark);
  }
  for (const spring of design.springs) {
    if (!spring.other_place) continue;
    const geometry = new THREE.BufferGeometry().setFromPoints([new THREE.Vector3(), new THREE.Vector3()]);
    const line = new THREE.Line(geometry, new THREE.LineDashedMaterial({color: page_color("--accent"), dashSize: 0.015 * size, gapSize: 0.01 * size}));
    line.userData = {kind: "spring", name: `spring ${spring.name}`, update: () => {
      geometry.setFromPoints([moved(design, spring.body, spring.place), moved(design, spring.other, spring.other_place)]);
      line.computeLineDistances();
    }};
    group.add(line);
  }
  return group;
}
