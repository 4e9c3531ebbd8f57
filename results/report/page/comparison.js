// The part of the report about a job "compare": errors of models against full accuracy.
import {range} from "d3";
import {line_chart} from "./charts.js";
import {palette} from "./colors.js";
import {comparison, parameter_text, stroke_unit} from "./result.js";
import {chooser, element, number_text, quantity_text, readable, shown_factor, shown_unit, table_of} from "./text.js";
import {result} from "./result.js";

const error_text = (x) => x === null || x === undefined ? "–" : number_text(100 * x, 3) + " %";
const error_keys = (model) => Object.keys(model.errors).filter((key) => Array.isArray(model.points[key]) && model.errors[key].count > 0);
/// As many quantities as there are colours, a chart each.
const charts_of = (keys) => range(0, Math.max(1, keys.length), palette.length).map((from) => keys.slice(from, from + palette.length));
const part_of = (k, count) => count > 1 ? `, ${k + 1} of ${count}` : "";

/// Strokes of all drives where there are several.
export const stroke_text = (stroke, strokes) => strokes
  ? Object.entries(strokes).map(([name, value]) => `${name} ${quantity_text(value, result.units?.stroke?.[name] ?? stroke_unit)}`).join(", ")
  : quantity_text(stroke, stroke_unit);

/// Dots of one model, a colour a quantity; x(design, stroke) says where.
function error_charts(model, title, x_label, x, extra = {}) {
  const {points} = model, designs = comparison.samples, groups = charts_of(error_keys(model));
  const lines = (keys) => keys.map((quantity, k) => ({
    name: readable(quantity), color: palette[k], line: false, radius: 1.8,
    points: points.design.map((d, i) => {
      const error = points[quantity][i];
      return {x: x(designs[d], points.stroke[i]), y: error === null ? NaN : Math.max(100 * error, 1e-6),
        name: `design ${d}, stroke ${stroke_text(points.stroke[i], points.strokes?.[i])}`, text: `${readable(quantity)}: ${error_text(error)}`};
    })}));
  return groups.map((keys, k) => line_chart({title: title + part_of(k, groups.length), note: `model ${model.name}; the largest error of each quantity at a stroke point; below 10⁻⁶ % drawn there`,
    x: x_label, y: "error [%]", log: true, lines: lines(keys), ...extra}));
}

/// Errors against any parameter of the designs, which the reader chooses.
function parameter_chart(model) {
  const names = [...new Set(comparison.samples.flatMap((s) => Object.keys(s.parameters)))];
  if (names.length === 0) return null;
  const place = element("div", {});
  const unit = (name) => result.units?.parameters?.[name] ?? "";
  const draw = (name) => place.replaceChildren(...error_charts(model, `Error against ${readable(name)}`, `${readable(name)} [${shown_unit(unit(name)) || "1"}]`,
    (design) => (design.parameters[name] ?? NaN) * shown_factor(unit(name)), {zero: false}));
  draw(names[0]);
  return element("div", {}, chooser("Parameter", names.map((n) => [n, readable(n)]), names[0], draw), place);
}

function error_table(model) {
  const rows = Object.entries(model.errors).flatMap(([name, figures]) => [
    {name: readable(name), figures},
    ...Object.entries(figures.by_direction ?? figures.by_component ?? {}).map(([d, of_d]) => ({name: `${readable(name)} ${readable(d)}`, figures: of_d}))]);
  const missing = rows.some((r) => r.figures.missing > 0);
  return table_of(rows.filter((r) => r.figures.count > 0 || r.figures.missing > 0), [
    {name: "Quantity", left: true, text: (r) => r.name},
    {name: "Median", text: (r) => error_text(r.figures.median)},
    {name: "99th percentile", text: (r) => error_text(r.figures.p99)},
    {name: "Worst", text: (r) => error_text(r.figures.worst)},
    {name: "at", left: true, text: ({figures: {worst_at: at}}) => at ? `design ${at.design}, ${stroke_text(at.stroke, at.strokes)}` : "–"},
    {name: "Numbers", text: (r) => String(r.figures.count)},
    ...(missing ? [{name: "that only one has", text: (r) => String(r.figures.missing), tone: (r) => r.figures.missing > 0 ? "warn" : ""}] : [])]);
}

/// What a model costs beside what it errs: a point a model and quantity.
function cost_charts() {
  const timed = comparison.models.filter((m) => m.speed_up);
  if (timed.length === 0) return [];
  const groups = charts_of([...new Set(timed.flatMap(error_keys))]);
  return groups.map((keys, part) => line_chart({title: `Error against cost${part_of(part, groups.length)}`, note: "99th percentile of the errors; cost: time as a share of full accuracy, coefficients made already", x: "time / time of full accuracy [%]", y: "error [%]", log: true, x_log: timed.length > 1,
    lines: keys.map((key, k) => ({name: readable(key), color: palette[k], line: timed.length > 1, radius: 4,
      points: timed.map((m) => ({x: 100 / m.speed_up, y: Math.max(1e-6, 100 * (m.errors[key]?.p99 ?? NaN)), name: `${m.name}: ${readable(key)}`})).sort((a, b) => a.x - b.x)}))}));
}

function facts(model) {
  return [
    `${comparison.designs} designs, ${comparison.failed_designs} not to the end at full accuracy, ${model.failures} where only this model stopped early.`,
    model.fallbacks.points > 0 && `${model.fallbacks.points} points of ${model.fallbacks.designs} designs have leaves at full accuracy instead.`,
    model.speed_up !== null && `Speed-up ${number_text(model.speed_up)} once the coefficients are there, ${number_text(model.speed_up_with_reduction)} with making them for this one stroke (by the clock; all else here is the same on every run).`,
  ].filter(Boolean).join(" ");
}

/// One section a model: figures, errors, and what was not as asked for. [[title, children], …]
export function comparison_sections() {
  if (!comparison) return [];
  const rotary = stroke_unit === "rad", length = (design) => design.parameters.length ?? NaN;
  const sections = comparison.models.map((model) => [`Model ${model.name} against full accuracy`, [
    element("p", {class: "lead"}, facts(model)), error_table(model),
    element("div", {class: "figures"},
      ...error_charts(model, "Error against stroke", rotary ? "stroke [°]" : "stroke / leaf length [1]",
        (design, stroke) => rotary ? stroke * shown_factor("rad") : stroke / length(design)),
      ...error_charts(model, "Error against leaf shape", "width²/(length · thickness) [1]", (design) => design.width2_over_length_thickness, {x_log: true}),
      parameter_chart(model)),
    model.exceptions.length ? element("details", {}, element("summary", {}, `${model.exceptions.length} designs with failures, missing numbers or leaves at full accuracy`),
      table_of(model.exceptions, [
        {name: "Design", text: (e) => String(e.design)},
        {name: "", left: true, text: (e) => readable(e.status), tone: (e) => e.status === "failed" ? "bad" : "warn"},
        {name: "Points", text: (e) => String(e.points)}, {name: "at full accuracy", text: (e) => String(e.fallback_points)},
        {name: "Dimensions", left: true, text: (e) => Object.entries(comparison.samples[e.design]?.parameters ?? {}).map(([n, v]) => `${readable(n)} ${parameter_text(n, v, 3)}`).join(", ")},
        {name: "Why", left: true, text: (e) => e.message || e.missing || e.fallback_reason}])) : null]]);
  const {samples} = comparison, names = [...new Set(samples.flatMap((s) => Object.keys(s.parameters)))];
  const cost = cost_charts();
  if (cost.length > 0) sections.push(["Error against cost", [element("div", {class: "figures"}, ...cost)]]);
  sections.push(["Designs", [element("details", {}, element("summary", {}, `${samples.length} sampled designs`), table_of(samples, [
    {name: "Design", text: (s) => String(s.design)},
    ...names.map((name) => ({name: readable(name), text: (s) => s.parameters[name] === undefined ? "–" : parameter_text(name, s.parameters[name], 4)})),
    {name: "Largest stroke", text: (s) => quantity_text(s.largest_stroke, stroke_unit)},
    {name: "w²/(L t)", text: (s) => number_text(s.width2_over_length_thickness)},
    {name: "Full accuracy", left: true, text: (s) => s.status === "ok" ? s.unstable_points ? `${s.unstable_points} points unstable` : "" : s.message, tone: (s) => s.status === "ok" ? "warn" : "bad"}])),
    element("p", {class: "soft"}, "A row a design and model: comparison.csv.")]]);
  return sections;
}
