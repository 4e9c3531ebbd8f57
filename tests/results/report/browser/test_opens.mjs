// Every kind of job has a page that opens without error and without network, shows its numbers with
// units, and fits the window: node test_opens.mjs FOLDER
import {existsSync, readdirSync, readFileSync, statSync} from "node:fs";
import {join} from "node:path";
import {checker, launch, need_chromium, open, picture} from "./browser.mjs";

need_chromium();
const folder = process.argv[2], {check, finish} = checker(), browser = await launch();
const names = readdirSync(folder).filter((name) => existsSync(join(folder, name, "report.html")));
check(names.length >= 10, "all jobs have a report", names);

/// Significant digits of "3460 N m/rad" or "1.28·10⁵ N/m".
const digits = (text) => text.replace(/·10.*| .*|°/g, "").replace(".", "").replace(/^[−0]+|0+$/g, "").length;

for (const name of names) for (const [width, dark] of [[1440, false], [420, true]]) {
  const file = join(folder, name, "report.html");
  const {page, faults, seconds} = await open(browser, file, {width, dark});
  const what = `${name} at ${width} px`;
  check(faults.length === 0, `${what}: no error and no request`, faults);
  check(statSync(file).size < 12e6, `${what}: below 12 MB`, statSync(file).size);
  if (width === 1440) console.log(`${name}: ${(statSync(file).size / 1e6).toFixed(2)} MB, open after ${seconds.toFixed(2)} s`);
  const seen = await page.evaluate(() => ({
    wide: document.documentElement.scrollWidth - innerWidth,
    text: document.querySelector("main").innerText,
    verdict: document.querySelector(".pill")?.textContent,
    lead: [...document.querySelector(".lead").childNodes].slice(0, 2).map((n) => n.textContent).join(""),
    tiles: [...document.querySelectorAll(".tile")].map((t) => t.querySelector(".number").textContent),
    svgs: document.querySelectorAll(".figure svg").length,
    cut: [...document.querySelectorAll(".tile, .limits li, .controls > *, .figure figcaption, h1, h2, .lead")].filter((e) => {
      const box = e.getBoundingClientRect();
      return box.width > 0 && (box.right > innerWidth + 1 || box.left < -1 || e.scrollWidth > e.clientWidth + 2 && getComputedStyle(e).display !== "inline" && e.clientWidth > 0);
    }).map((e) => e.textContent.slice(0, 60)),
  }));
  check(seen.wide <= 0, `${what}: nothing is wider than the window`, seen.wide);
  check(seen.cut.length === 0, `${what}: nothing is cut`, seen.cut);
  check(!/\bNaN\b|\bundefined\b|\[object/.test(seen.text), `${what}: no text of a broken number`, seen.text.match(/.{30}(NaN|undefined|\[object).{20}/)?.[0]);
  check(Boolean(seen.verdict), `${what}: a verdict`);
  if (name.startsWith("show_")) {
    const words = await page.evaluate(() => window.flexopt_report.view.figures[0].names.children.map((word) => word.userData.name));
    const drawn = await picture(page);
    check(drawn.colors > 40, `${what}: the mechanism is drawn`, drawn.colors);
    for (const word of name === "show_hinged_leaf" ? ["leaf", "end_effector", "hinge"] : ["leaf +y", "leaf -y", "end_effector"])
      check(words.includes(word), `${what}: ${word} has its name`, words);
    const over = await page.evaluate(() => {  // words that lie over each other
      const {view} = window.flexopt_report, {camera} = view, boxes = view.figures[0].names.children.map((word) => {
        const p = word.position.clone().applyMatrix4(camera.matrixWorldInverse);
        return [p.x / -p.z, p.y / -p.z, word.scale.x / -p.z / 2, 0.39 * word.scale.y / -p.z];
      });
      return boxes.flatMap((a, i) => boxes.slice(i + 1).filter((b) => Math.abs(a[0] - b[0]) < a[2] + b[2] && Math.abs(a[1] - b[1]) < a[3] + b[3])).length;
    });
    check(over === 0, `${what}: no name lies over another`, over);
    await page.click("#names");
    const bare = await picture(page);
    check(bare.hash !== drawn.hash, `${what}: names can be put away`);
    check(seen.tiles.length === 0 && seen.svgs === 0 && !(await page.$("#stroke")), `${what}: no numbers, no stroke`, seen.tiles);
    check(seen.verdict === "undeflected", `${what}: says that it is undeflected`, seen.verdict);
    await page.close();
    continue;
  }
  const said = JSON.parse(readFileSync(join(folder, name, "result.json"))).verdict;
  check(seen.verdict === said.word && seen.lead === said.word + said.text, `${what}: the verdict of result.json`, seen.lead);
  if (name !== "compare") {
    check(seen.tiles.length >= 1 && seen.tiles.length <= 5, `${what}: up to five numbers`, seen.tiles);
    for (const tile of seen.tiles) check(/^[−\d.·⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+( ?[A-Za-z°%].*)?$/.test(tile) && digits(tile) <= 3, `${what}: three digits and a unit`, tile);
    const {colors} = await picture(page);
    check(colors > 40, `${what}: the mechanism is drawn`, colors);
  }
  check(seen.svgs >= 1, `${what}: plots`, seen.svgs);
  await page.close();
}
await browser.close();
finish();
