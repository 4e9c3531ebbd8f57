// Draws the pictures of docs/report.md from jobs of the gallery, at 1440 and at 420 pixels:
//   node docs/report_pictures.mjs build/release/flexopt
import {execFileSync} from "node:child_process";
import {mkdtempSync, rmSync} from "node:fs";
import {tmpdir} from "node:os";
import {join, resolve} from "node:path";
import {launch, open, pause, source} from "../tests/results/report/browser/browser.mjs";

const flexopt = resolve(process.argv[2] ?? join(source, "build/release/flexopt"));
const folder = mkdtempSync(join(tmpdir(), "flexopt-pictures-"));
const pages = new Map();
function report(job) {
  if (!pages.has(job)) {
    const out = join(folder, job.replace(/\W/g, "_"));
    execFileSync(flexopt, ["run", join(source, job), "--out", out, "--quiet"], {stdio: "ignore"});
    pages.set(job, join(out, "report.html"));
  }
  return pages.get(job);
}

const guide = "tests/results/report/jobs/evaluate.json", hinge = "designs/jobs/three_flexure_cross_hinge.json";
const crossing = "designs/jobs/crossing_anywhere.json";
const front = "tests/results/report/jobs/front.json", listed = "tests/results/report/jobs/listed.json", compare = "tests/results/report/jobs/compare.json";
/// What is above this text, at the top of the window; `act` first.
const at = (text) => (page) => page.evaluate((t) => { const e = [...document.querySelectorAll("h2, figcaption")].find((x) => x.textContent.startsWith(t)); scrollTo(0, e.getBoundingClientRect().top + scrollY - 16); }, text);
const views = [
  {name: "first_screen", job: guide},
  {name: "mode", job: guide, act: async (page) => { await page.select("#mode", "locked:1"); await page.select("#leaf", "leaf +y"); await page.evaluate(() => { window.flexopt_report.state.phase = 0; }); await pause(300); }},
  {name: "plots", job: guide, act: at("Support stiffness, tr")},
  {name: "matrix", job: guide, act: at("Stroke table")},
  {name: "optimum", job: hinge, dark: true},
  {name: "sensitivities", job: hinge, act: at("What each dimension does")},
  {name: "designs", job: front, act: at("All evaluated designs")},
  {name: "front", job: front, act: at("Front of two objectives")},
  {name: "maps", job: crossing, act: at("Maps")},
  {name: "ranking", job: listed, act: at("Ranking")},
  {name: "comparison", job: compare},
];
const browser = await launch();
for (const {name, job, act, dark} of views) for (const width of [1440, 420]) {
  const {page, faults} = await open(browser, report(job), {width, height: width === 1440 ? 900 : 800, dark});
  if (faults.length > 0) throw new Error(`${name}: ${faults}`);
  if (act) await act(page);
  await pause(400);
  await page.screenshot({path: join(source, `docs/report/${name}_${width}.png`), optimizeForSpeed: false});
  await page.close();
}
await browser.close();
rmSync(folder, {recursive: true});
