// Draws the pictures of docs/report.md and docs/explore.md from jobs of the repository, at 1440 and at
// 420 pixels; all, or those that are named:
//   node docs/report_pictures.mjs build/release/flexopt [NAME...]
import {execFileSync} from "node:child_process";
import {copyFileSync, mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync} from "node:fs";
import {tmpdir} from "node:os";
import {join, resolve} from "node:path";
import {launch, open, pause, source} from "../tests/results/report/browser/browser.mjs";
import {open_page, served} from "../tests/results/server/browser/served.mjs";

const flexopt = resolve(process.argv[2] ?? join(source, "build/release/flexopt"));
const wanted = process.argv.slice(3), is_wanted = ({name}) => wanted.length === 0 || wanted.includes(name);
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
const shoot = (page, name, width) => page.screenshot({path: join(source, `docs/report/${name}_${width}.png`), optimizeForSpeed: false});
for (const {name, job, act, dark} of views.filter(is_wanted)) for (const width of [1440, 420]) {
  const {page, faults} = await open(browser, report(job), {width, height: width === 1440 ? 900 : 800, dark});
  if (faults.length > 0) throw new Error(`${name}: ${faults}`);
  if (act) await act(page);
  await pause(400);
  await shoot(page, name, width);
  await page.close();
}

/// A run of the job, as it was after so many evaluations.
function begun(job, evaluations) {
  const whole = resolve(report(job), ".."), out = join(folder, "hinge.out");
  mkdirSync(out);
  copyFileSync(join(whole, "job.json"), join(out, "job.json"));
  writeFileSync(join(out, "evaluations.jsonl"), `${readFileSync(join(whole, "evaluations.jsonl"), "utf8").split("\n").slice(0, evaluations + 1).join("\n")}\n`);
  return out;
}
const searched = "tests/results/server/jobs/optimise.json";
const served_views = [
  {name: "explore", args: () => ["explore", join(source, searched)], act: async (page) => {
    for (const [parameter, text] of [["length", "44"], ["thickness", "0.43"], ["inner_width", "62"]]) {
      const answered = await page.evaluate(() => window.flexopt_explore.answered);
      await page.$eval(`#move-${parameter}`, (e, t) => { const box = e.closest(".move").querySelector("input[type=number]"); box.value = t; box.dispatchEvent(new Event("change")); }, text);
      await page.waitForFunction((n) => window.flexopt_explore.answered > n, {}, answered);
    }
  }, ready: () => window.flexopt_explore?.answered > 0},
  {name: "watch", args: () => ["watch", begun(searched, 24)], ready: () => window.flexopt_watch?.shown > 0},
];
for (const {name, args, act, ready} of served_views.filter(is_wanted)) {
  const server = await served(flexopt, args());
  for (const width of [1440, 420]) {
    const {page, faults} = await open_page(browser, server, {width, height: width === 1440 ? 900 : 800});
    await page.waitForFunction(ready, {timeout: 60000});
    if (act) await act(page);
    if (faults.length > 0) throw new Error(`${name}: ${faults}`);
    await pause(400);
    await shoot(page, name, width);
    await page.close();
  }
  await server.closed();
}
await browser.close();
rmSync(folder, {recursive: true});
