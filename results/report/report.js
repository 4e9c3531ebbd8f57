// The report: result.json, section by section.
const result = JSON.parse(document.getElementById("result").textContent);
const job = result.job ?? {};
const report = document.getElementById("report");
const path = result.path ?? [];
const converged = path.filter((point) => point.status === "converged");
const optimum = result.optimum ?? null;
const comparison = result.comparison ?? null;
/// Of a job that lists designs; all else in the result is then of the best, or of the first.
const listed = result.ranking ?? result.designs ?? [];
/// Drives with names: the figures then show their points one after the other.
const drive_units = typeof result.units?.stroke === "object" ? result.units.stroke : null;
if (drive_units) path.forEach((point, k) => { point.strokes = point.stroke; point.stroke = k; });
const drive = drive_units ? "" : result.conventions?.drive ?? "";
const stroke_unit = drive_units ? "1" : result.units?.stroke ?? "";
const load_unit = result.units?.drive_load ?? "";
const load_unit_of = (name) => load_unit[name] ?? load_unit;
const load_path = job.load_path !== undefined;  // nothing is driven: stroke is the load factor
const stroke_label = load_path ? "load factor [1]" : drive_units ? "point [1]" : `stroke ${drive} [${shown_unit(stroke_unit)}]`;
const allowable = result.material?.allowable_stress ?? null;
const supports = Object.keys(result.units?.support_stiffness ?? {}).filter((d) => converged.some((p) => p.support_stiffness?.[d] !== undefined));

/// What the tables show: the result's own list, for which some converged point has a value.
const quantities = (result.quantities ?? []).map((q) => ({...q, value: (p) => q.at.reduce((v, key) => v?.[key], p) ?? null}))
  .filter((q) => converged.some((p) => q.value(p) !== null));
const largest_of = (q, points = converged) => d3.max(points, (p) => Math.abs(q.value(p) ?? 0)) ?? 0;
const heading = (label) => label[0].toUpperCase() + label.slice(1);

/// Points of a line over the stroke.
const over_stroke = (value, factor = 1, points = converged) => points.map((p) => {
  const y = value(p);
  return {x: p.stroke * shown_factor(stroke_unit), y: y === null || y === undefined ? NaN : y * factor};
});
const section = (title, ...children) => report.append(element("h2", {}, title), ...children.filter(Boolean));
const strokes_text = (point) => Object.entries(point.strokes).map(([name, s]) => `${name} ${quantity_text(s, drive_units[name])}`).join(", ");
const at_stroke = (point) => drive_units ? `at ${strokes_text(point)}` : `at ${load_path ? "load factor " : ""}${quantity_text(point.stroke, stroke_unit)}`;
/// The stroke point of least value.
const least_at = (value) => d3.least(converged.filter((p) => value(p) !== null && value(p) !== undefined), value);

function header() {
  const good = result.status === "ok";
  report.append(
    element("div", {class: "kicker"}, `flexopt · ${job.job ?? "run"} · ${listed.length ? `${listed.length} designs` : job.design?.family ?? ""}`),
    element("h1", {}, job.name ?? "flexopt report"),
    element("p", {class: "lead"}, element("span", {class: "pill " + (good ? "good" : "bad")}, readable(result.status ?? "unknown")), result.message ?? ""));
  const end = job.end_effector ?? {}, material = result.material ?? {}, model = job.model ?? {};
  const inertia = (Array.isArray(end.inertia) ? end.inertia : []).map((row, i) => Array.isArray(row) ? row[i] : row);
  const strokes = path.map((p) => p.stroke);
  const parameters = Object.entries(optimum?.parameters ?? job.design?.parameters ?? listed[0]?.result?.job?.design?.parameters ?? {}).filter(([, value]) => typeof value === "number");
  const facts = [
    load_path ? ["Load path", `force (${job.load_path.force.map((x) => number_text(x)).join(", ")}) N, moment (${job.load_path.moment.map((x) => number_text(x)).join(", ")}) N m at O; nothing is driven`]
      : drive_units ? ["Drives", Object.entries(result.conventions.drive).map(([name, text]) => `${name}: ${text}`).join("; ")]
      : ["Drive", drive && !/^[ur][xyz]$/.test(drive) ? drive : drive && `${drive}, ${stroke_unit === "rad" ? "rotation" : "translation"} of the end-effector`],
    drive_units ? ["Strokes", `${strokes.length} point${strokes.length === 1 ? "" : "s"}, ` + Object.keys(drive_units).map((name) => `${name} ${quantity_text(d3.min(path, (p) => p.strokes[name]), drive_units[name])} to ${quantity_text(d3.max(path, (p) => p.strokes[name]), drive_units[name])}`).join(", ")]
      : [load_path ? "Load factor" : "Stroke", strokes.length && `${quantity_text(d3.min(strokes), stroke_unit)} to ${quantity_text(d3.max(strokes), stroke_unit)}, ${strokes.length} point${strokes.length === 1 ? "" : "s"}`],
    ["Model", [model.accuracy && `${model.accuracy} accuracy`, model.flexure, model.mesh && `mesh ${model.mesh.join(" × ")} a leaf`].filter(Boolean).join(", ")],
    ["Material", [material.name, material.youngs_modulus && `E ${number_text(material.youngs_modulus * 1e-9)} GPa`, material.poissons_ratio !== undefined && `ν ${number_text(material.poissons_ratio)}`, material.density && `ρ ${number_text(material.density)} kg/m³`].filter(Boolean).join(", ")],
    ["Payload", end.mass !== undefined && `${number_text(end.mass)} kg, J ${inertia.map((v) => number_text(v)).join(", ")} kg m² about its centre of mass`],
    ["Geometry", parameters.map(([name, value]) => `${readable(name)} ${parameter_text(name, value)}`).join(", ")],
    ["Support stiffness", result.conventions?.support_stiffness],
    ["Parasitic frequency", result.conventions?.parasitic_frequency],
    ["Reference", "stiffness and motion at the end-effector's point O, moved along, global axes"],
    ["Made by", result.flexopt && `flexopt ${result.flexopt.version}, commit ${result.flexopt.commit}`],
  ];
  report.append(element("dl", {class: "facts"}, ...facts.filter(([, text]) => text).map(([name, text]) =>
    element("div", {}, element("dt", {}, name), element("dd", {}, text)))));
}

/// Units of parameters are those of the variables, else the result's list.
function parameter_text(name, value, digits = 5) {
  return quantity_text(value, result.units?.parameters?.[name] ?? "", digits);
}

function tiles() {
  if (converged.length === 0) return;
  const made = [];
  const add = (name, value, unit, where) => {
    if (value === null || value === undefined) return;
    made.push(element("div", {class: "tile"}, element("div", {class: "name"}, name),
      element("div", {class: "number"}, number_text(value * shown_factor(unit)), " ", element("small", {}, shown_unit(unit))),
      element("div", {class: "where"}, where)));
  };
  const slowest = least_at((p) => p.parasitic_frequency);
  if (slowest) add("Lowest parasitic frequency", slowest.parasitic_frequency, "Hz", at_stroke(slowest));
  for (const [name, list] of [["translation", supports.filter((d) => d[0] === "u")], ["rotation", supports.filter((d) => d[0] === "r")]]) {
    const weakest = d3.least(list.map((d) => ({d, p: least_at((q) => q.support_stiffness[d])})), (w) => w.p.support_stiffness[w.d]);
    if (weakest) add(`Weakest support: ${weakest.d}`, weakest.p.support_stiffness[weakest.d], result.units.support_stiffness[weakest.d], `${at_stroke(weakest.p)}, of all ${name}s, drive locked`);
  }
  const hardest = least_at((p) => -Math.abs(p.drive_load));
  for (const name of load_path ? [] : Object.keys(drive_units ?? {})) {
    const most = least_at((p) => -Math.abs(p.drive_load[name]));
    add(`Largest load of ${name}`, Math.abs(most.drive_load[name]), load_unit_of(name), at_stroke(most));
  }
  if (!load_path && !drive_units && drive) add("Largest drive load", Math.abs(hardest.drive_load), load_unit, at_stroke(hardest));
  const hottest = least_at((p) => p.max_stress === null ? null : -p.max_stress);
  if (hottest) add("Largest von Mises stress", hottest.max_stress, "Pa",
    at_stroke(hottest) + (hottest.max_stress_place ? `, ${hottest.max_stress_place.leaf}` : "") + (allowable ? `; allowed ${quantity_text(allowable, "Pa", 3)}` : ""));
  report.append(element("div", {class: "tiles"}, ...made));
}

function constraint_text(c, value) {
  return c.unit === "SI" ? number_text(value) : quantity_text(value, c.unit);
}

function optimisation() {
  if (!optimum) return;
  const {goal, constraints = [], verified} = optimum;
  const worst = d3.least(constraints.filter((c) => c.bound), (c) => c.margin / Math.abs(c.bound));
  const active = constraints.filter((c) => c.active).map((c) => c.label);
  const bounds = (optimum.variables ?? []).filter((v) => v.at_bound).map((v) => `${readable(v.parameter)} at its ${v.at_bound}imum`);
  const verdict = [
    `${goal.sense === "maximise" ? "Largest" : "Smallest"} ${goal.expression ?? readable(goal.quantity) + ` (${readable(goal.over_stroke)} over the stroke)`} found: ${constraint_text(goal, optimum.objective)}.`,
    worst && `Tightest constraint: ${readable(worst.label)}, ${worst.active ? "at its bound" : (worst.margin < 0 ? "violated by " : "margin ") + number_text(100 * Math.abs(worst.margin / worst.bound), 3) + " %"}.`,
    `Active: ${[...active.map(readable), ...bounds].join(", ") || "none"}.`,
    (optimum.starts ?? []).length > 1 && `${optimum.agreeing_starts ?? 0} of ${optimum.starts.length} starts agree within 0.1 %.`,
    verified && verified.objective !== null && `At full accuracy: ${constraint_text(goal, verified.objective)} (reduced/full − 1 = ${percent_text(verified.objective_difference)}).`,
    optimum.accuracy === "full" && verified?.loop && "Values and constraints are those of full accuracy.",
  ].filter(Boolean).join(" ");
  const design = table_of(optimum.variables ?? [], [
    {name: "Variable", left: true, text: (v) => readable(v.parameter)},
    {name: "Start", text: (v) => quantity_text(v.initial, v.unit)},
    {name: "Optimum", text: (v) => quantity_text(v.optimum, v.unit, 5)},
    {name: "Range", text: (v) => `${quantity_text(v.min, v.unit)} … ${quantity_text(v.max, v.unit)}`},
    {name: "", left: true, text: (v) => v.at_bound ? `at ${v.at_bound}` : "", tone: () => "warn"}]);
  const limits = table_of(constraints, [
    {name: "Constraint", left: true, text: (c) => readable(c.label)},
    {name: "Value", text: (c) => constraint_text(c, c.value)},
    {name: "Bound", text: (c) => c.bound === null ? "–" : `${c.bound === c.max ? "≤" : "≥"} ${constraint_text(c, c.bound)}`},
    {name: "Margin", text: (c) => c.bound ? percent_text(c.margin / Math.abs(c.bound)).replace("+", "") : number_text(c.margin), tone: (c) => c.active ? "warn" : c.margin < 0 ? "bad" : ""},
    {name: "Active", left: true, text: (c) => c.active ? "active" : ""},
    {name: "Multiplier", unit: "SI", text: (c) => number_text(c.multiplier)}], (c) => c.active);
  section("Optimum", element("p", {class: "lead"}, verdict),
    element("p", {class: "soft"}, `${optimum.algorithm.library} ${optimum.algorithm.library === "ipopt" ? "" : optimum.algorithm.name}${optimum.algorithm.local ? " with " + optimum.algorithm.local : ""}; gradients: ${optimum.gradients || "not recorded"}; ${optimum.evaluations} evaluations (${optimum.failed_evaluations} failed); ${optimum.stop_reason}`),
    design, constraints.length ? limits : null);
  stock();
  front();
  accuracy_box();
  verification();
  history();
  starts();
}

/// Reduced against full at the ends and the middle of the stroke.
function accuracy_box() {
  const verified = optimum.verified;
  if (!verified) return;
  const pairs = path.map((reduced, i) => ({reduced, full: verified.path[i]}))
    .filter((pair) => pair.reduced.status === "converged" && pair.full?.status === "converged");
  if (pairs.length === 0) return;
  const chosen = [...new Set([0, Math.floor((pairs.length - 1) / 2), pairs.length - 1])].map((i) => pairs[i]);
  // Where both vanish, as the drive load at rest, a ratio says nothing.
  const largest = new Map(quantities.map((q) => [q.name, largest_of(q, pairs.map((pair) => pair.full))]));
  const difference = (pair, q) => {
    const full = q.value(pair.full), reduced = q.value(pair.reduced);
    if (full === null || reduced === null || Math.abs(full) < 1e-6 * largest.get(q.name)) return null;
    return reduced / full - 1;
  };
  section("Accuracy: this model against full accuracy",
    element("p", {class: "soft"}, "Each cell: value at full accuracy, and reduced/full − 1."),
    table_of(quantities.filter((q) => pairs.some((pair) => q.value(pair.full) !== null)),
      [{name: "Quantity", left: true, text: (q) => q.label},
       ...chosen.flatMap((pair) => [
         {name: at_stroke(pair.full), text: (q) => quantity_text(without_noise(q.value(pair.full), largest.get(q.name)), q.unit)},
         {name: "difference", text: (q) => percent_text(difference(pair, q)), tone: (q) => Math.abs(difference(pair, q) ?? 0) > 0.012 ? "warn" : ""}])]));
}

function history() {
  const {start = [], number = [], objective = [], violation = []} = optimum.history ?? {};
  if (start.length === 0) return;
  const {goal} = optimum, factor = goal.unit === "SI" ? 1 : shown_factor(goal.unit);
  const palette = d3.schemeObservable10;
  const feasible = job.optimise?.constraint_tolerance ?? 1e-4;
  const lines = d3.groups(d3.range(start.length), (i) => start[i]).map(([s, rows], k) => {
    const color = palette[k % palette.length];
    let best = NaN;
    const better = (v) => !Number.isFinite(best) || (goal.sense === "maximise" ? v > best : v < best);
    const progress = [], worst = [];
    rows.forEach((i, n) => {
      if (objective[i] !== null && violation[i] <= feasible && better(objective[i])) best = objective[i];
      progress.push({x: n + 1, y: best * factor});
      if (violation[i] !== null) worst.push({x: n + 1, y: Math.max(violation[i], 1e-8)});
    });
    return {name: `start ${s}`, color, progress, worst};
  });
  const unit = goal.unit === "SI" ? "SI" : shown_unit(goal.unit);
  section("Convergence", element("div", {class: "figures"},
    line_chart({title: "Objective", note: "best feasible design so far, each start", x: "evaluation", y: `objective [${unit}]`, zero: false,
      lines: lines.map(({name, color, progress}) => ({name, color, points: progress, dots: false, curve: "step-after"}))}),
    line_chart({title: "Worst constraint violation", note: "relative to its bound; feasible points are drawn at 10⁻⁸", x: "evaluation", y: "violation [1]", log: true,
      lines: lines.map(({name, color, worst}) => ({name, color, points: worst, line: false, radius: 2}))})));
}

function starts() {
  const rows = optimum.starts ?? [];
  if (rows.length > 1)
    section("Starts", table_of(rows, [
      {name: "Start", text: (s) => String(s.start)},
      {name: "Objective", text: (s) => constraint_text(optimum.goal, s.objective)},
      {name: "Violation", text: (s) => number_text(s.violation, 2)},
      {name: "End", left: true, text: (s) => s.agrees ? "feasible, agrees" : s.feasible ? "feasible" : "infeasible", tone: (s) => s.feasible ? "good" : "bad"},
      {name: "KKT", text: (s) => number_text(s.kkt_residual, 2)},
      ...(optimum.variables ?? []).map((v) => ({name: readable(v.parameter), text: (s) => quantity_text(s.to?.[v.parameter], v.unit)})),
      {name: "Evaluations", unit: "failed", text: (s) => `${s.evaluations} (${s.failed_evaluations})`},
      {name: "Stopped", left: true, text: (s) => stop_text(s.stop_reason)}], (s) => s.start === optimum.best_start));
  const sensitivities = optimum.sensitivities ?? [];
  if (sensitivities.length > 0) {
    const factor = (unit) => unit === "SI" ? 1 : shown_factor(unit);
    const name = (unit) => unit === "SI" ? "SI" : shown_unit(unit) || "1";
    section("Sensitivities", table_of(sensitivities, [
      {name: "Of", left: true, text: (s) => readable(s.of)},
      {name: "With respect to", left: true, text: (s) => readable(s.parameter)},
      {name: "Derivative", text: (s) => `${number_text(s.value * factor(s.unit) / shown_factor(s.per))} ${name(s.unit)}/${name(s.per)}`},
      {name: "Change for +1 % of the parameter", text: (s) => `${number_text(s.value * factor(s.unit) * 0.01 * (optimum.parameters[s.parameter] ?? 0), 3)} ${name(s.unit)}`}]));
  }
}

function frequency_chart(which) {
  const list = (p) => p.frequencies?.[`drive_${which}`] ?? [];
  const modes = (p) => (p.modes ?? []).filter((m) => m.drive === which);
  const count = d3.max(converged, (p) => list(p).length) ?? 0;
  const kinds = [...new Set(converged.flatMap((p) => modes(p).map((m) => m.kind)))];
  const lines = d3.range(count).map((k) => ({color: "var(--metal)", width: 1, opacity: 0.7, name: "",
    points: converged.map((p) => {
      const mode = modes(p)[k];
      return {x: p.stroke * shown_factor(stroke_unit), y: list(p)[k], color: kind_colors[mode?.kind] ?? "var(--metal)",
        name: `mode ${k + 1}${mode ? ": " + readable(mode.kind) : ""}`};
    })}));
  const driven = over_stroke((p) => modes(p).find((m) => m.kind === "drive")?.frequency);
  if (driven.some((p) => Number.isFinite(p.y)))
    lines.unshift({name: "drive mode", color: kind_colors.drive, dashed: true, width: 2.5, points: driven, dots: false});
  return line_chart({title: `Natural frequencies, drive ${which}`, lines, x: stroke_label, y: "frequency [Hz]",
    note: which === "locked" ? "the drive holds its position; dots show what moves most" : "the drive load is constant; the drive's own mode is dashed",
    empty: "The job asked for no frequencies.",
    legend: kinds.map((kind) => ({name: `${readable(kind)} mode`, color: kind_colors[kind], line: kind === "drive", dashed: kind === "drive"}))});
}

/// Lowest frequency beside the drive's, along the path and as the undeflected state foretells it.
function foretold_chart() {
  const modes = (result.frequency_derivatives ?? []).filter((d) => d.kind !== "drive");
  if (modes.length === 0 || load_path || drive_units) return null;
  const lowest = (p) => (p.modes ?? []).filter((m) => m.drive === "free" && m.kind !== "drive").map((m) => m.frequency);
  const [low, high] = d3.extent(converged, (p) => p.stroke);
  if (!(high > low)) return null;
  const foretold = (f) => d3.range(121).map((k) => {
    const s = low + (high - low) * k / 120, values = modes.map((d) => f(d, s));
    return {x: s * shown_factor(stroke_unit), y: values.some((v) => v === null) ? NaN : d3.min(values)};
  });
  const hertz = (omega2) => Math.sqrt(omega2) / (2 * Math.PI), omega2 = (d) => (2 * Math.PI * d.frequency) ** 2;
  return line_chart({title: "Foretold from the undeflected state", x: stroke_label, y: "frequency [Hz]",
    note: "lowest frequency beside the drive's, drive free; the parabola of ω² fails first",
    lines: [
      {name: "path", color: kind_colors.end_effector, width: 2.5, points: over_stroke((p) => d3.min(lowest(p)))},
      {name: "parabola of 1/ω²", color: kind_colors.leaf, dashed: true, dots: false, points: foretold((d, s) => {
        const c = 1 / omega2(d) + s * (d.d_compliance + s * d.d2_compliance / 2);
        return c > 0 ? hertz(1 / c) : Infinity;  // stiffens: not the lowest
      })},
      {name: "parabola of ω²", color: direction_colors.uz, dashed: true, dots: false, points: foretold((d, s) => {
        const w = omega2(d) + s * (d.d_omega2 + s * d.d2_omega2 / 2);
        return w > 0 ? hertz(w) : null;  // beyond: nothing to say
      })}]});
}

function motion_charts() {
  const size = (v) => d3.max(converged, (p) => Math.abs(v(p))) ?? 0;
  const rotary = stroke_unit === "rad";
  const names = ["x", "y", "z"];
  const shifts = d3.range(3).filter((k) => load_path || `u${names[k]}` !== drive);
  const charts = [line_chart(load_path ? {title: "Displacement of O", note: "under the growing load", x: stroke_label, y: "displacement [mm]",
    lines: shifts.filter((k) => size((p) => p.displacement[k]) > 1e-12).map((k) => ({name: `u${names[k]}`, color: direction_colors[`u${names[k]}`], points: over_stroke((p) => p.displacement[k], 1e3)})),
    empty: "None."} : {title: rotary ? "Centre shift of O" : "Parasitic translation of O", x: stroke_label, y: "displacement [µm]",
    note: rotary ? "against an ideal rotation about the undeflected centre" : "of O, besides the drive",
    lines: shifts.filter((k) => size((p) => p.displacement[k]) > 1e-12).map((k) => ({name: `u${names[k]}`, color: direction_colors[`u${names[k]}`], points: over_stroke((p) => p.displacement[k], 1e6)})),
    empty: "None: below 10⁻⁶ µm."})];
  for (const {name} of job.probes ?? [])
    charts.push(line_chart({title: `Displacement of ${name}`, note: "a material point of a leaf", x: stroke_label, y: "displacement [mm]",
      lines: d3.range(3).filter((k) => size((p) => p.probes[name].displacement[k]) > 1e-12).map((k) => ({name: `u${names[k]}`, color: direction_colors[`u${names[k]}`], points: over_stroke((p) => p.probes[name].displacement[k], 1e3)})),
      empty: "It does not move."}));
  if (rotary && size((p) => Math.hypot(p.displacement[0], p.displacement[1])) > 1e-12)
    charts.push(line_chart({title: "Path of the rotation centre O", x: "ux [µm]", y: "uy [µm]", note: "seen along the hinge axis; the numbers are the stroke",
      lines: [{name: "", color: "var(--accent)", points: converged.map((p) => ({x: p.displacement[0] * 1e6, y: p.displacement[1] * 1e6, name: at_stroke(p)}))}],
      marks: [Plot.text(converged.filter((p, i) => i === 0 || i === converged.length - 1 || p.stroke === 0), {x: (p) => p.displacement[0] * 1e6, y: (p) => p.displacement[1] * 1e6, text: (p) => quantity_text(p.stroke, stroke_unit, 3), dy: -9, fontSize: 11})]}));
  const turns = d3.range(3).filter((k) => `r${names[k]}` !== drive && size((p) => p.rotation[k]) > 1e-9);
  if (turns.length > 0)
    charts.push(line_chart({title: "Parasitic rotation", note: "components of the end-effector's rotation vector", x: stroke_label, y: "rotation [mrad]",
      lines: turns.map((k) => ({name: `r${names[k]}`, color: direction_colors[`r${names[k]}`], points: over_stroke((p) => p.rotation[k], 1e3)}))}));
  return charts;
}

function stroke_figures() {
  if (converged.length === 0) return;
  const stiffness = (list, title, unit) => line_chart({title, note: "1/C with the drive locked, all other directions free", log: true, x: stroke_label, y: `stiffness [${unit}]`,
    lines: list.map((d) => ({name: d, color: direction_colors[d], points: over_stroke((p) => p.support_stiffness[d])}))});
  const rest = d3.least(converged, (p) => Math.abs(p.stroke));
  const moved = converged.some((p) => p !== rest);
  section("Over the stroke", element("div", {class: "figures"}, ...[
    stiffness(supports.filter((d) => d[0] === "u"), "Support stiffness, translations", "N/m"),
    stiffness(supports.filter((d) => d[0] === "r"), "Support stiffness, rotations", "N m/rad"),
    moved ? line_chart({title: "Retention of support stiffness", note: `relative to stroke ${quantity_text(rest.stroke, stroke_unit)}; drive locked`, x: stroke_label, y: "K / K₀ [1]",
      lines: supports.map((d) => ({name: d, color: direction_colors[d], points: over_stroke((p) => p.support_stiffness[d] / rest.support_stiffness[d])}))}) : null,
    ...(load_path ? [] : Object.keys(drive_units ?? {})).map((name) => line_chart({title: `Load of ${name}`, note: "that holds its stroke", x: stroke_label, y: `load [${load_unit_of(name)}]`,
      lines: [{name: "", color: "var(--accent)", points: over_stroke((p) => p.drive_load[name])}]})),
    load_path || drive_units || !drive ? null : line_chart({title: stroke_unit === "rad" ? "Drive moment" : "Drive force", note: "that holds the stroke", x: stroke_label, y: `${drive} load [${load_unit}]`,
      lines: [{name: "", color: "var(--accent)", points: over_stroke((p) => p.drive_load)}]}),
    frequency_chart("locked"), frequency_chart("free"), foretold_chart(),
    line_chart({title: "Largest von Mises stress", note: "in the leaves" + (allowable ? "; dashed: allowable" : ""), x: stroke_label, y: "stress [MPa]", empty: "The job asked for no stress.",
      lines: [{name: "", color: "var(--accent)", points: over_stroke((p) => p.max_stress, 1e-6)}],
      marks: allowable ? [Plot.ruleY([allowable * 1e-6], {stroke: "var(--bad)", strokeWidth: 1.5, strokeDasharray: "6 5"})] : []}),
    ...motion_charts()].filter(Boolean)));
}

function shapes() {
  if (!(result.shapes ?? []).length) return;
  section("Deformed shape", element("p", {class: "soft"}, "True scale, mid-surfaces. Black edges: base; grey: end-effector; dashed: undeflected. Drag a turned view to turn all."),
    shape_panels(result.shapes, drive_units ? Object.values(drive_units)[0] : stroke_unit));
}

function stroke_table() {
  if (path.length === 0) return;
  const value = (text) => (p) => p.status === "converged" ? text(p) : "–";
  section("Stroke table", table_of(path, [
    {name: load_path ? "Load factor" : "Stroke", unit: shown_unit(stroke_unit), text: (p) => number_text(p.stroke * shown_factor(stroke_unit))},
    ...quantities.filter((q) => !load_path || q.name !== "drive_load").map((q) => {
      const largest = largest_of(q);
      return {name: heading(q.label), unit: shown_unit(q.unit),
        text: value((p) => q.value(p) === null ? "–" : number_text(without_noise(q.value(p), largest) * shown_factor(q.unit))),
        tone: (p) => q.name === "max_stress" && allowable && p.max_stress > allowable * 1.0001 ? "bad" : ""};
    }),
    {name: "Where", left: true, text: value((p) => p.max_stress_place?.leaf ?? "")},
    {name: "Newton", unit: "iterations", text: (p) => String(p.newton_iterations)},
    {name: "State", left: true, text: (p) => p.status !== "converged" ? readable(p.status) : p.stable ? "stable" : "unstable", tone: (p) => p.status === "converged" && p.stable ? "" : "bad"}]));
  const lost = path.filter((p) => p.status !== "converged" && p.message);
  if (lost.length) report.append(...lost.map((p) => element("p", {class: "bad"}, `${at_stroke(p)}: ${p.message}`)));
}

function checks() {
  const rows = (comparison ? [] : result.leaves ?? []).map((leaf) => {
    const used = converged.map((p) => ({p, report: p.leaves?.find((l) => l.name === leaf.name)})).filter((u) => u.report);
    const models = [...d3.group(used, (u) => u.report.model)].map(([name, list]) => `${name} (${list.length})`).join(", ");
    return {...leaf, models, reasons: [...new Set(used.map((u) => u.report.reason).filter(Boolean))].join("; "), check: d3.max(used, (u) => Math.abs(u.report.check))};
  });
  const expected = result.expectations ?? [];
  section("Checks",
    rows.length ? table_of(rows, [
      {name: "Leaf", left: true, text: (l) => l.name},
      {name: "Length", text: (l) => quantity_text(l.length, "m")}, {name: "Width", text: (l) => quantity_text(l.width, "m")}, {name: "Thickness", text: (l) => quantity_text(l.thickness, "m")},
      {name: "Length/width", text: (l) => number_text(l.length / l.width, 3)},
      {name: "Beam theory", left: true, text: (l) => l.length / l.width < 2 ? "not enough, plate needed" : l.length / l.width < 4 ? "only with warping restraint" : "would do"},
      {name: "Model", unit: "points", left: true, text: (l) => l.models}, {name: "Own check", unit: "relative", text: (l) => l.check ? number_text(l.check, 2) : "–"}, {name: "Why not the default", left: true, text: (l) => l.reasons}]) : null,
    expected.length ? table_of(expected, [
      {name: "Expected number", left: true, text: (e) => e.pointer}, {name: "Expected", text: (e) => number_text(e.expected, 6)}, {name: "±", text: (e) => number_text(e.tolerance, 2)},
      {name: "Found", text: (e) => number_text(e.value, 6)}, {name: "", left: true, text: (e) => e.ok ? "agrees" : "differs", tone: (e) => e.ok ? "good" : "bad"}, {name: "Source", left: true, text: (e) => e.source}]) : null,
    converged.some((p) => !p.stable) ? element("p", {class: "bad"}, `Unstable with the drive held (buckled) ${converged.filter((p) => !p.stable).map(at_stroke).join(", ")}.`) : converged.length ? element("p", {}, "The tangent with the drive held has no negative eigenvalue at any converged point.") : null,
    comparison ? null : element("p", {class: "soft"}, "Not checked: fatigue, stiffness of the frame; clearance is that between leaves and boxes of bodies."),
    ...(result.notes ?? []).map((note) => element("p", {class: "warn"}, note)));
}

header();
design_sections();
tiles();
optimisation();
comparison_sections();
stroke_figures();
shapes();
stroke_table();
checks();
section("Job", element("details", {}, element("summary", {}, "as read, defaults filled in, SI"), element("pre", {}, JSON.stringify(job, null, 2))));
document.getElementById("made-by").textContent = `flexopt ${result.flexopt?.version ?? ""} (${result.flexopt?.commit ?? ""}). Figures: Observable Plot and D3, ISC licence, inside this file; nothing is loaded from elsewhere.`;
