// The 6 × 6 compliance at the stroke shown, and its copies for other programs.
import {converged, drive_units, place_text, stroke_unit} from "./result.js";
import {listen} from "./state.js";
import {action_button, chooser, copy_text, element, number_text, quantity_text, table_of} from "./text.js";
import {point_now} from "./view_panel.js";

const directions = ["ux", "uy", "uz", "rx", "ry", "rz"];
const kinds = [["drive_locked", "drive locked"], ["drive_free", "drive free"]];
const stroke_name = (p) => drive_units ? JSON.stringify(p.strokes) : `${p.stroke} ${stroke_unit}`;

/// Texts of [{name, point, rows}], matrices one after the other.
export const formats = {
  CSV: (list) => list.map(({name, rows}) => `# ${name}\n${rows.map((r) => r.join(",")).join("\n")}\n`).join("\n"),
  NumPy: (list) => list.length === 1
    ? `# ${list[0].name}\nC = np.array([${list[0].rows.map((r) => `[${r.join(", ")}]`).join(",\n              ")}])\n`
    : `stroke = np.array([${list.map((m) => m.point.stroke).join(", ")}])\nC = np.array([\n${list.map(({name, rows}) => `  # ${name}\n  [${rows.map((r) => `[${r.join(", ")}]`).join(",\n   ")}]`).join(",\n")}])\n`,
  Matlab: (list) => list.map(({name, rows}, k) => `% ${name}\nC${list.length > 1 ? `(:,:,${k + 1})` : ""} = [${rows.map((r) => r.join(" ")).join("; ...\n     ")}];\n`).join("\n"),
};

/// All principal support stiffnesses at the stroke shown, with their directions.
export function principal_panel() {
  const points = converged.filter((p) => p.principal_stiffness?.translations?.length);
  if (points.length === 0) return null;
  const place = element("div", {});
  const rows = (point) => [["translations", "translation", "N/m"], ["rotations", "rotation", "N m/rad"]]
    .flatMap(([key, kind, unit]) => (point.principal_stiffness[key] ?? []).map((entry) => ({kind, unit, ...entry})));
  const component = (k) => (row) => number_text(Math.abs(row.direction[k]) < 1e-6 ? 0 : row.direction[k]);
  const draw = () => {
    const point = point_now(points);
    place.replaceChildren(element("p", {class: "soft"}, `Principal support stiffness at ${place_text(point)}, drive locked: along such a direction a force moves O, or a moment turns it, in that same direction.`),
      table_of(rows(point), [
        {name: "Motion", left: true, text: (r) => r.kind}, {name: "Stiffness", text: (r) => quantity_text(r.value, r.unit)},
        ...["x", "y", "z"].map((name, k) => ({name, unit: "of the direction", text: component(k)}))]));
  };
  listen(["stroke"], draw);
  draw();
  return place;
}

export function matrix_panel() {
  const points = converged.filter((p) => p.compliance?.drive_free);
  if (points.length === 0) return null;
  let kind = "drive_locked";
  const caption = element("p", {class: "soft", id: "matrix-place"}), table = element("div", {class: "scroll", tabindex: "0"});
  const entry = (point) => ({point, rows: point.compliance[kind],
    name: `compliance, ${kind.replace("_", " ")}, at the moved O, global axes, rows and columns ${directions.join(" ")}, SI; stroke ${stroke_name(point)}`});
  const draw = () => {
    const point = point_now(points), rows = point.compliance[kind];
    const largest = (a, b) => Math.sqrt(Math.abs(rows[a][a] * rows[b][b]));
    caption.textContent = `At ${place_text(point)}, the computed point next to the stroke shown. Units: m/N, rad/N = m/(N m), rad/(N m).`;
    table.replaceChildren(element("table", {class: "matrix"},
      element("thead", {}, element("tr", {}, element("th", {}), ...directions.map((d) => element("th", {scope: "col"}, d, element("small", {}, d[0] === "u" ? "per N" : "per N m"))))),
      element("tbody", {}, ...rows.map((row, i) => element("tr", {}, element("th", {scope: "row"}, directions[i], element("small", {}, i < 3 ? "m" : "rad")),
        ...row.map((x, j) => element("td", {}, number_text(Math.abs(x) < 1e-9 * largest(i, j) ? 0 : x))))))));
  };
  const choice = chooser("Drive", kinds, kind, (value) => { kind = value; draw(); }, "compliance with the drive");
  const buttons = Object.entries(formats).flatMap(([name, text]) => [
    action_button(`Copy as ${name}`, () => copy_text(text([entry(point_now(points))]))),
    points.length > 1 ? action_button(`all ${points.length} points as ${name}`, () => copy_text(text(points.map(entry)))) : null]);
  listen(["stroke"], draw);
  draw();
  return element("div", {}, caption, element("div", {class: "controls"}, choice, ...buttons.filter(Boolean)), table);
}
