// How the optimum was looked for: history, starts, and all evaluated designs as parallel coordinates.
import {brushY, extent, groups, least, range, select} from "d3";
import * as Plot from "@observablehq/plot";
import {palette} from "./colors.js";
import {line_chart, narrow} from "./charts.js";
import {goal_factor, goal_text, goal_unit, job, optimum, result} from "./result.js";
import {evaluations, unpacked} from "./scene_data.js";
import {element, number_text, quantity_text, readable, shown_factor, shown_unit, table_of} from "./text.js";
import {stop_text} from "./stages.js";

const tolerance = () => job.optimise?.constraint_tolerance ?? 1e-4;

export function history_charts() {
  const {start = [], objective = [], violation = []} = optimum.history ?? {};
  if (start.length === 0) return [];
  const {goal} = optimum, factor = goal_factor(goal);
  const lines = groups(range(start.length), (i) => start[i]).map(([s, rows], k) => {
    const color = palette[k % palette.length];
    let best = NaN;
    const progress = rows.map((i, n) => {
      const good = objective[i] !== null && violation[i] <= tolerance();
      if (good && (!Number.isFinite(best) || (goal.sense === "maximise" ? objective[i] > best : objective[i] < best))) best = objective[i];
      return {x: n + 1, y: best * factor};
    });
    const worst = rows.map((i, n) => ({x: n + 1, y: violation[i] === null ? NaN : Math.max(violation[i], 1e-8)}));
    return {name: `start ${s}`, color, progress, worst};
  });
  return [
    line_chart({title: "Objective", note: "best feasible design so far, each start", x: "evaluation", y: `objective [${goal_unit(goal)}]`, zero: false,
      lines: lines.map(({name, color, progress}) => ({name, color, points: progress, dots: false, curve: "step-after"}))}),
    line_chart({title: "Worst constraint violation", note: "relative to its bound; feasible points are drawn at 10⁻⁸", x: "evaluation", y: "violation [1]", log: true,
      lines: lines.map(({name, color, worst}) => ({name, color, points: worst, line: false, radius: 2}))})];
}

export function starts_table() {
  const rows = optimum.starts ?? [];
  return rows.length < 2 ? [] : [table_of(rows, [
    {name: "Start", text: (s) => String(s.start)},
    {name: "Objective", text: (s) => goal_text(optimum.goal, s.objective)},
    {name: "Violation", text: (s) => number_text(s.violation, 2)},
    {name: "End", left: true, text: (s) => s.agrees ? "feasible, agrees" : s.feasible ? "feasible" : "infeasible", tone: (s) => s.feasible ? "good" : "bad"},
    {name: "KKT", text: (s) => number_text(s.kkt_residual, 2)},
    ...(optimum.variables ?? []).map((v) => ({name: readable(v.parameter), text: (s) => quantity_text(s.to?.[v.parameter], v.unit)})),
    {name: "Evaluations", unit: "failed", text: (s) => `${s.evaluations} (${s.failed_evaluations})`},
    {name: "Stopped", left: true, text: (s) => stop_text(s.stop_reason)}], (s) => s.start === optimum.best_start)];
}

/// The evaluated designs: [{row, values: {axis: SI}, feasible}], and the axes.
function evaluated() {
  const numbers = unpacked(evaluations.values), width = evaluations.values.shape[1];
  const {goal} = optimum;
  const axes = [
    ...evaluations.variables.map((name, k) => ({key: `v${k}`, column: 2 + k, name: readable(name), unit: result.units?.parameters?.[name] ?? ""})),
    ...evaluations.constraints.map((name, k) => ({key: `c${k}`, column: 2 + evaluations.variables.length + k, name: readable(name).replace(" over stroke", ""), unit: optimum.constraints[k]?.unit ?? "SI", constraint: true})),
    {key: "violation", column: 1, name: "violation", unit: "1"},
    {key: "objective", column: 0, name: "objective", unit: goal.unit},
  ];
  for (const axis of axes) axis.factor = axis.unit === "SI" ? 1 : shown_factor(axis.unit);
  const rows = range(evaluations.values.shape[0]).map((row) => ({row, at: (axis) => numbers[row * width + axis.column] * axis.factor,
    ok: Number.isFinite(numbers[row * width]), feasible: numbers[row * width + 1] <= tolerance()}));
  return {rows, axes};
}

/// Parallel coordinates. Brush an axis with the pointer, or give its range in the boxes below.
export function parallel_coordinates() {
  if (!evaluations || evaluations.values.shape[0] === 0) return [];
  const {rows, axes} = evaluated(), good = rows.filter((r) => r.ok);
  if (good.length === 0) return [];
  const scales = new Map(axes.map((axis) => {
    const [low, high] = extent(good, (r) => r.at(axis));
    return [axis.key, {low, high: high > low ? high : low + 1}];
  }));
  const share = (r, axis) => { const {low, high} = scales.get(axis.key); return (r.at(axis) - low) / (high - low); };
  const data = good.flatMap((r) => axes.map((axis) => ({row: r.row, axis: axis.key, share: share(r, axis), feasible: r.feasible})));
  const height = narrow ? 320 : 380, width = narrow ? Math.max(380, 90 * axes.length) : Math.max(1100, 110 * axes.length);
  const short = (word) => word.length > 13 ? `${word.slice(0, 12)}…` : word;
  const label = new Map(axes.map((a) => [a.key, a.name.split(" ").map(short).slice(0, 4).join(" ")]));
  const unit = (a) => a.unit === "SI" ? "SI" : shown_unit(a.unit) || "1";
  const words = (key) => label.get(key).split(" ").reduce((lines, w) => { if (lines.at(-1).length + w.length > 13) lines.push(w); else lines[lines.length - 1] += ` ${w}`; return lines; }, [""]).map((l) => l.trim()).filter(Boolean).join("\n");
  const ends = axes.flatMap((a) => [{axis: a.key, share: 1, text: number_text(scales.get(a.key).high)}, {axis: a.key, share: 0, text: number_text(scales.get(a.key).low)}]);
  const chart = Plot.plot({width, height, marginTop: 70, marginBottom: 34, marginLeft: 60, marginRight: 60, style: {fontSize: "12px", background: "transparent"},
    x: {type: "point", domain: axes.map((a) => a.key), axis: null}, y: {domain: [0, 1], axis: null},
    marks: [
      Plot.line(data, {x: "axis", y: "share", z: "row", stroke: (d) => d.feasible ? "var(--accent)" : "var(--orange)", strokeOpacity: good.length > 300 ? 0.25 : 0.5, strokeWidth: 1.2}),
      Plot.ruleX(axes.map((a) => a.key), {stroke: "currentColor"}),
      Plot.text(axes, {x: "key", y: () => 1, text: (a) => `${words(a.key)}\n[${unit(a)}]`, dy: -34, lineAnchor: "bottom", fontWeight: 600, lineHeight: 1.1}),
      Plot.text(ends.filter((e) => e.share === 1), {x: "axis", y: "share", text: "text", dy: -12}),
      Plot.text(ends.filter((e) => e.share === 0), {x: "axis", y: "share", text: "text", dy: 14}),
    ]});
  // The lines are in the order of the rows.
  const lines = chart.querySelectorAll("g[aria-label=line] path");
  const chosen = new Map();  // key → [low, high] as shares
  const count = element("p", {id: "brushed", "aria-live": "polite"}), place = element("div", {});
  const update = () => {
    const kept = good.filter((r) => axes.every((a) => { const c = chosen.get(a.key); return !c || (share(r, a) >= c[0] - 1e-9 && share(r, a) <= c[1] + 1e-9); }));
    const rest = new Set(kept.map((r) => r.row));
    good.forEach((r, k) => lines[k]?.setAttribute("display", rest.has(r.row) ? "inline" : "none"));
    const best = least(kept.filter((r) => r.feasible), (r) => (optimum.goal.sense === "maximise" ? -1 : 1) * r.at(axes.at(-1)));
    count.textContent = `${kept.length} of ${good.length} designs${rows.length > good.length ? ` (${rows.length - good.length} more failed)` : ""}; ${kept.filter((r) => r.feasible).length} of them feasible.`;
    place.replaceChildren(...(best ? [element("p", {}, `Best feasible of them: objective ${number_text(best.at(axes.at(-1)), 4)} ${unit(axes.at(-1))} at ${axes.filter((a) => a.key[0] === "v" && a.key !== "violation").map((a) => `${a.name} ${number_text(best.at(a), 4)} ${unit(a)}`).join(", ")}.`)] : []));
  };
  const x = chart.scale("x"), y = chart.scale("y"), boxes = new Map();
  for (const axis of axes) {
    const center = x.apply(axis.key), group = select(chart).append("g").attr("transform", `translate(${center},0)`).attr("class", "brush");
    const brush = brushY().extent([[-12, y.apply(1)], [12, y.apply(0)]]).on("brush end", ({selection}) => {
      if (selection) chosen.set(axis.key, [y.invert(selection[1]), y.invert(selection[0])]); else chosen.delete(axis.key);
      const {low, high} = scales.get(axis.key), now = chosen.get(axis.key);
      boxes.get(axis.key).forEach((box, k) => { box.value = now ? Number((low + now[k] * (high - low)).toPrecision(4)) : ""; });
      update();
    });
    group.call(brush);
    const set_range = () => {
      const {low, high} = scales.get(axis.key), [a, b] = boxes.get(axis.key).map((box) => box.value === "" ? null : (Number(box.value) - low) / (high - low));
      if (a === null && b === null) group.call(brush.clear);
      else group.call(brush.move, [y.apply(Math.min(1, b ?? 1)), y.apply(Math.max(0, a ?? 0))]);
    };
    boxes.set(axis.key, ["least", "largest"].map((end) => element("input", {type: "number", step: "any", placeholder: end, "aria-label": `${end} ${axis.name}`, onchange: set_range})));
  }
  const ranges = element("details", {}, element("summary", {}, "Ranges as numbers"), element("div", {class: "ranges"}, ...axes.map((a) => element("label", {}, element("span", {}, `${a.name} [${unit(a)}]`), ...boxes.get(a.key)))));
  update();
  return [element("p", {class: "soft"}, "Each line is an evaluated design: blue is feasible, orange is not. Drag along an axis to keep the designs in a range."),
    count, element("div", {class: "scroll parallel", tabindex: "0"}, chart), place, ranges];
}
