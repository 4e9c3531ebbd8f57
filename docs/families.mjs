// Draws docs/families.png: the slanting views of `flexopt designs FAMILY --svg`, in headless Chromium.
//   node docs/families.mjs build/release/flexopt docs/families.png
import {execFileSync} from "node:child_process";
import {launch} from "../tests/results/report/browser/browser.mjs";

const [program, picture] = process.argv.slice(2);
const run = (...words) => execFileSync(program, words, {encoding: "utf8"});
const names = run("designs").split("\nMaterials:")[0].split("\n").slice(1)
  .map((line) => line.trim().split(" ")[0]).filter(Boolean);

/// The drawing of a family, cut to its slanting view.
function slanting(name) {
  const svg = run("designs", name, "--svg"), box = svg.match(/<view id="slanting" viewBox="([^"]+)"/)[1];
  const [x, y] = box.split(" ");
  const cut = svg.replace(/width="\d+" height="\d+" viewBox="[^"]+"/, `viewBox="${box}"`)
    .replace(/(class="paper" )x="[^"]+" y="[^"]+"/, `$1x="${x}" y="${y}"`);
  return `data:image/svg+xml;base64,${Buffer.from(cut).toString("base64")}`;
}

const cells = names.map((name) => `<figure><figcaption>${name}</figcaption><img src="${slanting(name)}"></figure>`);
const browser = await launch(false), page = await browser.newPage();
await page.setViewport({width: 1240, height: 800});
await page.emulateMediaFeatures([{name: "prefers-color-scheme", value: "light"}]);
await page.setContent(`<style>
  body { margin: 8px; display: grid; grid-template-columns: repeat(6, 1fr); gap: 10px; background: #fff; }
  figure { margin: 0; text-align: center; font: 13px "DejaVu Sans", sans-serif; }
  img { width: 100%; height: 160px; object-fit: contain; }
</style>${cells.join("")}`, {waitUntil: "load"});
await page.screenshot({path: picture, fullPage: true});
await browser.close();
