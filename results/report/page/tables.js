// The tables: every point of the stroke, the checks, the overconstraints.
import {group, max} from "d3";
import {at_stroke, comparison, converged, error_at, heading, largest_of, load_path, part_of, path, quantities, result, stress_share, stroke_unit, drive_units, strokes_text} from "./result.js";
import {set} from "./state.js";
import {element, number_text, quantity_text, readable, shown_factor, shown_unit, table_of, without_noise} from "./text.js";

export function stroke_table() {
  if (path.length === 0) return [];
  const value = (text) => (p) => p.status === "converged" ? text(p) : "–";
  const lost = path.filter((p) => p.status !== "converged" && p.message);
  return [element("p", {class: "soft"}, "A click on a row moves the mechanism there."),
    table_of(path, [
      {name: load_path ? "Load factor" : "Stroke", unit: drive_units ? "" : shown_unit(stroke_unit), text: (p) => drive_units ? strokes_text(p.strokes) : number_text(p.stroke * shown_factor(stroke_unit), 4)},
      ...quantities.filter((q) => !load_path || q.at[0] !== "drive_load").map((q) => {
        const largest = largest_of(q);
        return {name: heading(q.label), unit: shown_unit(q.unit),
          text: value((p) => q.value(p) === null ? "–" : number_text(without_noise(q.value(p), largest) * shown_factor(q.unit))),
          tone: (p) => q.name === "max_stress" && stress_share(p) > 1.0001 ? "bad" : ""};
      }),
      {name: "Where", left: true, text: value((p) => part_of(p.max_stress_place))},
      {name: "Newton", unit: "iterations", text: (p) => String(p.newton_iterations ?? "–")},
      {name: "State", left: true, text: (p) => p.status !== "converged" ? readable(p.status) : p.stable ? "stable" : "unstable", tone: (p) => p.status === "converged" && p.stable ? "" : "bad"}],
    () => false, (p) => { if (p.status === "converged") set({stroke: p.stroke, playing: false}); }),
    ...lost.map((p) => element("p", {class: "bad"}, `${at_stroke(p)}: ${p.message}`))];
}

/// Each quantity with its largest estimated error over the stroke, the least exact first.
function estimates() {
  const rows = quantities.map((q) => {
    const known = converged.map((p) => ({p, relative: error_at(q, p, "relative")})).filter((e) => e.relative !== null);
    return {q, ...known.reduce((a, b) => b.relative > a.relative ? b : a, {p: null, relative: -1})};
  }).filter((row) => row.p).sort((a, b) => b.relative - a.relative);
  if (rows.length === 0) return [];
  return [element("p", {class: "soft"}, "Estimated errors, from full leaves on finer meshes: the largest of each quantity over the stroke."),
    table_of(rows, [{name: "Quantity", left: true, text: (row) => heading(row.q.label)},
      {name: "Estimated error", unit: "%", text: (row) => number_text(100 * row.relative, 2)},
      {name: "", unit: "absolute", text: (row) => quantity_text(error_at(row.q, row.p), row.q.unit, 2)},
      {name: "Where", left: true, text: (row) => at_stroke(row.p)}]),
    result.accuracy?.message ? element("p", {class: result.accuracy.met ? "" : "bad"}, result.accuracy.message) : null];
}

export function checks() {
  const rows = (comparison ? [] : result.leaves ?? []).map((leaf) => {
    const used = converged.map((p) => ({p, report: p.leaves?.find((l) => l.name === leaf.name)})).filter((u) => u.report);
    const models = [...group(used, (u) => u.report.model)].map(([name, list]) => `${readable(name)} (${list.length})`).join(", ");
    return {...leaf, models, reasons: [...new Set(used.map((u) => u.report.reason).filter(Boolean))].join("; "), check: max(used, (u) => Math.abs(u.report.check))};
  });
  const elastic = (converged[0]?.elastic_bodies ?? []).map(({name, degree, unknowns}, k) => {
    const reports = converged.map((p) => p.elastic_bodies[k]), hottest = reports.reduce((a, b) => (b.max_stress ?? -1) > (a.max_stress ?? -1) ? b : a);
    return {name, degree, unknowns, hottest, turn: max(reports, (r) => r.turn), share: max(reports, (r) => r.geometric_share ?? undefined)};
  });
  const told = (value, unit, digits) => typeof value === "number" ? quantity_text(value, unit, digits) : "–";
  const expected = result.expectations ?? [], constraints = result.constraints;
  return [
    ...estimates(),
    rows.length ? table_of(rows, [
      {name: "Leaf", left: true, text: (l) => l.name},
      {name: "Length", text: (l) => quantity_text(l.length, "m")}, {name: "Width", text: (l) => quantity_text(l.width, "m")}, {name: "Thickness", text: (l) => quantity_text(l.thickness, "m")},
      {name: "Needs", left: true, text: (l) => l.validity?.needed ? `theory of a ${readable(l.validity.needed)}` : "–"},
      {name: "Model", unit: "points", left: true, text: (l) => l.models}, {name: "Own check", unit: "relative", text: (l) => l.check ? number_text(l.check, 2) : "–"}, {name: "Why not the default", left: true, text: (l) => l.reasons}]) : null,
    elastic.length && !comparison ? table_of(elastic, [
      {name: "Elastic body", left: true, text: (b) => b.name}, {name: "Degree", text: (b) => String(b.degree)}, {name: "Unknowns", text: (b) => String(b.unknowns)},
      {name: "Largest turn of an interface", text: (b) => quantity_text(b.turn, "rad", 2)}, {name: "Stiffness changed by deformation", unit: "relative", text: (b) => told(b.share, "", 2)},
      {name: "Largest stress", text: (b) => told(b.hottest.max_stress, "Pa")}, {name: "Jump between cells", text: (b) => told(b.hottest.max_stress_jump, "Pa", 2)}]) : null,
    constraints ? element("p", {}, `Degrees of freedom of the undeflected mechanism: ${constraints.degrees_of_freedom}; overconstraints: ${constraints.overconstraints}.`) : null,
    constraints?.redundant?.length ? element("ul", {}, ...constraints.redundant.map((r) => element("li", {}, heading(r.text.replace(/`/g, ""))))) : null,
    expected.length ? table_of(expected, [
      {name: "Expected number", left: true, text: (e) => e.pointer}, {name: "Expected", text: (e) => number_text(e.expected, 6)}, {name: "±", text: (e) => number_text(e.tolerance, 2)},
      {name: "Found", text: (e) => number_text(e.value, 6)}, {name: "", left: true, text: (e) => e.ok ? "agrees" : "differs", tone: (e) => e.ok ? "good" : "bad"}, {name: "Source", left: true, text: (e) => e.source}]) : null,
    converged.some((p) => !p.stable) ? element("p", {class: "bad"}, `Unstable (buckled) ${converged.filter((p) => !p.stable).map(at_stroke).join(", ")}.`) : converged.length ? element("p", {}, "No converged point is unstable.") : null,
    comparison ? null : element("p", {class: "soft"}, `Not checked: ${result.stress_checks?.fatigue?.checked || result.stress_checks?.life?.checked ? "" : "fatigue, "}stiffness of the frame; clearance is that between leaves and boxes of bodies.`),
  ];
}
