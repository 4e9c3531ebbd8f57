// The mechanism as a picture of lines and faces, for browsers that cannot draw in three dimensions.
import {max, mean} from "d3";
import {svg_element} from "./charts.js";
import {stress_color} from "./colors.js";

const width = 640, height = 420;
/// Seen from the corner as the view of three dimensions begins: to the right, up, and towards the reader.
const seen = ([x, y, z]) => [0.786 * x - 0.618 * z, 0.893 * y - 0.278 * x - 0.354 * z, 0.55 * x + 0.45 * y + 0.7 * z];

/// Leaves and elastic bodies at a stroke as faces with the colours of their stress, what is behind first, and the
/// boxes of bodies as edges.
export function still_picture(design, stroke) {
  design.pose(stroke, null, 0);
  const {positions, shown_stress} = design, top = Math.max(1, max(design.shown_stress)), faces = [], edges = [];
  const point = (k) => seen(positions.subarray(3 * k, 3 * k + 3));
  const face = (corners) => {
    const places = corners.map(point);
    faces.push({places, depth: mean(places, (p) => p[2]), color: stress_color(Math.max(0, ...corners.map((k) => shown_stress[k])) / top)});
  };
  for (const {first, points_along: along, points_across: across} of design.leaves)
    for (let j = 0; j + 1 < across; ++j) for (let i = 0; i + 1 < along; ++i)
      face([[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]].map(([a, b]) => first + b * along + a));
  for (const {first, corners} of design.elastic_bodies)
    for (let k = 0; k < corners.length; k += 3) face([...corners.subarray(k, k + 3)].map((c) => first + c));
  design.bodies.forEach(({box}, b) => {
    if (!box) return;
    const corner = (k) => seen(box.center.map((x, c) => x + design.bodies_now[6 * b + c] + box.half_edges.reduce((sum, edge, e) => sum + (k & (1 << e) ? edge[c] : -edge[c]), 0)));
    for (let k = 0; k < 8; ++k) for (const e of [1, 2, 4]) if (!(k & e)) edges.push([corner(k), corner(k | e)]);
  });
  const all = [...faces.flatMap((f) => f.places), ...edges.flat()], ends = [0, 1].map((c) => [Math.min(...all.map((p) => p[c])), Math.max(...all.map((p) => p[c]))]);
  const scale = 0.9 * Math.min(...ends.map(([low, high], c) => [width, height][c] / (high - low || 1)));
  const at = (p) => [0, 1].map((c) => ([width, height][c] / 2 + (c === 0 ? 1 : -1) * scale * (p[c] - (ends[c][0] + ends[c][1]) / 2)).toFixed(1)).join();
  return svg_element("svg", {viewBox: `0 0 ${width} ${height}`, width: "100%", height: "100%", role: "img", "aria-label": "the mechanism at the end of its stroke"},
    ...faces.sort((a, b) => a.depth - b.depth).map(({places, color}) => svg_element("polygon", {points: places.map(at).join(" "), fill: color, stroke: color})),
    ...edges.map((edge) => svg_element("polyline", {points: edge.map(at).join(" "), fill: "none", stroke: "var(--soft)", "stroke-width": 1})));
}
