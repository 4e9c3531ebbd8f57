// What is drawn beside the parts: arrows of the drives and loads, O and its path, axes, words.
import * as THREE from "three";
import {page_color} from "./colors.js";
import {body_pose, moved} from "./parts.js";
import {drive_units, job, load_path} from "./result.js";
import {number_text} from "./text.js";

const vector = (list) => new THREE.Vector3(...list);
const up = new THREE.Vector3(0, 1, 0);

/// A word that always faces the reader, `height` high; drawn over everything. `halo`: colour of its rim.
export function word(text, color, height, halo = null) {
  const canvas = document.createElement("canvas"), draw = canvas.getContext("2d");
  const font = "600 44px system-ui, 'DejaVu Sans', sans-serif";
  draw.font = font;
  canvas.width = Math.ceil(draw.measureText(text).width) + 12;
  canvas.height = 56;
  draw.font = font;
  draw.fillStyle = color;
  draw.textBaseline = "middle";
  if (halo) { draw.strokeStyle = halo; draw.lineWidth = 9; draw.lineJoin = "round"; draw.strokeText(text, 6, 30); }
  draw.fillText(text, 6, 30);
  const map = new THREE.CanvasTexture(canvas);
  map.colorSpace = THREE.SRGBColorSpace;
  map.minFilter = THREE.LinearFilter;  // smaller pictures of thin letters are pale
  map.generateMipmaps = false;
  const sprite = new THREE.Sprite(new THREE.SpriteMaterial({map, depthTest: false, depthWrite: false}));
  sprite.scale.set(height * canvas.width / canvas.height, height, 1);
  sprite.renderOrder = 10;
  return sprite;
}

/// An arrow of length 1 along y; of a rotation about y three quarters of a ring.
function arrow(color, turning, thick = 0.022) {
  const group = new THREE.Group(), material = new THREE.MeshLambertMaterial({color, emissive: color, emissiveIntensity: 0.25});
  const tip = new THREE.Mesh(new THREE.ConeGeometry(3 * thick, 9 * thick, 20), material);
  if (turning) {
    const angle = 1.4 * Math.PI;
    const ring = new THREE.Mesh(new THREE.TorusGeometry(0.5, thick, 10, 48, angle), material);
    ring.rotation.x = -Math.PI / 2;
    tip.position.set(0.5 * Math.cos(angle), 0, -0.5 * Math.sin(angle));
    tip.quaternion.setFromUnitVectors(up, new THREE.Vector3(-Math.sin(angle), 0, -Math.cos(angle)));
    group.add(ring, tip);
  } else {
    const shaft = new THREE.Mesh(new THREE.CylinderGeometry(thick, thick, 1 - 9 * thick, 12), material);
    shaft.position.y = 0.5 - 4.5 * thick;
    tip.position.y = 1 - 4.5 * thick;
    group.add(shaft, tip);
  }
  return group;
}

const aim = (object, direction) => object.quaternion.setFromUnitVectors(up, direction.clone().normalize());

export function drive_arrows(design, size) {
  const group = new THREE.Group();
  if (load_path) return group;  // nothing is driven
  for (const drive of design.drives) {
    const turning = drive.direction[0] === "r", mark = arrow(page_color("--drive"), turning);
    mark.scale.setScalar((turning ? 0.24 : 0.2) * size);
    const text = word(drive.name || `drive ${drive.direction}`, page_color("--drive"), 0.042 * size);
    const holder = new THREE.Group();
    holder.add(mark, text);
    holder.userData = {kind: "drive", name: `drive ${drive.name || drive.direction}`, update: () => {
      const axis = vector(drive.axis);
      if (drive.other >= 0) axis.applyQuaternion(body_pose(design, drive.other).rotation);
      mark.position.copy(moved(design, drive.body, design.bodies[drive.body].reference));
      aim(mark, axis);
      text.position.copy(mark.position).addScaledVector(axis, (turning ? 0.05 : 0.22) * size);
      if (turning) text.position.x += 0.15 * size;
    }};
    group.add(holder);
  }
  return group;
}

/// Forces as straight, moments as turning arrows, at the moved place; all of one length.
export function load_arrows(design, size) {
  const group = new THREE.Group();
  const gravity = Array.isArray(job.gravity) && job.gravity.length === 3 && job.gravity.every((g) => typeof g === "number") ? vector(job.gravity) : null;
  if (gravity && gravity.length() > 0) {
    const mark = arrow(page_color("--soft"), false), text = word(`gravity ${number_text(gravity.length())} m/s²`, page_color("--soft"), 0.042 * size), holder = new THREE.Group();
    mark.scale.setScalar(0.14 * size);
    aim(mark, gravity);
    holder.add(mark, text);
    holder.userData = {kind: "load", name: "gravity", update: () => {
      mark.position.copy(moved(design, design.end_effector, design.bodies[design.end_effector].center_of_mass));
      text.position.copy(mark.position).addScaledVector(gravity.clone().normalize(), 0.17 * size);
    }};
    group.add(holder);
  }
  for (const load of design.loads)
    for (const [key, unit] of [["force", "N"], ["moment", "N m"]]) {
      const amount = vector(load[key]);
      if (amount.length() === 0) continue;
      const mark = arrow(page_color("--load"), key === "moment");
      mark.scale.setScalar(0.18 * size);
      aim(mark, amount);
      const value = `${load.name ? load.name + ": " : ""}${number_text(amount.length())} ${unit}${load.growing ? " × load factor" : ""}`;
      const text = word(value, page_color("--load"), 0.042 * size), holder = new THREE.Group();
      holder.add(mark, text);
      holder.userData = {kind: "load", name: `${key} ${value}`, update: () => {
        mark.position.copy(moved(design, load.body, load.place));
        text.position.copy(mark.position).addScaledVector(amount.clone().normalize(), 0.21 * size);
      }};
      group.add(holder);
    }
  return group;
}

/// O as a ball with its letter, and the way it takes over the whole stroke.
export function reference_point(design, size) {
  const group = new THREE.Group(), b = design.end_effector, color = page_color("--accent");
  const ball = new THREE.Mesh(new THREE.SphereGeometry(0.011 * size, 20, 14), new THREE.MeshLambertMaterial({color, depthTest: false, transparent: true}));
  ball.renderOrder = 9;
  const letter = word("O", color, 0.045 * size), reference = vector(design.bodies[b].reference);
  const places = design.order.map(({k}) => {
    const at = 6 * (k * design.bodies.length + b);
    return reference.clone().add(new THREE.Vector3(design.motion[at], design.motion[at + 1], design.motion[at + 2]));
  });
  if (drive_units) {  // the points of several drives have no order
    const dots = new THREE.Points(new THREE.BufferGeometry().setFromPoints(places), new THREE.PointsMaterial({color, size: 3, sizeAttenuation: false, depthTest: false, transparent: true}));
    dots.renderOrder = 8;
    group.add(dots);
  } else if (places.length > 1) {
    const way = new THREE.CatmullRomCurve3(places).getPoints(12 * places.length);
    const line = new THREE.Line(new THREE.BufferGeometry().setFromPoints(way), new THREE.LineBasicMaterial({color, depthTest: false, transparent: true}));
    line.renderOrder = 8;
    group.add(line);
  }
  const holder = new THREE.Group();
  holder.add(ball, letter);
  holder.userData = {kind: "point", name: "O", update: () => {
    ball.position.copy(moved(design, b, design.bodies[b].reference));
    letter.position.copy(ball.position).add(new THREE.Vector3(0.03 * size, 0.03 * size, 0));
  }};
  group.add(holder);
  return group;
}

/// Names of leaves (nearer to the base, since leaves often cross in the middle), bodies, joints and springs.
export function name_words(design, solids, surfaces, bodies, size) {
  const group = new THREE.Group();
  const add = (text, color, where) => {
    if (!text) return;
    const mark = word(text, page_color(color), 0.034 * size, page_color("--panel"));
    mark.userData = {kind: "name", name: text, update: () => mark.position.copy(where())};
    group.add(mark);
  };
  // Of a reinforced leaf and its parts one name is enough.
  const reinforced = new Set(solids.map(({leaf}) => /^(.*)\/reinforcement$/.exec(leaf.name)?.[1]).filter(Boolean));
  const whole = (name) => { const [, stem, part] = /^(.*)\/(.*)$/.exec(name ?? "") ?? []; return !reinforced.has(stem) ? name : part === "reinforcement" ? stem : ""; };
  for (const solid of solids)
    add(whole(solid.leaf.name), "--ink", () => solid.point(Math.floor(solid.ny / 2) * solid.nx + Math.round(0.3 * (solid.nx - 1)), new THREE.Vector3()));
  for (const {body, geometry} of surfaces)
    add(body.name, "--accent", () => {
      const {center} = geometry.boundingSphere;
      return center.clone().setY(center.y + 0.03 * size);
    });
  design.bodies.forEach((body, b) => {
    if (design.is_frame(b)) return;
    let place = vector(body.center_of_mass);
    if (bodies[b]) {  // above what is drawn of it
      bodies[b].geometry.computeBoundingBox();
      const {min, max} = bodies[b].geometry.boundingBox;
      place = min.clone().add(max).multiplyScalar(0.5).setY(max.y + 0.03 * size).add(vector(body.reference));
    }
    add(whole(body.name), "--accent", () => moved(design, b, place.toArray()));
  });
  for (const tie of [...design.joints, ...design.springs])
    add(tie.name, "--soft", () => moved(design, tie.body, tie.place).add(new THREE.Vector3(0, 0.03 * size, 0)));
  return group;
}

/// x, y, z for a corner of the view, of length 1.
export function axis_cross() {
  const scene = new THREE.Scene();
  scene.add(new THREE.AmbientLight(0xffffff, 3));
  for (const [name, axis] of [["x", [1, 0, 0]], ["y", [0, 1, 0]], ["z", [0, 0, 1]]]) {
    const mark = arrow(page_color("--ink"), false, 0.03);
    aim(mark, vector(axis));
    const letter = word(name, page_color("--ink"), 0.5);
    letter.position.copy(vector(axis)).multiplyScalar(1.3);
    scene.add(mark, letter);
  }
  return scene;
}
