// Plots of the chosen leaf: its stress along its length now, and its largest stress over the stroke.
import {range} from "d3";
import {line_chart} from "./charts.js";
import {converged, result, shown_stroke, stroke_label} from "./result.js";
import {designs} from "./scene_data.js";
import {listen, state} from "./state.js";
import {element, quantity_text, readable} from "./text.js";

function along_chart(design, leaf) {
  design.pose(state.stroke, null, 0);
  const across = range(leaf.points_across);
  const largest = (i) => Math.max(...across.map((j) => design.shown_stress[leaf.first + j * leaf.points_along + i]));
  return line_chart({title: `Stress along ${leaf.name}`, note: "largest across the width, larger of both surfaces, at the stroke shown",
    x: "from base to tip [mm]", y: "stress [MPa]",
    lines: [{name: "", color: "var(--accent)", points: leaf.along.map((s, i) => ({x: 1e3 * s * leaf.length, y: 1e-6 * Math.max(0, largest(i))}))}]});
}

function stroke_chart(design, leaf) {
  return line_chart({title: `Largest stress of ${leaf.name}`, note: "at the points of its mesh; the check of the result looks between them too", x: stroke_label, y: "stress [MPa]", linked: true,
    lines: [{name: "", color: "var(--accent)", points: design.order.map(({k, stroke}) => ({x: shown_stroke(stroke), y: 1e-6 * design.largest_stress(leaf, k)}))}]});
}

/// A place that shows the leaf chosen in the view.
export function leaf_panel() {
  const place = element("div", {id: "leaf-plots", class: "leaf-plots", "aria-live": "polite"});
  const design = designs[0];
  if (!design || converged.length === 0) return place;
  const along = element("div", {}), stroke = element("div", {}), facts = element("p", {class: "soft"});
  const current = () => design.leaves.find((l) => l.name === state.leaf);
  const redraw = () => { const leaf = current(); if (leaf) along.replaceChildren(along_chart(design, leaf)); };
  const show = () => {
    const leaf = current();
    if (!leaf) { place.replaceChildren(); return; }
    const own = (result.leaves ?? []).find((l) => l.name === leaf.name);
    facts.textContent = `${quantity_text(leaf.length, "m")} long, ${leaf.round ? `diameter ${quantity_text(leaf.thickness, "m")}` : `${quantity_text(leaf.width, "m")} wide, ${quantity_text(leaf.thickness, "m")} thick`}`
      + (own?.validity?.needed ? `; needs the theory of a ${readable(own.validity.needed)}` : "") + (own?.allowable_stress ? `; allowed ${quantity_text(own.allowable_stress, "Pa")}` : "") + ".";
    stroke.replaceChildren(stroke_chart(design, leaf));
    redraw();
    place.replaceChildren(element("h3", {}, `Chosen: ${leaf.name}`), facts, along, stroke);
  };
  listen(["leaf"], show);
  let waiting = false;
  listen(["stroke"], () => {
    if (!current() || waiting) return;
    waiting = true;
    requestAnimationFrame(() => { waiting = false; redraw(); });
  });
  show();
  return place;
}
