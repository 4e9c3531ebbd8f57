// Deformed leaves as coloured facets: seen along z, and from a corner that the mouse can turn.

/// Screen axes of an orthographic view; z is up in the turned view.
function view_axes(azimuth, elevation) {
  const [ca, sa, ce, se] = [Math.cos(azimuth), Math.sin(azimuth), Math.cos(elevation), Math.sin(elevation)];
  return {right: [-sa, ca, 0], up: [-se * ca, -se * sa, ce], towards: [ce * ca, ce * sa, se]};
}
const along_z = {right: [1, 0, 0], up: [0, 1, 0], towards: [0, 0, 1]};
const dot3 = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

/// Colours of low stress start at blue: turbo's own black would vanish in the dark.
const stress_color = (t) => d3.interpolateTurbo(0.1 + 0.9 * t);

/// Quarters of every element of a leaf, bilinear, with their mean stress.
function facets(leaf) {
  const n = leaf.points_along, made = [];
  const value = (list, i, j) => {  // at half steps, bilinear
    const ends = (x) => [Math.floor(x), Math.ceil(x)];
    const picked = ends(i).flatMap((a) => ends(j).map((b) => list[b * n + a]));
    return Array.isArray(picked[0]) ? middle(picked) : d3.mean(picked);
  };
  for (let j = 0; j < leaf.points_across - 1; j += 0.5)
    for (let i = 0; i < n - 1; i += 0.5) {
      const corners = [[i, j], [i + 0.5, j], [i + 0.5, j + 0.5], [i, j + 0.5]];
      made.push({corners: corners.map(([a, b]) => value(leaf.deflected, a, b)),
                 stress: d3.mean(corners, ([a, b]) => value(leaf.von_mises, a, b))});
    }
  return made;
}

/// The clamped edges: at the base and at the tip.
function end_edges(leaf) {
  const edge = (i) => d3.range(leaf.points_across).map((j) => leaf.deflected[j * leaf.points_along + i]);
  return {base: edge(0), tip: edge(leaf.points_along - 1)};
}

function outline(leaf) {
  const [n, m] = [leaf.points_along, leaf.points_across];
  const along = (j) => d3.range(n).map((i) => leaf.deflected[j * n + i]);
  const {base, tip} = end_edges(leaf);
  return [...along(0), ...tip, ...along(m - 1).reverse(), ...base.reverse()];
}

const middle = (points) => [0, 1, 2].map((k) => d3.mean(points, (p) => p[k]));

/// All extents of all shapes on the screen, so that the panels share one true scale.
function screen_box(shapes, axes) {
  const points = shapes.flatMap((shape) => [...shape.leaves.flatMap((leaf) => leaf.deflected),
                                            ...(shape.reference ? [shape.reference] : [])]);
  const [x0, x1] = d3.extent(points, (p) => dot3(p, axes.right));
  const [y0, y1] = d3.extent(points, (p) => dot3(p, axes.up));
  const size = Math.max(x1 - x0, y1 - y0);
  return {x0: x0 - 0.06 * size, x1: x1 + 0.06 * size, y0: y0 - 0.06 * size, y1: y1 + 0.06 * size};
}

function draw_shape(svg, shape, rest, box, axes, color) {
  const width = 360, scale = width / (box.x1 - box.x0), height = (box.y1 - box.y0) * scale;
  const screen = (p) => [(dot3(p, axes.right) - box.x0) * scale, (box.y1 - dot3(p, axes.up)) * scale];
  const path = (points, close) => "M" + points.map((p) => screen(p).map((v) => v.toFixed(2)).join(",")).join("L") + (close ? "Z" : "");
  const drawing = d3.select(svg).attr("viewBox", `0 0 ${width} ${height.toFixed(1)}`);
  drawing.selectAll("*").remove();
  const add = (d, style) => {
    const made = drawing.append("path").attr("d", d).attr("fill", "none");
    for (const [name, value] of Object.entries(style)) made.attr(name, value);
  };
  if (rest && rest !== shape)
    for (const leaf of rest.leaves)
      add(path(outline(leaf), true), {stroke: "var(--metal)", "stroke-dasharray": "3 3", "stroke-width": 0.8});
  if (shape.reference)
    for (const leaf of shape.leaves)
      add(path([middle(end_edges(leaf).tip), shape.reference]), {stroke: "var(--metal)", "stroke-width": 1});
  const painted = shape.leaves.flatMap(facets);
  const depth = (facet) => d3.mean(facet.corners, (p) => dot3(p, axes.towards));
  for (const facet of d3.sort(painted, depth)) {  // the far ones first
    const fill = color(facet.stress);
    add(path(facet.corners, true), {fill, stroke: fill, "stroke-width": axes === along_z ? 2.4 : 0.6, "stroke-linejoin": "round"});
  }
  for (const leaf of shape.leaves) {
    const {base, tip} = end_edges(leaf);
    add(path(base), {stroke: "var(--ink)", "stroke-width": 4, "stroke-linecap": "round"});
    add(path(tip), {stroke: "var(--metal)", "stroke-width": 3, "stroke-linecap": "round"});
  }
  if (shape.reference) {
    const [x, y] = screen(shape.reference);
    drawing.append("circle").attr("cx", x).attr("cy", y).attr("r", 3.5).attr("fill", "var(--accent)");
    drawing.append("text").attr("x", x + 6).attr("y", y - 5).attr("font-size", 12).attr("fill", "currentColor").text("O");
  }
}

/// Two rows of panels, one column for each shape.
function shape_panels(shapes, stroke_unit) {
  const rest = d3.least(shapes, (shape) => Math.abs(shape.stroke));
  const top = Math.max(d3.max(shapes, (shape) => d3.max(shape.leaves, (leaf) => d3.max(leaf.von_mises))), 1);
  const color = d3.scaleSequential([0, top], stress_color).clamp(true);
  const stress_of = (shape) => d3.max(shape.leaves, (leaf) => d3.max(leaf.von_mises));
  const turned = {azimuth: -1.9, elevation: 0.55};
  const grid = element("div", {class: "shapes"});
  grid.style.gridTemplateColumns = `repeat(${shapes.length}, minmax(0, 26rem))`;
  const panels = [];
  for (const solid of [false, true])
    for (const shape of shapes) {
      const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
      if (solid) svg.setAttribute("class", "turnable");
      panels.push({svg, shape, solid});
      grid.append(element("figure", {}, element("figcaption", {},
        solid ? "turned view" : `stroke ${quantity_text(shape.stroke, stroke_unit)}, at most ${quantity_text(without_noise(stress_of(shape), top), "Pa", 3)}`), svg));
    }
  const draw = () => {
    for (const solid of [false, true]) {
      const axes = solid ? view_axes(turned.azimuth, turned.elevation) : along_z;
      const box = screen_box(shapes, axes);
      for (const panel of panels.filter((p) => p.solid === solid))
        draw_shape(panel.svg, panel.shape, rest, box, axes, color);
    }
  };
  for (const panel of panels.filter((p) => p.solid))
    d3.select(panel.svg).call(d3.drag().on("drag", (event) => {
      turned.azimuth -= 0.01 * event.dx;
      turned.elevation = Math.min(1.57, Math.max(-1.57, turned.elevation + 0.01 * event.dy));
      draw();
    }));
  draw();
  const legend = Plot.legend({color: {type: "linear", domain: [0, top * 1e-6], interpolate: stress_color,
                                      label: "von Mises stress of the leaf surfaces [MPa]"}, width: 320});
  return element("div", {}, legend, grid);
}
