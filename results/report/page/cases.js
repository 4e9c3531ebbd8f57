// A job with several load cases: which of them the page shows, and which are decisive.
import {cases, quantities, result, shown_case} from "./result.js";
import {set} from "./state.js";
import {chooser, element, heading, quantity_text, table_of} from "./text.js";

/// The page is drawn anew for the load case of its address.
export function case_chooser() {
  const names = Object.keys(cases);
  if (names.length < 2) return null;
  return element("p", {}, chooser("Load case", names.map((n) => [n, n]), shown_case, (name) => {
    location.hash = `case=${encodeURIComponent(name)}`;
    set({load_case: name});
  }));
}

/// "standing, at 8 mm": load case, if there are several, and stroke of something.
export const place_of = (entry) => {
  const {stroke: unit} = (cases[entry.case] ?? result).units ?? {};
  const stroke = typeof entry.stroke === "object" ? Object.values(entry.stroke).map((s) => quantity_text(s, "")).join(", ")
    : quantity_text(entry.stroke, typeof unit === "string" ? unit : "");
  return `${entry.case ? `${entry.case}, ` : ""}at ${stroke}`;
};

/// Least and largest value of each quantity over all load cases.
export function case_section() {
  if (!result.extremes) return [];
  const rows = quantities.filter((q) => result.extremes[q.name]).map((q) => ({q, ...result.extremes[q.name]}));
  return [element("p", {class: "soft"}, "Over all load cases and their strokes."),
    table_of(rows, [
      {name: "Quantity", left: true, text: (r) => heading(r.q.label)},
      {name: "Least", text: (r) => quantity_text(r.least.value, r.q.unit)}, {name: "in", left: true, text: (r) => place_of(r.least)},
      {name: "Largest", text: (r) => quantity_text(r.largest.value, r.q.unit)}, {name: "in", left: true, text: (r) => place_of(r.largest)}])];
}
