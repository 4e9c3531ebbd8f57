// The page answers: slider, play, mode, leaf, plots, brush, keyboard, dark mode, copies.
//   node test_moves.mjs FOLDER
import {join} from "node:path";
import {checker, launch, need_chromium, open, pause, picture} from "./browser.mjs";

need_chromium();
const folder = process.argv[2], {check, finish} = checker(), browser = await launch();
const show = (name, options) => open(browser, join(folder, name, "report.html"), options);
const state = (page) => page.evaluate(() => ({...window.flexopt_report.state}));
const text_of = (page, selector) => page.$eval(selector, (e) => e.textContent);

/// Does something and says whether pixels changed.
async function changes(page, act) {
  const before = (await picture(page)).hash;
  await act();
  for (let k = 0; k < 30; ++k) {  // the machine may be busy
    await pause(100);
    if ((await picture(page)).hash !== before) return true;
  }
  return false;
}

/// Does something with a page, which makes no error.
async function on(name, without_error, act) {
  const {page, faults} = await show(name);
  await act(page);
  check(faults.length === 0, without_error, faults);
  await page.close();
}

await on("evaluate", "all of it without an error", async (page) => {  // an evaluation
  const slide = (value) => page.$eval("#stroke", (e, v) => { e.value = v; e.dispatchEvent(new Event("input")); }, value);
  check(await changes(page, () => slide(0)), "the slider moves the mechanism");
  check(await text_of(page, "#stroke-text") === "−15 mm", "and shows its stroke", await text_of(page, "#stroke-text"));
  await slide(500);
  check(Math.abs((await state(page)).stroke) < 1e-9, "its middle is the undeflected state", (await state(page)).stroke);
  check(await text_of(page, "#stroke-text") === "0 mm", "shown as zero", await text_of(page, "#stroke-text"));

  // At a computed point the drawn leaf is the computed one: O of the guide is the mean of its tips.
  const [tips, O] = await page.evaluate(() => {
    const {view, state} = window.flexopt_report, result = JSON.parse(document.getElementById("result").textContent);
    const point = result.path.at(-1), {design, solids} = view.figures[0];
    design.pose(point.stroke, null, 0);
    solids.forEach((s) => s.update(design, null, {r: 0, g: 0, b: 0}));
    const middles = solids.map((s) => s.edge(1).middle);
    return [[middles[0].x / 2 + middles[1].x / 2, middles[0].y / 2 + middles[1].y / 2], design.bodies[0].reference.map((x, k) => x + point.displacement[k])];
  });
  check(Math.hypot(tips[0] - O[0], tips[1] - O[1]) < 1e-6, "the drawn leaves end at the computed body", [tips, O]);
  const thickness = await page.evaluate(() => {
    const {solids} = window.flexopt_report.view.figures[0], p = solids[0].geometry.attributes.position, n = solids[0].nx * solids[0].ny;
    return Math.hypot(p.getX(5) - p.getX(n + 5), p.getY(5) - p.getY(n + 5), p.getZ(5) - p.getZ(n + 5));
  });
  check(Math.abs(thickness - 0.5e-3) < 1e-8, "with their true thickness", thickness);

  check(await changes(page, () => page.click("#play").then(() => pause(500))), "play moves the mechanism");
  check((await state(page)).playing, "and goes on");
  await page.click("#play");
  const stopped = (await state(page)).stroke;
  await pause(150);
  check((await state(page)).stroke === stopped, "until it is stopped");

  const modes = await page.$$eval("#mode option", (list) => list.map((o) => o.value));
  check(modes.filter((m) => m.startsWith("locked")).length === 4 && modes.filter((m) => m.startsWith("free")).length === 4, "all modes are offered", modes);
  check(await changes(page, () => page.select("#mode", "free:0").then(() => pause(350))), "a mode moves the mechanism");
  const [phase] = [(await state(page)).phase];
  await pause(200);
  check((await state(page)).phase > phase, "and is animated");
  // In the drive's mode of the guide the body moves along y, and the leaves' tips with it.
  const share = await page.evaluate(() => {
    const {design} = window.flexopt_report.view.figures[0], m = {drive: "free", index: 0};
    design.pose(0, null, 0);
    const before = Array.from(design.positions), still = Array.from(design.bodies_now), at = design.leaves[0].points_along - 1;
    design.pose(0, m, 1e-3);
    const body = Array.from(design.bodies_now, (x, k) => x - still[k]);
    const O = design.bodies[0].reference, r = [0, 1, 2].map((c) => before[3 * at + c] - O[c]), w = body.slice(3, 6);
    const turned = [w[1] * r[2] - w[2] * r[1], w[2] * r[0] - w[0] * r[2], w[0] * r[1] - w[1] * r[0]];
    return {body: [body[0], body[1], body[2]], rigid: turned.map((x, c) => x + body[c]), tip: [0, 1, 2].map((c) => design.positions[3 * at + c] - before[3 * at + c])};
  });
  check(Math.abs(share.body[1]) > 0.9e-3 && Math.hypot(share.body[0], share.body[2]) < 0.02e-3, "the drive's mode is along the drive", share);
  check(Math.hypot(...share.tip.map((x, c) => x - share.rigid[c])) < 1e-7, "leaf and body go together", share);
  await page.select("#mode", "");
  await page.evaluate(() => scrollTo(0, 0));

  // Pointing at a stroke in a plot.
  await page.waitForSelector(".linked svg");
  const chart = await page.$(".linked > svg");
  await chart.scrollIntoView();
  const box = await chart.boundingBox();
  check(await changes(page, () => page.mouse.move(box.x + 0.85 * box.width, box.y + 0.5 * box.height)), "pointing at a plot moves the mechanism");
  const pointed = (await state(page)).stroke;
  check(pointed > 0.008 && pointed < 0.015, "to the stroke pointed at", pointed);
  const lines = await page.$$eval(".linked", (all) => all.map((f) => { const n = f.querySelector(".now"), s = n.closest("svg"); return (n.getAttribute("x1") / s.viewBox.baseVal.width).toFixed(3); }));
  check(new Set(lines).size === 1, "all plots show the same stroke", lines);

  // A leaf by click, its plots, and what the pointer names.
  await page.evaluate(() => scrollTo(0, 0));
  await pause(100);
  const place = await page.evaluate(() => window.flexopt_report.view.place_of("leaf +y"));
  await page.mouse.move(...place);
  await pause(150);
  check(/leaf \+y.*100 mm × 30 mm × 0\.5 mm.*MPa/.test(await text_of(page, ".tip")), "the pointer names part and values", await text_of(page, ".tip"));
  check(await changes(page, () => page.mouse.click(...place)), "a click on a leaf marks it");
  check((await state(page)).leaf === "leaf +y", "and chooses it", (await state(page)).leaf);
  check((await page.$$("#leaf-plots .figure svg")).length >= 2, "its plots appear");
  const along = () => page.$eval("#leaf-plots", (e) => e.querySelector("path")?.getAttribute("d") + e.innerHTML.length);
  const before = await along();
  await slide(900);
  await pause(150);
  check(await along() !== before, "and follow the stroke");

  for (const name of ["x–y", "x–z", "y–z", "3-D"])
    check(await changes(page, () => page.evaluate((n) => [...document.querySelectorAll(".views button")].find((b) => b.textContent === n).click(), name)), `the view ${name}`);
  check(await changes(page, () => page.click("#turntable").then(() => pause(300))), "the turntable turns");
  await page.click("#turntable");
  check(await changes(page, () => page.select("#up", "z")), "another axis may be up");
  const corner = await page.evaluate(() => { const {camera} = window.flexopt_report.view; return camera.up.toArray(); });
  check(corner.join() === "0,0,1", "and is up", corner);
  check(await changes(page, () => page.keyboard.press("ArrowLeft").then(() => page.focus("canvas")).then(() => page.keyboard.press("ArrowUp"))), "arrow keys turn it then too");
  await page.select("#up", "y");
  check(await changes(page, () => page.click("#names")), "names can be shown");
  await page.click("#names");
  check(await changes(page, () => page.select("#color", "plain")), "plain colours");
  check(await changes(page, () => page.click("#bodies")), "bodies can be hidden");
  await page.select("#color", "stress");
  check(/von Mises stress \[MPa\]/.test(await text_of(page, "#stress-legend")), "the legend is in MPa", await text_of(page, "#stress-legend"));

  // Copies.
  await page.evaluate(() => { window.copied = []; Object.defineProperty(navigator, "clipboard", {value: {writeText: async (t) => { window.copied.push(t); }, write: async (items) => { window.copied.push(await (await items[0].getType("image/png")).arrayBuffer()); }}, configurable: true}); });
  await page.click("#copy-png");
  await page.waitForFunction(() => window.copied.length === 1);
  const png = await page.evaluate(() => [...new Uint8Array(window.copied[0])].slice(0, 4));
  check(png.join() === "137,80,78,71", "the view is copied as PNG", png);
  for (const format of ["CSV", "NumPy", "Matlab"]) {
    await page.evaluate((f) => [...document.querySelectorAll("button")].find((b) => b.textContent === `Copy as ${f}`).click(), format);
    await pause(50);
  }
  const copied = await page.evaluate(() => window.copied.slice(1));
  const matrix = await page.evaluate(() => {
    const result = JSON.parse(document.getElementById("result").textContent), {stroke} = window.flexopt_report.state;
    return result.path.reduce((a, b) => Math.abs(b.stroke - stroke) < Math.abs(a.stroke - stroke) ? b : a).compliance.drive_locked;
  });
  const csv = copied[0].split("\n").filter((l) => l && !l.startsWith("#")).map((l) => l.split(",").map(Number));
  check(JSON.stringify(csv) === JSON.stringify(matrix), "the CSV is the matrix of the point shown");
  check(JSON.stringify(JSON.parse(copied[1].replace(/^#.*\n/, "").replace(/^C = np\.array\(/, "").replace(/\)\n$/, ""))) === JSON.stringify(matrix), "and so is the NumPy array", copied[1].slice(0, 200));
  check(JSON.stringify(copied[2].split("\n").slice(1).join("").replace(/^C = \[|\];$|\.\.\./g, "").split(";").map((r) => r.trim().split(/\s+/).map(Number))) === JSON.stringify(matrix), "and the Matlab one", copied[2].slice(0, 200));
});

await on("evaluate", "the keyboard makes no error", async (page) => {  // the keyboard alone
  const reached = new Set();
  for (let k = 0; k < 90; ++k) {
    await page.keyboard.press("Tab");
    reached.add(await page.evaluate(() => { const e = document.activeElement; return e.id || (e.classList.contains("linked") ? "plot" : e.tagName === "CANVAS" ? "canvas" : e.tagName === "TR" ? "row" : e.textContent.slice(0, 20)); }));
  }
  for (const what of ["stroke", "play", "mode", "leaf", "color", "turntable", "bodies", "copy-png", "canvas", "plot", "row", "x–y", "Copy as CSV"]) check(reached.has(what), `the keyboard reaches ${what}`, [...reached]);
  await page.focus(".linked");
  await page.keyboard.press("ArrowLeft");
  check(Math.abs((await state(page)).stroke - 0.012) < 1e-9, "an arrow key steps to the next computed point", (await state(page)).stroke);
  await page.focus("canvas");
  check(await changes(page, () => page.keyboard.press("ArrowLeft")), "arrow keys turn the view");
  check(await changes(page, () => page.keyboard.press("+")), "plus zooms");
  await page.focus("#play");
  check(await changes(page, () => page.keyboard.press("Enter").then(() => pause(400))), "enter plays");
  await page.focus("tr.pick");
  await page.keyboard.press("Enter");
  check(Math.abs((await state(page)).stroke + 0.015) < 1e-12, "enter on a row of the table goes there", (await state(page)).stroke);
});

{  // light and dark
  const {page} = await show("evaluate");
  const paper = () => page.evaluate(() => getComputedStyle(document.body).backgroundColor);
  const light = await paper();
  check(await changes(page, () => page.emulateMediaFeatures([{name: "prefers-color-scheme", value: "dark"}])), "dark mode redraws the view");
  const bent = await page.evaluate(() => { const {view, state} = window.flexopt_report, {design} = view.figures[0]; return [state.stroke, design.bodies_now[1]]; });
  check(Math.abs(bent[0] - 0.015) < 1e-12 && Math.abs(bent[1] - 0.015) < 1e-6, "at the same stroke", bent);
  check(light === "rgb(255, 255, 255)" && await paper() === "rgb(20, 24, 31)", "and the page", [light, await paper()]);
  await page.close();
}

await on("front", "an optimisation makes no error", async (page) => {  // an optimisation: side by side, brush, front
  check((await page.evaluate(() => window.flexopt_report.view.figures.length)) === 2, "start and optimum stand side by side");
  check(await changes(page, () => page.select("#beside", "")), "or the optimum alone");
  const all = await page.$$eval(".parallel g[aria-label=line] path", (list) => list.filter((l) => l.getAttribute("display") !== "none").length);
  check(all > 5, "every evaluated design is a line", all);
  const brush = await page.$(".parallel .brush .overlay");
  await brush.scrollIntoView();
  const box = await brush.boundingBox();
  await page.mouse.move(box.x + box.width / 2, box.y + 0.05 * box.height);
  await page.mouse.down();
  await page.mouse.move(box.x + box.width / 2, box.y + 0.45 * box.height, {steps: 5});
  await page.mouse.up();
  const left = await page.$$eval(".parallel g[aria-label=line] path", (list) => list.filter((l) => l.getAttribute("display") !== "none").length);
  check(left < all, "a brush leaves fewer", [all, left]);
  check((await text_of(page, "#brushed")).startsWith(`${left} of ${all} designs`), "and counts them", await text_of(page, "#brushed"));
  const inside = await page.evaluate(() => [...document.querySelectorAll(".ranges input")].slice(0, 2).map((i) => Number(i.value)));
  check(inside[0] < inside[1] && inside[0] > 60 && inside[1] <= 120, "the range stands in the boxes, in mm", inside);
  const dot = await page.$("#front .figure svg g[aria-label=dot] circle");
  await dot.scrollIntoView();
  const at = await dot.boundingBox();
  check(await changes(page, async () => { await page.mouse.move(at.x + 3, at.y + 3); await pause(80); await page.mouse.click(at.x + at.width / 2, at.y + at.height / 2); }), "a point of the front shows its mechanism");
  const beside = (await state(page)).beside;
  check((await page.$eval(`#beside option[value="${beside}"]`, (o) => o.textContent)).startsWith("front, point"), "beside the optimum", beside);
  const bars = await page.$$eval(".bars", (all) => all.map((f) => f.textContent));
  check(bars.some((t) => /\+0\.01 mm thickness/.test(t)), "sensitivities are in handy steps", bars);
});

{  // an optimum's first screen
  const {page} = await show("three_flexure_cross_hinge");
  const found = await page.evaluate(() => {
    const {optimum, path} = JSON.parse(document.getElementById("result").textContent);
    const rows = [...document.querySelectorAll(".found tbody tr")].map((row) => [...row.children].map((c) => c.textContent));
    return {rows, variables: optimum.variables, bottom: document.querySelector(".found").getBoundingClientRect().bottom, most: Math.max(...path.map((p) => p.max_stress)),
      legend: document.querySelector("#stress-legend > span").textContent, card: [...document.querySelectorAll(".tile")].find((t) => /von Mises/.test(t.textContent)).querySelector(".number").textContent};
  });
  check(found.rows.length === found.variables.length && found.rows.every(([, value, low, , high], k) => [value, low, high].every((text, n) => Math.abs(parseFloat(text) / (found.variables[k].unit === "m" ? 1e3 : 180 / Math.PI) / found.variables[k][["optimum", "min", "max"][n]] - 1) < 5e-3)), "the dimensions that were found stand in their ranges", found.rows);
  check(found.bottom < 900, "without scrolling", found.bottom);
  check(found.legend.includes(`largest ${found.card},`) && parseFloat(found.card) === Number((found.most / 1e6).toPrecision(3)), "there is one largest stress", [found.legend, found.card, found.most]);
  check(!/Largest parasitic|min over/.test(await page.$eval("main", (m) => m.innerText)) && /^Lowest parasitic frequency over the stroke, maximised: /.test((await page.$eval(".lead", (e) => e.lastChild.textContent))), "the objective is said in words", await text_of(page, ".lead"));
  const text = await page.$eval(".limits", (e) => e.textContent);
  check(/1 % more \(4\.5 MPa\) would change the objective by \+3\.5\d Hz/.test(text), "active constraints have their price in words", text);
  await page.close();
}

await on("two_drives", "two drives make no error", async (page) => {  // two drives have two sliders
  check((await page.$$("input[id^=stroke-]")).length === 2, "two drives, two sliders");
  check(await changes(page, () => page.$eval("#stroke-1", (e) => { e.value = 1; e.dispatchEvent(new Event("input")); })), "the second one moves the mechanism");
  const strokes = await page.$$eval("input[id^=stroke-] + output", (all) => all.map((o) => o.textContent));
  check(strokes.every((s) => /^[−\d.]+ mm$/.test(s)), "both show their stroke", strokes);
  // Over both strokes: a map, and families of curves.
  const titles = () => page.$$eval("#first figure", (all) => all.map((f) => f.dataset.title));
  check((await titles()).join() === "parasitic frequency,Parasitic frequency over x,Parasitic frequency over y", "a map and two families of curves", await titles());
  check(!/point \[1\]/.test(await page.$eval("#first", (e) => e.textContent)), "nothing is drawn against the number of the point");
  await page.select("select[aria-label=Quantity]", "drive_load.x");
  check((await titles()).join() === "drive load x,Drive load x over x,Drive load x over y", "of the quantity that is chosen", await titles());
  const map = ".map > svg[role=application]";
  await page.$eval(map, (e) => e.focus());
  const before = (await state(page)).stroke;
  check(await changes(page, () => page.keyboard.press("ArrowDown")), "an arrow key on the map moves the mechanism");
  const told = await text_of(page, ".map output"), point = await page.evaluate(() => JSON.parse(document.getElementById("result").textContent).path[window.flexopt_report.state.stroke]);
  check((await state(page)).stroke !== before && told.startsWith(`x ${Math.round(1e3 * point.stroke.x)} mm`.replace("-", "−")), "to the place that it tells", [told, point.stroke]);
  check(Math.abs(Number(/: ([−\d.]+) N/.exec(told)[1].replace("−", "-")) / point.drive_load.x - 1) < 1e-3, "with the number of the result", [told, point.drive_load]);
});

await on("listed", "ranked designs make no error", async (page) => {  // designs ranked
  check(await changes(page, () => page.$eval("#beside", (e) => { e.value = e.options[e.options.length - 1].value; e.dispatchEvent(new Event("change")); })), "another design stands beside the best");
  const ranked = await page.evaluate(() => {
    const table = document.querySelector("main > .scroll table"), result = JSON.parse(document.getElementById("result").textContent);
    return [Boolean(table && table.compareDocumentPosition(document.getElementById("viewer")) & Node.DOCUMENT_POSITION_FOLLOWING),
      [...table?.querySelectorAll("tbody tr") ?? []].map((row) => row.children[1].textContent), result.ranking.map((e) => e.name)];
  });
  check(ranked[0] && ranked[1].join() === ranked[2].join(), "the ranking stands above the picture", ranked);
});

await on("compare", "a comparison makes no error", async (page) => {  // a comparison: errors against any parameter
  const chart = () => page.$eval("select[aria-label=Parameter]", (e) => e.closest("div").innerHTML);
  const before = await chart();
  await page.$eval("select[aria-label=Parameter]", (e) => { e.value = "width"; e.dispatchEvent(new Event("change")); });
  check(await chart() !== before, "errors are drawn against the parameter chosen");
  const text = await page.$eval("main", (m) => m.textContent);
  check(/Error against cost/.test(text), "and against cost");
  check(/buckling drive locked/.test(text) && /load capacity -ux/.test(text) && /fatigue safety/.test(text), "with what the job's sections ask for");
  const titles = await page.$$eval("figure", (all) => all.map((f) => f.dataset.title));
  check(titles.includes("Error against stroke, 1 of 2") && titles.includes("Error against stroke, 2 of 2"), "a chart has as many quantities as colours", titles);
});
await on("front", "maps make no error", async (page) => {  // maps and the global search
  const map = ".map > svg[role=application]", told = () => page.$$eval(".map output", (all) => all.map((e) => e.textContent));
  check((await page.$$(map)).length === 2, "a map for each goal", (await page.$$(map)).length);
  const chart = await page.$(map);
  await chart.scrollIntoView();
  const box = await chart.boundingBox(), before = await told();
  check(before.every((text) => /^length .* mm, thickness .* mm: /.test(text)), "the place of the optimum is told first", before);
  await page.mouse.move(box.x + 0.3 * box.width, box.y + 0.75 * box.height);
  const pointed = await told();
  check(pointed.every((text, k) => text !== before[k]), "pointing at a place tells its numbers in all maps", pointed);
  const numbers = await page.evaluate(() => {
    const [map] = JSON.parse(document.getElementById("result").textContent).maps;
    const [, length, thickness, stress] = /^length ([\d.]+) mm, thickness ([\d.]+) mm: ([\d.]+) MPa/.exec(document.querySelectorAll(".map output")[1].textContent);
    const i = map.parameters[0].values.findIndex((v) => Math.abs(v - length / 1e3) < 5e-5), j = map.parameters[1].values.findIndex((v) => Math.abs(v - thickness / 1e3) < 5e-7);
    return [map.quantities[1].values[i][j] / 1e6, Number(stress)];
  });
  check(Math.abs(numbers[0] / numbers[1] - 1) < 1e-3, "and they are those of the result", numbers);
  await page.$eval(map, (e) => e.focus());
  await page.keyboard.press("ArrowRight");
  const stepped = await told();
  check(stepped[0] !== pointed[0] && stepped[0].split(", thickness")[1].split(":")[0] === pointed[0].split(", thickness")[1].split(":")[0], "an arrow key steps along one parameter", stepped[0]);
  const drawn = await page.$$eval(map, (charts) => charts.map((c) => [c.querySelectorAll("g[aria-label=contour] path").length, [...c.querySelectorAll("g[aria-label=text] text")].map((t) => t.textContent)]));
  check(drawn.every(([contours]) => contours > 8), "maps have levels and the border of feasible designs", drawn);
  check(drawn.every(([, texts]) => texts.includes("optimum") && texts.includes("start")), "start and optimum are marked", drawn);
  const text = await page.evaluate(() => document.querySelector("main").innerText);
  check(/60 designs of the whole box on reduced leaves/.test(text) && /Different optima/.test(text), "the global search is told");
});
await on("linear_models", "frequency responses make no error", async (page) => {  // frequency responses
  const told = () => page.$eval("#frequency-responses figure .soft", (e) => e.textContent);
  const [frequencies, compliance] = await page.evaluate(() => {
    const {path} = JSON.parse(document.getElementById("result").textContent);
    return [path.map((p) => p.frequencies.drive_free[0]), path.map((p) => p.compliance.drive_free[1][1])];
  });
  const numbers = async () => /at ([-\d.]+) mm; largest ([\d.]+) m\/N at ([\d.]+) Hz/.exec(await told())?.slice(1).map(Number);
  check((await page.$$("#frequency-responses figure svg[role=img], #frequency-responses figure > svg")).length === 4, "four charts");
  const drawn = () => page.$eval("#frequency-responses figure:nth-child(4)", (e) => e.innerHTML);
  let before = null;
  for (const [k, stroke] of [[2, 0.01], [0, 0]]) {
    await page.evaluate((s) => window.flexopt_report.set({stroke: s}), stroke);
    const found = await numbers();
    check(found?.[0] === stroke * 1e3, "they are those of the stroke that is shown", await told());
    // a mode that is alone, of damping 0.02
    check(Math.abs(found?.[2] / frequencies[k] - 1) < 3e-3, "the largest gain is at the lowest frequency", [found, frequencies]);
    check(Math.abs(found?.[1] * 2 * 0.02 / compliance[k] - 1) < 0.02, "and is the static one over twice the damping", [found, compliance]);
    check(await drawn() !== before, "they follow the stroke");
    before = await drawn();
  }
});
await on("fatigue", "the fatigue section makes no error", async (page) => {  // fatigue
  const {path} = await page.evaluate(() => JSON.parse(document.getElementById("result").textContent));
  const worst = path.reduce((a, p) => p.fatigue_safety < a.fatigue_safety ? p : a), {amplitude, mean, line} = worst.fatigue_safety_place;
  const figure = '#fatigue figure[data-title="Haigh diagram"]';
  const drawn = await page.$eval(figure, (f) => ({
    curves: [...f.querySelectorAll("g[aria-label=line] path")].map((p) => p.getAttribute("d").match(/-?[\d.]+,-?[\d.]+/g).map((xy) => xy.split(",").map(Number))),
    dots: [...f.querySelectorAll("g[aria-label=dot] circle")].map((c) => [Number(c.getAttribute("cx")), Number(c.getAttribute("cy"))]),
    note: f.querySelector(".soft").textContent, legend: [...f.querySelectorAll(".legend span")].map((e) => e.textContent)}));
  check(drawn.dots.length === path.length, "every stroke point has its worst cycle", drawn.dots);
  check(drawn.legend.includes("Gerber"), "the line has its name", drawn.legend);
  // from the ray: a dot is at the origin plus a share of it, and the line is met at the safety
  const [limit, ray] = drawn.curves, [origin, end] = ray, dot = drawn.dots.at(-1), far = Math.max(1, worst.fatigue_safety);
  for (const i of [0, 1]) check(Math.abs(origin[i] + (end[i] - origin[i]) / far - dot[i]) < 0.2, "the worst cycle lies on its ray", [origin, end, dot]);
  const share = worst.fatigue_safety * amplitude / line.endured_amplitude + (worst.fatigue_safety * mean / line.largest_mean) ** 2;
  check(Math.abs(share - 1) < 1e-9, "the safety leads to Gerber's line", [share, line]);
  const meets = origin.map((o, i) => o + (end[i] - o) * worst.fatigue_safety / far);
  const next = limit.findIndex(([x]) => x > meets[0]), [a, b] = [limit[next - 1], limit[next]], y = a[1] + (b[1] - a[1]) * (meets[0] - a[0]) / (b[0] - a[0]);
  check(Math.abs(y - meets[1]) < 0.5, "so does the picture", [y, meets]);
  const told = () => page.$eval("#fatigue-now", (e) => e.textContent);
  await page.evaluate(() => window.flexopt_report.set({stroke: -0.002}));
  const left = await told();
  await page.evaluate(() => window.flexopt_report.set({stroke: 0.004}));
  check(left.startsWith("at -2 mm") || left.startsWith("at −2 mm"), "the cycle of the stroke that is shown is told", left);
  check(await told() !== left, "it follows the stroke", left);
  // the stress behind it, with its sign, over the stroke
  const signed = await page.$eval('figure[data-title="Stress behind the worst cycle"]', (f) => ({
    curves: [...f.querySelectorAll("g[aria-label=line] path")].map((p) => p.getAttribute("d").match(/-?[\d.]+,-?[\d.]+/g).map((xy) => Number(xy.split(",")[1]))),
    legend: [...f.querySelectorAll(".legend span")].map((e) => e.textContent)}));
  check(signed.legend.join() === "along the leaf,across the leaf,shear,largest von Mises stress, with the fillet", "each part has its name", signed.legend);
  const parts = ["along", "across", "shear"].map((part) => path.map((p) => p.fatigue_stress[part])), [along] = parts;
  check(Math.min(...along) < 0 && Math.max(...along) > 0, "bent to and fro it changes its sign", along);
  const drawn_along = signed.curves[0], scale = (drawn_along.at(-1) - drawn_along[0]) / (along.at(-1) - along[0]);
  check(along.every((s, k) => Math.abs(drawn_along[k] - drawn_along[0] - scale * (s - along[0])) < 0.5), "it is drawn as it is", drawn_along);
  const {other_point} = worst.fatigue_safety_place, [from, to] = [worst, path[other_point]].map((p) => p.fatigue_stress);
  const half = (part) => (from[part] - to[part]) / 2, [s1, s2, s3] = ["along", "across", "shear"].map(half);
  check(Math.abs(Math.sqrt(s1 * s1 - s1 * s2 + s2 * s2 + 3 * s3 * s3) / amplitude - 1) < 1e-9, "its ends make the amplitude", [from, to, amplitude]);
});
{  // load cases
  const {page} = await show("cases");
  const strokes = () => page.evaluate(() => [...document.querySelectorAll("table")].filter((t) => /^(Stroke|Load factor)/.test(t.querySelector("th").textContent))
    .flatMap((t) => [...t.querySelectorAll("tbody tr")].map((row) => row.querySelector("td").textContent)));
  const select = 'select[aria-label="Load case"]';
  check(await page.$eval(select, (e) => e.value) === "hanging", "the first load case is shown");
  check((await strokes()).join() === "0,2.5,5", "with its strokes", await strokes());
  for (const [name, text, label] of [["standing", "0,2.667,5.333,8", "stroke"], ["pulled", "0,0.5,1", "load factor"]]) {
    await page.select(select, name);
    for (let tries = 0; tries < 50 && (await strokes()).join() !== text; ++tries)
      await new Promise((done) => setTimeout(done, 100));  // the page draws the case anew
    await page.waitForFunction(() => document.documentElement.dataset.ready === "yes", {timeout: 60000});
    check(await page.$eval(select, (e) => e.value) === name, `the load case ${name} can be chosen`);
    check((await strokes()).join() === text, `${name} has its own ${label}s`, await strokes());
    const far = await page.evaluate(() => {
      const {view, state} = window.flexopt_report, {design} = view.figures[0];
      design.pose(state.stroke, null, 0);
      return [state.stroke, design.bodies_now[1]];
    });
    check(name !== "standing" || Math.abs(far[1] - 8e-3) < 1e-7, `${name} is drawn at its own stroke`, far);
  }
  const text = await page.evaluate(() => document.querySelector("main").innerText);
  check(/Tolerances/.test(text) && /sampled designs keep every constraint/.test(text), "the tolerances are told");
  check(/Errors of assembly/.test(text) && /leaf \+y base turned/.test(text), "the worst errors of assembly are told");
  await page.close();
}

await browser.close();
finish();
