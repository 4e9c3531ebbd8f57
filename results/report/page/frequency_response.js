// Frequency responses about the equilibrium that is shown, from the modes of its linear model:
// equation (H3) of core/response/modes/README.md.
import {greatest, max, min, range} from "d3";
import {line_chart} from "./charts.js";
import {direction_colors, palette} from "./colors.js";
import {at_stroke, converged, result} from "./result.js";
import {listen, state} from "./state.js";
import {element, number_text} from "./text.js";

let models = [], inputs = [], outputs = [];  // those of the result that is shown
const place = (signals, name) => signals.findIndex((s) => s.name === name);
const omega = (model) => model.omega2.map((w2) => Math.sqrt(Math.abs(w2)));

/// {re, im} of output i to input j at a frequency [Hz].
export function response(model, i, j, frequency) {
  const w = 2 * Math.PI * frequency;
  let re = model.residual[i][j], im = 0;
  model.omega2.forEach((w2, k) => {
    const share = model.motions[i][k] * model.forces[k][j], a = w2 - w * w, b = 2 * model.damping[k] * w * Math.sqrt(Math.abs(w2));
    const size = a * a + b * b || Number.MIN_VALUE;
    re += share * a / size;
    im -= share * b / size;
  });
  return {re, im};
}

/// Even on a logarithmic scale, and closer where a mode is.
function frequencies(model) {
  const own = omega(model).map((w) => w / (2 * Math.PI)), low = 0.1 * min(own), high = 1.2 * max(own);
  const beside = own.flatMap((f, k) => range(-12, 13).map((n) => f * (1 + n * Math.abs(n) / 12 * Math.max(model.damping[k], 1e-4))));
  return [...range(301).map((k) => low * (high / low) ** (k / 300)), ...beside.filter((f) => f > low && f < high)].sort((a, b) => a - b);
}

const magnitude = ({re, im}) => Math.hypot(re, im);
const line = (at, name, color, value) => ({name, color, dots: false, points: at.map((f) => ({x: f, y: value(f), name}))});
const chart = (spec) => line_chart({x: "frequency [Hz]", x_log: true, zero: false, ...spec});

/// Degrees, without jumps.
function unwrapped(at, value) {
  let last = 0;
  return at.map((f) => {
    const {re, im} = value(f), angle = Math.atan2(im, re) * 180 / Math.PI;
    last = angle + 360 * Math.round((last - angle) / 360);
    return {x: f, y: last};
  });
}

function charts_of(point) {
  const model = point.state_space, at = frequencies(model), charts = [], where = at_stroke(point);
  const drives = inputs.map((s, j) => ({s, j, i: place(outputs, s.name.replace("drive_load", "stroke"))})).filter(({s}) => s.name.startsWith("drive_load"));
  const named = ({s}) => s.name.split(".")[1] ?? "", others = drives.length > 1 ? "; the other drives free" : "";
  for (const unit of new Set(drives.map(({i}) => outputs[i].unit))) {
    const some = drives.filter(({i}) => outputs[i].unit === unit), of = unit === "m" ? "m/N" : "rad/(N m)";
    const lines = some.map((d, k) => line(at, named(d), palette[k], (f) => magnitude(response(model, d.i, d.j, f))));
    const most = greatest(lines.flatMap((l) => l.points), (p) => p.y);
    charts.push(chart({title: "Drive load to stroke", y: `gain [${of}]`, log: true, lines,
      note: `${where}${others}; largest ${number_text(most.y, 4)} ${of} at ${number_text(most.x, 4)} Hz`}));
    charts.push(chart({title: "Drive load to stroke, phase", y: "phase [°]", note: `${where}${others}`,
      lines: some.map((d, k) => ({name: named(d), color: palette[k], dots: false, points: unwrapped(at, (f) => response(model, d.i, d.j, f))}))}));
  }
  const along = ["ux", "uy", "uz"].filter((d) => model.residual[place(outputs, `O.${d}`)].some((x) => x !== 0) || model.motions[place(outputs, `O.${d}`)].some((x) => x !== 0));
  const pair = (kind, d) => [place(outputs, `O.${d}`), place(inputs, `${kind}.${d}`)];
  charts.push(chart({title: "Disturbing force at O to its motion", y: "gain [m/N]", note: `${where}; along the force, drives free`, log: true,
    lines: along.map((d) => line(at, d, direction_colors[d], (f) => magnitude(response(model, ...pair("load", d), f))))}));
  charts.push(chart({title: "Transmissibility of the ground", y: "gain [1]", note: `${where}; absolute motion of O over that of the ground, drives free`, log: true,
    lines: along.map((d) => line(at, d, direction_colors[d], (f) => {  // y = H a, a = −ω² x of the ground
      const {re, im} = response(model, ...pair("ground", d), f), w2 = (2 * Math.PI * f) ** 2;
      return Math.hypot(1 - w2 * re, w2 * im);
    }))}));
  return charts;
}

/// The response at the point nearest to the stroke that is shown; it follows that.
export function frequency_response_section() {
  models = converged.filter((p) => p.state_space);
  ({inputs = [], outputs = []} = result.state_space ?? {});
  if (models.length === 0) return [];
  const box = element("div", {class: "figures", id: "frequency-responses"});
  let shown = null;
  const draw = () => {
    const nearest = models.reduce((a, p) => Math.abs(p.stroke - state.stroke) < Math.abs(a.stroke - state.stroke) ? p : a);
    if (nearest === shown) return;
    shown = nearest;
    box.dataset.stroke = nearest.stroke;
    box.replaceChildren(...charts_of(nearest));
  };
  listen(["stroke"], draw);
  draw();
  return [box];
}
