// Numbers with units for people, page elements, and line charts. Everything else builds on these.

/// SI unit → what a designer reads, and the factor.
const shown_units = {
  "m": ["mm", 1e3], "rad": ["°", 180 / Math.PI], "Pa": ["MPa", 1e-6],
  "N/m": ["N/m", 1], "N m/rad": ["N m/rad", 1], "N": ["N", 1], "N m": ["N m", 1], "Hz": ["Hz", 1],
  "1": ["", 1],
};
const shown_unit = (unit) => (shown_units[unit] ?? [unit ?? "", 1])[0];
const shown_factor = (unit) => (shown_units[unit] ?? ["", 1])[1];

const superscript = (n) => String(n).replace(/[-0-9]/g, (c) => c === "-" ? "⁻" : "⁰¹²³⁴⁵⁶⁷⁸⁹"[+c]);

/// Four significant digits; powers of ten where that would be long.
function number_text(x, digits = 4) {
  if (x === null || x === undefined) return "–";
  if (x === 0) return "0";
  const size = Math.abs(x);
  if (size >= 1e-3 && size < 1e5) {
    const text = x.toPrecision(digits);
    const plain = text.includes("e") ? String(Number(text)) : text;
    return (plain.includes(".") ? plain.replace(/\.?0+$/, "") : plain).replace("-", "−");
  }
  const [mantissa, exponent] = x.toExponential(digits - 1).split("e");
  return `${mantissa.replace(/\.?0+$/, "")}·10${superscript(Number(exponent))}`.replace(/^-/, "−");
}

/// An SI value in the unit a designer reads: 0.35 rad → 20.05 °.
function quantity_text(x, unit, digits = 4) {
  if (x === null || x === undefined) return "–";
  const name = shown_unit(unit);
  return number_text(x * shown_factor(unit), digits) + (name === "" ? "" : (name === "°" ? "°" : " " + name));
}

const percent_text = (x) => x === null || x === undefined ? "–"
  : Math.abs(x) < 1e-6 ? "< 10⁻⁴ %"
  : (x > 0 ? "+" : "") + number_text(100 * x, 2) + " %";

/// Rounding noise beside the largest value of its kind is shown as zero.
const without_noise = (x, largest) => x !== null && Math.abs(x) < 1e-9 * largest ? 0 : x;

/// element("p", {class: "soft"}, "text", child, …): text is never read as HTML.
function element(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  made.append(...children.filter((child) => child !== null && child !== undefined));
  return made;
}

/// A stop reason without what the page says elsewhere: the algorithm, residual and evaluations.
function stop_text(reason) {
  return reason.replace(/^(NLopt \w+|Ipopt): /, "").replace(/ \(0 without values\)$/, "")
               .replace(/^the first-order conditions hold to .*$/, "conditions hold");
}

/// columns: [{name, unit, text: row => string, left}], one table row each; `mark` highlights rows.
function table_of(rows, columns, mark = () => false) {
  const head = element("tr", {}, ...columns.map((column) =>
    element("th", column.left ? {class: "text"} : {}, column.name,
            column.unit ? element("small", {}, column.unit) : null)));
  const body = rows.map((row) => element("tr", mark(row) ? {class: "mark"} : {},
    ...columns.map((column) => {
      const text = column.text(row);
      const kind = [column.left ? "text" : "", column.tone ? column.tone(row) : ""].join(" ").trim();
      return element("td", kind ? {class: kind} : {}, text);
    })));
  return element("div", {class: "scroll"},
                 element("table", {}, element("thead", {}, head), element("tbody", {}, ...body)));
}

const direction_colors = {
  ux: "#4269d0", uy: "#e08e0b", uz: "#e4572e", rx: "#2a9d8f", ry: "#3ca951", rz: "#a463f2",
};
const kind_colors = {
  drive: "#8d97a6", end_effector: "#4269d0", intermediate_body: "#a463f2", leaf: "#e08e0b",
};
const readable = (name) => name.replace(/_/g, " ");

function line_sample(color, dashed, dotted) {
  const sample = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  sample.setAttribute("width", 22);
  sample.setAttribute("height", 10);
  const shape = document.createElementNS("http://www.w3.org/2000/svg", dotted ? "circle" : "line");
  const place = dotted ? {cx: 11, cy: 5, r: 3.5, fill: color}
    : {x1: 0, x2: 22, y1: 5, y2: 5, stroke: color, "stroke-width": 2,
       "stroke-dasharray": dashed ? "5 4" : "none"};
  for (const [name, value] of Object.entries(place)) shape.setAttribute(name, value);
  sample.append(shape);
  return sample;
}

/// Whole decades around the values, so that a log axis always has labelled ticks.
function decades(values) {
  const low = Math.floor(Math.log10(d3.min(values)) + 1e-9);
  const high = Math.ceil(Math.log10(d3.max(values)) - 1e-9);
  return [10 ** low, 10 ** Math.max(high, low + 1)];
}

/// A figure with caption, note, legend and chart. lines: [{name, color, points: [{x, y}], dashed,
/// line: false for dots only, width}]; points without y are left out. log, x_log: logarithmic axes.
function line_chart(spec) {
  const lines = spec.lines
    .map((line) => ({...line, points: line.points.filter((p) => Number.isFinite(p.x) && Number.isFinite(p.y) && (!spec.log || p.y > 0) && (!spec.x_log || p.x > 0))}))
    .filter((line) => line.points.length > 0);
  const figure = element("figure", {class: "figure"}, element("figcaption", {}, spec.title),
                         element("div", {class: "soft"}, spec.note ?? ""));
  if (lines.length === 0) {
    figure.append(element("p", {class: "soft"}, spec.empty ?? "No values."));
    return figure;
  }
  const named = (spec.legend ?? lines).filter((line) => line.name);
  figure.append(element("div", {class: "legend"}, ...named.map((line) =>
      element("span", {}, line_sample(line.color, line.dashed, line.line === false), line.name))));
  const all = lines.flatMap((line) => line.points.map((p) => ({...p, line})));
  const y = {label: null, grid: true, ...(spec.y_domain ? {domain: spec.y_domain} : {nice: true})};
  const top = d3.max(all, (p) => Math.abs(p.y));
  if (top < 1e-3 || top >= 1e6) y.tickFormat = (v) => number_text(v, 3);
  if (spec.log) {
    const domain = decades(all.map((p) => p.y));
    const first = Math.round(Math.log10(domain[0])), last = Math.round(Math.log10(domain[1]));
    const every = Math.ceil((last - first) / 7);
    Object.assign(y, {type: "log", domain, nice: false,
      ticks: d3.range(first, last + 1, every).map((k) => 10 ** k),
      tickFormat: (v) => "10" + superscript(Math.round(Math.log10(v)))});
  }
  figure.append(Plot.plot({
    width: 560, height: spec.height ?? 300, marginLeft: 62, marginRight: 18, marginTop: 26, marginBottom: 40,
    aspectRatio: spec.aspect, style: {fontSize: "12px", background: "transparent"},
    x: {label: spec.x, labelAnchor: "center", labelArrow: "none", ...(spec.x_log ? {type: "log", ticks: 6, tickFormat: (v) => number_text(v, 2)} : {}), nice: !spec.x_domain, ...(spec.x_domain ? {domain: spec.x_domain} : {})},
    y,
    marks: [
      spec.log || spec.zero === false ? null : Plot.ruleY([0], {strokeOpacity: 0.35}),
      Plot.text([spec.y], {frameAnchor: "top-left", dy: -22, dx: -58, textAnchor: "start", fontWeight: 500}),
      ...lines.filter((line) => line.line !== false).map((line) => Plot.line(line.points, {
        x: "x", y: "y", stroke: line.color, strokeWidth: line.width ?? 2, strokeOpacity: line.opacity ?? 1,
        strokeDasharray: line.dashed ? "6 5" : undefined, curve: line.curve ?? "linear"})),
      ...lines.filter((line) => line.dots !== false).map((line) => Plot.dot(line.points, {
        x: "x", y: "y", fill: (p) => p.color ?? line.color, r: line.radius ?? 2.4})),
      ...(spec.marks ?? []),
      Plot.tip(all, Plot.pointer({x: "x", y: "y", maxRadius: 30, title: (p) =>
        `${p.name ?? p.line.name ?? spec.title}\n${p.text ?? `${spec.x}: ${number_text(p.x)}\n${spec.y}: ${number_text(p.y)}`}`})),
    ],
  }));
  return figure;
}
