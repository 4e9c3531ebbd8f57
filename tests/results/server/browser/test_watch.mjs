// A run that goes on is watched in the browser, to its end; a log that ends in half a record.
//   node test_watch.mjs FLEXOPT FOLDER
import {spawn} from "node:child_process";
import {once} from "node:events";
import {appendFileSync, cpSync, existsSync, mkdirSync, readFileSync, readdirSync, rmSync, statSync, writeFileSync} from "node:fs";
import {join} from "node:path";
import {checker, launch, need_chromium, pause, picture, source} from "../../report/browser/browser.mjs";
import {open_page, post, served} from "./served.mjs";

need_chromium();
const [flexopt, folder] = process.argv.slice(2), {check, finish} = checker(), browser = await launch();
const job = join(source, "tests/results/server/jobs/optimise.json"), out = join(folder, "run");
const text_of = (page, selector) => page.$eval(selector, (e) => e.textContent);
const log = (page) => page.evaluate(() => ({...window.flexopt_watch}));
const lines_of = (page) => page.$$eval(".parallel g[aria-label=line] path", (all) => all.length);

rmSync(folder, {recursive: true, force: true});
mkdirSync(out, {recursive: true});

{  // from before its beginning to its end
  const server = await served(flexopt, ["watch", out]);
  const {page, faults} = await open_page(browser, server);
  await page.waitForFunction(() => /Nothing to show yet/.test(document.getElementById("say").textContent), {timeout: 20000});
  const run = spawn(flexopt, ["run", job, "--out", out, "--quiet", "--threads", "1", "--set", "/optimise/starts=12"], {stdio: ["ignore", "ignore", "inherit"]});
  const ended = once(run, "exit");
  await page.waitForFunction(() => window.flexopt_watch.evaluations > 3, {timeout: 60000});
  const early = await log(page);
  check(!early.finished, "evaluations are shown before the run is finished", early);
  check(/The run goes on/.test(await text_of(page, "#say")) && /Last written/.test(await text_of(page, "#when")), "which it says", await text_of(page, "#live"));
  check((await text_of(page, ".pill")) === "running", "in the verdict too", await text_of(page, ".pill"));
  const lines = await lines_of(page), drawn = (await log(page)).evaluations, facts = await text_of(page, "#facts");
  check(lines > 1, "evaluated designs are lines over parallel axes", lines);
  check(/Best so far[\d.]+ Hz/.test(facts) && /Worst constraint.*(margin|violated by|at its bound)/.test(facts), "the best so far and the worst constraint are told", facts);
  const plots = await page.$$eval("figure[data-title]", (all) => all.map((f) => f.dataset.title));
  check(plots.includes("Objective") && plots.includes("Worst constraint violation"), "the history is drawn", plots);
  await page.waitForFunction((n) => window.flexopt_watch.evaluations > n + 5, {timeout: 60000}, drawn);
  check(await lines_of(page) > lines, "more come as the run goes on", [lines, await lines_of(page)]);
  check((await ended)[0] === 0, "the run is not disturbed");
  await page.waitForFunction(() => window.flexopt_watch.finished, {timeout: 30000});
  await page.waitForFunction(() => window.flexopt_report.view !== null, {timeout: 30000});
  check((await text_of(page, ".pill")) === "optimal" && /finished/.test(await text_of(page, "#say")), "its end is shown", await text_of(page, ".pill"));
  check((await picture(page)).colors > 20 && (await page.$$(".linked svg")).length > 5, "with the picture and the plots of the report");
  const traces = () => readdirSync(out).map((name) => `${name} ${statSync(join(out, name)).mtimeMs}`).join();
  const before = traces();
  for (let k = 0; k < 3; ++k) check((await post(server, "/state", {since: ""})).status === 200, "the state can be asked for");
  check(traces() === before, "nothing in the folder changes");
  for (const body of ["", "[]", "{}", '{"since": 1}', '{"since": "", "path": "/etc/passwd"}', '{"since": "../../x"}']) {
    const answer = await post(server, "/state", body);
    check(body.includes("..") ? answer.status === 200 : answer.status === 400, `a wrong question: ${body}`, [answer.status, answer.text.slice(0, 80)]);
  }
  for (const path of ["/evaluate", "/job"]) check((await post(server, path, {parameters: {}})).status === 404, `nothing can be asked of ${path}`);
  check(faults.length === 0, "all of it without an error", faults);
  check(await server.closed() === 0, "Ctrl-C ends the server with exit code 0");
  await page.close();
}

{  // an interrupted run, whose log ends in half a record
  const half = join(folder, "half");
  mkdirSync(half);
  cpSync(join(out, "job.json"), join(half, "job.json"));
  const records = readFileSync(join(out, "evaluations.jsonl"), "utf8").split("\n").filter(Boolean);
  const torn = records[8].slice(0, records[8].length / 2);
  writeFileSync(join(half, "evaluations.jsonl"), `${records.slice(0, 8).join("\n")}\n${torn}`);
  const server = await served(flexopt, ["watch", half]);
  const {page, faults} = await open_page(browser, server, {width: 420, height: 800});
  await page.waitForFunction(() => window.flexopt_watch.shown === 1, {timeout: 30000});
  check((await log(page)).evaluations === 7, "half a record is left out", await log(page));
  await page.click("#follow");
  appendFileSync(join(half, "evaluations.jsonl"), `${records[8].slice(torn.length)}\n${records[9]}\n`);
  await pause(2500);
  check((await log(page)).shown === 1, "who does not follow the run keeps what is shown");
  await page.click("#follow");
  await page.waitForFunction(() => window.flexopt_watch.shown === 2, {timeout: 30000});
  check((await log(page)).evaluations === 9, "and read when it is whole", await log(page));
  check(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth), "nothing is wider than 420 pixels");
  rmSync(half, {recursive: true});
  await page.waitForFunction(() => /Nothing to show/.test(document.getElementById("say").textContent), {timeout: 30000});
  check((await lines_of(page)) > 1, "a folder that goes leaves the page as it is");
  check(faults.length === 0, "none of it is an error", faults);
  check(await server.closed() === 0 && !existsSync(half), "the server ends with exit code 0");
  await page.close();
}

await browser.close();
finish();
