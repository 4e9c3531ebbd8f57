// What the tolerances do: to the goals, to every quantity, and which of them does it.
import {bar_chart} from "./charts.js";
import {cases, goal_text, heading, quantities, result, shown_case} from "./result.js";
import {element, number_text, quantity_text, readable, table_of} from "./text.js";

const per_cent = (share) => `${number_text(100 * share, 2)} %`;
const largest = (shares) => Object.entries(shares ?? {}).reduce((a, b) => b[1] > a[1] ? b : a, ["", 0]);
const share_text = (number) => { const [name, share] = largest(number.shares); return share > 0 ? `${readable(name)} ${per_cent(share)}` : ""; };
const columns = (text) => [
  {name: "Value", text: (r) => text(r, r.value)},
  {name: "± worst", unit: "first order", text: (r) => text(r, r.worst)},
  {name: "σ", unit: "first order", text: (r) => text(r, r.standard_deviation)},
  {name: "σ", unit: "sampled", text: (r) => r.sampled ? text(r, r.sampled.standard_deviation) : "–"},
  {name: "Most of it by", left: true, text: share_text}];

/// Each quantity at the point of the stroke where it spreads most.
function quantity_rows(tolerances) {
  const path = tolerances.cases?.[shown_case]?.path ?? tolerances.path ?? [];
  return quantities.map((q) => {
    const numbers = path.map((p) => ({...p.quantities[q.name], q})).filter((n) => typeof n.standard_deviation === "number");
    return numbers.length ? numbers.reduce((a, b) => b.standard_deviation > a.standard_deviation ? b : a) : null;
  }).filter((n) => n && n.standard_deviation > 1e-9 * Math.abs(n.value));
}

export function tolerance_section() {
  const {tolerances} = result;
  if (!tolerances) return [];
  const {entries, goals, samples, room} = tolerances, rows = quantity_rows(tolerances);
  const said = [
    `${entries.map((e) => `${readable(e.name)}: ${Object.entries(e.at_upper_limit).map(([p, c]) => `${p === e.name ? "" : readable(p) + " "}±${quantity_text(Math.abs(c), e.units[p])}`).join(", ")} (${e.distribution})`).join("; ")}.`,
    room && (room.scale > 1e-4 ? `All tolerances may be ${number_text(room.scale)} times as large, to first order; then ${readable(room.constraint)} is at its bound.`
      : `There is no room for any tolerance: ${readable(room.constraint)} is at its bound or beyond it.`),
    tolerances.yield !== null && `${per_cent(tolerances.yield)} of ${samples.count} sampled designs keep every constraint${samples.failed ? `, ${samples.failed} of them have no equilibrium` : ""}.`,
    tolerances.message].filter(Boolean).join(" ");
  return [element("p", {class: "lead"}, said),
    goals.length ? table_of(goals, [{name: "Goal", left: true, text: (g) => heading(readable(g.label === "objective" ? g.quantity ?? g.expression : g.label))},
      ...columns((g, x) => x === null ? "–" : goal_text(g, x)),
      {name: "Room", text: (g) => g.room === null ? "" : number_text(g.room), tone: (g) => g.room !== null && g.room < 1 ? "warn" : ""}]) : null,
    goals.filter((g) => largest(g.shares)[1] > 0).length ? element("div", {class: "figures"}, ...goals.filter((g) => largest(g.shares)[1] > 0).map((g) =>
      bar_chart({title: heading(readable(g.label)), note: "share of each tolerance in the variance", x: "share [%]", color: ["var(--accent)", "var(--orange)"],
        bars: Object.entries(g.shares).map(([name, share]) => ({name: readable(name), value: 100 * share, text: per_cent(share)}))}))) : null,
    rows.length ? element("details", {}, element("summary", {}, `${rows.length} quantities, each where it spreads most${Object.keys(cases).length ? ` in ${shown_case}` : ""}`),
      table_of(rows, [{name: "Quantity", left: true, text: (r) => heading(r.q.label)}, ...columns((r, x) => quantity_text(x, r.q.unit))])) : null];
}
