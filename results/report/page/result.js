// The result of the run, and what the whole page wants to know of it. Quantities are those of the
// result's own table that some point has a value of.
import {least, max} from "d3";
import {heading, number_text, quantity_text, shown_unit, shown_factor} from "./text.js";

/// As it came; a job with several load cases has the numbers of all of them.
export let whole = {};
/// Load cases of a job with several, and the one that the page shows: that of its address.
export let cases = {}, shown_case = null;
export let result = {}, job = {}, optimum = null, comparison = null;
/// Designs that a job lists; all else in the result is then of the best, or of the first.
export let listed = [];
/// Drives with names: the plots then show their points one after the other.
export let drive_units = null;
export let path = [], converged = [], quantities = [], supports = [];
export let drive = "", stroke_unit = "", stroke_label = "";
/// What the material allows where the stress is largest; null where that is not one number for all points.
export let allowable = null;
/// Nothing was computed: the page shows the mechanism as designed.
export let undeflected = false;
export let load_path = false;  // nothing is driven: stroke is the load factor

function job_of_case() {
  const {name, ...own} = [whole.job?.cases ?? []].flat().find((c) => c.name === shown_case) ?? {}, all = {...whole.job};
  if (own.stroke) delete all.load_path;
  if (own.load_path) delete all.stroke;
  return {...all, ...own};
}

/// Makes this result the one that the page is about.
export function read_result(json) {
  whole = json;
  cases = whole.cases ?? {};
  const asked = /case=([^&]+)/.exec(location.hash)?.[1];
  shown_case = Object.keys(cases).find((name) => encodeURIComponent(name) === asked) ?? whole.case ?? null;
  result = shown_case ? {...whole, ...cases[shown_case], status: whole.status, message: whole.message} : whole;
  job = shown_case ? job_of_case() : result.job ?? {};
  undeflected = result.status === "undeflected";
  optimum = result.optimum ?? null;
  if (optimum?.verified?.cases) optimum.verified.path = optimum.verified.cases[shown_case]?.path ?? [];
  comparison = result.comparison ?? null;
  listed = result.ranking ?? result.designs ?? [];
  drive_units = typeof result.units?.stroke === "object" ? result.units.stroke : null;
  path = with_one_stroke(result.path ?? []);
  converged = path.filter((point) => point.status === "converged");
  drive = drive_units ? "" : result.conventions?.drive ?? "";
  stroke_unit = drive_units ? "1" : result.units?.stroke ?? "";
  load_path = job.load_path !== undefined;
  stroke_label = load_path ? "load factor [1]" : drive_units ? "point [1]"
    : `stroke ${/^[ur][xyz]$/.test(drive) ? drive : ""} [${shown_unit(stroke_unit)}]`.replace("  ", " ");
  const allowed = new Set(converged.map((p) => p.max_stress_place?.allowable_stress ?? null));
  allowable = allowed.size === 1 ? [...allowed][0] : null;
  quantities = (result.quantities ?? []).map((q) => ({...q, value: (point) => value_at(q, point)}))
    .filter((q) => converged.some((p) => q.value(p) !== null));
  supports = quantities_of("support_stiffness").map((q) => q.at[1]);
}

/// Gives the points of a path one number as stroke: with named drives their place in the path.
export function with_one_stroke(points) {
  if (drive_units) points.forEach((point, k) => { point.strokes ??= point.stroke; point.stroke = k; });
  return points;
}
export const by_stroke = (points) => [...points].sort((a, b) => a.stroke - b.stroke);
export const shown_stroke = (x) => x * shown_factor(stroke_unit);
export const load_unit_of = (name) => (result.units?.drive_load ?? {})[name] ?? result.units?.drive_load ?? "";

/// Value of a quantity at a point of a path, or null.
export const value_at = (quantity, point) => {
  const value = quantity.at.reduce((v, key) => v?.[key], point);
  return typeof value === "number" ? value : null;
};
/// Estimated error of a quantity at a point, in its unit or relative; null where there is none.
export const error_at = (quantity, point, of = "absolute") => {
  const value = quantity.at.reduce((v, key) => v?.[key], point.estimated_error?.[of]);
  return typeof value === "number" ? value : null;
};
export const largest_of = (q, points = converged) => max(points, (p) => Math.abs(q.value(p) ?? 0)) ?? 0;
/// Quantities of one key, as all directions of the support stiffness.
export const quantities_of = (key) => quantities.filter((q) => q.at[0] === key);

export const strokes_text = (strokes) => Object.entries(strokes).map(([name, s]) => `${name} ${quantity_text(s, drive_units[name])}`).join(", ");
/// "at 20°": where a point is.
export const place_text = (point) => drive_units ? strokes_text(point.strokes)
  : `${load_path ? "load factor " : ""}${quantity_text(point.stroke, stroke_unit)}`;
export const at_stroke = (point) => `at ${place_text(point)}`;
/// The leaf or the elastic body that a stress is in.
export const part_of = (place) => place?.leaf ?? place?.elastic_body ?? "";
/// The stress of a point as a share of what the material of its part allows, where that is largest; null where no material tells.
export const stress_share = ({allowable_stress_place: place}) => place ? place.stress / place.allowable_stress : null;
/// The converged point of least value.
export const least_at = (value) => least(converged.filter((p) => typeof value(p) === "number"), value);
export const all_leaves_full = () => converged.every((p) => (p.leaves ?? [{}]).every((leaf) => leaf.model === "full"));
export const rest_point = () => least(converged, (p) => drive_units
  ? max(Object.values(p.strokes), Math.abs) : Math.abs(p.stroke));

/// Units of parameters are those of the result's list.
export const parameter_text = (name, value, digits = 4) => quantity_text(value, result.units?.parameters?.[name] ?? "", digits);
/// Value of an objective or a constraint; "SI" is a formula of the user without a known unit.
export const goal_text = (goal, value, digits = 4) => goal.unit === "SI" ? number_text(value, digits) : quantity_text(value, goal.unit, digits);
export const goal_factor = (goal) => goal.unit === "SI" ? 1 : shown_factor(goal.unit);
export const goal_unit = (goal) => goal.unit === "SI" ? "SI" : shown_unit(goal.unit);
/// "lowest parasitic frequency over the stroke": an objective or a constraint in words.
export const goal_name = (goal) => `${goal.name ?? ""}${goal.as ? `, ${goal.under === "assembly_tolerances" ? "worst assembly" : goal.as === "worst" ? "worst within tolerances" : goal.as}` : ""}`;
export {heading};
