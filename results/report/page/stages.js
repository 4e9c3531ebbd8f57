// What follows the starts of an optimisation: stock sizes, the front of two objectives, verification.
import {line_chart} from "./charts.js";
import {palette} from "./colors.js";
import {goal_factor, goal_name, goal_text, goal_unit, optimum, parameter_text} from "./result.js";
import {designs} from "./scene_data.js";
import {set} from "./state.js";
import {element, number_text, percent_text, quantity_text, readable, table_of} from "./text.js";

/// A stop reason without what the page says elsewhere: the algorithm, residual and evaluations.
export function stop_text(reason) {
  return (reason ?? "").replace(/^(NLopt \w+|Ipopt): /, "").replace(/ \(0 without values\)$/, "")
    .replace(/^the first-order conditions hold to .*$/, "conditions hold");
}

/// Neighbouring designs of the sizes that there are.
export function stock_section() {
  if (!optimum.stock) return [];
  const {continuous, designs: tried, neighbours, chosen} = optimum.stock;
  const names = Object.keys(tried[0]?.sizes ?? {});
  return [element("p", {class: "soft"}, `Optimum of any size: ${goal_text(optimum.goal, continuous.objective)} at ${names.map((n) => `${readable(n)} ${parameter_text(n, continuous.parameters[n])}`).join(", ")}. ${tried.length} of ${neighbours} combinations of the next sizes had their other variables optimised again.` +
      (chosen === null ? " None of them is feasible." : "")),
    table_of(tried, [
      ...names.map((n) => ({name: readable(n), text: (d) => parameter_text(n, d.sizes[n])})),
      {name: "Objective", text: (d) => d.objective === null ? "–" : goal_text(optimum.goal, d.objective)},
      {name: "Against any size", text: (d) => d.objective === null ? "–" : percent_text(d.objective / continuous.objective - 1)},
      {name: "Violation", text: (d) => number_text(d.violation, 2)},
      {name: "End", left: true, text: (d) => d.feasible ? "feasible" : "infeasible", tone: (d) => d.feasible ? "good" : "bad"},
      {name: "Evaluations", text: (d) => String(d.evaluations)},
      {name: "Stopped", left: true, text: (d) => stop_text(d.stop_reason)}], (d) => tried.indexOf(d) === chosen)];
}

/// Puts the mechanism of a point of the front beside the optimum.
function show_point(index) {
  const place = designs.findIndex((d) => d.kind === "pareto" && d.label === `front, point ${index + 1}`);
  if (place > 0) set({beside: place});
}

/// The designs between the best of one objective and the best of another.
export function front_section() {
  const {pareto, goal} = optimum;
  if (!pareto) return [];
  const {second, points} = pareto;
  const at = (p) => ({x: p.second * goal_factor(second), y: p.objective * goal_factor(goal), index: points.indexOf(p),
    name: `point ${points.indexOf(p) + 1} of the front`});
  const good = points.filter((p) => p.feasible), bad = points.filter((p) => p.objective !== null && !p.feasible);
  const variables = (optimum.variables ?? []).map((v) => ({...v, range: v.max - v.min}));
  const drawn = designs.some((d) => d.kind === "pareto");
  const x = `${goal_name(second)} [${goal_unit(second)}]`;
  return [
    pareto.message ? element("p", {class: "soft"}, readable(pareto.message)) : null,
    drawn ? element("p", {class: "soft"}, "A click on a point, or on a row of the table, shows its mechanism beside the optimum.") : null,
    points.length < 2 ? null : element("div", {class: "figures", id: "front"},
      line_chart({title: "What one objective costs the other", note: `each dot the best design with the second objective ${second.sense === "maximise" ? "at least" : "at most"} so large`,
        x, y: `${goal_name(goal)} [${goal_unit(goal)}]`, zero: false, pick: (p) => show_point(p.index),
        lines: [{name: "feasible", color: "var(--accent)", radius: 4, points: good.map(at)},
                ...(bad.length ? [{name: "not feasible", color: "var(--bad)", line: false, radius: 4, points: bad.map(at)}] : [])]}),
      line_chart({title: "How the design changes along the front", note: "0: the variable's minimum, 1: its maximum",
        x, y: "share of the range [1]", zero: false, y_domain: [0, 1],
        lines: variables.map((v, k) => ({name: readable(v.parameter), color: palette[k % palette.length],
          points: good.map((p) => ({x: p.second * goal_factor(second), y: (p.parameters[v.parameter] - v.min) / v.range,
            text: `${readable(v.parameter)}: ${quantity_text(p.parameters[v.parameter], v.unit)}`}))}))})),
    table_of(points, [
      {name: "Point", text: (p) => String(points.indexOf(p) + 1)},
      {name: "Bound", text: (p) => p.bound === null ? "–" : goal_text(second, p.bound)},
      {name: "Second", text: (p) => p.second === null ? "–" : goal_text(second, p.second)},
      {name: "Objective", text: (p) => p.objective === null ? "–" : goal_text(goal, p.objective)},
      {name: "Trade-off", unit: "SI", text: (p) => number_text(p.trade_off)},
      ...variables.map((v) => ({name: readable(v.parameter), text: (p) => quantity_text(p.parameters?.[v.parameter], v.unit)})),
      {name: "End", left: true, text: (p) => p.feasible ? readable(p.status) : "infeasible", tone: (p) => p.feasible ? "" : "bad"},
      {name: "Evaluations", text: (p) => String(p.evaluations)}], () => false, drawn ? (p) => show_point(points.indexOf(p)) : null)];
}

/// How the optimum of full accuracy was come by.
export function verification_section() {
  const loop = optimum.verified?.loop;
  if (!loop) return [];
  return [element("p", {class: "soft"}, `${loop.converged ? "Converged" : "Not converged"}: ${loop.message}. Tolerance ${percent_text(loop.tolerance).replace("+", "")}.`),
    table_of(loop.steps, [
      {name: "Evaluation", text: (s) => String(loop.steps.indexOf(s) + 1)},
      {name: "Trust region", text: (s) => s.trust_region === 0 ? "–" : `± ${number_text(s.trust_region)} of the range`},
      ...(optimum.variables ?? []).map((v) => ({name: readable(v.parameter), text: (s) => quantity_text(s.variables[v.parameter], v.unit, 5)})),
      {name: "Objective at full accuracy", text: (s) => s.objective === null ? "no equilibrium" : goal_text(optimum.goal, s.objective)},
      {name: "Violation", text: (s) => number_text(s.violation, 2)},
      {name: "Model off by", text: (s) => s.difference === null ? "–" : percent_text(s.difference).replace("+", ""), tone: (s) => s.difference > loop.tolerance ? "warn" : ""},
      {name: "", left: true, text: (s) => s.accepted ? "accepted" : "rejected"}])];
}
