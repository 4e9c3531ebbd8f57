// The screening of a global search, and the different optima that it led to.
import {goal_text, optimum} from "./result.js";
import {element, number_text, quantity_text, readable, table_of} from "./text.js";

/// One sentence with the counts of a screening.
function counts_text({designs, evaluated, ruled_out, failed, feasible, nearly_feasible, atlas, clusters}) {
  const rest = [ruled_out ? `${ruled_out} ruled out by formulas` : "", failed ? `${failed} without values` : ""].filter(Boolean);
  return `${designs} designs of the whole box on reduced leaves${atlas ? ", looked up in an atlas" : ""}: ${evaluated} evaluated${rest.length ? ", " + rest.join(", ") : ""}; ` +
    `${feasible} feasible, ${nearly_feasible} more miss no bound by more than 10 %. The good ones make ${clusters} cluster${clusters === 1 ? "" : "s"}.`;
}

function optima_table(searches) {
  const {optima, goal} = optimum;
  const found = (o) => o.starts.length;
  return table_of(optima, [
    {name: "Optimum", text: (o) => String(optima.indexOf(o) + 1)},
    {name: "Objective", text: (o) => goal_text(goal, o.objective)},
    {name: "At full accuracy", text: (o) => o.full ? goal_text(goal, o.full.objective) : "no equilibrium"},
    {name: "Violation", text: (o) => number_text(o.violation, 2)},
    {name: "End", left: true, text: (o) => o.feasible ? "feasible" : "infeasible", tone: (o) => o.feasible ? "good" : "bad"},
    {name: "Found from", text: (o) => `${found(o)} of ${searches}`},
    ...(optimum.variables ?? []).map((v) => ({name: readable(v.parameter), text: (o) => quantity_text(o.variables?.[v.parameter], v.unit)}))],
    (o) => o.starts.includes(optimum.best_start));
}

function clusters_table(searched) {
  return table_of(searched, [
    {name: "Start", text: (c) => String(c.start)},
    {name: "Objective", text: (c) => goal_text(optimum.goal, c.objective)},
    {name: "Violation", text: (c) => number_text(c.violation, 2)},
    {name: "Designs", text: (c) => String(c.designs)},
    {name: "To anything better", unit: "of the box", text: (c) => number_text(c.distance, 2)},
    ...(optimum.variables ?? []).map((v) => ({name: readable(v.parameter), text: (c) => quantity_text(c.from?.[v.parameter], v.unit)}))]);
}

const share_table = (rows, key, name, all) => rows.length === 0 ? null : table_of(rows, [
  {name, left: true, text: (r) => readable(r[key])},
  {name: "Designs", text: (r) => String(r.designs)},
  {name: "Share", text: (r) => `${number_text(100 * r.designs / all, 2)} %`}]);

export function screening_section() {
  const {screening, optima} = optimum;
  if (!screening) return [];
  const {searched, failures, violated, designs, evaluated} = screening;
  return [element("p", {class: "soft"}, counts_text(screening)),
    optima.length ? element("h3", {}, "Different optima") : null,
    optima.length ? optima_table(searched.length) : null,
    searched.length ? element("h3", {}, "Clusters from which a search was begun") : null,
    searched.length ? clusters_table(searched) : null,
    violated.length ? element("h3", {}, "What stands against feasible designs") : null,
    share_table(violated, "label", "Missed constraint", evaluated),
    share_table(failures, "reason", "No values because of", designs)];
}
