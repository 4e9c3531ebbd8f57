// Quantities over two parameters: filled contours with the border of what is feasible. One place is
// shown in all maps of the same two parameters; pointer and arrow keys move it.
import {extent, range} from "d3";
import * as Plot from "@observablehq/plot";
import {narrow} from "./charts.js";
import {goal_factor, goal_unit, optimum, result} from "./result.js";
import {listen} from "./state.js";
import {element, heading, number_text, quantity_text, readable, shown_factor, shown_unit} from "./text.js";

/// One parameter as an axis: its values as shown, and the half step beyond them.
function axis_of({parameter, unit, values, start, held}) {
  const factor = shown_factor(unit), shown = values.map((v) => v * factor);
  const half = (shown.at(-1) - shown[0]) / (shown.length - 1) / 2;
  return {name: readable(parameter), unit, shown, half, start: start * factor, held: held * factor,
    label: `${readable(parameter)} [${shown_unit(unit) || "1"}]`, text: (k) => quantity_text(values[k], unit)};
}

/// The list of rows (a row for each value of the first parameter) as Plot wants it: row by row of
/// the second one.
const by_rows = (rows, factor) => range(rows[0].length).flatMap((j) => rows.map((row) => row[j] === null ? NaN : row[j] * factor));

/// Levels for filled contours: round numbers, or a few in each decade where the values span many.
function color_of(values) {
  const good = values.filter(Number.isFinite), [low, high] = extent(good);
  if (good.length === 0 || low === high) return null;
  const log = low > 0 && high / low > 50;
  const levels = log ? range(0, 17).map((k) => low * (high / low) ** (k / 16)) : range(0, 17).map((k) => low + (high - low) * k / 16);
  return {log, low, high, levels};
}

function marks_of(map, x, y) {
  if (map.of_strokes) return [];
  const places = [{x: x.held, y: y.held, symbol: optimum ? "star" : "circle", name: optimum ? "optimum" : "this design"}];
  if (optimum && (x.start !== x.held || y.start !== y.held)) places.push({x: x.start, y: y.start, symbol: "circle", name: "start"});
  const inside = places.filter((p) => Math.abs(2 * p.x - x.shown[0] - x.shown.at(-1)) <= x.shown.at(-1) - x.shown[0] + 1e-9 * Math.abs(p.x) && Math.abs(2 * p.y - y.shown[0] - y.shown.at(-1)) <= y.shown.at(-1) - y.shown[0] + 1e-9 * Math.abs(p.y));
  return [
    Plot.dot(inside, {x: "x", y: "y", symbol: "symbol", r: 6, fill: "#ffffff", stroke: "#000000", strokeWidth: 1.6}),
    Plot.text(inside, {x: "x", y: "y", text: "name", dy: -13, fill: "#000000", stroke: "#ffffff", strokeWidth: 4, fontWeight: 600, paintOrder: "stroke"}),
  ];
}

/// The chart of one quantity. Returns it with its legend.
function chart_of(map, quantity, x, y) {
  const factor = goal_factor(quantity), values = by_rows(quantity.values, factor), color = color_of(values);
  const frame = {x1: x.shown[0] - x.half, x2: x.shown.at(-1) + x.half, y1: y.shown[0] - y.half, y2: y.shown.at(-1) + y.half,
    width: x.shown.length, height: y.shown.length, clip: true};
  const margin = map.margin ? by_rows(map.margin, -1).map((v) => Number.isNaN(v) ? 1e9 : v) : null;
  const holes = range(values.length).filter((k) => Number.isNaN(values[k])).map((k) => ({x: x.shown[k % x.shown.length], y: y.shown[Math.floor(k / x.shown.length)]}));
  const chart = Plot.plot({
    width: narrow ? 380 : 560, height: narrow ? 320 : 400, marginLeft: 62, marginRight: 18, marginTop: 26, marginBottom: 42,
    style: {fontSize: "12px", background: "transparent"},
    x: {label: x.label, labelAnchor: "center", labelArrow: "none", domain: [x.shown[0], x.shown.at(-1)], ticks: narrow ? 5 : 7},
    y: {label: null, domain: [y.shown[0], y.shown.at(-1)]},
    color: color ? {type: color.log ? "log" : "linear", scheme: "viridis", domain: [color.low, color.high]} : {},
    marks: [
      color ? Plot.contour(values, {...frame, fill: Plot.identity, stroke: "#ffffff", strokeOpacity: 0.35, thresholds: color.levels}) : null,
      margin ? Plot.contour(margin, {...frame, value: Plot.identity, thresholds: [0], fill: "#ffffff", fillOpacity: 0.6, stroke: "#000000", strokeWidth: 2}) : null,
      Plot.dot(holes, {x: "x", y: "y", symbol: "times", r: 3, stroke: "var(--soft)"}),
      Plot.text([y.label], {frameAnchor: "top-left", dy: -22, dx: -58, textAnchor: "start", fontWeight: 500}),
      Plot.frame({stroke: "var(--soft)"}),
      ...marks_of(map, x, y),
    ]});
  const unit = goal_unit(quantity) || "1";
  const legend = color ? chart.legend("color", {label: `[${unit}]`, width: narrow ? 300 : 360, ticks: color.log ? range(0, 17, 4).map((k) => color.levels[k]) : 5, tickFormat: (v) => number_text(v, color.log ? 2 : 3)})
    : element("p", {class: "soft"}, values.some(Number.isFinite) ? `the same everywhere: ${number_text(values.find(Number.isFinite), 4)} ${unit}` : "no design has a value");
  return {chart, legend};
}

/// What the job's constraints say of a place.
function verdict(map, i, j) {
  const margin = map.margin?.[i][j];
  if (margin === undefined) return "";
  if (margin === null) return "";
  return margin >= 0 ? ", feasible" : `, misses a bound by ${number_text(-100 * margin, 2)} %`;
}

/// The maps of one pair of parameters. Where they are the strokes of two drives (`of_strokes`), the place
/// is the stroke that the page shows: `map.show(i, j)` sets it, `map.shown()` gives it.
export function panel(map) {
  const [x, y] = map.parameters.map(axis_of), shown = [];
  const nearest = (axis, value) => Math.max(0, Math.min(axis.shown.length - 1, Math.round((value - axis.shown[0]) / (2 * axis.half))));
  const place = {i: nearest(x, x.held), j: nearest(y, y.held)};
  if (map.of_strokes) listen(["stroke"], () => { Object.assign(place, map.shown()); tell(); });
  const update = () => map.of_strokes ? map.show(place.i, place.j) : tell();
  const tell = () => {
    for (const {quantity, dot, chart, output} of shown) {
      const value = quantity.values[place.i][place.j], {i, j} = place;
      dot.setAttribute("cx", chart.scale("x").apply(x.shown[i]));
      dot.setAttribute("cy", chart.scale("y").apply(y.shown[j]));
      output.textContent = `${x.name} ${x.text(i)}, ${y.name} ${y.text(j)}: ${value === null ? "no value" : `${number_text(value * goal_factor(quantity), 4)} ${goal_unit(quantity)}`.trim()}${verdict(map, i, j)}`;
    }
  };
  const figure_of = (quantity) => {
    const {chart, legend} = chart_of(map, quantity, x, y), output = element("output", {class: "soft here", "aria-live": "polite"});
    const dot = document.createElementNS("http://www.w3.org/2000/svg", "circle");
    for (const [name, value] of Object.entries({r: 4.5, fill: "none", stroke: "#d55e00", "stroke-width": 2.5, class: "cursor"})) dot.setAttribute(name, value);
    chart.append(dot);
    chart.setAttribute("tabindex", "0");
    chart.setAttribute("role", "application");
    chart.setAttribute("aria-label", `Map of ${readable(quantity.label)} over ${x.name} and ${y.name}; arrow keys move the place that is shown`);
    const point = (event) => {
      const box = chart.getBoundingClientRect(), [, , width, height] = chart.getAttribute("viewBox").split(" ").map(Number);
      place.i = nearest(x, chart.scale("x").invert((event.clientX - box.left) * width / box.width));
      place.j = nearest(y, chart.scale("y").invert((event.clientY - box.top) * height / box.height));
      update();
    };
    chart.addEventListener("pointermove", point);
    chart.addEventListener("pointerdown", point);
    chart.addEventListener("keydown", (event) => {
      const step = {ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowDown: [0, -1], ArrowUp: [0, 1]}[event.key];
      if (!step) return;
      event.preventDefault();
      place.i = Math.max(0, Math.min(x.shown.length - 1, place.i + step[0]));
      place.j = Math.max(0, Math.min(y.shown.length - 1, place.j + step[1]));
      update();
    });
    shown.push({quantity, dot, chart, output});
    return element("figure", {class: "figure map", "data-title": quantity.label}, element("figcaption", {}, heading(readable(quantity.label))), legend, output, chart);
  };
  const figures = map.quantities.map(figure_of);
  if (map.of_strokes) Object.assign(place, map.shown());
  tell();
  return element("div", {class: "figures maps"}, ...figures);
}

export function map_section() {
  return (result.maps ?? []).flatMap((map) => {
    const [a, b] = map.parameters.map((p) => readable(p.parameter));
    const count = map.parameters[0].values.length * map.parameters[1].values.length;
    return [element("h3", {}, `${heading(a)} and ${b}`),
      element("p", {class: "soft"}, `${count} designs on reduced leaves${map.model.atlas ? ", looked up in an atlas" : ""}; everything else as in ${optimum ? "the optimum" : "the design"}.` +
        (map.margin ? " Where the colours are pale a constraint is missed; the line is the border." : "") +
        (map.failed ? ` ${map.failed} of them have no values (×), the first: ${map.first_failure}.` : "") +
        " Point at a place, or step with the arrow keys."),
      panel(map)];
  });
}
