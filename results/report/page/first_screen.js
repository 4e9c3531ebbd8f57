// What a manager reads: is it good, five numbers, and what limits it.
import {least, max, min} from "d3";
import {case_chooser} from "./cases.js";
import {stroke_text} from "./comparison.js";
import {at_stroke, comparison, converged, drive, drive_units, goal_factor, goal_name, goal_text, goal_unit, heading, job, least_at, listed, load_path, optimum, parameter_text, part_of, path, quantities, rest_point, result, stress_share, stroke_unit, supports, undeflected} from "./result.js";
import {ranking_table} from "./designs.js";
import {element, number_text, quantity_parts, quantity_text, readable} from "./text.js";

const lowest_buckling = () => {
  const q = quantities.find((one) => one.name.startsWith("buckling"));
  const point = q && least_at((p) => { const v = q.value(p); return v === null ? null : Math.abs(v); });
  return point ? {q, point, value: q.value(point)} : null;
};

/// {tone, word, text}: the verdict in one word and one sentence.
export function verdict() {
  if (undeflected) return {tone: "good", word: "undeflected", text: result.message};
  if (result.status === "running") return {tone: "warn", word: "running", text: result.message ?? ""};
  return result.verdict ?? {tone: result.status === "ok" ? "good" : "bad", word: readable(result.status ?? "unknown"), text: result.message ?? ""};
}

/// Up to five tiles.
function five_numbers() {
  const tiles = [], used = new Set();
  const add = (name, value, unit, where) => {
    if (typeof value !== "number" || tiles.length >= 5) return;
    tiles.push(element("div", {class: "tile"}, element("div", {class: "name"}, name),
      element("div", {class: "number"}, quantity_parts(value, unit)[0], element("small", {}, quantity_parts(value, unit)[1])),
      element("div", {class: "where"}, where)));
  };
  if (optimum && typeof optimum.objective === "number" && optimum.goal.quantity !== "parasitic_frequency" && optimum.goal.unit !== "SI")
    add(`Objective: ${goal_name(optimum.goal)}`, optimum.objective, optimum.goal.unit, "at the optimum");
  const slowest = least_at((p) => p.parasitic_frequency);
  if (slowest) add("Lowest parasitic frequency", slowest.parasitic_frequency, "Hz", at_stroke(slowest));
  for (const [name, letter] of [["translation", "u"], ["rotation", "r"]]) {
    const weakest = least(supports.filter((d) => d[0] === letter).map((d) => ({d, p: least_at((q) => q.support_stiffness?.[d])})).filter((w) => w.p), (w) => w.p.support_stiffness[w.d]);
    if (weakest) add(`Weakest support, ${name}: ${weakest.d}`, weakest.p.support_stiffness[weakest.d], letter === "u" ? "N/m" : "N m/rad", at_stroke(weakest.p));
  }
  const hottest = least_at((p) => typeof p.max_stress === "number" ? -p.max_stress : null);
  if (hottest) add("Largest von Mises stress", hottest.max_stress, "Pa", at_stroke(hottest) + (hottest.max_stress_place ? `, ${part_of(hottest.max_stress_place)}` : ""));
  const loads = load_path ? [] : quantities.filter((q) => q.at[0] === "drive_load");
  for (const q of loads) {
    const most = least_at((p) => q.value(p) === null ? null : -Math.abs(q.value(p)));
    if (most) add(`Largest ${q.label}`, Math.abs(q.value(most)), q.unit, at_stroke(most));
  }
  for (const key of ["max_stress", "drive_load", "support_stiffness", "parasitic_frequency", "gain", "cross_coupling"]) used.add(key);
  for (const q of quantities) {  // jobs without some of these: others of the table
    if (used.has(q.at[0])) continue;
    const most = least_at((p) => q.value(p) === null ? null : -Math.abs(q.value(p)));
    if (most && q.value(most) !== 0) { used.add(q.at[0]); add(`Largest ${q.label}`, Math.abs(q.value(most)), q.unit, at_stroke(most)); }
  }
  return tiles;
}

/// The model's worst errors and what it saves, for a comparison.
function comparison_numbers() {
  const percent = (x) => typeof x === "number" ? [number_text(100 * x), " %"] : ["–", ""];
  const tile = (name, [number, unit], where) => element("div", {class: "tile"}, element("div", {class: "name"}, name),
    element("div", {class: "number"}, number, unit ? element("small", {}, unit) : null), element("div", {class: "where"}, where));
  const model = comparison.models[0], worst = (key) => model.errors[key];
  const tiles = ["support_stiffness", "frequencies", "max_stress"].filter((key) => worst(key)?.count > 0)
    .map((key) => tile(`Largest error: ${readable(key)}`, percent(worst(key).worst), `design ${worst(key).worst_at.design}, ${stroke_text(worst(key).worst_at.stroke, worst(key).worst_at.strokes)}`));
  if (model.speed_up) tiles.push(tile("Speed-up", [number_text(model.speed_up), " ×"], "once the coefficients are there"));
  tiles.push(tile("Failures", [String(model.failures), ""], `of ${comparison.designs} designs; ${model.fallbacks.points} points at full accuracy instead`));
  return [element("p", {class: "soft"}, `Model ${model.name} against full accuracy:`), element("div", {class: "tiles"}, ...tiles)];
}

/// "1 % more of it would give …": what a bound costs, of its multiplier.
export function price_text(c) {
  const {goal} = optimum;
  if (typeof c.multiplier !== "number" || !c.bound || !c.multiplier) return null;
  const looser = c.bound === c.max ? 0.01 * Math.abs(c.bound) : -0.01 * Math.abs(c.bound), gain = c.multiplier * looser;
  const share = optimum.objective ? ` (${number_text(100 * Math.abs(gain / optimum.objective), 2)} %)` : "";
  return `1 % ${c.bound === c.max ? "more" : "less"} (${goal_text(c, Math.abs(looser), 3)}) would change the objective by ${gain > 0 ? "+" : ""}${number_text(gain * goal_factor(goal))} ${goal_unit(goal)}${share}`;
}

/// Sentences, the most pressing first.
function limits() {
  const said = [];
  if (optimum) {
    for (const c of (optimum.constraints ?? []).filter((k) => k.active || k.margin < 0)) {
      const price = price_text(c);
      said.push(`${heading(goal_name(c))} is ${c.active ? "at its bound" : "violated"}: ${goal_text(c, c.value, 3)}${price ? `. ${price}.` : "."}`);
    }
    for (const v of (optimum.variables ?? []).filter((k) => k.at_bound)) said.push(`${heading(readable(v.parameter))} is at its ${v.at_bound}imum, ${quantity_text(v.optimum, v.unit)}.`);
    if (said.length === 0) said.push("No constraint is active: the optimum lies inside all of them.");
  }
  const lost = path.filter((p) => p.status !== "converged");
  if (lost.length) said.push(`${lost.length} of ${path.length} points ${result.status === "limit_reached" ? "were not done within the limits of the job" : "have no equilibrium"}, the first ${at_stroke(lost[0])}.`);
  const most = least_at((p) => stress_share(p) === null ? null : -stress_share(p)), stressed = most?.allowable_stress_place;
  if (stressed && !optimum) said.push(`Stress: ${quantity_text(stressed.stress, "Pa")} of ${quantity_text(stressed.allowable_stress, "Pa")} allowed (${number_text(100 * stress_share(most))} %), ${at_stroke(most)} in ${part_of(stressed)}.`);
  const rest = converged.length > 1 && supports.length ? rest_point() : null;
  if (rest) {
    const kept = least(supports.map((d) => ({d, p: least_at((q) => q.support_stiffness?.[d])})).filter((k) => k.p && rest.support_stiffness?.[k.d]), (k) => k.p.support_stiffness[k.d] / rest.support_stiffness[k.d]);
    const part = kept && kept.p.support_stiffness[kept.d] / rest.support_stiffness[kept.d];
    if (kept && part < 0.9) said.push(`Support stiffness ${kept.d} falls to ${number_text(100 * part)} % of its value at rest, ${at_stroke(kept.p)}.`);
  }
  const buckled = lowest_buckling();
  if (buckled && Math.abs(buckled.value) < 3) said.push(`${heading(buckled.q.label)} is only ${number_text(buckled.value)}, ${at_stroke(buckled.point)}.`);
  for (const [key, name] of [["yield_safety", "yield"], ["fatigue_safety", "fatigue"]]) {
    const least_safe = least_at((p) => p[key]), place = least_safe?.[`${key}_place`];
    if (least_safe && least_safe[key] < 2) said.push(`Safety against ${name} is ${number_text(least_safe[key])}, ${at_stroke(least_safe)}${place ? ` in ${part_of(place)}` : ""}.`);
  }
  const shortest = least_at((p) => p.fatigue_life), life = shortest?.fatigue_life_place;
  if (life && life.on_curve !== "endurance") said.push(`Life is ${life.cycles === null ? `${life.on_curve}, log10 of the cycles ${number_text(shortest.fatigue_life)}` : `${number_text(life.cycles)} cycles`}, ${at_stroke(shortest)} in ${part_of(life)}.`);
  return said.slice(0, 6);
}

/// What else is to be known of the mechanism and its model, folded.
function notes() {
  const over = result.constraints?.overconstraints ?? 0, said = [...result.notes ?? []];
  if (over > 0) said.push(`${over === 1 ? "One direction is" : `${over} directions are`} held more than once: ${(result.constraints.redundant ?? []).slice(0, 2).map((r) => r.text.replace(/`/g, "")).join("; ")}${over > 2 ? "; and others" : ""}. Errors of assembly cause stress there.`);
  return said.length === 0 ? null : element("details", {class: "notes"}, element("summary", {}, said.length === 1 ? "One note" : `${said.length} notes`), element("ul", {}, ...said.map((line) => element("li", {}, line))));
}

/// The dimensions that were found, each in its range.
function found_dimensions() {
  const variables = optimum?.variables ?? [];
  if (variables.length === 0) return null;
  const share = (v) => Math.min(1, Math.max(0, (v.optimum - v.min) / (v.max - v.min)));
  return element("table", {class: "found"}, element("thead", {}, element("tr", {}, ...["Found", "", "Least", "", "Most"].map((name) => element("th", {scope: "col"}, name)))),
    element("tbody", {}, ...variables.map((v) => element("tr", {}, element("th", {scope: "row"}, readable(v.parameter)), element("td", {class: `value ${v.at_bound ? "warn" : ""}`}, quantity_text(v.optimum, v.unit, 4)),
      element("td", {}, quantity_text(v.min, v.unit)), element("td", {}, element("meter", {min: 0, max: 1, value: share(v), "aria-label": `${number_text(100 * share(v), 2)} % of the range`})), element("td", {}, quantity_text(v.max, v.unit))))));
}

export function first_screen(picture) {
  const {tone, word, text} = verdict(), said = comparison ? [] : limits();
  return [
    element("header", {}, element("div", {class: "kicker"}, `flexopt · ${job.job ?? "run"} · ${listed.length ? `${listed.length} designs` : job.design?.family ?? job.design?.file ?? "mechanism"}`),
      element("h1", {}, job.name ?? "flexopt report"),
      element("p", {class: "lead"}, element("span", {class: `pill ${tone}`}, word), text), case_chooser()),
    result.ranking ? ranking_table() : null,
    element("div", {class: comparison ? "" : "stage"}, comparison ? null : picture, element("div", {class: "beside", id: "first"},
      ...(comparison ? comparison_numbers() : [element("div", {class: "tiles"}, ...five_numbers()), found_dimensions()]),
      said.length ? element("div", {class: "limits"}, element("h3", {}, "What limits it"), element("ul", {}, ...said.map((line) => element("li", {}, line)))) : null, notes())),
  ].filter(Boolean);
}

/// What was computed, of what.
export function facts() {
  const end = job.end_effector ?? {}, material = result.material ?? {}, model = job.model ?? {};
  const inertia = (Array.isArray(end.inertia) ? end.inertia : []).map((row, i) => Array.isArray(row) ? row[i] : row);
  const strokes = path.map((p) => p.stroke), points = `${strokes.length} point${strokes.length === 1 ? "" : "s"}`;
  const parameters = Object.entries(optimum?.parameters ?? job.design?.parameters ?? listed[0]?.result?.job?.design?.parameters ?? {}).filter(([, value]) => typeof value === "number");
  const rows = [
    load_path ? ["Load path", `force (${job.load_path.force.map((x) => number_text(x)).join(", ")}) N, moment (${job.load_path.moment.map((x) => number_text(x)).join(", ")}) N m at O; nothing is driven`]
      : drive_units ? ["Drives", Object.entries(result.conventions.drive).map(([name, text]) => `${name}: ${text}`).join("; ")]
      : ["Drive", drive && !/^[ur][xyz]$/.test(drive) ? drive : drive && `${drive}, ${stroke_unit === "rad" ? "rotation" : "translation"} of the end-effector`],
    undeflected ? ["Stroke", "none: undeflected"] : drive_units ? ["Strokes", `${points}, ` + Object.keys(drive_units).map((name) => `${name} ${quantity_text(min(path, (p) => p.strokes[name]), drive_units[name])} to ${quantity_text(max(path, (p) => p.strokes[name]), drive_units[name])}`).join(", ")]
      : [load_path ? "Load factor" : "Stroke", strokes.length > 0 && `${quantity_text(min(strokes), stroke_unit)} to ${quantity_text(max(strokes), stroke_unit)}, ${points}`],
    ["Model", [model.accuracy && `${model.accuracy} accuracy`, model.flexure, model.mesh && `mesh ${model.mesh.join(" × ")} a leaf`].filter(Boolean).join(", ")],
    ["Material", [material.name, material.youngs_modulus && `E ${number_text(material.youngs_modulus * 1e-9)} GPa`, material.poissons_ratio !== undefined && `ν ${number_text(material.poissons_ratio)}`, material.density && `ρ ${number_text(material.density, 4)} kg/m³`].filter(Boolean).join(", ")],
    ["Payload", end.mass !== undefined && `${number_text(end.mass)} kg, J ${inertia.map((v) => number_text(v)).join(", ")} kg m² about its centre of mass`],
    ["Geometry", parameters.map(([name, value]) => `${readable(name)} ${parameter_text(name, value)}`).join(", ")],
    ["Support stiffness", !undeflected && result.conventions?.support_stiffness],
    ["Parasitic frequency", !undeflected && result.conventions?.parasitic_frequency],
    ...Object.entries((!undeflected && result.stress_checks) || {}).filter(([key]) => ["yield", "fatigue", "life", "fillets"].includes(key))
      .map(([key, check]) => [heading(key), check.checked ? check.how : `not checked: ${check.how}`]),
    ["Reference", !undeflected && "stiffness and motion at the end-effector's point O, moved along, global axes"],
    ["Made by", result.flexopt && `flexopt ${result.flexopt.version}, commit ${result.flexopt.commit}`],
  ];
  return element("dl", {class: "facts"}, ...rows.filter(([, text]) => text).map(([name, text]) => element("div", {}, element("dt", {}, name), element("dd", {}, text))));
}
