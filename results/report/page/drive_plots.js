// Quantities over the strokes of several drives: maps and families of curves where two drives make a
// grid, else dots over the stroke of each drive.
import {line_chart} from "./charts.js";
import {palette} from "./colors.js";
import {panel} from "./maps.js";
import {converged, drive_units, heading, place_text, quantities} from "./result.js";
import {set, state} from "./state.js";
import {chooser, element, quantity_text, shown_factor, shown_unit} from "./text.js";

const strokes_of = (name) => [...new Set(converged.map((p) => p.strokes[name]))].sort((a, b) => a - b);
const axis = (name) => `stroke of ${name} [${shown_unit(drive_units[name]) || "1"}]`;
const label_of = (q) => `${q.label} [${shown_unit(q.unit) || "1"}]`;

/// A chart with one curve for each of at most seven strokes of the other drive.
function family(q, x, other) {
  const values = strokes_of(other), step = Math.ceil(values.length / 7), chosen = values.filter((_, k) => k % step === 0);
  return line_chart({title: `${heading(q.label)} over ${x}`, note: `one curve for each stroke of ${other}`, x: axis(x), y: label_of(q), zero: false,
    lines: chosen.map((value, k) => ({name: `${other} ${quantity_text(value, drive_units[other])}`, color: palette[k % 4], dashed: k >= 4,
      points: converged.filter((p) => p.strokes[other] === value && q.value(p) !== null)
        .map((p) => ({x: p.strokes[x] * shown_factor(drive_units[x]), y: q.value(p) * shown_factor(q.unit), text: place_text(p)})).sort((a, b) => a.x - b.x)}))});
}

/// A chart of every converged point over the stroke of one drive.
const scatter = (q, x) => line_chart({title: `${heading(q.label)} over ${x}`, note: "a dot for each point; the other drives differ", x: axis(x), y: label_of(q), zero: false,
  lines: [{name: "", color: "var(--accent)", line: false, points: converged.filter((p) => q.value(p) !== null).map((p) => ({x: p.strokes[x] * shown_factor(drive_units[x]), y: q.value(p) * shown_factor(q.unit), text: place_text(p)}))}]});

/// The map of a quantity over the grid of two drives.
function stroke_map(x, y, q) {
  const xs = strokes_of(x), ys = strokes_of(y), points = new Map(converged.map((p) => [`${p.strokes[x]} ${p.strokes[y]}`, p]));
  const at = (i, j) => points.get(`${xs[i]} ${ys[j]}`);
  return panel({of_strokes: true,
    parameters: [[x, xs], [y, ys]].map(([name, values]) => ({parameter: name, unit: drive_units[name], values, start: 0, held: 0})),
    quantities: [{label: q.label, unit: q.unit, values: xs.map((_, i) => ys.map((_, j) => at(i, j) ? q.value(at(i, j)) : null))}],
    show: (i, j) => { if (at(i, j)) set({stroke: at(i, j).stroke, playing: false}); },
    shown: () => {
      const now = converged.reduce((a, p) => Math.abs(p.stroke - state.stroke) < Math.abs(a.stroke - state.stroke) ? p : a);
      return {i: xs.indexOf(now.strokes[x]), j: ys.indexOf(now.strokes[y])};
    }});
}

/// A chart that is drawn for the quantity that the reader chooses.
function chosen_charts(charts) {
  const place = element("div", {class: "figures"}), draw = (name) => place.replaceChildren(...charts(quantities.find((q) => q.name === name)));
  const first = quantities.find((q) => q.name === "parasitic_frequency") ?? quantities[0];
  draw(first.name);
  return [element("div", {class: "controls"}, chooser("Quantity", quantities.map((q) => [q.name, q.label]), first.name, draw)), place];
}

export function drive_charts() {
  const names = Object.keys(drive_units);
  if (converged.length === 0 || quantities.length === 0) return [];
  const [x, y] = names, even = (s) => s.length > 2 && s.every((v, k) => k === 0 || Math.abs(v - s[k - 1] - (s.at(-1) - s[0]) / (s.length - 1)) < 1e-6 * (s.at(-1) - s[0]));
  const grid = names.length === 2 && [x, y].every((name) => even(strokes_of(name))) && converged.length > 0.5 * strokes_of(x).length * strokes_of(y).length;
  if (!grid) return chosen_charts((q) => names.map((name) => scatter(q, name)));
  return chosen_charts((q) => [stroke_map(x, y, q), family(q, x, y), family(q, y, x)]);
}
