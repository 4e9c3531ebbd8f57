// Charts by Observable Plot. Those over the stroke are linked: pointing at a place moves the
// mechanism there, and a line shows where it is.
import {extent, max, min, range} from "d3";
import * as Plot from "@observablehq/plot";
import {converged, shown_stroke, stroke_unit, drive_units} from "./result.js";
import {listen, set, state} from "./state.js";
import {element, number_text, shown_factor, superscript} from "./text.js";

export const narrow = matchMedia("(max-width: 600px)").matches;
export const svg_element = (tag, attributes, ...children) => {
  const made = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  made.append(...children);
  return made;
};

function line_sample(color, dashed, dotted) {
  const sample = svg_element("svg", {width: 22, height: 10, "aria-hidden": "true"});
  sample.append(dotted ? svg_element("circle", {cx: 11, cy: 5, r: 3.5, fill: color})
    : svg_element("line", {x1: 0, x2: 22, y1: 5, y2: 5, stroke: color, "stroke-width": 2, "stroke-dasharray": dashed ? "5 4" : "none"}));
  return sample;
}

/// Whole decades around the values, so that a log axis always has labelled ticks.
function decades(values) {
  const low = Math.floor(Math.log10(min(values)) + 1e-9);
  const high = Math.ceil(Math.log10(max(values)) - 1e-9);
  return [10 ** low, 10 ** Math.max(high, low + 1)];
}

/// Settings of the y axis.
function y_axis(spec, all) {
  const y = {label: null, grid: true, ...(spec.y_domain ? {domain: spec.y_domain} : {nice: true})};
  const [low, high] = extent(all, (p) => p.y), top = Math.max(Math.abs(low), Math.abs(high));
  if (!spec.log && !spec.y_domain && high - low < 1e-9 * top) y.domain = top === 0 ? [-1, 1] : [Math.min(0, 1.2 * low), Math.max(0, 1.2 * high)];
  if (top < 1e-2 || top >= 1e4) y.tickFormat = (v) => number_text(v);
  if (!spec.log) return y;
  const domain = decades(all.map((p) => p.y));
  const first = Math.round(Math.log10(domain[0])), last = Math.round(Math.log10(domain[1]));
  return Object.assign(y, {type: "log", domain, nice: false, ticks: range(first, last + 1, Math.ceil((last - first) / 7)).map((k) => 10 ** k),
    tickFormat: (v) => "10" + superscript(Math.round(Math.log10(v)))});
}

/// Links a chart whose x axis is the stroke: pointer and arrow keys set it, a line shows it.
function link(figure, chart) {
  const x = chart.scale("x"), [left, right] = x.range, [low, high] = extent(converged, (p) => p.stroke);
  const box = chart.viewBox.baseVal;
  const rule = svg_element("line", {class: "now", y1: 20, y2: box.height - 38});
  chart.append(rule);
  const follow = () => {
    const at = x.apply(shown_stroke(state.stroke));
    rule.setAttribute("x1", at);
    rule.setAttribute("x2", at);
  };
  chart.addEventListener("pointermove", (event) => {
    const screen = chart.getBoundingClientRect(), at = (event.clientX - screen.left) / screen.width * box.width;
    if (at < left - 4 || at > right + 4) return;
    const stroke = x.invert(Math.min(right, Math.max(left, at))) / shown_factor(stroke_unit);
    const inside = Math.min(high, Math.max(low, stroke));
    set({stroke: drive_units ? converged.reduce((a, p) => Math.abs(p.stroke - inside) < Math.abs(a - inside) ? p.stroke : a, low) : inside, playing: false});
  });
  figure.tabIndex = 0;
  figure.classList.add("linked");
  figure.addEventListener("keydown", (event) => {
    const step = {ArrowLeft: -1, ArrowRight: 1}[event.key];
    if (!step) return;
    event.preventDefault();
    const strokes = converged.map((p) => p.stroke).sort((a, b) => a - b), tiny = 1e-9 * (high - low);
    const next = step > 0 ? strokes.find((s) => s > state.stroke + tiny) : strokes.findLast((s) => s < state.stroke - tiny);
    if (next !== undefined) set({stroke: next, playing: false});
  });
  listen(["stroke"], follow);
  follow();
}

/// A figure with caption, note, legend and chart. lines: [{name, color, points: [{x, y}], dashed,
/// line: false for dots only, width}]; points without y are left out. log, x_log: logarithmic axes;
/// linked: x is the stroke; pick(point): what a click on the nearest point does.
export function line_chart(spec) {
  const lines = spec.lines
    .map((line) => ({...line, points: line.points.filter((p) => Number.isFinite(p.x) && Number.isFinite(p.y) && (!spec.log || p.y > 0) && (!spec.x_log || p.x > 0))}))
    .filter((line) => line.points.length > 0);
  const figure = element("figure", {class: "figure", "data-title": spec.title}, element("figcaption", {}, spec.title),
                         spec.note ? element("div", {class: "soft"}, spec.note) : null);
  if (lines.length === 0) {
    figure.append(element("p", {class: "soft"}, spec.empty ?? "No values."));
    return figure;
  }
  const named = (spec.legend ?? lines).filter((line) => line.name);
  if (named.length > 0)
    figure.append(element("div", {class: "legend"}, ...named.map((line) =>
      element("span", {}, line_sample(line.color, line.dashed, line.line === false), line.name))));
  const all = lines.flatMap((line) => line.points.map((p) => ({...p, line})));
  const [first, last] = extent(all, (p) => p.x);
  const x_domain = spec.x_domain ?? (first === last ? [first - 1, last + 1] : undefined);
  const chart = Plot.plot({
    width: narrow ? 380 : 560, height: spec.height ?? (narrow ? 260 : 280), marginLeft: 62, marginRight: 18, marginTop: 26, marginBottom: 40,
    style: {fontSize: "12px", background: "transparent"},
    x: {label: spec.x, labelAnchor: "center", labelArrow: "none", ticks: narrow ? 5 : undefined, ...(spec.x_log ? {type: "log", ticks: 5, tickFormat: (v) => number_text(v, 2)} : {}), nice: !x_domain && !spec.x_log && !spec.linked, ...(x_domain ? {domain: x_domain} : {})},
    y: y_axis(spec, all),
    marks: [
      spec.log || spec.zero === false ? null : Plot.ruleY([0], {strokeOpacity: 0.35}),
      Plot.text([spec.y], {frameAnchor: "top-left", dy: -22, dx: -58, textAnchor: "start", fontWeight: 500}),
      ...lines.filter((line) => line.band).map((line) => Plot.areaY(line.points, {x: "x", y1: "low", y2: "high", fill: line.color, fillOpacity: 0.18})),
      ...lines.filter((line) => line.line !== false).map((line) => Plot.line(line.points, {
        x: "x", y: "y", stroke: line.color, strokeWidth: line.width ?? 2, strokeOpacity: line.opacity ?? 1,
        strokeDasharray: line.dashed ? "6 5" : undefined, curve: line.curve ?? "linear"})),
      ...lines.filter((line) => line.dots !== false).map((line) => Plot.dot(line.points, {
        x: "x", y: "y", fill: (p) => p.color ?? line.color, r: line.radius ?? 2.6})),
      ...(spec.marks ?? []),
      Plot.tip(all, Plot.pointer({x: "x", y: "y", maxRadius: 30, fontSize: 12, title: (p) =>
        `${p.name ?? p.line.name ?? spec.title}\n${p.text ?? `${spec.x}: ${number_text(p.x, 4)}\n${spec.y}: ${number_text(p.y, 4)}`}`})),
    ],
  });
  figure.append(chart);
  if (spec.linked) link(figure, chart);
  if (spec.pick) {
    chart.style.cursor = "pointer";
    chart.addEventListener("click", () => { if (chart.value) spec.pick(chart.value); });
  }
  return figure;
}

/// Bars from zero, sorted by length. bars: [{name, value, text}]
export function bar_chart({title, note, x, bars, color}) {
  const sorted = [...bars].sort((a, b) => Math.abs(b.value) - Math.abs(a.value));
  return element("figure", {class: "figure bars", "data-title": title}, element("figcaption", {}, title), note ? element("div", {class: "soft"}, note) : null,
    Plot.plot({
      width: narrow ? 380 : 560, height: 52 + 26 * sorted.length, marginLeft: 24 + 7 * Math.max(...sorted.map((b) => b.name.length)), marginRight: 80, marginTop: 4, marginBottom: 38, style: {fontSize: "12px", background: "transparent"},
      x: {label: x, labelAnchor: "center", labelArrow: "none", nice: true, ticks: 4, insetLeft: sorted.some((b) => b.value < 0) ? 60 : 0, tickFormat: (v) => number_text(v)}, y: {label: null, domain: sorted.map((b) => b.name)},
      marks: [Plot.barX(sorted, {x: "value", y: "name", fill: (b) => b.value < 0 ? color[1] : color[0]}), Plot.ruleX([0]),
        Plot.text(sorted, {x: "value", y: "name", text: "text", textAnchor: "start", dx: 5, filter: (b) => b.value >= 0}),
        Plot.text(sorted, {x: "value", y: "name", text: "text", textAnchor: "end", dx: -5, filter: (b) => b.value < 0})],
    }));
}
