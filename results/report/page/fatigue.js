// The worst cycle of stress of every point of the stroke in the diagram of Haigh: its amplitude over
// its mean, and the line that is endured: equations (Y4) and (Y5) of core/response/README.md.
import {max, min, range} from "d3";
import * as Plot from "@observablehq/plot";
import {line_chart} from "./charts.js";
import {palette} from "./colors.js";
import {at_stroke, converged, part_of, path} from "./result.js";
import {listen, set, state} from "./state.js";
import {element, number_text} from "./text.js";

const MPa = 1e-6, names = {goodman: "Goodman", gerber: "Gerber", soderberg: "Soderberg"};

/// The amplitude that is endured at a mean; compression counts as none.
export function endured(line, mean) {
  const share = Math.max(mean, 0) / line.largest_mean;
  return line.endured_amplitude * (1 - (line.mean_stress === "gerber" ? share * share : share));
}

const text = (p) => {
  const place = p.fatigue_safety_place, {amplitude, mean, other_point} = place, other = path[other_point];
  return `${at_stroke(p)}, ${part_of(place)}\nsafety ${number_text(p.fatigue_safety)}\nmean ${number_text(mean * MPa)} MPa, amplitude ${number_text(amplitude * MPa)} MPa${other ? `\nother end of the cycle ${at_stroke(other)}` : ""}`;
};

/// One line for each material and rule, with the parts that it is of.
function lines_of(points) {
  const lines = new Map();
  for (const {fatigue_safety_place: place} of points) {
    const key = JSON.stringify(place.line);
    if (!lines.has(key)) lines.set(key, {line: place.line, parts: new Set()});
    lines.get(key).parts.add(part_of(place));
  }
  return [...lines.values()];
}

export function fatigue_section() {
  const points = converged.filter((p) => typeof p.fatigue_safety === "number" && p.fatigue_safety_place?.line?.endured_amplitude);
  if (points.length === 0) return [];
  const worst = points.reduce((a, p) => p.fatigue_safety < a.fatigue_safety ? p : a), place = worst.fatigue_safety_place;
  const lines = lines_of(points), n = worst.fatigue_safety, far = Math.max(1, n);
  const low = Math.min(0, 1.15 * min(points, (p) => p.fatigue_safety_place.mean)) * MPa;
  const high = Math.max(max(lines, (l) => l.line.largest_mean), far * place.mean) * MPa;
  const dot = (p, color) => ({x: p.fatigue_safety_place.mean * MPa, y: p.fatigue_safety_place.amplitude * MPa, text: text(p), name: "worst cycle", color, stroke: p.stroke});
  const figure = line_chart({
    title: "Haigh diagram", x: "mean stress [MPa]", y: "amplitude [MPa]", x_domain: [low, high],
    note: `Worst cycle ${at_stroke(worst)} in ${part_of(place)}: ${number_text(place.mean * MPa)} ± ${number_text(place.amplitude * MPa)} MPa, ${number_text(n)} times as large it would be at the line.`,
    lines: [
      ...lines.map(({line, parts}, k) => ({name: `${names[line.mean_stress]}${lines.length > 1 ? `, ${[...parts].join(", ")}` : ""}`, color: palette[k % palette.length], dots: false,
        points: [low, ...range(41).map((i) => line.largest_mean * MPa * i / 40)].map((x) => ({x, y: endured(line, x / MPa) * MPa}))})),
      {name: "worst cycle times its safety", color: "var(--soft)", dashed: true, dots: false, points: [0, far].map((f) => ({x: f * place.mean * MPa, y: f * place.amplitude * MPa}))},
      {name: "worst cycle of each stroke point", color: "var(--accent)", line: false, radius: 4, points: points.filter((p) => p !== worst).map((p) => dot(p))},
      {name: "the worst of all", color: palette[3], line: false, radius: 6, points: [dot(worst)]}],
    marks: [Plot.ruleX([0], {strokeOpacity: 0.35})],
    pick: (p) => { if (p.stroke !== undefined) set({stroke: p.stroke, playing: false}); }});
  const now = element("div", {class: "soft", id: "fatigue-now", "aria-live": "polite"});
  const tell = () => {
    const p = points.reduce((a, b) => Math.abs(b.stroke - state.stroke) < Math.abs(a.stroke - state.stroke) ? b : a);
    now.textContent = text(p).replace(/\n/g, "; ");
  };
  listen(["stroke"], tell);
  tell();
  figure.append(now);
  return [element("div", {class: "figures", id: "fatigue"}, figure)];
}
