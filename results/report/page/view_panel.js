// The panel around the view: stroke sliders, play, modes, colours, views, the legend, and what is
// under the pointer.
import {max, range, ticks} from "d3";
import {svg_element} from "./charts.js";
import {stress_color} from "./colors.js";
import {allowable, converged, drive_units, load_path, path, result, stroke_unit, undeflected} from "./result.js";
import {designs} from "./scene_data.js";
import {listen, set, state} from "./state.js";
import {action_button, chooser, element, number_text, quantity_text, readable, shown_factor, shown_unit, without_noise} from "./text.js";
import {still_picture} from "./still_picture.js";
import {standard_views, View} from "./view.js";

// What the reader has set, and the canvas: both outlive the result that is shown.
const chosen = {color: "stress", bodies: true, names: null, looking: "3-D", magnified: 1};
let stage = null;

const seconds_of_stroke = 5, turns_of_mode = 0.9, mode_size = 0.07;

/// Converged point of the path next to the stroke shown.
export function point_now(points = converged) {
  let near = points[0];
  for (const p of points) if (Math.abs(p.stroke - state.stroke) < Math.abs(near.stroke - state.stroke)) near = p;
  return near;
}

/// Lists of modes that some point has: [["locked:0", "…"], …].
function mode_options() {
  const options = [["", "none: equilibrium"]];
  const {locked = 0, free = 0} = designs[0]?.modes ?? {};
  for (const [drive, count] of [["locked", locked], ["free", free]])
    for (let k = 0; k < count; ++k) {
      const mode = (point_now()?.modes ?? []).filter((m) => m.drive === drive)[k];
      if (mode) options.push([`${drive}:${k}`, `drive ${drive} ${k + 1}: ${quantity_text(mode.frequency, "Hz")}, ${readable(mode.kind)}`]);
    }
  return options;
}

function stroke_sliders() {
  const sorted = [...converged].sort((a, b) => a.stroke - b.stroke);
  if (!drive_units) {
    const low = sorted[0].stroke, high = sorted.at(-1).stroke, range = high - low || 1;
    const slider = element("input", {type: "range", id: "stroke", min: 0, max: 1000, step: 1, "aria-label": load_path ? "load factor" : "stroke", ...(high > low ? {} : {disabled: true}),
      oninput: (event) => set({stroke: low + range * event.target.value / 1000, playing: false})});
    const text = element("output", {id: "stroke-text", for: "stroke"});
    const follow = () => {
      slider.value = Math.round(1000 * (state.stroke - low) / range);
      text.textContent = quantity_text(without_noise(state.stroke, Math.max(Math.abs(low), Math.abs(high)) * 1e6), stroke_unit);
      slider.setAttribute("aria-valuetext", text.textContent);
    };
    listen(["stroke"], follow);
    follow();
    return [element("label", {class: "slider"}, element("span", {}, load_path ? "Load factor" : "Stroke"), slider, text)];
  }
  // Each slider of several drives walks through the strokes that were computed; the nearest
  // computed point is shown.
  const names = Object.keys(drive_units);
  const values = names.map((name) => [...new Set(sorted.map((p) => p.strokes[name]))].sort((a, b) => a - b));
  const wanted = names.map((name) => point_now(sorted)?.strokes[name] ?? 0);
  const nearest = () => sorted.reduce((best, p) => distance(p) < distance(best) ? p : best);
  const distance = (p) => names.reduce((sum, name, k) => sum + ((p.strokes[name] - wanted[k]) / (values[k].at(-1) - values[k][0] || 1)) ** 2, 0);
  return names.map((name, k) => {
    const slider = element("input", {type: "range", id: `stroke-${k}`, min: 0, max: values[k].length - 1, step: 1, "aria-label": `stroke of ${name}`,
      oninput: (event) => { wanted[k] = values[k][event.target.value]; set({stroke: nearest().stroke, playing: false}); }});
    const text = element("output", {});
    const follow = () => {
      const now = point_now(sorted);
      wanted[k] = now.strokes[name];
      slider.value = values[k].indexOf(wanted[k]);
      text.textContent = quantity_text(wanted[k], drive_units[name]);
    };
    listen(["stroke"], follow);
    follow();
    return element("label", {class: "slider"}, element("span", {}, name), slider, text);
  });
}

/// Moves the stroke or the phase of the mode while the page plays.
const player = {last: null, run: 0};
function play_on() {
  const sorted = () => converged.map((p) => p.stroke).sort((a, b) => a - b);
  const step = (now) => {
    if (!state.playing && !state.mode) { player.last = null; return; }
    const strokes = sorted(), low = strokes[0], high = strokes.at(-1);
    const dt = player.last === null ? 0 : Math.min(0.1, (now - player.last) / 1000);
    player.last = now;
    const fresh = {phase: state.mode ? state.phase + 2 * Math.PI * turns_of_mode * dt : 0};
    if (state.playing) {
      player.run += dt / seconds_of_stroke;
      const x = low + (high - low) * (0.5 - 0.5 * Math.cos(2 * Math.PI * player.run));
      fresh.stroke = drive_units ? strokes[Math.floor(player.run * strokes.length) % strokes.length] : x;
    }
    set(fresh);
    requestAnimationFrame(step);
  };
  listen(["playing", "mode"], () => {
    if (player.last !== null) return;
    const strokes = sorted(), low = strokes[0], high = strokes.at(-1);
    if (state.playing) player.run = Math.acos(Math.min(1, Math.max(-1, 1 - 2 * (state.stroke - low) / (high - low || 1)))) / (2 * Math.PI);
    requestAnimationFrame(step);
  });
}

/// Words about the part under the pointer.
function part_text(hit) {
  const {figure, name, kind, solid, vertex} = hit, {design} = figure;
  const lines = [name];
  if (kind === "leaf") {
    const {leaf} = solid;
    lines.push(leaf.round ? `${quantity_text(leaf.length, "m")} long, diameter ${quantity_text(leaf.thickness, "m")}`
      : `${quantity_text(leaf.length, "m")} × ${quantity_text(leaf.width, "m")} × ${quantity_text(leaf.thickness, "m")}`);
    if (!undeflected) lines.push(`here ${quantity_text(solid.stress[solid.point_of_vertex[vertex]], "Pa")}`);
  }
  if (kind === "elastic" && !undeflected) lines.push(`here ${quantity_text(solid.stress[vertex], "Pa")}`);
  if (kind === "body") {
    const now = design.bodies_now.subarray(6 * hit.body, 6 * hit.body + 6), names = ["x", "y", "z"];
    const size = Math.hypot(now[0], now[1], now[2]), turn = Math.hypot(now[3], now[4], now[5]);
    if (design.bodies[hit.body].mass) lines.push(quantity_text(design.bodies[hit.body].mass, "kg"));
    if (undeflected) return lines;
    lines.push(names.map((c, k) => `u${c} ${quantity_text(without_noise(now[k], size * 1e4), "m")}`).join(", "));
    lines.push(names.map((c, k) => `r${c} ${quantity_text(without_noise(now[3 + k], turn * 1e4), "rad")}`).join(", "));
  }
  return lines;
}

/// The colours as a bar with numbers. `top` is where they end [Pa].
function stress_legend(top) {
  const [unit, factor] = [shown_unit("Pa"), shown_factor("Pa")], width = 240, left = 8, end = top * factor;
  const at = (v) => left + width * v / end;
  const bar = svg_element("svg", {viewBox: "0 0 262 46", width: 262, height: 46, role: "img", "aria-label": `colours from 0 to ${number_text(end)} ${unit}`},
    svg_element("defs", {}, svg_element("linearGradient", {id: "stress-ramp"}, ...range(0, 1.001, 0.05).map((t) => svg_element("stop", {offset: t, "stop-color": stress_color(t)})))),
    svg_element("text", {x: left, y: 11, "font-weight": 500}, `von Mises stress [${unit}]`),
    svg_element("rect", {x: left, y: 16, width, height: 10, fill: "url(#stress-ramp)"}),
    ...ticks(0, end, 4).flatMap((v) => [svg_element("line", {x1: at(v), x2: at(v), y1: 16, y2: 30, stroke: "currentColor"}), svg_element("text", {x: at(v), y: 42, "text-anchor": v === 0 ? "start" : "middle"}, number_text(v))]));
  return element("div", {class: "stress-legend", id: "stress-legend"}, bar,
    element("span", {class: "soft"}, `largest ${quantity_text(top, "Pa")}${allowable ? `, allowed ${quantity_text(allowable, "Pa")}` : ""}`));
}

const shown_designs = () => [designs[0], designs[state.beside]].filter(Boolean);
/// Largest stress of the designs shown: that of the result, whose places are closer than the mesh that
/// is drawn, where it is known.
const top_stress = () => Math.max(1, max(shown_designs(), (d) => max(d.path, (p) => p.max_stress) ?? d.largest_stress()));
const stressed = () => chosen.color === "stress" && !undeflected, names_shown = () => chosen.names ?? undeflected;
const pose = () => stage.view.pose({stroke: state.stroke, mode: state.mode, amount: mode_size * designs[0].size * Math.sin(state.phase),
  magnified: chosen.magnified, top: stressed() ? top_stress() : null, chosen: state.leaf, show_bodies: chosen.bodies, show_names: names_shown()});

/// Draws the designs of a scene that was just read, before the rest of the page follows. The
/// direction stays; what does not fit is moved into the picture.
export function redraw_view() {
  if (!stage?.view || designs.length === 0 || converged.length === 0) return;
  const {view} = stage;
  const dispose = view.forget();
  view.show(shown_designs());
  if (view.misfits() && !view.turned) view.look(chosen.looking);
  pose();
  view.draw();
  dispose();
}

/// How much larger than true the motion is drawn: up to a third of the mechanism.
function magnifier() {
  const moved = max(shown_designs(), (d) => d.largest_motion()), most = moved > 0 ? 0.33 * designs[0].size / moved : 1;
  chosen.magnified = Math.min(chosen.magnified, Math.max(1, most));
  if (undeflected || !(most > 1.5)) return null;
  const text = element("output", {for: "magnified"});
  const tell = () => { text.textContent = chosen.magnified > 1 ? `× ${number_text(chosen.magnified, 2)}` : "true scale"; };
  const slider = element("input", {type: "range", id: "magnified", min: 0, max: 100, value: 100 * Math.log(chosen.magnified) / Math.log(most), "aria-label": "motion drawn larger than true",
    oninput: (event) => { chosen.magnified = most ** (event.target.value / 100); tell(); pose(); }});
  tell();
  return element("div", {class: "controls"}, element("label", {class: "slider"}, element("span", {}, "Motion"), slider, text));
}

/// The canvas with its view, and what is told under the pointer. Made once.
function make_stage() {
  const canvas = element("canvas", {tabindex: "0", role: "img", "aria-label": "mechanism; arrow keys turn it, plus and minus zoom"});
  const place = element("div", {class: "canvas"}, canvas), tip = element("div", {class: "tip", hidden: true}), labels = element("div", {class: "slots"});
  stage = {place, labels, view: null};
  try {
    stage.view = new View(canvas);
  } catch {
    return;  // view_panel draws a still picture
  }
  const {view} = stage;
  place.append(labels, tip);
  canvas.addEventListener("pointermove", (event) => {
    if (event.buttons) { tip.hidden = true; return; }
    const hit = view.pick(event.clientX, event.clientY);
    tip.hidden = !hit;
    canvas.style.cursor = hit?.kind === "leaf" ? "pointer" : "grab";
    if (!hit) return;
    const box = place.getBoundingClientRect();
    tip.replaceChildren(...part_text(hit).map((line, k) => element(k === 0 ? "strong" : "div", {}, line)));
    tip.style.left = `${Math.max(4, Math.min(event.clientX - box.left + 14, box.width - tip.offsetWidth - 4))}px`;
    tip.style.top = `${Math.max(4, Math.min(event.clientY - box.top + 14, box.height - tip.offsetHeight - 4))}px`;
  });
  canvas.addEventListener("pointerleave", () => { tip.hidden = true; });
  let pressed = null;
  canvas.addEventListener("pointerdown", (event) => { pressed = [event.clientX, event.clientY]; });
  canvas.addEventListener("click", (event) => {
    if (pressed && Math.hypot(event.clientX - pressed[0], event.clientY - pressed[1]) > 4) return;  // a drag
    const hit = view.pick(event.clientX, event.clientY);
    if (hit?.kind === "leaf") set({leaf: hit.name === state.leaf ? null : hit.name});
  });
}

/// The view with its panel; a text where there is nothing to draw or no WebGL.
export function view_panel() {
  const panel = element("section", {class: "viewer", id: "viewer", "aria-label": "the mechanism in three dimensions"});
  if (designs.length === 0 || (converged.length === 0 && !undeflected)) {
    panel.append(element("p", {class: "soft"}, result.status === "running" ? "The picture comes when the run is finished." : "No deformed shapes in this result, so no picture."));
    return {panel, view: null};
  }
  if (!stage) make_stage();
  const {view, labels} = stage;
  panel.append(stage.place);
  if (!view) {
    stage.place.replaceChildren(still_picture(designs[0], state.stroke));
    panel.append(element("p", {class: "soft hint", id: "no-webgl"}, "This browser has no WebGL: the mechanism is drawn as it stands at the end of its stroke, and cannot be turned. All plots and tables work without it."));
    return {panel, view};
  }
  const legend_place = element("div", {});
  const arrange = (look) => {
    view.show(shown_designs());
    labels.replaceChildren(...(shown_designs().length > 1 ? shown_designs() : []).map((d) => element("span", {}, d.label)));
    legend_place.replaceChildren(stressed() ? stress_legend(top_stress()) : element("span"));
    if (look) view.look(chosen.looking);
    pose();
  };

  const play = element("button", {type: "button", id: "play", "aria-pressed": "false", onclick: () => set({playing: !state.playing})}, "▶ Play");
  listen(["playing"], () => { play.textContent = state.playing ? "❚❚ Pause" : "▶ Play"; play.setAttribute("aria-pressed", state.playing); });
  const modes = chooser("Mode", mode_options(), state.mode ? `${state.mode.drive}:${state.mode.index}` : "", (value) => {
    const [drive, index] = value.split(":");
    set({mode: value ? {drive, index: Number(index)} : null, phase: 0});
  });
  const list = modes.querySelector("select");
  list.id = "mode";
  listen(["stroke"], () => {  // the frequencies change along the stroke
    const texts = new Map(mode_options());
    for (const option of list.options) if (texts.has(option.value) && option.textContent !== texts.get(option.value)) option.textContent = texts.get(option.value);
  });
  const leaf_list = chooser("Leaf", [["", "none"], ...designs[0].leaves.map((l) => [l.name, l.name])], state.leaf ?? "", (value) => set({leaf: value || null}));
  leaf_list.querySelector("select").id = "leaf";
  listen(["leaf"], () => { leaf_list.querySelector("select").value = state.leaf ?? ""; });
  const beside = designs.length > 1 ? chooser("Beside it", [["", "nothing"], ...designs.slice(1).map((d, k) => [String(k + 1), d.label])],
    state.beside === null ? "" : String(state.beside), (value) => set({beside: value ? Number(value) : null})) : null;
  if (beside) {
    beside.querySelector("select").id = "beside";
    listen(["beside"], () => { beside.querySelector("select").value = state.beside === null ? "" : String(state.beside); });
  }
  const colors = chooser("Colour", [["stress", "stress"], ["plain", "plain"]], chosen.color, (value) => { chosen.color = value; arrange(true); });
  colors.querySelector("select").id = "color";
  const views = element("div", {class: "views", role: "group", "aria-label": "standard views"},
    ...Object.keys(standard_views).map((name) => element("button", {type: "button", onclick: () => { chosen.looking = name; view.look(name); }}, name)));
  const upward = chooser("Up", ["x", "y", "z"].map((axis) => [axis, axis]), view.upward, (axis) => { view.upward = axis; view.look(chosen.looking); });
  upward.querySelector("select").id = "up";
  const turning = element("input", {type: "checkbox", id: "turntable", checked: view.turntable, onchange: (event) => { view.turntable = event.target.checked; }});
  const bodies = element("input", {type: "checkbox", id: "bodies", checked: chosen.bodies, onchange: (event) => { chosen.bodies = event.target.checked; pose(); }});
  const names = element("input", {type: "checkbox", id: "names", checked: names_shown(), onchange: (event) => { chosen.names = event.target.checked; pose(); }});
  const copy = action_button("Copy as PNG", async () => {
    const picture = await view.picture();
    try {
      await navigator.clipboard.write([new ClipboardItem({"image/png": picture})]);
    } catch {
      return false;
    }
  });
  copy.id = "copy-png";
  const save = action_button("Save PNG", async () => {
    const link = element("a", {href: URL.createObjectURL(await view.picture()), download: "mechanism.png"});
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 10000);
  }, "saved");
  panel.append(
    element("div", {class: "controls"}, ...(undeflected ? [] : stroke_sliders()), converged.length > 1 ? play : null),
    magnifier(),
    element("div", {class: "controls"}, list.options.length > 1 ? modes : null, undeflected ? null : colors, designs[0].leaves.length ? leaf_list : null, beside),
    element("div", {class: "controls"}, views, upward, element("label", {class: "choice"}, turning, "turntable"), element("label", {class: "choice"}, bodies, "bodies"), element("label", {class: "choice"}, names, "names"), copy, save),
    legend_place,
    element("p", {class: "soft hint"}, "Drag or use the arrow keys to turn, wheel or + and − to zoom" + (undeflected ? "" : ", click a leaf for its plots") + ". Hatched: ground."));

  listen(["stroke", "mode", "phase", "leaf"], pose);
  listen(["beside"], () => arrange(true));
  play_on();
  arrange(view.figures.length === 0);
  return {panel, view};
}
