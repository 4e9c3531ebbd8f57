// The three-dimensional view: one or two mechanisms on one canvas, drawn when something has changed.
import * as THREE from "three";
import {OrbitControls} from "three/addons/controls/OrbitControls.js";
import {dark_mode, page_color} from "./colors.js";
import {ElasticSurface} from "./elastic_surface.js";
import {LeafSolid} from "./leaf_solid.js";
import {body_mesh, body_pose, ground_blocks, joint_marks} from "./parts.js";
import {job} from "./result.js";
import {axis_cross, drive_arrows, load_arrows, name_words, reference_point} from "./symbols.js";

/// Directions from which the standard views look; in that of three dimensions y is up.
export const standard_views = {
  "3-D": [0.55, 0.45, 0.7], "x–y": [0, 0, 1], "x–z": [0, 1, 0.0001], "y–z": [1, 0, 0],
};
const axes = {x: [1, 0, 0], y: [0, 1, 0], z: [0, 0, 1]};

/// The axis along which gravity points the most is the upright one; without gravity y.
export function upright() {
  const gravity = Array.isArray(job.gravity) ? job.gravity.map((g) => typeof g === "number" ? Math.abs(g) : 0) : [];
  const most = Math.max(0, ...gravity);
  return most > 0 ? "xyz"[gravity.indexOf(most)] : "y";
}

/// One mechanism with all that is drawn of it.
class Figure {
  constructor(design) {
    this.design = design;
    this.scene = new THREE.Scene();
    this.solids = design.leaves.map((leaf) => new LeafSolid(leaf));
    this.surfaces = design.elastic_bodies.map((body) => new ElasticSurface(body));
    this.build();
  }

  build() {
    const {design, scene, solids} = this, {size} = design;
    scene.clear();
    scene.add(new THREE.HemisphereLight(0xffffff, 0x667788, 2.2));
    design.pose(0, null, 0);
    design.positions.set(design.rest);
    design.bodies_now.fill(0);
    for (const solid of [...solids, ...this.surfaces]) { solid.update(design, null, new THREE.Color(page_color("--metal"))); scene.add(solid.mesh); }
    this.ground = ground_blocks(solids, design.elastic_bodies, size);
    this.bodies = design.bodies.map((_, b) => design.is_frame(b) ? null : body_mesh(design, b, solids, size));
    this.marks = [...joint_marks(design, size).children, ...drive_arrows(design, size).children, ...load_arrows(design, size).children];
    const point = reference_point(design, size);
    scene.add(this.ground, ...this.bodies.filter(Boolean), ...this.marks, point);
    this.marks.push(...point.children);
    this.names = null;  // made when they are asked for: a moved design is built many times a second
  }

  /// Gives back what the graphics processor holds of it.
  dispose() {
    this.scene.traverse((part) => { part.geometry?.dispose(); for (const one of [part.material].flat()) { one?.map?.dispose(); one?.dispose(); } });
  }

  /// amount: largest motion of the mode [m]; top: stress of the brightest colour, null for none.
  pose({stroke, mode, amount, magnified, top, chosen, show_bodies, show_names}) {
    const {design} = this, plain = new THREE.Color(page_color("--metal"));
    design.pose(stroke, mode, amount, magnified);
    for (const solid of this.solids) {
      solid.update(design, top, plain);
      solid.mesh.material.emissive.set(chosen && solid.leaf.name === chosen ? page_color("--chosen") : 0x000000);
    }
    for (const surface of this.surfaces) surface.update(design, top, plain);
    this.bodies.forEach((mesh, b) => {
      if (!mesh) return;
      const {position, rotation} = body_pose(design, b);
      mesh.position.copy(position);
      mesh.quaternion.copy(rotation);
      mesh.visible = show_bodies;
    });
    if (show_names && !this.names) {
      this.names = name_words(design, this.solids, this.surfaces, this.bodies, design.size);
      this.scene.add(this.names);
      this.marks.push(...this.names.children);
    }
    if (this.names) this.names.visible = show_names;
    for (const mark of this.marks) mark.userData.update?.();
  }

  /// Moves names up the picture until none lies over another word.
  part_words(camera) {
    if (!this.names?.visible) return;
    const taken = [], upward = new THREE.Vector3().setFromMatrixColumn(camera.matrixWorld, 1);
    const place = (sprite) => {  // middle and half sizes, seen at depth 1
      const {x, y, z} = sprite.getWorldPosition(new THREE.Vector3()).applyMatrix4(camera.matrixWorldInverse), depth = -z;
      return {x: x / depth, y: y / depth, depth, wide: sprite.scale.x / depth / 2, high: 0.4 * sprite.scale.y / depth};
    };
    for (const mark of this.marks) if (!mark.isSprite) mark.traverse((part) => { if (part.isSprite) taken.push(place(part)); });
    for (const name of this.names.children) {
      name.userData.update();
      const at = place(name), first = at.y;
      const over = (other) => Math.abs(at.x - other.x) < at.wide + other.wide && Math.abs(at.y - other.y) < 0.999 * (at.high + other.high);
      for (let hit = taken.find(over), k = 0; hit && k < 100; hit = taken.find(over), ++k) at.y = hit.y + hit.high + at.high;
      taken.push(at);
      name.position.addScaledVector(upward, (at.y - first) * at.depth);
    }
  }
}

/// Throws where the browser has no WebGL.
export class View {
  constructor(canvas) {
    this.canvas = canvas;
    this.renderer = new THREE.WebGLRenderer({canvas, antialias: true, alpha: true, preserveDrawingBuffer: true});
    this.renderer.autoClear = false;
    this.camera = new THREE.PerspectiveCamera(28, 1, 0.001, 100);
    this.lamp = new THREE.DirectionalLight(0xffffff, 1.6);
    this.camera.add(this.lamp);
    this.lamp.position.set(-0.6, 1, 0.8);
    this.make_controls();
    this.corner = new THREE.OrthographicCamera(-1.8, 1.8, 1.8, -1.8, 0.1, 20);
    this.cross = axis_cross();
    this.figures = [];
    this.known = new Map();
    this.frames_drawn = 0;
    new ResizeObserver(() => {
      this.resize();
      if (!this.turned) this.look(this.looking ?? "3-D");  // until the reader has turned it
      this.request();
    }).observe(canvas.parentElement);
    dark_mode.addEventListener("change", () => this.rebuild());
    matchMedia("print").addEventListener("change", () => { this.rebuild(); this.draw(); });  // paper is white
    canvas.addEventListener("keydown", (event) => this.key(event));
  }

  /// Turning by the pointer, about the axis that is up for the camera now.
  make_controls() {
    const turntable = this.controls?.autoRotate ?? false;
    this.controls?.dispose();
    this.controls = Object.assign(new OrbitControls(this.camera, this.canvas), {autoRotateSpeed: 4, autoRotate: turntable});
    this.controls.addEventListener("change", () => this.request());
    this.controls.addEventListener("start", () => { this.turned = true; });
  }

  /// "x", "y" or "z": the axis that is up; it takes effect with the next look().
  get upward() { return this.up_axis ?? upright(); }
  set upward(axis) { this.up_axis = axis; }

  /// Designs from left to right. What is known of others is kept: the reader may go back to them.
  show(designs) {
    this.figures = designs.map((design) => {
      if (!this.known.has(design)) this.known.set(design, new Figure(design));
      return this.known.get(design);
    });
    this.resize();
    this.request();
  }

  /// Forgets all designs: others take their places with the next show(). What it gives back belongs
  /// to the old ones, to be called when the new ones have been drawn: they share shaders, which would
  /// otherwise be made again.
  forget() {
    const old = [...this.known.values()];
    this.known = new Map();
    this.figures = [];
    return () => old.forEach((figure) => figure.dispose());
  }

  rebuild() {
    this.cross = axis_cross();
    for (const figure of this.known.values()) figure.build();
    if (this.settings) this.pose(this.settings);
    this.request();
  }

  resize() {
    const box = this.canvas.parentElement.getBoundingClientRect();
    if (box.width === 0) return;
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.renderer.setSize(box.width, box.height, false);
    this.camera.aspect = box.width / Math.max(1, this.figures.length) / box.height;
    this.camera.updateProjectionMatrix();
  }

  /// Whether what is shown has outgrown the picture, or is small in it.
  misfits() {
    if (!this.fitted) return true;
    const {low, high} = this.box(), size = (b) => Math.hypot(...b.low.map((x, c) => b.high[c] - x));
    const slack = 0.03 * size(this.fitted);
    return low.some((x, c) => x < this.fitted.low[c] - slack || high[c] > this.fitted.high[c] + slack) || size({low, high}) < 0.65 * size(this.fitted);
  }

  /// Box around all figures, with a margin for the ground behind the edges.
  box() {
    const first = this.figures[0].design, margin = 0.04 * first.size;
    return {low: first.low.map((x, c) => Math.min(...this.figures.map((f) => f.design.low[c])) - margin),
      high: first.high.map((x, c) => Math.max(...this.figures.map((f) => f.design.high[c])) + margin)};
  }

  /// Looks at the middle of all figures from a standard direction.
  look(name) {
    const first = this.figures[0]?.design;
    if (!first) return;
    this.looking = name;
    this.turned = false;
    const {low, high} = this.fitted = this.box();
    const center = new THREE.Vector3(...low.map((x, c) => (x + high[c]) / 2));
    const [a, b, c] = standard_views[name];
    const direction = new THREE.Vector3(...(name !== "3-D" ? [a, b, c] : {x: [b, c, a], y: [a, b, c], z: [c, a, b]}[this.upward])).normalize();
    const up = new THREE.Vector3(...axes[this.upward]);
    if (Math.abs(up.dot(direction)) > 0.99) up.set(...axes[name === "x–z" ? "z" : "y"]);  // looked at from above
    if (!this.camera.up.equals(up)) { this.camera.up.copy(up); this.make_controls(); }
    this.controls.target.copy(center);
    this.camera.position.copy(center).add(direction);
    this.camera.lookAt(center);
    this.camera.updateMatrixWorld();
    const inverse = this.camera.matrixWorld.clone().invert(), half = Math.tan(this.camera.fov * Math.PI / 360);
    let distance = 0;
    for (let k = 0; k < 8; ++k) {
      const corner = new THREE.Vector3(...low.map((x, c) => k & (1 << c) ? high[c] : x)).applyMatrix4(inverse);
      distance = Math.max(distance, corner.z + 1 + Math.max(Math.abs(corner.y) / half, Math.abs(corner.x) / half / this.camera.aspect));
    }
    distance *= 1.03;
    this.camera.position.copy(center).addScaledVector(direction, distance);
    this.camera.near = distance / 100;
    this.camera.far = distance * 20;
    this.camera.updateProjectionMatrix();
    this.controls.update();
    this.request();
  }

  get turntable() { return this.controls.autoRotate; }
  set turntable(on) {
    this.controls.autoRotate = on;
    this.request();
  }

  key(event) {
    const turn = {ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, -0.1], ArrowDown: [0, 0.1]}[event.key];
    const zoom = {"+": 0.9, "=": 0.9, "-": 1.1}[event.key];
    if (!turn && !zoom) return;
    event.preventDefault();
    this.turned = true;
    const offset = this.camera.position.clone().sub(this.controls.target);
    const upright = new THREE.Quaternion().setFromUnitVectors(this.camera.up, new THREE.Vector3(0, 1, 0));
    offset.applyQuaternion(upright);
    const ball = new THREE.Spherical().setFromVector3(offset);
    if (turn) { ball.theta += turn[0]; ball.phi = Math.min(3.1, Math.max(0.04, ball.phi + turn[1])); }
    if (zoom) ball.radius *= zoom;
    this.camera.position.copy(this.controls.target).add(offset.setFromSpherical(ball).applyQuaternion(upright.invert()));
    this.controls.update();
    this.request();
  }

  pose(settings) {
    this.settings = settings;
    for (const figure of this.figures) figure.pose(settings);
    this.request();
  }

  request() {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(() => {
      this.waiting = false;
      this.draw();
      if (this.controls.autoRotate) { this.controls.update(); this.request(); }
    });
  }

  draw() {
    const {renderer, camera, figures} = this, size = renderer.getSize(new THREE.Vector2());
    const width = size.x / Math.max(1, figures.length);
    renderer.setScissorTest(false);
    renderer.clear();
    renderer.setScissorTest(true);
    figures.forEach((figure, k) => {
      renderer.setViewport(k * width, 0, width, size.y);
      renderer.setScissor(k * width, 0, width, size.y);
      figure.scene.add(camera);
      figure.part_words(camera);
      renderer.render(figure.scene, camera);
      figure.scene.remove(camera);
    });
    const side = Math.min(90, 0.28 * size.y);
    renderer.setViewport(0, 0, side, side);
    renderer.setScissor(0, 0, side, side);
    this.corner.position.copy(camera.position).sub(this.controls.target).setLength(6);
    this.corner.up.copy(camera.up);
    this.corner.lookAt(0, 0, 0);
    renderer.clearDepth();
    renderer.render(this.cross, this.corner);
    this.frames_drawn += 1;
  }

  /// The part under a place of the page: {kind, name, figure, solid, vertex}, or null.
  pick(x, y) {
    const box = this.canvas.getBoundingClientRect(), share = (x - box.left) / box.width * this.figures.length;
    const figure = this.figures[Math.floor(share)];
    if (!figure) return null;
    const ray = new THREE.Raycaster();
    ray.setFromCamera(new THREE.Vector2(2 * (share % 1) - 1, 1 - 2 * (y - box.top) / box.height), this.camera);
    const parts = [...[...figure.solids, ...figure.surfaces].map((s) => s.mesh), ...figure.bodies.filter((b) => b?.visible), ...figure.ground.children];
    const hits = ray.intersectObjects(parts, false);
    const hit = hits.find((h) => ["leaf", "elastic"].includes(h.object.userData.kind)) ?? hits[0];  // bodies are clear
    return hit ? {...hit.object.userData, figure, vertex: hit.face?.a ?? 0} : null;
  }

  /// Middle of a leaf on the page, for tests and for the tip of a chosen one.
  place_of(name) {
    const figure = this.figures[0], solid = figure?.solids.find((s) => s.leaf.name === name);
    if (!solid) return null;
    const p = solid.point(Math.floor(solid.ny / 2) * solid.nx + Math.floor(solid.nx / 2), new THREE.Vector3()).project(this.camera);
    const box = this.canvas.getBoundingClientRect();
    return [box.left + (p.x + 1) / 2 * box.width / this.figures.length, box.top + (1 - p.y) / 2 * box.height];
  }

  /// The picture as a PNG.
  picture() {
    this.draw();
    return new Promise((resolve) => this.canvas.toBlob(resolve, "image/png"));
  }
}
