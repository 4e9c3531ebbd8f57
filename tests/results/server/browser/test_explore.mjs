// A design is moved in the browser: picture, plots, tables and goals follow; the job is written.
//   node test_explore.mjs FLEXOPT FOLDER
import {execFileSync} from "node:child_process";
import {mkdirSync, readFileSync, readdirSync, rmSync} from "node:fs";
import {join} from "node:path";
import {checker, launch, need_chromium, pause, picture, source} from "../../report/browser/browser.mjs";
import {open_page, served} from "./served.mjs";

need_chromium();
const [flexopt, folder] = process.argv.slice(2), {check, finish} = checker(), browser = await launch();
const job = (name) => join(source, "tests/results/server/jobs", `${name}.json`);
const log = (page) => page.evaluate(() => ({...window.flexopt_explore}));
const text_of = (page, selector) => page.$eval(selector, (e) => e.textContent);
const answered = async (page, count) => page.waitForFunction((n) => window.flexopt_explore.answered + window.flexopt_explore.failed >= n, {timeout: 60000}, count);
const slide = (page, name, share) => page.$eval(`#move-${name}`, (e, s) => { e.value = Math.round(s * e.max); e.dispatchEvent(new Event("input")); }, share);
const fill = (page, name, text) => page.$eval(`#move-${name}`, (e, t) => { const box = e.closest(".move").querySelector("input[type=number]"); box.value = t; box.dispatchEvent(new Event("change")); }, text);
/// What plots and tables show.
const drawn = (page) => page.evaluate(() => ({
  plots: [...document.querySelectorAll(".linked > svg")].map((s) => [...s.querySelectorAll("path")].map((p) => p.getAttribute("d")).join()).join("|"),
  tables: [...document.querySelectorAll("#report table")].map((t) => t.textContent).join("|"),
  tiles: [...document.querySelectorAll(".tile .number")].map((t) => t.textContent)}));

rmSync(folder, {recursive: true, force: true});
mkdirSync(folder, {recursive: true});

{  // an evaluation
  const server = await served(flexopt, ["explore", job("hinge")]);
  check(/^http:\/\/127\.0\.0\.1:\d+\/\?token=[0-9a-f]{32}$/.test(server.address), "one address with a token", server.address);
  const {page, faults} = await open_page(browser, server);
  await answered(page, 1);
  const names = await page.$$eval(".move input[type=range]", (all) => all.map((e) => e.id.slice(5)));
  check(names.join() === "length,thickness,half_angle,inner_width,gap,crossing_fraction" || names.toSorted().join() === "crossing_fraction,gap,half_angle,inner_width,length,thickness", "every number of the design has a slider, the formula none", names);
  check(/works/.test(await text_of(page, ".pill")), "the job's own design is shown first", await text_of(page, ".pill"));
  const before = await drawn(page), seen = await picture(page);
  check(before.plots.length > 1000 && before.tiles.length === 5 && seen.colors > 20, "with plots, numbers and a picture", [before.plots.length, before.tiles, seen.colors]);

  await page.evaluate(() => scrollTo(0, 600));
  await slide(page, "thickness", 1);
  await answered(page, 2);
  const after = await drawn(page), now = await picture(page);
  check(now.hash !== seen.hash, "a slider moves the picture");
  check(after.plots !== before.plots, "and the plots");
  check(after.tables !== before.tables && after.tiles.join() !== before.tiles.join(), "and the tables and numbers", [before.tiles, after.tiles]);
  check(await page.evaluate(() => scrollY) === 600, "the page stays where it was scrolled to", await page.evaluate(() => scrollY));
  check(await page.$$eval("canvas", (all) => all.length) === 1, "there is one canvas still");
  check(/^Evaluated in [\d.]+ ms/.test(await text_of(page, "#say")), "the time is told", await text_of(page, "#say"));

  // What is shown is what a run finds.
  const shown = await page.evaluate(() => [...document.querySelectorAll("details pre")].map((e) => e.textContent).find((t) => t.includes("three_flexure_cross_hinge")));
  const own = JSON.parse(shown).design.parameters;
  check(Math.abs(own.thickness - 0.0008) < 1e-12 && own.length === 0.05, "the job shown is that of the sliders", own);

  // Many moves at once: the newest counts, the picture settles on it.
  const begun = (await log(page)).answered;
  await page.evaluate(() => { for (let k = 0; k <= 40; ++k) { const e = document.getElementById("move-length"); e.value = 10 * k; e.dispatchEvent(new Event("input")); } });
  await answered(page, begun + 2);
  await pause(800);
  const many = await log(page);
  check(many.answered - begun <= 4 && many.dropped >= 30, "of many moves the newest alone are evaluated", many);
  const length = await page.$eval("#move-length", (e) => Number(e.closest(".move").querySelector("input[type=number]").value));
  const last = JSON.parse(await page.evaluate(() => [...document.querySelectorAll("details pre")].map((e) => e.textContent).find((t) => t.includes("three_flexure_cross_hinge")))).design.parameters.length;
  check(Math.abs(last - length / 1e3) < 1e-9 && length === 55, "and the last one is shown", [last, length]);

  // A number typed in, also out of range: it is taken to the end of the range.
  let count = (await log(page)).answered;
  await fill(page, "half_angle", "37.5");
  await answered(page, ++count);
  check((await page.$eval("#move-half_angle", (e) => e.getAttribute("aria-valuetext"))) === "37.5°", "a number can be typed");
  await fill(page, "length", "1e9");
  await answered(page, ++count);
  check(await page.$eval("#move-length", (e) => e.value === e.max), "out of range it goes to the end");

  // A mode that was chosen goes on; a leaf keeps its plots.
  await page.select("#mode", "locked:1");
  await page.select("#leaf", await page.$eval("#leaf", (e) => e.options[1].value));
  await slide(page, "length", 0.4);
  await answered(page, ++count);
  check(await page.$eval("#mode", (e) => e.value) === "locked:1", "the chosen mode stays");
  check((await page.$$("#leaf-plots .figure svg")).length >= 2, "and the plots of the chosen leaf");
  const moving = (await picture(page)).hash;
  await pause(400);
  check((await picture(page)).hash !== moving, "the mode still moves");
  await page.select("#mode", "");

  // A broken rule shows its text and leaves the picture.
  const good = (await picture(page)).hash;
  await fill(page, "inner_width", "98");
  await page.waitForFunction(() => window.flexopt_explore.failed > 0, {timeout: 30000});
  check(/thinner than long and wide/.test(await text_of(page, "#say")), "a broken rule shows its text", await text_of(page, "#say"));
  check((await picture(page)).hash === good, "and leaves the picture as it was");
  check(await page.evaluate(() => document.body.classList.contains("stale")), "which is told apart");
  await page.click("#back");
  await answered(page, (await log(page)).answered + (await log(page)).failed + 1);
  check(!await page.evaluate(() => document.body.classList.contains("stale")), "until it works again");
  check((await drawn(page)).tables === before.tables, "back at the job's design all tables are as at first");

  // The job file.
  await slide(page, "length", 0.3);
  const downloads = join(folder, "downloads");
  mkdirSync(downloads, {recursive: true});
  const session = await page.createCDPSession();
  await session.send("Browser.setDownloadBehavior", {behavior: "allow", downloadPath: downloads});
  await page.click("#write");
  for (let k = 0; k < 50 && !readdirSync(downloads).some((f) => f.endsWith(".json")); ++k) await pause(100);
  const file = readdirSync(downloads).find((f) => f.endsWith(".json"));
  check(file === "three-leaf_hinge.json", "the browser offers the job file", readdirSync(downloads));
  const written = JSON.parse(readFileSync(join(downloads, file), "utf8"));
  check(Math.abs(written.design.parameters.length - 0.0475) < 1e-12 && written.design.parameters.outer_width.expression, "with the new number, formulas as they were", written.design.parameters);
  execFileSync(flexopt, ["run", join(downloads, file), "--out", join(folder, "written"), "--quiet"], {stdio: ["ignore", "ignore", "inherit"]});
  check(JSON.parse(readFileSync(join(folder, "written/result.json"), "utf8")).status === "ok", "and flexopt runs it");

  check(faults.length === 0, "all of it without an error", faults);
  check(await server.closed("SIGINT") === 0, "Ctrl-C ends the server with exit code 0");
  await slide(page, "length", 0.5);
  await page.waitForFunction(() => /does not answer/.test(document.getElementById("say").textContent), {timeout: 20000});
  await page.close();
}

{  // an optimisation: variables with their bounds, goals with theirs
  const server = await served(flexopt, ["explore", job("optimise")]);
  const {page, faults} = await open_page(browser, server, {width: 420, height: 800});
  await answered(page, 1);
  const names = await page.$$eval(".move input[type=range]", (all) => all.map((e) => e.id.slice(5)).join());
  check(names === "length,thickness,half_angle,inner_width", "an optimisation has its variables", names);
  const ends = await page.$eval("#move-length", (e) => { const box = e.closest(".move").querySelector("input[type=number]"); return [box.min, box.max]; });
  check(ends.join() === "20,100", "with their bounds", ends);
  const rows = await page.$$eval("#goals tbody tr", (all) => all.map((r) => r.textContent));
  check(rows.length === 5 && /parasitic frequency/.test(rows[0]) && /maximised/.test(rows[0]) && /MPa/.test(rows[1]) && /≤ 450 MPa/.test(rows[1]), "goals have values and bounds", rows);
  await fill(page, "length", "42.302");
  await fill(page, "thickness", "0.40102");
  await fill(page, "half_angle", "43.338");
  await fill(page, "inner_width", "67.018");
  await page.waitForFunction(() => /25\d(\.\d+)? Hz/.test(document.querySelector("#goals tbody tr").textContent.split("maximised")[0]), {timeout: 30000});
  const best = await page.$$eval("#goals tbody tr", (all) => all.map((r) => r.textContent));
  check(/25[67]\.?\d* Hz/.test(best[0]), "the optimum of the run has its objective here", best[0]);
  check(/^.*4(49|50)(\.\d+)? MPa/.test(best[1]), "and its stress", best[1]);
  check(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth), "nothing is wider than 420 pixels", await page.evaluate(() => document.documentElement.scrollWidth));
  await fill(page, "thickness", "1");
  await page.waitForFunction(() => document.querySelector("#goals .bad"), {timeout: 30000});
  check(/misses ≤ 450 MPa/.test((await page.$$eval("#goals tbody tr", (all) => all.map((r) => r.textContent)))[1]), "a constraint that is missed says so");
  check(faults.length === 0, "an optimisation makes no error", faults);
  check(await server.closed("SIGTERM") === 0, "SIGTERM ends the server with exit code 0");
  await page.close();
}

{  // load cases, and two drives
  const server = await served(flexopt, ["explore", join(source, "tests/results/report/jobs/cases.json")]);
  const {page, faults} = await open_page(browser, server);
  await answered(page, 1);
  await page.select('select[aria-label="Load case"]', "standing");
  await page.waitForFunction(() => document.querySelector('select[aria-label="Load case"]').value === "standing" && [...document.querySelectorAll("table th")].some((h) => h.textContent.startsWith("Stroke")), {timeout: 20000});
  const first = await page.$eval(".move input[type=range]", (e) => e.id.slice(5));
  const before = await drawn(page);
  await slide(page, first, 0.7);
  await answered(page, 2);
  check(await page.$eval('select[aria-label="Load case"]', (e) => e.value) === "standing", "the chosen load case stays");
  check((await drawn(page)).tables !== before.tables, "and its tables follow");
  check(faults.length === 0, "load cases make no error", faults);
  await page.close();
  await server.closed();

  const other = await served(flexopt, ["explore", join(source, "tests/results/report/jobs/two_drives.json")]);
  const two = await open_page(browser, other);
  await answered(two.page, 1);
  const place = await two.page.$$eval(".slider output", (all) => all.map((o) => o.textContent).join());
  const one = await picture(two.page);
  await slide(two.page, await two.page.$eval(".move input[type=range]", (e) => e.id.slice(5)), 0.9);
  await answered(two.page, 2);
  check((await picture(two.page)).hash !== one.hash, "a mechanism of two drives follows");
  check(await two.page.$$eval(".slider output", (all) => all.map((o) => o.textContent).join()) === place, "at the same strokes", place);
  check(two.faults.length === 0, "two drives make no error", two.faults);
  await two.page.close();
  await other.closed();
}

await browser.close();
finish();
