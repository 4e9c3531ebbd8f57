// Numbers with units for people, and page elements. Everything else builds on these.

/// SI unit → what a designer reads, and the factor.
const shown_units = {
  "m": ["mm", 1e3], "rad": ["°", 180 / Math.PI], "Pa": ["MPa", 1e-6], "1": ["", 1],
};
export const shown_unit = (unit) => (shown_units[unit] ?? [unit ?? "", 1])[0];
export const shown_factor = (unit) => (shown_units[unit] ?? ["", 1])[1];

export const superscript = (n) => String(n).replace(/[-0-9]/g, (c) => c === "-" ? "⁻" : "⁰¹²³⁴⁵⁶⁷⁸⁹"[+c]);

/// Significant digits without zeros at the end; powers of ten where that would be long.
export function number_text(x, digits = 3) {
  if (x === null || x === undefined || Number.isNaN(x)) return "–";
  if (!Number.isFinite(x)) return x > 0 ? "∞" : "−∞";
  if (x === 0) return "0";
  const size = Math.abs(x);
  if (size >= 1e-3 && size < 1e5) {
    const text = x.toPrecision(digits);
    const plain = text.includes("e") ? String(Number(text)) : text;
    return (plain.includes(".") ? plain.replace(/\.?0+$/, "") : plain).replace("-", "−");
  }
  const [mantissa, exponent] = x.toExponential(digits - 1).split("e");
  const short = mantissa.includes(".") ? mantissa.replace(/\.?0+$/, "") : mantissa;
  return `${short}·10${superscript(Number(exponent))}`.replace(/^-/, "−");
}

/// Number and unit, with the space between them, of an SI value as a designer reads it: 0.35 rad →
/// ["20.1", "°"], 3.13e6 N/m → ["3.13", " N/µm"].
export function quantity_parts(x, unit, digits = 3) {
  const [name, factor] = unit === "N/m" && Math.abs(x) >= 1e5 ? ["N/µm", 1e-6] : [shown_unit(unit), shown_factor(unit)];
  return [number_text(x * factor, digits), name === "" || name === "°" ? name : " " + name];
}
export const quantity_text = (x, unit, digits = 3) =>
  x === null || x === undefined || Number.isNaN(x) ? "–" : quantity_parts(x, unit, digits).join("");

export const percent_text = (x) => x === null || x === undefined ? "–"
  : Math.abs(x) < 1e-6 ? "< 10⁻⁴ %"
  : (x > 0 ? "+" : "") + number_text(100 * x, 2) + " %";

/// Rounding noise beside the largest value of its kind is shown as zero.
export const without_noise = (x, largest) => x !== null && Math.abs(x) < 1e-9 * largest ? 0 : x;

export const readable = (name) => String(name).replace(/_/g, " ");
export const heading = (label) => label === "" ? "" : label[0].toUpperCase() + label.slice(1);

/// element("p", {class: "soft"}, "text", child, …): text is never read as HTML. A key like onclick
/// takes a function.
export function element(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes))
    if (typeof value === "function") made.addEventListener(name.slice(2), value);
    else if (value !== false && value !== null && value !== undefined) made.setAttribute(name, value === true ? "" : value);
  made.append(...children.flat().filter((child) => child !== null && child !== undefined && child !== false));
  return made;
}

/// A select with a label before it. options: [[value, text], …]
export function chooser(label, options, chosen, change, name = label) {
  const list = element("select", {"aria-label": name, onchange: (event) => change(event.target.value)},
    ...options.map(([value, text]) => element("option", {value, ...(value === chosen ? {selected: true} : {})}, text)));
  return element("label", {class: "choice"}, element("span", {}, label), list);
}

/// columns: [{name, unit, text: row => string, left, tone}], one table row each; `mark` highlights
/// rows; `pick`: what a click on a row does.
export function table_of(rows, columns, mark = () => false, pick = null) {
  const head = element("tr", {}, ...columns.map((column) =>
    element("th", {scope: "col", ...(column.left ? {class: "text"} : {})}, column.name,
            column.unit ? element("small", {}, column.unit) : null)));
  const body = rows.map((row) => {
    const cells = columns.map((column) => {
      const kind = [column.left ? "text" : "", column.tone ? column.tone(row) : ""].join(" ").trim();
      return element("td", kind ? {class: kind} : {}, column.text(row));
    });
    const made = element("tr", mark(row) ? {class: "mark"} : {}, ...cells);
    if (pick) {
      made.classList.add("pick");
      made.tabIndex = 0;
      made.addEventListener("click", () => pick(row));
      made.addEventListener("keydown", (event) => { if (event.key === "Enter") pick(row); });
    }
    return made;
  });
  return element("div", {class: "scroll", tabindex: "0"},
                 element("table", {}, element("thead", {}, head), element("tbody", {}, ...body)));
}

/// Copies a text; true when the browser let us.
export async function copy_text(text) {
  try {
    await navigator.clipboard.writeText(text);
    return true;
  } catch {
    const area = element("textarea", {class: "offscreen"});
    area.value = text;
    document.body.append(area);
    area.select();
    const done = document.execCommand("copy");
    area.remove();
    return done;
  }
}

/// A button that says for a moment what it did.
export function action_button(text, act, done = "copied") {
  const button = element("button", {type: "button", onclick: async () => {
    const good = await act();
    button.textContent = good === false ? "not possible here" : done;
    setTimeout(() => { button.textContent = text; }, 1200);
  }}, text);
  return button;
}
