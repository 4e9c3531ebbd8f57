// Headless Chromium for the tests of the report and for the pictures of the documentation.
import {createRequire} from "node:module";
import {existsSync} from "node:fs";
import {dirname, resolve} from "node:path";
import {fileURLToPath, pathToFileURL} from "node:url";

const here = dirname(fileURLToPath(import.meta.url));
export const source = resolve(here, "../../../..");
const puppeteer = createRequire(resolve(source, "results/report/package.json"))("puppeteer-core");

export const skipped = 77;  // ctest's code of a skipped test
export const chromium = [process.env.CHROMIUM, "/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"].find((path) => path && existsSync(path));

/// Ends the test as skipped where there is no browser.
export function need_chromium() {
  if (chromium) return;
  console.log("SKIPPED: no Chromium here; install Debian's package chromium (./flexopt test does it), or name one in CHROMIUM");
  process.exit(skipped);
}

export const launch = (webgl = true) => (puppeteer.default ?? puppeteer).launch({
  executablePath: chromium, headless: true, protocolTimeout: 240000,
  args: ["--no-sandbox", "--disable-dev-shm-usage", "--hide-scrollbars", "--force-color-profile=srgb",
    ...(webgl ? ["--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"] : ["--disable-gpu", "--disable-3d-apis"])]});

/// Opens a file; `faults` grows with every console error, exception and request beside the file itself.
export async function open(browser, file, {width = 1440, height = 900, dark = false, allow = []} = {}) {
  const page = await browser.newPage(), faults = [], address = pathToFileURL(file).href;
  page.on("console", (message) => { if (message.type() === "error" && !allow.some((text) => message.text().includes(text))) faults.push(`console: ${message.text()}`); });
  page.on("pageerror", (error) => faults.push(`exception: ${error.message}`));
  page.on("request", (request) => { if (request.url() !== address && !/^(data|blob):/.test(request.url())) faults.push(`request: ${request.url()}`); });
  await page.setViewport({width, height});
  await page.emulateMediaFeatures([{name: "prefers-color-scheme", value: dark ? "dark" : "light"}]);
  const begin = performance.now();
  await page.goto(address, {waitUntil: "load", timeout: 120000});
  await page.waitForFunction(() => document.documentElement.dataset.ready === "yes", {timeout: 60000});
  return {page, faults, seconds: (performance.now() - begin) / 1000};
}

/// Checks that say what they found; finish() ends the process.
export function checker() {
  let bad = 0, good = 0;
  const check = (fine, text, found = "") => {
    if (fine) { good += 1; return; }
    bad += 1;
    console.log(`FAILED: ${text}${found === "" ? "" : `; found ${typeof found === "string" ? found : JSON.stringify(found)}`}`);
  };
  const finish = () => {
    console.log(`${good} checks good, ${bad} failed`);
    process.exit(bad > 0 || good === 0 ? 1 : 0);
  };
  return {check, finish};
}

/// A number that changes with the pixels of the three-dimensional view, and how many colours it has.
export const picture = (page) => page.evaluate(() => {
  const {view} = window.flexopt_report;
  view.draw();
  const {canvas} = view, copy = document.createElement("canvas");
  copy.width = canvas.width;
  copy.height = canvas.height;
  const draw = copy.getContext("2d");
  draw.drawImage(canvas, 0, 0);
  const {data} = draw.getImageData(0, 0, copy.width, copy.height), colors = new Set();
  let hash = 0;
  for (let i = 0; i < data.length; i += 4) {
    const color = data[i] * 65536 + data[i + 1] * 256 + data[i + 2];
    hash = (hash * 31 + color + data[i + 3]) % 1000000007;
    if (data[i + 3] > 0) colors.add(color);
  }
  return {hash, colors: colors.size};
});

export const pause = (ms) => new Promise((done) => setTimeout(done, ms));
