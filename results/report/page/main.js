// The report: result.json and scene.json, section by section.
import {case_section} from "./cases.js";
import {comparison_sections} from "./comparison.js";
import {design_sections} from "./designs.js";
import {facts, first_screen} from "./first_screen.js";
import {leaf_panel} from "./leaf_plots.js";
import {map_section} from "./maps.js";
import {matrix_panel, principal_panel} from "./matrices.js";
import {accuracy_table, optimum_tables, sensitivity_charts} from "./optimum.js";
import {converged, job, optimum, result} from "./result.js";
import {designs} from "./scene_data.js";
import {history_charts, parallel_coordinates, starts_table} from "./search.js";
import {screening_section} from "./screening.js";
import {front_section, stock_section, verification_section} from "./stages.js";
import {state} from "./state.js";
import {stroke_charts} from "./stroke_plots.js";
import {checks, stroke_table} from "./tables.js";
import {element} from "./text.js";
import {tolerance_section} from "./tolerances.js";
import {view_panel} from "./view_panel.js";

const page = document.getElementById("report");
const section = (title, children, id) => {
  const shown = children.flat().filter(Boolean);
  if (shown.length > 0) page.append(element("h2", id ? {id} : {}, title), ...shown);
};
const figures = (charts) => charts.length > 0 ? [element("div", {class: "figures"}, ...charts)] : [];

function draw() {
  if (converged.length > 0) {  // where the most is to be seen
    const far = converged.reduce((a, b) => Math.abs(b.stroke) >= Math.abs(a.stroke) ? b : a);
    state.stroke = far.stroke;
  }
  const start = designs.findIndex((d) => d.kind === "start");
  if (start > 0) state.beside = start;
  const {panel, view} = view_panel();
  page.append(...first_screen(panel));
  const beside = document.getElementById("first");
  beside.append(leaf_panel());
  const charts = stroke_charts();
  if (charts.length > 0)
    beside.append(element("h2", {id: "over-the-stroke"}, "Over the stroke"), element("p", {class: "soft"}, "Point at a stroke, or step with the arrow keys: the mechanism moves there."), ...charts);
  for (const [title, children] of design_sections()) section(title, children);
  if (optimum && optimum.goal) {
    section("Optimum", optimum_tables());
    section("What each dimension does", figures(sensitivity_charts()));
    section("Front of two objectives", front_section());
    section("All evaluated designs", parallel_coordinates());
    section("Convergence", figures(history_charts()));
    section("Global search", screening_section());
    section("Starts", starts_table());
    section("Stock sizes", stock_section());
    section("Accuracy: this model against full accuracy", accuracy_table());
    section("Towards the optimum of full accuracy", verification_section());
  }
  for (const [title, children] of comparison_sections()) section(title, children);
  section("Maps", map_section());
  section("Tolerances", tolerance_section());
  section("Load cases", case_section());
  section("Stroke table", stroke_table());
  section("Compliance", [matrix_panel(), principal_panel()]);
  section("Checks", checks());
  section("What was computed", [facts()]);
  section("Job", [element("details", {}, element("summary", {}, "as read, defaults filled in, SI"), element("pre", {tabindex: "0"}, JSON.stringify(job, null, 2)))]);
  document.getElementById("made-by").textContent = `flexopt ${result.flexopt?.version ?? ""} (${result.flexopt?.commit ?? ""}). Made with Observable Plot, D3, three.js and fflate, inside this file; nothing is loaded from elsewhere.`;
  document.documentElement.dataset.ready = "yes";
  return view;
}

/// For tests: the view and what the page shows.
window.flexopt_report = {view: draw(), state};
