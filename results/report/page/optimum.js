// The optimum: what limits it, its variables, what each dimension does, and how far to trust it.
import {group, least} from "d3";
import {bar_chart} from "./charts.js";
import {all_leaves_full, converged, goal_factor, goal_name, goal_text, goal_unit, heading, largest_of, optimum, path, place_text, quantities} from "./result.js";
import {designs} from "./scene_data.js";
import {price_text} from "./first_screen.js";
import {set} from "./state.js";
import {element, number_text, percent_text, quantity_text, readable, shown_factor, shown_unit, table_of, without_noise} from "./text.js";

export function optimum_tables() {
  const {goal, constraints = [], verified} = optimum;
  const worst = least(constraints.filter((c) => c.bound), (c) => c.margin / Math.abs(c.bound));
  const active = constraints.filter((c) => c.active).map(goal_name);
  const bounds = (optimum.variables ?? []).filter((v) => v.at_bound).map((v) => `${readable(v.parameter)} at its ${v.at_bound}imum`);
  const said = [
    `${heading(goal_name(goal))}, ${goal.sense}d: ${goal_text(goal, optimum.objective)}.`,
    worst && `Tightest constraint: ${goal_name(worst)}, ${worst.active ? "at its bound" : (worst.margin < 0 ? "violated by " : "margin ") + number_text(100 * Math.abs(worst.margin / worst.bound)) + " %"}.`,
    `Active: ${[...active, ...bounds].join(", ") || "none"}.`,
    (optimum.starts ?? []).length > 1 && `${optimum.agreeing_starts ?? 0} of ${optimum.starts.length} starts agree within 0.1 %.`,
    verified && verified.objective !== null && !all_leaves_full() && `At full accuracy: ${goal_text(goal, verified.objective)} (reduced/full − 1 = ${percent_text(verified.objective_difference)}).`,
    optimum.accuracy === "full" && verified?.loop && "Values and constraints are those of full accuracy.",
  ].filter(Boolean).join(" ");
  const start = designs.findIndex((d) => d.kind === "start");
  return [element("p", {class: "lead"}, said),
    element("p", {class: "soft"}, `${optimum.algorithm.library} ${optimum.algorithm.library === "ipopt" ? "" : optimum.algorithm.name}${optimum.algorithm.local ? " with " + optimum.algorithm.local : ""}; gradients: ${optimum.gradients || "not recorded"}; ${optimum.evaluations} evaluations (${optimum.failed_evaluations} failed); ${optimum.stop_reason}`),
    start > 0 ? element("p", {}, element("button", {type: "button", id: "show-start", onclick: () => { set({beside: start}); document.getElementById("viewer").scrollIntoView(); }}, "Show start and optimum side by side")) : null,
    table_of(optimum.variables ?? [], [
      {name: "Variable", left: true, text: (v) => readable(v.parameter)},
      {name: "Start", text: (v) => quantity_text(v.initial, v.unit)},
      {name: "Optimum", text: (v) => quantity_text(v.optimum, v.unit, 4)},
      {name: "Range", text: (v) => `${quantity_text(v.min, v.unit)} … ${quantity_text(v.max, v.unit)}`},
      {name: "", left: true, text: (v) => v.at_bound ? `at ${v.at_bound}` : "", tone: () => "warn"}]),
    constraints.length ? table_of(constraints, [
      {name: "Constraint", left: true, text: goal_name},
      {name: "Value", text: (c) => goal_text(c, c.value)},
      {name: "Bound", text: (c) => c.bound === null ? "–" : `${c.bound === c.max ? "≤" : "≥"} ${goal_text(c, c.bound)}`},
      {name: "Margin", text: (c) => c.bound ? percent_text(c.margin / Math.abs(c.bound)).replace("+", "") : number_text(c.margin), tone: (c) => c.active ? "warn" : c.margin < 0 ? "bad" : ""},
      {name: "Active", left: true, text: (c) => c.active ? "active" : ""},
      {name: "What it costs", left: true, text: (c) => price_text(c) ?? (c.active ? "the algorithm gave no price" : "nothing")}], (c) => c.active) : null];
}

/// A round step of a parameter, some per cent of its value, in its shown unit: 0.401 mm → 0.01 mm.
export function handy_step(value, unit) {
  const shown = Math.abs(value * shown_factor(unit));
  return shown > 0 ? 10 ** Math.floor(Math.log10(shown) - 1.3) : 1;
}

export function sensitivity_charts() {
  const charts = [];
  for (const [of, list] of group(optimum.sensitivities ?? [], (s) => s.of)) {
    const goal = of === "objective" ? optimum.goal : {unit: list[0].unit}, unit = goal_unit(goal);
    const bars = list.map((s) => {
      const step = handy_step(optimum.parameters?.[s.parameter] ?? 0, s.per), change = s.value * goal_factor(goal) * step / shown_factor(s.per);
      const per = shown_unit(s.per);
      const name = `+${number_text(step, 2)}${per === "°" ? "" : " "}${per} ${readable(s.parameter)}`;
      return {name, value: change, text: `${change > 0 ? "+" : ""}${number_text(change)} ${unit}`};
    });
    charts.push(bar_chart({title: heading(readable(of)), note: of === "objective" ? goal_name(optimum.goal) : undefined, x: `change [${unit || "1"}]`, bars, color: ["var(--accent)", "var(--orange)"]}));
  }
  return charts;
}

/// Reduced against full at the ends and the middle of the stroke, where some leaf is reduced.
export function accuracy_table() {
  if (all_leaves_full()) return [];
  const pairs = path.map((reduced, i) => ({reduced, full: optimum.verified?.path?.[i]}))
    .filter((pair) => pair.reduced.status === "converged" && pair.full?.status === "converged");
  if (pairs.length === 0) return [];
  const chosen = [...new Set([0, Math.floor((pairs.length - 1) / 2), pairs.length - 1])].map((i) => pairs[i]);
  // Where both vanish, as the drive load at rest, a ratio says nothing.
  const largest = new Map(quantities.map((q) => [q.name, largest_of(q, pairs.map((pair) => pair.full))]));
  const difference = (pair, q) => {
    const full = q.value(pair.full), reduced = q.value(pair.reduced);
    if (full === null || reduced === null || Math.abs(full) < 1e-6 * largest.get(q.name)) return null;
    return reduced / full - 1;
  };
  return [element("p", {class: "soft"}, "Each cell: value at full accuracy, and reduced/full − 1."),
    table_of(quantities.filter((q) => pairs.some((pair) => q.value(pair.full) !== null)),
      [{name: "Quantity", left: true, text: (q) => q.label},
       ...chosen.flatMap((pair) => [
         {name: place_text(pair.reduced), text: (q) => quantity_text(without_noise(q.value(pair.full), largest.get(q.name)), q.unit)},
         {name: "difference", text: (q) => percent_text(difference(pair, q)), tone: (q) => Math.abs(difference(pair, q) ?? 0) > 0.012 ? "warn" : ""}])])];
}
