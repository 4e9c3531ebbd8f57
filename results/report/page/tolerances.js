// What tolerances do to the goals and to every quantity, and which of them does it; and what errors
// of assembly do.
import {groups, rollup, sum} from "d3";
import {place_of} from "./cases.js";
import {bar_chart} from "./charts.js";
import {cases, goal_text, heading, quantities, result, shown_case} from "./result.js";
import {element, number_text, quantity_text, readable, shown_factor, shown_unit, table_of} from "./text.js";

const per_cent = (share) => `${number_text(100 * share, 2)} %`;
const entry_of = (e) => e.entry ?? e.name;
/// Shares of the entries of the job, each with all of its leaves.
const shares_of = ({shares}) => [...rollup(result.tolerances.entries, (own) => sum(own, (e) => shares?.[e.name] ?? 0), entry_of)];
const largest = (number) => shares_of(number).reduce((a, b) => b[1] > a[1] ? b : a, ["", 0]);
const share_text = (number) => { const [name, share] = largest(number); return share > 0 ? `${readable(name)} ${per_cent(share)}` : ""; };
const columns = (text) => [
  {name: "Value", text: (r) => text(r, r.value)},
  {name: "± worst", unit: "first order", text: (r) => text(r, r.worst)},
  {name: "σ", unit: "first order", text: (r) => text(r, r.standard_deviation)},
  {name: "σ", unit: "sampled", text: (r) => r.sampled ? text(r, r.sampled.standard_deviation) : "–"},
  {name: "Most of it by", left: true, text: share_text}];

/// Each quantity at the point of the stroke where it spreads most.
const quantity_rows = ({widest = []}) => widest.filter((n) => (n.case ?? null) === shown_case)
  .map((n) => ({...n, q: quantities.find((q) => q.name === n.quantity)})).filter((n) => n.q);

/// "thickness: ±10 µm (uniform)"; of an entry that deviates leaf by leaf, the leaves are counted.
function entry_text([first, ...others]) {
  const of_all = (name) => name.split(" of ")[0], entry = entry_of(first), own = first.name !== entry;
  const changes = Object.entries(first.at_upper_limit).map(([p, c]) => [own ? of_all(p) : p, c, first.units[p]])
    .map(([p, c, unit]) => `${p === entry ? "" : readable(p) + " "}±${quantity_text(Math.abs(c), unit)}`).join(", ");
  return `${readable(entry)}${own ? `, each of ${others.length + 1} leaves by itself` : ""}: ${changes} (${first.distribution})`;
}

/// Errors of assembly: the worst of the box, and its critical size.
export function assembly_section() {
  const {assembly_tolerances} = result;
  if (!assembly_tolerances) return [];
  const {worst_case, critical, message} = assembly_tolerances;
  const way = (word, v, unit) => v.some((x) => x !== 0) && `${word} (${v.map((x) => number_text(x * shown_factor(unit))).join(", ")}) ${shown_unit(unit)}`;
  const error_text = (e) => `${e.leaf} ${e.end} ${[way("moved", e.move, "m"), way("turned", e.turn, "rad")].filter(Boolean).join(", ") || "as designed"}`;
  return [element("p", {class: "lead"}, [critical && `Critical errors of assembly: the box times ${number_text(critical.scale)}; ${critical.reason}.`, message].filter(Boolean).join(" ")),
    worst_case.length ? table_of(worst_case, [{name: "Quantity", left: true, text: (w) => heading(readable(w.quantity ?? w.expression)) + `, ${readable(w.over_stroke)}`},
      {name: "As designed", text: (w) => goal_text(w, w.nominal)}, {name: "Worst in the box", text: (w) => w.worst === null ? w.reason : goal_text(w, w.worst)},
      {name: "Where", left: true, text: place_of},
      {name: "By", left: true, text: (w) => w.misalignment.map(error_text).join("; ")}]) : null];
}

export function tolerance_section() {
  const {tolerances} = result;
  if (!tolerances) return [];
  const {entries, goals, samples, room} = tolerances, rows = quantity_rows(tolerances);
  const said = [
    `${groups(entries, entry_of).map(([, own]) => entry_text(own)).join("; ")}.`,
    room && (room.scale > 1e-4 ? `All tolerances may be ${number_text(room.scale)} times as large, to first order; then ${readable(room.constraint)} is at its bound.`
      : `There is no room for any tolerance: ${readable(room.constraint)} is at its bound or beyond it.`),
    tolerances.yield !== null && `${per_cent(tolerances.yield)} of ${samples.count} sampled designs keep every constraint${samples.failed ? `, ${samples.failed} of them have no equilibrium` : ""}.`,
    tolerances.message].filter(Boolean).join(" ");
  return [element("p", {class: "lead"}, said),
    goals.length ? table_of(goals, [{name: "Goal", left: true, text: (g) => heading(readable(g.label === "objective" ? g.quantity ?? g.expression : g.label))},
      ...columns((g, x) => x === null ? "–" : goal_text(g, x)),
      {name: "Room", text: (g) => g.room === null ? "" : number_text(g.room), tone: (g) => g.room !== null && g.room < 1 ? "warn" : ""},
      {name: "Missed by", unit: "of the samples", text: (g) => (g.missed ?? null) === null ? "" : per_cent(g.missed), tone: (g) => g.missed > 0.1 ? "warn" : ""}]) : null,
    goals.filter((g) => largest(g)[1] > 0).length ? element("div", {class: "figures"}, ...goals.filter((g) => largest(g)[1] > 0).map((g) =>
      bar_chart({title: heading(readable(g.label)), note: "share of each tolerance in the variance", x: "share [%]", color: ["var(--accent)", "var(--orange)"],
        bars: shares_of(g).map(([name, share]) => ({name: readable(name), value: 100 * share, text: per_cent(share)}))}))) : null,
    rows.length ? element("details", {open: goals.length === 0}, element("summary", {}, `${rows.length} quantities, each where it spreads most${Object.keys(cases).length ? ` in ${shown_case}` : ""}`),
      table_of(rows, [{name: "Quantity", left: true, text: (r) => heading(r.q.label)}, ...columns((r, x) => quantity_text(x, r.q.unit))])) : null];
}
