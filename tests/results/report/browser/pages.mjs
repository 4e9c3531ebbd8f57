// Runs the jobs whose reports the other tests open: node pages.mjs FLEXOPT FOLDER
import {execFileSync} from "node:child_process";
import {readdirSync} from "node:fs";
import {join, basename} from "node:path";
import {source} from "./browser.mjs";

const [flexopt, folder] = process.argv.slice(2);
const own = join(source, "tests/results/report/jobs");
const jobs = [...readdirSync(own).filter((name) => name.endsWith(".json")).map((name) => join(own, name)),
  join(source, "designs/jobs/three_flexure_cross_hinge.json")];
for (const job of jobs) {
  const out = join(folder, basename(job, ".json"));
  try {
    execFileSync(flexopt, ["run", job, "--out", out, "--quiet"], {stdio: ["ignore", "ignore", "inherit"]});
  } catch (error) {
    if (error.status !== 1 || basename(job) !== "stops_early.json") throw error;  // 1: ran, but not usable
  }
}
for (const name of ["hinged_leaf", "load_cases"])  // nothing is computed there
  execFileSync(flexopt, ["show", join(source, `designs/jobs/${name}.json`), "--out", join(folder, `show_${name}`)], {stdio: ["ignore", "ignore", "inherit"]});
console.log(`${jobs.length} reports in ${folder}`);
