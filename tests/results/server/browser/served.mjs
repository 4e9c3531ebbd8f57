// Starts flexopt's servers for the tests, and opens their pages.
import {spawn} from "node:child_process";
import {once} from "node:events";

/// {address, origin, port, token, closed(signal)}: a running server. closed() ends it and gives its
/// exit code.
export async function served(flexopt, args) {
  const child = spawn(flexopt, args, {stdio: ["ignore", "pipe", "inherit"]});
  const ended = once(child, "exit");
  let text = "";
  for await (const part of child.stdout) { text += part; if (text.includes("\n")) break; }
  const address = text.trim(), url = new URL(address);
  return {address, origin: url.origin, port: Number(url.port), token: url.searchParams.get("token"), child,
    closed: async (signal = "SIGINT") => { child.kill(signal); return (await ended)[0]; }};
}

/// The answer to a good request: {status, text, seconds}.
export async function post(server, path, body, headers = {}) {
  const begin = performance.now();
  const response = await fetch(server.origin + path, {method: "POST", body: typeof body === "string" ? body : JSON.stringify(body), headers: {"X-Flexopt-Token": server.token, ...headers}});
  return {status: response.status, text: await response.text(), seconds: (performance.now() - begin) / 1000};
}

/// Opens an address; `faults` grows with every console error, exception, and request to elsewhere.
export async function open_page(browser, server, {width = 1440, height = 900} = {}) {
  const page = await browser.newPage(), faults = [];
  page.on("console", (message) => { if (message.type() === "error") faults.push(`console: ${message.text()} ${message.location().url ?? ""}`); });
  page.on("pageerror", (error) => faults.push(`exception: ${error.message}`));
  page.on("request", (request) => { if (!request.url().startsWith(`${server.origin}/`) && !/^(data|blob):/.test(request.url())) faults.push(`request: ${request.url()}`); });
  await page.setViewport({width, height});
  await page.goto(server.address, {waitUntil: "load", timeout: 120000});
  return {page, faults};
}
