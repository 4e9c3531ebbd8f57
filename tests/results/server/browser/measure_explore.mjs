// Times from a slider to picture, plots and tables, over 100 moves:
//   node measure_explore.mjs FLEXOPT [JOB]
import {join} from "node:path";
import {launch, pause, source} from "../../report/browser/browser.mjs";
import {open_page, served} from "./served.mjs";

const [flexopt, job = join(source, "tests/results/server/jobs/hinge.json")] = process.argv.slice(2), moves = 100;
const browser = await launch(), server = await served(flexopt, ["explore", job]);
const {page} = await open_page(browser, server);
const answered = (n) => page.waitForFunction((k) => window.flexopt_explore.answered >= k, {timeout: 60000}, n);
await answered(1);
const names = await page.$$eval(".move input[type=range]", (all) => all.map((e) => e.id));
for (let k = 0; k < moves; ++k) {
  await page.$eval(`#${names[k % names.length]}`, (e, share) => { e.value = Math.round(share * e.max); e.dispatchEvent(new Event("input")); }, 0.3 + 0.4 * ((k * 0.618034) % 1));
  await answered(k + 2);
  await pause(20);
}
const times = (await page.evaluate(() => window.flexopt_explore.times)).slice(1);
for (const key of ["evaluation", "picture", "everything"]) {
  const sorted = times.map((t) => t[key]).sort((a, b) => a - b), at = (share) => sorted[Math.floor(share * (sorted.length - 1))].toFixed(0);
  console.log(`${key}: median ${at(0.5)} ms, 95th percentile ${at(0.95)} ms, over ${sorted.length} moves`);
}
await browser.close();
await server.closed();
