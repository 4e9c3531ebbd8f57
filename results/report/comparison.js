// The part of the report about a job "compare": errors of models against full accuracy.
const quantity_colors = {
  drive_load: "#4269d0", support_stiffness: "#e4572e", displacement: "#3ca951",
  frequencies: "#a463f2", parasitic_frequency: "#e08e0b", max_stress: "#8d97a6",
};
const error_text = (x) => x === null || x === undefined ? "–" : number_text(100 * x, 3) + " %";

/// Dots of one model, a colour a quantity; x(design, stroke) says where.
function error_chart(model, title, x_label, x, extra = {}) {
  const points = model.points, designs = comparison.samples;
  const lines = Object.keys(quantity_colors).map((quantity) => ({
    name: readable(quantity), color: quantity_colors[quantity], line: false, radius: 1.8,
    points: points.design.map((d, i) => {
      const error = points[quantity][i];
      return {x: x(designs[d], points.stroke[i]), y: error === null ? NaN : Math.max(100 * error, 1e-6),
        name: `design ${d}, stroke ${quantity_text(points.stroke[i], stroke_unit)}`,
        text: `${readable(quantity)}: ${error_text(error)}`};
    })}));
  return line_chart({title, note: `model ${model.name}; the largest error of each quantity at a stroke point; below 10⁻⁶ % drawn there`,
    x: x_label, y: "error [%]", log: true, lines, ...extra});
}

function error_table(model) {
  const rows = Object.entries(model.errors).flatMap(([name, figures]) => [
    {name: readable(name), figures},
    ...Object.entries(figures.by_direction ?? {}).map(([d, of_d]) => ({name: `${readable(name)} ${d}`, figures: of_d}))]);
  return table_of(rows.filter((r) => r.figures.count > 0), [
    {name: "Quantity", left: true, text: (r) => r.name},
    {name: "Median", text: (r) => error_text(r.figures.median)},
    {name: "99th percentile", text: (r) => error_text(r.figures.p99)},
    {name: "Worst", text: (r) => error_text(r.figures.worst)},
    {name: "at", left: true, text: (r) => `design ${r.figures.worst_at.design}, ${quantity_text(r.figures.worst_at.stroke, stroke_unit)}`},
    {name: "Numbers", text: (r) => String(r.figures.count)}]);
}

/// One section a model: figures, errors, and what was not as asked for.
function comparison_sections() {
  if (!comparison) return;
  const rotary = stroke_unit === "rad";
  const length = (design) => design.parameters.length ?? NaN;
  for (const model of comparison.models) {
    const facts = [
      `${comparison.designs} designs, ${comparison.failed_designs} not to the end at full accuracy, ${model.failures} where only this model stopped early.`,
      model.fallbacks.points > 0 && `${model.fallbacks.points} points of ${model.fallbacks.designs} designs have leaves at full accuracy instead.`,
      model.speed_up !== null && `Speed-up ${number_text(model.speed_up, 3)} once the coefficients are there, ${number_text(model.speed_up_with_reduction, 3)} with making them for this one stroke (by the clock; all else here is the same on every run).`];
    section(`Model ${model.name} against full accuracy`, element("p", {class: "lead"}, facts.filter(Boolean).join(" ")),
      error_table(model),
      element("div", {class: "figures"},
        error_chart(model, "Error against stroke", rotary ? "stroke [°]" : "stroke / leaf length [1]",
          (design, stroke) => rotary ? stroke * shown_factor("rad") : stroke / length(design)),
        error_chart(model, "Error against leaf shape", "width²/(length · thickness) [1]",
          (design) => design.width2_over_length_thickness, {x_log: true})),
      model.exceptions.length ? element("details", {}, element("summary", {}, `${model.exceptions.length} designs with failures or leaves at full accuracy`),
        table_of(model.exceptions, [
          {name: "Design", text: (e) => String(e.design)},
          {name: "", left: true, text: (e) => readable(e.status), tone: (e) => e.status === "failed" ? "bad" : "warn"},
          {name: "Points", text: (e) => String(e.points)}, {name: "at full accuracy", text: (e) => String(e.fallback_points)},
          {name: "Why", left: true, text: (e) => e.message || e.fallback_reason}])) : null);
  }
  const samples = comparison.samples;
  const names = [...new Set(samples.flatMap((s) => Object.keys(s.parameters)))];
  section("Designs", element("details", {}, element("summary", {}, `${samples.length} sampled designs`), table_of(samples, [
    {name: "Design", text: (s) => String(s.design)},
    ...names.map((name) => ({name: readable(name), text: (s) => s.parameters[name] === undefined ? "–" : parameter_text(name, s.parameters[name], 4)})),
    {name: "Largest stroke", text: (s) => quantity_text(s.largest_stroke, stroke_unit)},
    {name: "w²/(L t)", text: (s) => number_text(s.width2_over_length_thickness, 3)},
    {name: "Full accuracy", left: true, text: (s) => s.status === "ok" ? s.unstable_points ? `${s.unstable_points} points unstable` : "" : s.message, tone: (s) => s.status === "ok" ? "warn" : "bad"}])),
    element("p", {class: "soft"}, "A row a design and model: comparison.csv."));
}
