// The part of the report about a job that lists designs: who is best, and all of them side by side.
import {max, min} from "d3";
import {line_chart} from "./charts.js";
import {palette} from "./colors.js";
import {drive_units, goal_factor, goal_name, goal_unit, heading, job, listed, result, shown_stroke, stroke_label, stroke_unit, value_at} from "./result.js";
import {designs, left_out} from "./scene_data.js";
import {set} from "./state.js";
import {element, number_text, quantity_text, readable, shown_factor, shown_unit, table_of, without_noise} from "./text.js";

// Four colours that are told apart at once, then the same ones dashed.
const design_color = (entry) => palette[entry.design % 4], second_round = (entry) => entry.design % 8 >= 4;
const own_path = (entry) => (entry.result?.path ?? []).filter((p) => p.status === "converged" && typeof p.stroke === "number");

/// Best feasible objective after each evaluation, all starts one after the other.
function best_so_far(entry) {
  const {start = [], objective = [], violation = []} = entry.result?.optimum?.history ?? {};
  const {goal} = entry.result?.optimum ?? {}, feasible = job.optimise?.constraint_tolerance ?? 1e-4;
  let best = NaN;
  return start.map((_, i) => {
    const good = objective[i] !== null && violation[i] <= feasible;
    if (good && (!Number.isFinite(best) || (goal.sense === "maximise" ? objective[i] > best : objective[i] < best))) best = objective[i];
    return {x: i + 1, y: best};
  });
}

/// Least violation after each evaluation: how designs without a feasible point came nearer to one.
function least_violation(entry) {
  const {violation = []} = entry.result?.optimum?.history ?? {};
  let least = Infinity;
  return violation.map((v, i) => {
    if (v !== null) least = Math.min(least, v);
    return {x: i + 1, y: Number.isFinite(least) ? Math.max(least, 1e-8) : NaN};
  });
}

/// The quantities of all listed designs, by their own tables.
const all_quantities = () => [...new Map(listed.flatMap((e) => e.result?.quantities ?? []).map((q) => [q.name, q])).values()];

/// A quantity of every design over the stroke.
function side_by_side(q) {
  const factor = shown_factor(q.unit), values = listed.flatMap((e) => own_path(e).map((p) => value_at(q, p))).filter((v) => v !== null);
  const log = /^N( m)?\/(m|rad)$/.test(q.unit) && min(values) > 0 && max(values) > 20 * min(values);
  return line_chart({title: heading(q.label), x: stroke_label, y: `${q.label}${shown_unit(q.unit) ? ` [${shown_unit(q.unit)}]` : " [1]"}`, log, linked: true,
    lines: listed.map((entry) => ({name: entry.name, color: design_color(entry), dashed: second_round(entry), points: own_path(entry).map((p) => {
      const y = value_at(q, p);
      return {x: shown_stroke(p.stroke), y: y === null ? NaN : y * factor};
    }).sort((a, b) => a.x - b.x)}))});
}

const link_of = (entry) => element("a", {href: `${entry.folder}/report.html`}, entry.name);
const show_design = (entry) => {
  const place = designs.findIndex((d) => d.label === entry.name);
  set({beside: place > 0 ? place : null});
};

/// Least and largest value of each of the report's quantities over the stroke.
function quantity_table() {
  const rows = all_quantities().map((q) => ({...q, of: listed.map((entry) => {
    const values = own_path(entry).map((p) => value_at(q, p)).filter((v) => v !== null);
    return values.length ? [min(values), max(values)] : null;
  })})).filter((q) => q.of.some((r) => r));
  return table_of(rows, [
    {name: "Over the stroke", left: true, text: (q) => q.label},
    ...listed.map((entry, i) => ({name: entry.name, text: (q) => {
      const ends = q.of[i];
      if (!ends) return "–";
      const largest = Math.max(Math.abs(ends[0]), Math.abs(ends[1]));
      const [low, high] = ends.map((v) => quantity_text(without_noise(v, largest), q.unit));
      return low === high ? low : `${low} … ${high}`;
    }}))]);
}

/// Stiffnesses and frequencies at both ends of the stroke, and over those of the first design.
function ends_table() {
  const paths = listed.map((entry) => (entry.result?.path ?? []).filter((p) => p.status === "converged"));
  if (paths.some((p) => p.length === 0)) return null;
  const last = paths[0].length - 1, modes = paths[0][0].frequencies?.drive_locked ?? [];
  const stroke = (k) => drive_units ? `point ${k + 1}` : quantity_text(paths[0][k].stroke, stroke_unit);
  const rows = [...all_quantities().filter((q) => ["drive_stiffness", "support_stiffness"].includes(q.at[0])),
    ...modes.map((_, i) => ({label: `frequency ${i + 1}, drive locked`, unit: "Hz", at: ["frequencies", "drive_locked", i]}))];
  return table_of(rows, [{name: "At the ends of the stroke", left: true, text: (q) => q.label},
    ...(last > 0 ? [0, last] : [0]).flatMap((k) => listed.map((entry, i) => ({name: `${entry.name}, ${stroke(k)}`, text: (q) => {
      const value = value_at(q, paths[i][k] ?? {}), first = value_at(q, paths[0][k]);
      return value === null ? "–" : quantity_text(value, q.unit) + (i > 0 && first ? ` (× ${number_text(value / first, 4)})` : "");
    }})))]);
}

/// Sizes that are the same at every point.
function size_table() {
  const rows = [["envelope.x", "box, x"], ["envelope.y", "box, y"], ["envelope.z", "box, z"], ["envelope.cylinder", "cylinder"],
    ["envelope.moving.cylinder", "cylinder over the stroke"], ["leaf_mass", "mass of the leaves"]]
    .map(([name, label]) => ({label, unit: name === "leaf_mass" ? "kg" : "m",
      of: listed.map((entry) => name.split(".").reduce((v, key) => v?.[key], own_path(entry)[0]) ?? null)}))
    .filter((row) => row.of.some((v) => v !== null));
  return rows.length === 0 ? null : table_of(rows, [
    {name: "Size", left: true, text: (row) => row.label},
    ...listed.map((entry, i) => ({name: entry.name, text: (row) => quantity_text(row.of[i], row.unit)}))]);
}

const ranked_goal = () => listed.find((e) => e.result?.optimum)?.result.optimum.goal ?? {unit: "SI"};

/// Who is best: a row a design.
export function ranking_table() {
  const goal = ranked_goal(), worst = (e) => e.worst_constraint, unit = goal_unit(goal), factor = goal_factor(goal);
  return table_of(listed, [
    {name: "Rank", text: (e) => String(e.rank)},
    {name: "Design", left: true, text: link_of},
    {name: "Objective", unit, text: (e) => e.objective === null ? "–" : number_text(e.objective * factor, 4), tone: (e) => e.feasible ? "" : "bad"},
    {name: "End", left: true, text: (e) => readable(e.status), tone: (e) => e.status === "ok" ? "good" : e.feasible ? "warn" : "bad"},
    {name: "Tightest constraint", left: true, text: (e) => worst(e) ? readable(worst(e).label) : "–"},
    {name: "Margin", text: (e) => !worst(e) ? "–" : Math.abs(worst(e).violation) < 1e-4 ? "at its bound" : number_text(-100 * worst(e).violation) + " %", tone: (e) => e.feasible ? "" : "bad"},
    {name: "Evaluations", text: (e) => String(e.evaluations)},
    {name: "Optimum", left: true, text: (e) => element("div", {class: "wide"}, (e.result?.optimum?.variables ?? []).map((v) => `${readable(v.parameter)} ${quantity_text(v.optimum, v.unit, 4)}${v.at_bound ? ` (${v.at_bound})` : ""}`).join(", "))}],
  (e) => e.rank === 1 && e.feasible, show_design);
}

function ranking() {
  const goal = ranked_goal(), unit = goal_unit(goal), factor = goal_factor(goal);
  const best = listed.map((entry) => ({name: entry.name, color: design_color(entry), dashed: second_round(entry), dots: false, curve: "step-after",
    points: best_so_far(entry).map(({x, y}) => ({x, y: y * factor}))}));
  const missed = listed.map((entry) => ({name: entry.name, color: design_color(entry), dashed: second_round(entry), dots: false, curve: "step-after", points: least_violation(entry)}));
  return ["How the designs were found", [
    element("p", {class: "soft"}, `Every design under the same requirement${goal.quantity || goal.expression ? `; the objective is ${goal_name(goal)}` : ""}. Feasible ones by their objective, then the others by how much they miss a bound. Each name leads to the report of its own; a click on a row shows the mechanism beside the best.`),
    element("div", {class: "figures"},
      line_chart({title: "Best feasible design so far", note: "all starts of a design one after the other", x: "evaluation", y: `objective [${unit}]`, zero: false, lines: best}),
      line_chart({title: "Least violation so far", note: "relative to the bound; feasible designs are drawn at 10⁻⁸", x: "evaluation", y: "violation [1]", log: true, lines: missed}))]];
}

/// [[title, children], …]
export function design_sections() {
  if (listed.length === 0) return [];
  const shown = result.ranking ? listed[0] : listed.find((e) => e.design === 0);
  return [...(result.ranking ? [ranking()] : []),
    ["Designs side by side", [result.ranking ? null : ends_table(), quantity_table(), size_table(),
      left_out.length ? element("p", {class: "soft"}, `Not drawn in three dimensions here, because the file would grow too large: ${left_out.join(", ")}. Their own reports have them.`) : null,
      element("div", {class: "figures"}, ...all_quantities().map(side_by_side)),
      shown?.result ? element("p", {class: "lead"}, `The picture, the numbers above it and the plots over the stroke are those of ${result.ranking ? "the best design" : "the first design"}, ${shown.name}; so is all that follows.`) : null]]];
}
