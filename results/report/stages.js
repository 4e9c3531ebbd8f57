// What follows the starts of an optimisation: stock sizes, front, verification.
/// Neighbouring designs of the sizes that there are.
function stock() {
  if (!optimum.stock) return;
  const {continuous, designs, neighbours, chosen} = optimum.stock;
  const names = Object.keys(designs[0]?.sizes ?? {});
  section("Stock sizes",
    element("p", {class: "soft"}, `Optimum of any size: ${constraint_text(optimum.goal, continuous.objective)} at ${names.map((n) => `${readable(n)} ${parameter_text(n, continuous.parameters[n])}`).join(", ")}. ${designs.length} of ${neighbours} combinations of the next sizes had their other variables optimised again.` +
      (chosen === null ? " None of them is feasible." : "")),
    table_of(designs, [
      ...names.map((n) => ({name: readable(n), text: (d) => parameter_text(n, d.sizes[n])})),
      {name: "Objective", text: (d) => d.objective === null ? "–" : constraint_text(optimum.goal, d.objective)},
      {name: "Against any size", text: (d) => d.objective === null ? "–" : percent_text(d.objective / continuous.objective - 1)},
      {name: "Violation", text: (d) => number_text(d.violation, 2)},
      {name: "End", left: true, text: (d) => d.feasible ? "feasible" : "infeasible", tone: (d) => d.feasible ? "good" : "bad"},
      {name: "Evaluations", text: (d) => String(d.evaluations)},
      {name: "Stopped", left: true, text: (d) => stop_text(d.stop_reason)}], (d) => designs.indexOf(d) === chosen));
}

/// The designs between the best of one objective and the best of another.
function front() {
  const pareto = optimum.pareto;
  if (!pareto) return;
  const {goal} = optimum, {second, points} = pareto;
  const factor = (of) => of.unit === "SI" ? 1 : shown_factor(of.unit), unit = (of) => of.unit === "SI" ? "SI" : shown_unit(of.unit);
  const name = (of) => of.expression ?? `${readable(of.quantity)}, ${readable(of.over_stroke)} over the stroke`;
  const at = (p) => ({x: p.second * factor(second), y: p.objective * factor(goal)});
  const good = points.filter((p) => p.feasible), bad = points.filter((p) => p.objective !== null && !p.feasible);
  const variables = (optimum.variables ?? []).map((v) => ({...v, range: v.max - v.min}));
  const palette = d3.schemeObservable10;
  section("Front of two objectives", pareto.message ? element("p", {class: "soft"}, readable(pareto.message)) : null,
    points.length < 2 ? null : element("div", {class: "figures"},
      line_chart({title: "What one objective costs the other", note: `each dot the best design with the second objective ${second.sense === "maximise" ? "at least" : "at most"} so large`,
        x: `${name(second)} [${unit(second)}]`, y: `${name(goal)} [${unit(goal)}]`, zero: false,
        lines: [{name: "feasible", color: "var(--metal)", radius: 3.5, points: good.map(at)},
                ...(bad.length ? [{name: "not feasible", color: "var(--bad, #c0392b)", line: false, radius: 3.5, points: bad.map(at)}] : [])]}),
      line_chart({title: "How the design changes along the front", note: "0: the variable's minimum, 1: its maximum",
        x: `${name(second)} [${unit(second)}]`, y: "share of the range [1]", zero: false, y_domain: [0, 1],
        lines: variables.map((v, k) => ({name: readable(v.parameter), color: palette[k % palette.length],
          points: good.map((p) => ({x: p.second * factor(second), y: (p.parameters[v.parameter] - v.min) / v.range,
            text: `${readable(v.parameter)}: ${quantity_text(p.parameters[v.parameter], v.unit)}`}))}))})),
    table_of(points, [
      {name: "Bound", text: (p) => p.bound === null ? "–" : constraint_text(second, p.bound)},
      {name: "Second", text: (p) => p.second === null ? "–" : constraint_text(second, p.second)},
      {name: "Objective", text: (p) => p.objective === null ? "–" : constraint_text(goal, p.objective)},
      {name: "Trade-off", unit: "SI", text: (p) => number_text(p.trade_off, 3)},
      ...variables.map((v) => ({name: readable(v.parameter), text: (p) => quantity_text(p.parameters?.[v.parameter], v.unit)})),
      {name: "End", left: true, text: (p) => p.feasible ? p.status : "infeasible", tone: (p) => p.feasible ? "" : "bad"},
      {name: "Evaluations", text: (p) => String(p.evaluations)}]));
}

/// How the optimum of full accuracy was come by.
function verification() {
  const loop = optimum.verified?.loop;
  if (!loop) return;
  section("Towards the optimum of full accuracy",
    element("p", {class: "soft"}, `${loop.converged ? "Converged" : "Not converged"}: ${loop.message}. Tolerance ${percent_text(loop.tolerance).replace("+", "")}.`),
    table_of(loop.steps, [
      {name: "Evaluation", text: (s) => String(loop.steps.indexOf(s) + 1)},
      {name: "Trust region", text: (s) => s.trust_region === 0 ? "–" : `± ${number_text(s.trust_region, 3)} of the range`},
      ...(optimum.variables ?? []).map((v) => ({name: readable(v.parameter), text: (s) => quantity_text(s.variables[v.parameter], v.unit, 5)})),
      {name: "Objective at full accuracy", text: (s) => s.objective === null ? "no equilibrium" : constraint_text(optimum.goal, s.objective)},
      {name: "Violation", text: (s) => number_text(s.violation, 2)},
      {name: "Model off by", text: (s) => s.difference === null ? "–" : percent_text(s.difference).replace("+", ""), tone: (s) => s.difference > loop.tolerance ? "warn" : ""},
      {name: "", left: true, text: (s) => s.accepted ? "accepted" : "rejected"}]));
}
