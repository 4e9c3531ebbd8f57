// The scene: equilibria and modes on the meshes of the leaves, decoded from the file, and the pose
// of a mechanism at any stroke between them.
import {unzlibSync} from "fflate";
import {cases, drive_units, load_path, path, shown_case, whole, with_one_stroke} from "./result.js";

function bytes_of(text) {
  const binary = atob(text);
  const bytes = new Uint8Array(binary.length);
  for (let i = 0; i < binary.length; ++i) bytes[i] = binary.charCodeAt(i);
  return unzlibSync(bytes);
}

/// Numbers of an array of packed_floats, in order: the file has the first bytes of all numbers,
/// then the second ones, and so on.
export function unpacked(array) {
  const by_place = bytes_of(array.data), size = array.type === "float32" ? 4 : 2, n = by_place.length / size;
  const bytes = new Uint8Array(by_place.length);
  for (let b = 0; b < size; ++b) for (let i = 0; i < n; ++i) bytes[size * i + b] = by_place[b * n + i];
  if (array.type === "float32") return new Float32Array(bytes.buffer);
  const values = new Int16Array(bytes.buffer), row = array.shape[0] > 0 ? n / array.shape[0] : 0;
  for (let i = row; i < n; ++i) values[i] += values[i - row];  // rows are differences
  return values;
}

/// Weights of the values at the places xs (ascending) for the value at x: a cubic through them with
/// slopes from differences. Where a place is there twice, as at a fold, there is a kink. [[place, weight], …]
export function cubic_weights(xs, x) {
  const n = xs.length;
  if (n === 1 || x <= xs[0]) return [[0, 1]];
  if (x >= xs[n - 1]) return [[n - 1, 1]];
  let i = 0;
  while (xs[i + 1] < x) ++i;
  let first = i, last = i + 1;  // ends of the smooth part
  while (first > 0 && xs[first - 1] < xs[first]) --first;
  while (last + 1 < n && xs[last + 1] > xs[last]) ++last;
  const h = xs[i + 1] - xs[i], t = (x - xs[i]) / h, weights = new Map();
  const add = (k, w) => weights.set(k, (weights.get(k) ?? 0) + w);
  const slope = (k, w) => {  // w times h d/dx at place k
    const a = Math.max(k - 1, first), b = Math.min(k + 1, last);
    if (b - a < 2) { add(b, w * h / (xs[b] - xs[a])); add(a, -w * h / (xs[b] - xs[a])); return; }
    const l = xs[k] - xs[a], r = xs[b] - xs[k];  // derivative of the parabola through three places
    add(a, -w * h * r / (l * (l + r)));
    add(k, w * h * (r - l) / (l * r));
    add(b, w * h * l / (r * (l + r)));
  };
  add(i, (1 + 2 * t) * (1 - t) ** 2);
  add(i + 1, t * t * (3 - 2 * t));
  slope(i, t * (1 - t) ** 2);
  slope(i + 1, t * t * (t - 1));
  return [...weights];
}

/// One mechanism and its equilibria.
export class Design {
  constructor(json, place) {
    Object.assign(this, json);
    this.place = place;
    this.path = json.path ? with_one_stroke(json.path) : path;
    this.rest = unpacked(json.rest);
    this.displacement = unpacked(json.displacement);
    this.stress = unpacked(json.von_mises);
    this.motion = unpacked(json.motion);
    this.points = this.rest.length / 3;
    // A listed design has the points of its own job, whose path this result does not have.
    // So has another load case.
    const other = this.kind === "case" && cases[json.case]?.path;
    const own = this.kind === "listed" ? listed_path(json.listed) ?? this.path
      : other ? with_one_stroke(structuredClone(other)) : this.path;
    this.path = own;
    this.order = json.frames.map((point, k) => ({k, stroke: own[point]?.stroke ?? k})).sort((a, b) => a.stroke - b.stroke);
    this.strokes = this.order.map((f) => f.stroke);
    let first = 0;
    for (const leaf of this.leaves) {
      leaf.first = first;
      first += leaf.points_along * leaf.points_across;
    }
    this.elastic_bodies = (json.elastic_bodies ?? []).filter((body) => body.points > 0);  // imported matrices have none
    for (const body of this.elastic_bodies) {
      body.first = first;
      body.corners = unpacked(body.triangles);
      first += body.points;
    }
    if (json.modes) {
      this.mode_values = unpacked(json.modes.leaves);
      this.mode_bodies = unpacked(json.modes.bodies);
      this.mode_strokes = json.modes.frames.map((point) => own[point]?.stroke ?? 0);
    }
    this.size = this.measure();
    this.positions = new Float32Array(3 * this.points);
    this.shown_stress = new Float32Array(this.points);
    this.bodies_now = new Float32Array(6 * this.bodies.length);
  }

  /// Box of all points at all strokes.
  measure() {
    const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    const take = (c, x) => { low[c] = Math.min(low[c], x); high[c] = Math.max(high[c], x); };
    for (let f = 0, at = 0; f < this.frames.length; ++f)
      for (let i = 0; i < 3 * this.points; ++i, ++at) take(i % 3, this.rest[i] + this.displacement[at]);
    for (const body of this.bodies) {
      for (let c = 0; c < 3; ++c) take(c, body.reference[c]);
      if (body.box) for (let c = 0; c < 3; ++c) {
        const half = body.box.half_edges.reduce((sum, edge) => sum + Math.abs(edge[c]), 0);
        take(c, body.box.center[c] - half);
        take(c, body.box.center[c] + half);
      }
    }
    const thick = Math.max(0, ...this.leaves.flatMap((leaf) => leaf.half_thickness));
    low.forEach((x, c) => { low[c] = x - thick; high[c] += thick; });
    const size = Math.hypot(...low.map((x, c) => high[c] - x));
    // The arrows of drives and loads, with their words.
    const arrow = (body, place, direction, length) => {
      const norm = Math.hypot(...direction) || 1;
      for (let f = 0; f < this.frames.length; ++f) for (let c = 0; c < 3; ++c)
        take(c, place[c] + this.motion[6 * (f * this.bodies.length + body) + c] + length * size * direction[c] / norm);
    };
    if (!load_path) for (const drive of this.drives) if (drive.direction[0] === "u") arrow(drive.body, this.bodies[drive.body].reference, drive.axis, 0.25);
    for (const load of this.loads) for (const key of ["force", "moment"]) if (Math.hypot(...load[key]) > 0) arrow(load.body, load.place, load[key], 0.24);
    this.low = low;
    this.high = high;
    return size;
  }

  /// Weights of the frames for a stroke; with named drives the nearest frame alone.
  frame_weights(stroke) {
    if (drive_units) {
      const near = this.order.reduce((a, b) => Math.abs(b.stroke - stroke) < Math.abs(a.stroke - stroke) ? b : a);
      return [[near.k, 1]];
    }
    return cubic_weights(this.strokes, stroke).map(([i, w]) => [this.order[i].k, w]);
  }

  /// Fills positions, shown_stress and bodies_now for a stroke, its motion `magnified`, and adds
  /// `amount` (a length) of a mode.
  pose(stroke, mode, amount, magnified = 1) {
    this.positions.set(this.rest);
    this.shown_stress.fill(0);
    this.bodies_now.fill(0);
    const add = (to, from, offset, w) => { for (let i = 0; i < to.length; ++i) to[i] += w * from[offset + i]; };
    for (const [k, w] of this.frame_weights(stroke)) {
      add(this.positions, this.displacement, 3 * this.points * k, w * magnified);
      add(this.shown_stress, this.stress, this.points * k, w);
      add(this.bodies_now, this.motion, 6 * this.bodies.length * k, w * magnified);
    }
    const row = this.mode_row(stroke, mode);
    if (row === null) return;
    add(this.positions, this.mode_values, 3 * this.points * row, amount / 32767);
    add(this.bodies_now, this.mode_bodies, 6 * this.bodies.length * row, amount);
  }

  /// Row of a mode in the arrays of modes, at the stored stroke next to this one; null without it.
  mode_row(stroke, mode) {
    if (!mode || !this.mode_values) return null;
    const {locked, free} = this.modes;
    if (mode.index >= (mode.drive === "locked" ? locked : free)) return null;
    let near = 0;
    this.mode_strokes.forEach((s, k) => { if (Math.abs(s - stroke) < Math.abs(this.mode_strokes[near] - stroke)) near = k; });
    return near * (locked + free) + (mode.drive === "locked" ? 0 : locked) + mode.index;
  }

  /// Whether a body is but the frame of an elastic one, which is drawn itself.
  is_frame(b) { return !this.bodies[b].mass && !this.bodies[b].box && this.elastic_bodies.some((e) => e.bodies.includes(b)); }

  /// Largest displacement component of a point in all frames [m].
  largest_motion() { return this.displacement.reduce((largest, x) => Math.max(largest, Math.abs(x)), 0); }

  /// Largest stress of all frames, of one leaf or of all [Pa].
  largest_stress(leaf = null, frame = null) {
    const first = leaf ? leaf.first : 0, count = leaf ? leaf.points_along * leaf.points_across : this.points;
    let largest = 0;
    for (let f = frame ?? 0; f < (frame === null ? this.frames.length : frame + 1); ++f)
      for (let i = first; i < first + count; ++i) largest = Math.max(largest, this.stress[f * this.points + i]);
    return largest;
  }
}

function listed_path(k) {
  const entry = (whole.ranking ?? whole.designs ?? []).find((e) => e.design === k);
  return entry?.result?.path ? with_one_stroke(entry.result.path) : null;
}

/// The load case that is shown first; start and front are drawn beside their own case alone.
function ordered(list) {
  const k = list.findIndex((d) => d.case && d.case === shown_case);
  if (k <= 0) return list;
  const others = list.filter((d, i) => i !== k && d.case).map((d) => ({...d, kind: "case", label: `load case ${d.case}`}));
  return [{...list[k], kind: "result", label: list[0].label}, ...others];
}

/// The designs of the scene that can be drawn; the first is the one of the result.
export let designs = [];
export let evaluations = null, left_out = [];

/// Makes this scene the one that the page draws; that of the result which was read before.
export function read_scene(json) {
  const scene = json ?? {};
  designs = ordered(scene.designs ?? []).map((one, k) => new Design(one, k));
  evaluations = scene.evaluations ?? null;
  left_out = scene.left_out ?? [];
}
