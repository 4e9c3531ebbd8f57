// The part of the report about a job that lists designs: who is best, and all of them side by side.
const design_palette = d3.schemeObservable10;
const design_color = (entry) => design_palette[entry.design % design_palette.length];
const own_path = (entry) => (entry.result?.path ?? []).filter((p) => p.status === "converged");

/// Best feasible objective after each evaluation, all starts one after the other.
function best_so_far(entry) {
  const {start = [], objective = [], violation = []} = entry.result?.optimum?.history ?? {};
  const {goal} = entry.result?.optimum ?? {};
  const feasible = job.optimise?.constraint_tolerance ?? 1e-4;
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

/// A quantity of every design over the stroke.
function side_by_side(name, label, unit, spec = {}) {
  const value = (p) => name.split(".").reduce((v, key) => v?.[key], p);
  return line_chart({title: heading(label), x: stroke_label, y: `${label} [${shown_unit(unit)}]`, ...spec,
    lines: listed.map((entry) => ({name: entry.name, color: design_color(entry), points: own_path(entry).map((p) => {
      const y = value(p);
      return {x: p.stroke * shown_factor(stroke_unit), y: typeof y === "number" ? y * shown_factor(unit) : NaN};
    })}))});
}

function link_of(entry) {
  return element("a", {href: `${entry.folder}/report.html`}, entry.name);
}

/// Least and largest value of each of the report's quantities over the stroke.
function quantity_table() {
  const rows = (listed.find((e) => e.result)?.result.quantities ?? []).map((q) => ({...q, of: listed.map((entry) => {
    const values = own_path(entry).map((p) => q.at.reduce((v, key) => v?.[key], p)).filter((v) => typeof v === "number");
    return values.length ? [d3.min(values), d3.max(values)] : null;
  })})).filter((q) => q.of.some((range) => range));
  return table_of(rows, [
    {name: "Over the stroke", left: true, text: (q) => q.label},
    ...listed.map((entry, i) => ({name: entry.name, text: (q) => {
      const range = q.of[i];
      if (!range) return "–";
      const largest = Math.max(Math.abs(range[0]), Math.abs(range[1]));
      const [low, high] = range.map((v) => quantity_text(without_noise(v, largest), q.unit));
      return low === high ? low : `${low} … ${high}`;
    }}))]);
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

function ranking() {
  const goal = listed.find((e) => e.result?.optimum)?.result.optimum.goal;
  const worst = (e) => e.worst_constraint;
  const unit = goal && goal.unit !== "SI" ? shown_unit(goal.unit) : "SI", factor = goal && goal.unit !== "SI" ? shown_factor(goal.unit) : 1;
  const goal_name = goal ? goal.expression ?? `${readable(goal.quantity)}, ${readable(goal.over_stroke)} over the stroke` : "objective";
  const table = table_of(listed, [
    {name: "Rank", text: (e) => String(e.rank)},
    {name: "Design", left: true, text: link_of},
    {name: "Objective", unit, text: (e) => e.objective === null ? "–" : number_text(e.objective * factor, 5), tone: (e) => e.feasible ? "" : "bad"},
    {name: "End", left: true, text: (e) => readable(e.status), tone: (e) => e.status === "ok" ? "good" : e.feasible ? "warn" : "bad"},
    {name: "Tightest constraint", left: true, text: (e) => worst(e) ? readable(worst(e).label) : "–"},
    {name: "Margin", text: (e) => !worst(e) ? "–" : Math.abs(worst(e).violation) < 1e-4 ? "at its bound" : number_text(-100 * worst(e).violation, 3) + " %", tone: (e) => e.feasible ? "" : "bad"},
    {name: "Evaluations", text: (e) => String(e.evaluations)},
    {name: "Optimum", left: true, text: (e) => element("div", {style: "min-width: 20em"}, (e.result?.optimum?.variables ?? []).map((v) => `${readable(v.parameter)} ${quantity_text(v.optimum, v.unit, 4)}${v.at_bound ? ` (${v.at_bound})` : ""}`).join(", "))}], (e) => e.rank === 1 && e.feasible);
  const best = listed.map((entry) => ({name: entry.name, color: design_color(entry), dots: false, curve: "step-after",
    points: best_so_far(entry).map(({x, y}) => ({x, y: y * factor}))}));
  const missed = listed.map((entry) => ({name: entry.name, color: design_color(entry), dots: false, curve: "step-after", points: least_violation(entry)}));
  section("Ranking",
    element("p", {class: "soft"}, `Every design under the same requirement; the objective is ${goal_name}` + ". Feasible ones by their objective, then the others by how much they miss a bound. Each name leads to the report of its own."),
    table, element("div", {class: "figures"},
      line_chart({title: "Best feasible design so far", note: "all starts of a design one after the other", x: "evaluation", y: `objective [${unit}]`, zero: false, lines: best}),
      line_chart({title: "Least violation so far", note: "relative to the bound; feasible designs are drawn at 10⁻⁸", x: "evaluation", y: "violation [1]", log: true, lines: missed})));
}

function design_sections() {
  if (listed.length === 0) return;
  if (result.ranking) ranking();
  const of_objective = job.optimise?.objective?.maximise ?? job.optimise?.objective?.minimise;
  const charts = [["parasitic_frequency", "parasitic frequency", "Hz"], ["drive_load", "drive load", typeof load_unit === "string" ? load_unit : "1"],
    ["max_stress", "largest von Mises stress", "Pa"], ["principal_stiffness.value", "softest translation", "N/m"]];
  charts.sort((a, b) => (b[0] === of_objective) - (a[0] === of_objective));
  section("Designs side by side", quantity_table(), size_table(),
    element("div", {class: "figures"}, ...charts.map(([name, label, unit]) =>
      side_by_side(name, label, unit, name === "principal_stiffness.value" ? {log: true} : {}))));
  const shown = result.ranking ? listed[0] : listed.find((e) => e.design === 0);
  if (shown?.result) report.append(element("p", {class: "lead"}, `What follows is ${result.ranking ? "the best design" : "the first design"}, ${shown.name}.`));
}
