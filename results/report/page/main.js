// The report: result.json and scene.json, section by section.
import {case_section} from "./cases.js";
import {comparison_sections} from "./comparison.js";
import {design_sections} from "./designs.js";
import {fatigue_section} from "./fatigue.js";
import {facts, first_screen} from "./first_screen.js";
import {frequency_response_section} from "./frequency_response.js";
import {leaf_panel} from "./leaf_plots.js";
import {map_section} from "./maps.js";
import {matrix_panel, principal_panel} from "./matrices.js";
import {accuracy_table, optimum_tables, sensitivity_charts} from "./optimum.js";
import {converged, job, optimum, read_result, result, shown_case, undeflected} from "./result.js";
import {designs, read_scene} from "./scene_data.js";
import {history_charts, parallel_coordinates, starts_table} from "./search.js";
import {screening_section} from "./screening.js";
import {front_section, stock_section, verification_section} from "./stages.js";
import {forget_listeners, listen, set, state} from "./state.js";
import {stroke_charts} from "./stroke_plots.js";
import {checks, stroke_table} from "./tables.js";
import {element} from "./text.js";
import {assembly_section, tolerance_section} from "./tolerances.js";
import {redraw_view, view_panel} from "./view_panel.js";

const page = document.getElementById("report");
const section = (title, children, id) => {
  const shown = children.flat().filter(Boolean);
  if (shown.length > 0) page.append(element("h2", id ? {id} : {}, title), ...shown);
};
const figures = (charts) => charts.length > 0 ? [element("div", {class: "figures"}, ...charts)] : [];

/// What the reader has chosen stays, as far as there is such a thing in the result shown.
function choose() {
  const strokes = converged.map((p) => p.stroke), again = drawn && case_drawn === shown_case;
  case_drawn = shown_case;
  if (strokes.length > 0 && !(again && Math.min(...strokes) <= state.stroke && state.stroke <= Math.max(...strokes)))
    state.stroke = strokes.reduce((a, b) => Math.abs(b) >= Math.abs(a) ? b : a);  // where the most is to be seen
  const start = designs.findIndex((d) => d.kind === "start");
  if (!drawn || !designs[state.beside]) state.beside = start > 0 ? start : null;
  const {modes, leaves = []} = designs[0] ?? {};
  if (state.mode && !(state.mode.index < (modes?.[state.mode.drive] ?? 0))) state.mode = null;
  if (!leaves.some((leaf) => leaf.name === state.leaf)) state.leaf = null;
}

function draw() {
  page.replaceChildren();
  const {panel, view} = view_panel();
  page.append(...first_screen(panel));
  const beside = document.getElementById("first");
  beside.append(leaf_panel());
  const charts = stroke_charts();
  if (charts.length > 0)
    beside.append(element("h2", {id: "over-the-stroke"}, "Over the stroke"), element("p", {class: "soft"}, "Point at a stroke, or step with the arrow keys: the mechanism moves there."), ...charts);
  for (const [title, children] of design_sections()) section(title, children);
  if (optimum && optimum.goal) {
    const running = result.status === "running";  // then its progress is what the reader looks for
    if (running) section("Convergence", figures(history_charts()));
    if (running) section("All evaluated designs", parallel_coordinates());
    section(running ? "Best so far" : "Optimum", optimum_tables());
    section("What each dimension does", figures(sensitivity_charts()));
    section("Front of two objectives", front_section());
    if (!running) section("All evaluated designs", parallel_coordinates());
    if (!running) section("Convergence", figures(history_charts()));
    section("Global search", screening_section());
    section("Starts", starts_table());
    section("Stock sizes", stock_section());
    section("Accuracy: this model against full accuracy", accuracy_table());
    section("Towards the optimum of full accuracy", verification_section());
  }
  for (const [title, children] of comparison_sections()) section(title, children);
  section("Frequency responses", frequency_response_section());
  section("Fatigue", fatigue_section());
  section("Maps", map_section());
  section("Tolerances", tolerance_section());
  section("Errors of assembly", assembly_section());
  section("Load cases", case_section());
  section("Stroke table", stroke_table());
  section("Compliance", [matrix_panel(), principal_panel()]);
  section("Checks", undeflected ? [] : checks());
  section(undeflected ? "What is shown" : "What was computed", [facts()]);
  section("Job", [element("details", {}, element("summary", {}, "as read, defaults filled in, SI"), element("pre", {tabindex: "0"}, JSON.stringify(job, null, 2)))]);
  document.getElementById("made-by").textContent = `flexopt ${result.flexopt?.version ?? ""} (${result.flexopt?.commit ?? ""}). Made with Observable Plot, D3, three.js and fflate, inside this file; nothing is loaded from elsewhere.`;
  document.documentElement.dataset.ready = "yes";
  return view;
}

let drawn = false, shown = null, case_drawn = null;
const embedded = (json) => JSON.parse(document.getElementById(json).textContent);

/// Shows this result and its scene in the place of what was shown: the picture first, then, as soon
/// as that is on the screen, all else. The promise is kept when everything is there.
async function show(result_json, scene_json) {
  const mine = shown = [result_json, scene_json];
  read_result(result_json);
  read_scene(scene_json);
  choose();
  if (drawn) {
    redraw_view();
    await new Promise((done) => requestAnimationFrame(() => setTimeout(done)));
    if (shown !== mine) return;  // something newer came
  }
  const [x, y] = [scrollX, scrollY], focused = document.activeElement?.id;
  const open = new Set([...page.querySelectorAll("details[open] > summary")].map((s) => s.textContent));
  forget_listeners();
  listen(["load_case"], () => show(...shown));
  window.flexopt_report.view = draw();
  for (const summary of page.querySelectorAll("details > summary")) if (open.has(summary.textContent)) summary.parentElement.open = true;
  if (focused && page.contains(document.getElementById(focused))) document.getElementById(focused).focus({preventScroll: true});
  if (drawn) scrollTo(x, y);
  drawn = true;
}

/// For tests, and for pages that show one result after the other: the view, and what the page shows.
window.flexopt_report = {view: null, state, set, show};
if (embedded("result")) show(embedded("result"), embedded("scene"));
