// Everything over the stroke. The charts follow the result's table of quantities: those that have
// more to say have a chart of their own, all others one by their key.
import * as Plot from "@observablehq/plot";
import {group, max, min, range} from "d3";
import {direction_colors, kind_colors, palette} from "./colors.js";
import {line_chart} from "./charts.js";
import {drive_charts} from "./drive_plots.js";
import {allowable, converged, drive, drive_units, error_at, heading, job, load_path, optimum, path, place_text, quantities, rest_point, result, shown_stroke, stroke_label, stroke_unit, supports} from "./result.js";
import {designs} from "./scene_data.js";
import {number_text, quantity_text, readable, shown_factor, shown_unit} from "./text.js";

const start = designs.find((d) => d.kind === "start");
const by_stroke = (points) => [...points].sort((a, b) => a.stroke - b.stroke);

/// Points of a line over the stroke.
export const over_stroke = (value, factor = 1, points = converged) => by_stroke(points.filter((p) => p.status === "converged")).map((p) => {
  const y = value(p);
  return {x: shown_stroke(p.stroke), y: typeof y === "number" ? y * factor : NaN, point: p};
});
const chart = (spec) => line_chart({x: stroke_label, linked: true, ...spec});
const size = (value) => max(converged, (p) => Math.abs(value(p) ?? 0)) ?? 0;

/// The bounds of an optimisation on a quantity, as lines to draw.
function bounds_of(name, factor) {
  const marks = [];
  for (const c of optimum?.constraints ?? []) {
    if (c.quantity !== name) continue;
    for (const [bound, label] of [[c.max, "at most"], [c.min, "at least"]])
      if (typeof bound === "number") marks.push(Plot.ruleY([bound * factor], {stroke: "var(--bad)", strokeWidth: 1.5, strokeDasharray: "6 5"}),
        Plot.text([`${label} ${number_text(bound * factor)}`], {y: bound * factor, frameAnchor: "right", dy: -7, fill: "var(--bad)"}));
  }
  if (name === "max_stress" && allowable && marks.length === 0)
    marks.push(Plot.ruleY([allowable * factor], {stroke: "var(--bad)", strokeWidth: 1.5, strokeDasharray: "6 5"}),
      Plot.text([`allowed ${number_text(allowable * factor)}`], {y: allowable * factor, frameAnchor: "right", dy: -7, fill: "var(--bad)"}));
  return marks;
}

/// Between this model and full accuracy, where the optimum was evaluated with both.
function error_band(q, color, factor) {
  const full = optimum?.verified?.path ?? [];
  const points = path.map((p, k) => ({p, here: q.value(p), there: full[k] ? q.value(full[k]) : null}))
    .filter(({p, here, there}) => p.status === "converged" && here !== null && there !== null)
    .map(({p, here, there}) => ({x: shown_stroke(p.stroke), y: there * factor, low: Math.min(here, there) * factor, high: Math.max(here, there) * factor}));
  return points.length > 1 ? [{name: "", color, band: true, line: false, dots: false, points: points.sort((a, b) => a.x - b.x)}] : [];
}

/// Where the values are by their estimated errors.
function estimated_band(q, color, factor) {
  const points = by_stroke(converged).map((p) => ({x: shown_stroke(p.stroke), y: q.value(p), error: error_at(q, p)}))
    .filter((p) => p.y !== null && p.error !== null)
    .map((p) => ({x: p.x, y: p.y * factor, low: (p.y - p.error) * factor, high: (p.y + p.error) * factor}));
  return points.length > 1 ? [{name: "", color, band: true, estimated: true, line: false, dots: false, points: points.filter((p) => p.low > 0 || p.y <= 0)}] : [];
}

/// One chart of some quantities of one unit, with the start of an optimisation dashed.
function quantity_chart(some, title, extra = {}) {
  const unit = some[0].unit, factor = shown_factor(unit), key = some[0].at[0];
  const color = (q, k) => direction_colors[q.at.at(-1)] ?? (some.length === 1 ? "var(--accent)" : palette[k % palette.length]);
  const short = (q) => some.length === 1 ? "" : q.at.length > 1 ? q.at.slice(1).join(" ") : q.label;
  const lines = some.flatMap((q, k) => [
    {name: short(q), color: color(q, k), points: over_stroke(q.value, factor)},
    ...error_band(q, color(q, k), factor),
    ...estimated_band(q, color(q, k), factor),
    ...(start ? [{name: "", color: color(q, k), dashed: true, width: 1.3, opacity: 0.8, dots: false, points: over_stroke(q.value, factor, start.path)}] : [])]);
  const legend = [...lines.filter((l) => l.name), ...(start ? [{name: "start", color: "var(--soft)", dashed: true}] : [])];
  const banded = lines.some((l) => l.band && !l.estimated), estimated = lines.some((l) => l.estimated);
  const limits = some.flatMap((q) => bounds_of(q.name, factor));
  return chart({title: title ?? heading(some[0].label), note: [result.conventions?.[key], banded && "shaded: difference to full accuracy", estimated && "shaded: estimated error"].filter(Boolean).join("; ") || undefined, y: `${some.length === 1 ? some[0].label : readable(key)}${shown_unit(unit) ? ` [${shown_unit(unit)}]` : " [1]"}`, lines, legend, marks: limits, ...extra});
}

/// Charts of the quantities that no other chart has, one for each key and unit.
function other_charts(done) {
  const left = quantities.filter((q) => !done.has(q.at[0]) && !(load_path && q.at[0] === "drive_load") && converged.some((p) => q.value(p) !== null));
  return [...group(left, (q) => `${q.at[0] === "quantities" ? q.name : q.at[0]} ${q.unit}`).values()].map((some) => {
    const values = some.flatMap((q) => converged.map(q.value)).filter((v) => v !== null);
    const stiff = /^N( m)?\/(m|rad)$/.test(some[0].unit) && min(values) > 0;
    const key = some[0].at[0];
    return quantity_chart(some, some.length > 1 ? heading(readable(key)) : undefined, stiff && max(values) > 20 * min(values) ? {log: true} : {zero: min(values) <= 0 || max(values) > 2 * min(values)});
  });
}

function stiffness_charts() {
  return [["u", "translations", "N/m"], ["r", "rotations", "N m/rad"]].flatMap(([letter, name, unit]) => {
    const some = quantities.filter((q) => q.at[0] === "support_stiffness" && q.at[1][0] === letter);
    return some.length === 0 ? [] : [quantity_chart(some, `Support stiffness, ${name}`, {log: true, y: `stiffness [${unit}]`})];
  });
}

/// All three principal values, with their directions under the pointer.
function principal_charts() {
  const has = converged.some((p) => p.principal_stiffness?.translations?.length);
  if (!has) return [];
  const direction = (d) => `(${d.map((x) => number_text(Math.abs(x) < 1e-6 ? 0 : x, 2)).join(", ")})`;
  return [["translations", "N/m"], ["rotations", "N m/rad"]].map(([key, unit]) => {
    const count = max(converged, (p) => p.principal_stiffness?.[key]?.length ?? 0);
    return chart({title: `Principal support stiffness, ${key}`, note: "point at a dot for its direction", log: true, y: `stiffness [${unit}]`,
      lines: range(count).map((k) => ({name: ["softest", "second", "third"][k], color: palette[k], points: over_stroke((p) => p.principal_stiffness?.[key]?.[k]?.value).map((d) => {
        const entry = d.point.principal_stiffness?.[key]?.[k];
        return {...d, text: entry ? `${quantity_text(entry.value, unit)}\nalong ${direction(entry.direction)}\n${place_text(d.point)}` : undefined};
      })}))});
  });
}

function retention_chart() {
  const rest = rest_point();
  if (supports.length === 0 || !converged.some((p) => p !== rest)) return [];
  return [chart({title: "Support stiffness kept over the stroke", note: `relative to ${place_text(rest)}`, y: "K / K₀ [1]",
    lines: supports.map((d) => ({name: d, color: direction_colors[d], points: over_stroke((p) => p.support_stiffness?.[d] / rest.support_stiffness?.[d])}))})];
}

/// Branches of modes along the stroke; dots have the colour of what moves most.
function frequency_chart(which) {
  const modes = (p) => (p.modes ?? []).filter((m) => m.drive === which);
  const count = max(converged, (p) => modes(p).length) ?? 0;
  if (count === 0) return [];
  const ids = designs[0]?.branches?.[which], sorted = by_stroke(converged);
  const branch = (p, k) => ids?.[result.path.indexOf(p)]?.[k] ?? k;
  const lines = new Map();
  for (const p of sorted) modes(p).forEach((mode, k) => {
    const id = branch(p, k);
    if (!lines.has(id)) lines.set(id, {color: "var(--metal)", width: 1.4, opacity: 0.9, name: "", points: []});
    lines.get(id).points.push({x: shown_stroke(p.stroke), y: mode.frequency, color: kind_colors[mode.kind] ?? "var(--metal)",
      name: `mode ${k + 1}: ${readable(mode.kind)}`, text: `${quantity_text(mode.frequency, "Hz")}\n${place_text(p)}\nbranch ${id + 1}`});
  });
  const kinds = [...new Set(converged.flatMap((p) => modes(p).map((m) => m.kind)))];
  return [chart({title: `Natural frequencies, drive ${which}`, lines: [...lines.values()], y: "frequency [Hz]",
    note: `${which === "locked" ? "the drive holds its position" : "the drive load is constant"}; lines follow one mode, dots show what moves most`,
    legend: kinds.map((kind) => ({name: `${readable(kind)} mode`, color: kind_colors[kind], line: false}))})];
}

/// Lowest frequency beside the drive's, along the path and as the undeflected state foretells it.
function foretold_chart() {
  const modes = (result.frequency_derivatives ?? []).filter((d) => d.kind !== "drive");
  if (modes.length === 0 || load_path || drive_units) return [];
  const lowest = (p) => (p.modes ?? []).filter((m) => m.drive === "free" && m.kind !== "drive").map((m) => m.frequency);
  const low = min(converged, (p) => p.stroke), high = max(converged, (p) => p.stroke);
  if (!(high > low)) return [];
  const foretold = (f) => range(121).map((k) => {
    const s = low + (high - low) * k / 120, values = modes.map((d) => f(d, s));
    return {x: shown_stroke(s), y: values.some((v) => v === null) ? NaN : min(values)};
  });
  const hertz = (omega2) => Math.sqrt(omega2) / (2 * Math.PI), omega2 = (d) => (2 * Math.PI * d.frequency) ** 2;
  return [chart({title: "Foretold from the undeflected state", y: "frequency [Hz]",
    note: "lowest frequency beside the drive's, drive free; the parabola of ω² fails first",
    lines: [
      {name: "path", color: kind_colors.end_effector, width: 2.5, points: over_stroke((p) => min(lowest(p)))},
      {name: "parabola of 1/ω²", color: palette[1], dashed: true, dots: false, points: foretold((d, s) => {
        const c = 1 / omega2(d) + s * (d.d_compliance + s * d.d2_compliance / 2);
        return c > 0 ? hertz(1 / c) : Infinity;  // stiffens: not the lowest
      })},
      {name: "parabola of ω²", color: palette[3], dashed: true, dots: false, points: foretold((d, s) => {
        const w = omega2(d) + s * (d.d_omega2 + s * d.d2_omega2 / 2);
        return w > 0 ? hertz(w) : null;  // beyond: nothing to say
      })}]})];
}

function motion_charts() {
  const rotary = stroke_unit === "rad", names = ["x", "y", "z"];
  const three = (list, letter, floor, value, factor) => list.filter((k) => size((p) => value(p)?.[k]) > floor)
    .map((k) => ({name: `${letter}${names[k]}`, color: direction_colors[`${letter}${names[k]}`], points: over_stroke((p) => value(p)?.[k], factor)}));
  const shifts = range(3).filter((k) => load_path || `u${names[k]}` !== drive);
  const large = load_path || drive_units || size((p) => Math.hypot(...shifts.map((k) => p.displacement[k]))) > 1e-3;
  const charts = [chart({title: load_path || drive_units ? "Displacement of O" : rotary ? "Centre shift of O" : "Parasitic translation of O",
    note: load_path ? "under the growing load" : rotary ? "against an ideal rotation about the undeflected centre" : "of O, besides the drive",
    y: `displacement [${large ? "mm" : "µm"}]`, lines: three(shifts, "u", 1e-12, (p) => p.displacement, large ? 1e3 : 1e6), empty: "None: below 10⁻⁶ µm."})];
  for (const {name} of [...(job.points ?? []), ...(job.probes ?? [])])
    charts.push(chart({title: `Displacement of ${name}`, note: "a point of a body or a leaf", y: "displacement [mm]",
      lines: three(range(3), "u", 1e-12, (p) => (p.points ?? p.probes)?.[name]?.displacement, 1e3), empty: "It does not move."}));
  if (rotary && size((p) => Math.hypot(p.displacement[0], p.displacement[1])) > 1e-12) {
    const ends = by_stroke(converged), marked = ends.filter((p, i) => i === 0 || i === ends.length - 1 || p.stroke === 0);
    charts.push(line_chart({title: "Path of the rotation centre O", x: "ux [µm]", y: "uy [µm]", note: "seen along the hinge axis; the numbers are the stroke", zero: false,
      lines: [{name: "", color: "var(--accent)", points: ends.map((p) => ({x: p.displacement[0] * 1e6, y: p.displacement[1] * 1e6, name: place_text(p)}))}],
      marks: [Plot.text(marked, {x: (p) => p.displacement[0] * 1e6, y: (p) => p.displacement[1] * 1e6, text: place_text, dy: -9, fontSize: 11})]}));
  }
  const turns = three(range(3).filter((k) => `r${names[k]}` !== drive), "r", 1e-9, (p) => p.rotation, 1e3);
  if (turns.length > 0) charts.push(chart({title: "Parasitic rotation", note: "components of the end-effector's rotation vector", y: "rotation [mrad]", lines: turns}));
  return charts;
}

/// The stress behind the worst cycle, with its sign, beside the largest one, which has none.
function signed_stress_chart() {
  const points = converged.filter((p) => p.fatigue_stress);
  if (points.length === 0) return [];
  const key = points.some((p) => typeof p.fatigue_safety === "number") ? "fatigue_safety" : "fatigue_life";
  const worst = points.filter((p) => typeof p[key] === "number").reduce((a, p) => p[key] < a[key] ? p : a), place = worst[`${key}_place`];
  const MPa = 1e-6, where = `${place.leaf}, ${number_text(100 * place.along)} % along, ${number_text(100 * place.across)} % across, ${place.surface === "positive_normal" ? "on the side of the normal" : "on the side away from the normal"}`;
  const parts = [["along", "along the leaf", 0], ["across", "across the leaf", 1], ["shear", "shear", 2]];
  return [chart({title: "Stress behind the worst cycle", y: "stress [MPa]", note: `at one place, with its sign and the fillet: ${where}; the largest von Mises stress is that of any place`,
    lines: [...parts.map(([part, name, k]) => ({name, color: palette[k], points: over_stroke((p) => p.fatigue_stress?.[part], MPa)})),
      {name: points.some((p) => p.notch_stress) ? "largest von Mises stress, with the fillet" : "largest von Mises stress", color: "var(--soft)", dashed: true, dots: false, points: over_stroke((p) => p.notch_stress ?? p.max_stress, MPa)}],
    marks: [Plot.ruleY([0], {strokeOpacity: 0.35})]})];
}

/// All charts over the stroke, the most asked for first.
export function stroke_charts() {
  if (converged.length === 0) return [];
  if (drive_units) return drive_charts();
  const done = new Set(["support_stiffness", "principal_stiffness", "max_stress", "drive_load", "displacement", "rotation", "frequencies"]);
  const of = (key, extra) => {
    const some = quantities.filter((q) => q.at[0] === key);
    return some.length === 0 || (load_path && key === "drive_load") ? [] : [...group(some, (q) => q.unit).values()].map((list) => quantity_chart(list, undefined, extra));
  };
  return [...of("max_stress"), ...signed_stress_chart(), ...stiffness_charts(), ...frequency_chart("locked"), ...of("drive_load"), ...motion_charts(),
    ...principal_charts(), ...retention_chart(), ...frequency_chart("free"), ...other_charts(done), ...foretold_chart()];
}
