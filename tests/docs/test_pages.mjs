// Pages of the site in headless Chromium, on a desk and on a telephone: nothing is cut off at the side, pictures
// are there, nothing is asked from a network, light and dark differ.
//   node test_pages.mjs SITE [PICTURES]     writes screenshots to the folder PICTURES
import {existsSync, mkdirSync} from "node:fs";
import {resolve} from "node:path";
import {pathToFileURL} from "node:url";
import {checker, launch, need_chromium, skipped} from "../results/report/browser/browser.mjs";

const [site, pictures] = process.argv.slice(2).map((path) => resolve(path));
need_chromium();
if (!existsSync(resolve(site, "index.html"))) {
  console.log("SKIPPED: the site was not built");
  process.exit(skipped);
}
const pages = ["index", "docs/tutorial", "gallery/families", "gallery/families/infinity_hinge", "gallery/jobs",
  "gallery/jobs/parallel_guide", "reference/jobs", "reference/quantities", "reference/commands",
  "core/elements/README", "docs/benchmarks", "docs/designs"];
const {check, finish} = checker();
const browser = await launch(false);
const backgrounds = new Set();
for (const width of [1440, 420])
  for (const name of pages) {
    const page = await browser.newPage(), where = `${name} at ${width}`;
    page.on("request", (request) => check(/^(file|data):/.test(request.url()), `${where} asks no network`, request.url()));
    page.on("requestfailed", (request) => check(false, `${where} finds its files`, request.url()));
    page.on("pageerror", (error) => check(false, `${where} has no error`, error.message));
    await page.setViewport({width, height: 1400});
    const dark = width === 420 && name === "index";
    await page.emulateMediaFeatures([{name: "prefers-color-scheme", value: dark ? "dark" : "light"}]);
    await page.goto(pathToFileURL(resolve(site, `${name}.html`)).href, {waitUntil: "load"});
    const seen = await page.evaluate(() => ({
      room: document.documentElement.clientWidth, needed: document.documentElement.scrollWidth,
      background: getComputedStyle(document.body).backgroundColor,
      missing: [...document.images].filter((image) => image.complete && image.naturalWidth === 0).map((image) => image.src),
      outside: [...document.querySelectorAll("article p, article h1, article h2, article h3, article img, article pre, article table")]
        .filter((part) => part.offsetParent && !part.closest("table, pre") && part.getBoundingClientRect().right > document.documentElement.clientWidth + 1)
        .map((part) => part.textContent.slice(0, 60))}));
    check(seen.needed <= seen.room, `${where} needs no scrolling sideways`, seen.needed);
    check(seen.outside.length === 0, `${where} has nothing beyond its border`, seen.outside);
    check(seen.missing.length === 0, `${where} shows its pictures`, seen.missing);
    if (name === "index") backgrounds.add(seen.background);
    if (pictures) {
      mkdirSync(pictures, {recursive: true});
      await page.screenshot({path: resolve(pictures, `${name.replaceAll("/", "_")}_${width}.png`)});
    }
    await page.close();
  }
check(backgrounds.size === 2, "light and dark have backgrounds of their own", [...backgrounds]);
await browser.close();
finish();
