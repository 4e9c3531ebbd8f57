// Clients that mean no good get nothing, and stop nothing: a good request is answered meanwhile.
//   node test_hostile.mjs FLEXOPT
import {connect} from "node:net";
import {existsSync} from "node:fs";
import {join} from "node:path";
import {checker, pause, source} from "../../report/browser/browser.mjs";
import {post, served} from "./served.mjs";

const flexopt = process.argv[2], {check, finish} = checker();
const within = 2;  // seconds that a good request may take beside all that
const server = await served(flexopt, ["explore", join(source, "tests/results/server/jobs/hinge.json")]);
const {port, token} = server, here = `127.0.0.1:${port}`;
const good_move = {parameters: {length: 0.051}};

/// Sends bytes and gives what comes back until the socket is closed, or for so long.
const raw = (pieces, {ms = 3000} = {}) => new Promise((done) => {
  let text = "";
  const socket = connect(port, "127.0.0.1", () => { for (const piece of [pieces].flat()) socket.write(piece); });
  const end = () => { socket.destroy(); done(text); };
  socket.on("data", (part) => { text += part; });
  socket.on("close", end);
  socket.on("error", end);
  setTimeout(end, ms);
});
const status_of = (text) => Number(/^HTTP\/1\.1 (\d+)/.exec(text)?.[1] ?? 0);
const request = (line, headers = {}, body = "") =>
  `${line}\r\n${Object.entries({Host: here, ...headers}).filter(([, v]) => v !== null).map(([k, v]) => `${k}: ${v}\r\n`).join("")}\r\n${body}`;
const post_text = (path, body, headers = {}) => request(`POST ${path} HTTP/1.1`, {"X-Flexopt-Token": token, "Content-Length": Buffer.byteLength(body), ...headers}, body);
const get_text = (path, headers) => request(`GET ${path} HTTP/1.1`, headers);

/// A good request, with the time that it takes.
async function still_good(what) {
  const answer = await post(server, "/job", good_move);
  check(answer.status === 200 && JSON.parse(answer.text).design.parameters.length === 0.051, `good requests are answered: ${what}`, answer.status);
  check(answer.seconds < within, `and soon: ${what}`, answer.seconds);
  return answer.seconds;
}
async function refused(what, text, expected) {
  const answer = await raw(text), status = status_of(answer);
  check([expected].flat().includes(status), what, answer.slice(0, 200));
  check(!/"design"|<script|youngs/.test(answer), `${what}: nothing is told`, answer.slice(0, 300));
}

check((await raw(get_text(`/?token=${token}`))).startsWith("HTTP/1.1 200"), "the page itself opens");
await still_good("at first");

// Who asks.
await refused("no token", get_text("/"), 403);
await refused("an empty token", get_text("/?token="), 403);
await refused("half a token", get_text(`/?token=${token.slice(0, 16)}`), 403);
await refused("another token", get_text(`/?token=${"0".repeat(32)}`), 403);
await refused("a longer token", get_text(`/?token=${token}0`), 403);
await refused("a POST without token", post_text("/evaluate", JSON.stringify(good_move), {"X-Flexopt-Token": null}), 403);
await refused("a POST with the token in its address alone", post_text(`/evaluate?token=${token}`, JSON.stringify(good_move), {"X-Flexopt-Token": null}), 403);
for (const origin of ["http://evil.example", `http://127.0.0.1:${port + 1}`, `https://127.0.0.1:${port}`, "null", `http://127.0.0.1:${port}.evil.example`])
  await refused(`from ${origin}`, post_text("/evaluate", JSON.stringify(good_move), {Origin: origin}), 403);
for (const host of ["evil.example", `evil.example:${port}`, "127.0.0.1", `127.0.0.1:${port + 1}`, `127.0.0.1:${port}@evil.example`, "", `[::1]:${port}`])
  await refused(`for the host "${host}"`, get_text(`/?token=${token}`, {Host: host}), [421, 400]);
await refused("no host at all", get_text(`/?token=${token}`, {Host: null}), [421, 400]);
await refused("two hosts", `GET /?token=${token} HTTP/1.1\r\nHost: ${here}\r\nHost: evil.example\r\n\r\n`, 400);
await refused("two tokens", `POST /job HTTP/1.1\r\nHost: ${here}\r\nX-Flexopt-Token: ${token}\r\nX-Flexopt-Token: x\r\nContent-Length: 2\r\n\r\n{}`, 400);
check((await fetch(`http://localhost:${port}/?token=${token}`).catch(() => ({status: 0}))).status === 200, "localhost is here too");

// Where to.
for (const path of ["/../../etc/passwd", "/..%2f..%2fetc/passwd", "//etc/passwd", "/etc/passwd", "/%2e%2e/job.json", "/evaluate/../../x", "/.git/config", "/%00", "/job", "/evaluate", "/state", "/favicon.ico"])
  await refused(`the path ${path}`, get_text(path, {"X-Flexopt-Token": token}), [400, 404]);
await refused("an address of another server", get_text(`http://evil.example/?token=${token}`, {"X-Flexopt-Token": token}), 400);
for (const path of ["/../x", "/save", "/job/", "/job.json", "/evaluate%00", "/state"])
  await refused(`a POST to ${path}`, post_text(path, JSON.stringify(good_move)), [400, 404]);
for (const method of ["PUT", "DELETE", "PATCH", "OPTIONS", "HEAD", "TRACE", "CONNECT", "get", "PRI"])
  await refused(`the method ${method}`, request(`${method} /?token=${token} HTTP/1.1`), 405);

// What.
const wrong = {
  "nothing": "", "no JSON": "}{", "half a JSON": '{"parameters": {"length": 0.05', "an array": "[1]", "a number": "1", "null": "null",
  "no parameters": "{}", "parameters that are a text": '{"parameters": "length"}', "another key": '{"parameters": {}, "out": "/tmp/flexopt_test_hostile_out"}',
  "NaN": '{"parameters": {"length": NaN}}', "Infinity": '{"parameters": {"length": Infinity}}', "1e999": '{"parameters": {"length": 1e999}}', "-1e999": '{"parameters": {"length": -1e999}}',
  "null as a number": '{"parameters": {"length": null}}', "a text as a number": '{"parameters": {"length": "0.05"}}', "true": '{"parameters": {"length": true}}', "an object": '{"parameters": {"length": {"expression": "1"}}}',
  "too large": '{"parameters": {"length": 0.11}}', "too small": '{"parameters": {"length": 0.001}}', "negative": '{"parameters": {"length": -0.05}}', "zero": '{"parameters": {"thickness": 0}}',
  "a formula's parameter": '{"parameters": {"outer_width": 0.02}}', "another parameter": '{"parameters": {"mass": 1}}', "a pointer": '{"parameters": {"/design/file": 1}}', "a path": '{"parameters": {"../../x": 1}}',
  "the prototype": '{"parameters": {"__proto__": 1}}', "a name twice": '{"parameters": {"length": 0.05, "length": 0.06}}', "deep nesting": "[".repeat(30000), "not UTF-8": Buffer.from([0x7b, 0x22, 0xff, 0xfe, 0x22, 0x7d]).toString("latin1"),
  "a zero byte": '{"parameters": {"length\u0000": 0.05}}', "a comment": '{"parameters": {} /* x */}',
};
for (const [what, body] of Object.entries(wrong)) for (const path of ["/evaluate", "/job"])
  await refused(`${what} to ${path}`, post_text(path, body), 400);
await still_good("after wrong moves");

// How.
await refused("a gigabyte that is announced", post_text("/evaluate", "x", {"Content-Length": 1e9}), 413);
await refused("a body just too large", post_text("/evaluate", "x".repeat(65537)), 413);
await refused("a length of 40 digits", post_text("/evaluate", "x", {"Content-Length": "9".repeat(40)}), 400);
await refused("a negative length", post_text("/evaluate", "x", {"Content-Length": -1}), 400);
await refused("a length that is no number", post_text("/evaluate", "x", {"Content-Length": "1e1"}), 400);
await refused("two lengths", `POST /job HTTP/1.1\r\nHost: ${here}\r\nX-Flexopt-Token: ${token}\r\nContent-Length: 2\r\nContent-Length: 5\r\n\r\n{}`, 400);
await refused("no length", post_text("/evaluate", "{}", {"Content-Length": null}), 411);
await refused("chunks", post_text("/evaluate", "5\r\nhello\r\n", {"Content-Length": null, "Transfer-Encoding": "chunked"}), 501);
await refused("chunks and a length", post_text("/evaluate", "{}", {"Transfer-Encoding": "chunked"}), 501);
await refused("a request behind the request", post_text("/evaluate", "{}") + get_text("/"), 400);
await refused("headers without end", `GET / HTTP/1.1\r\n${"X: y\r\n".repeat(3000)}`, 431);
await refused("a long header", get_text(`/?token=${token}`, {X: "y".repeat(9000)}), 431);
await refused("a long address", get_text(`/?token=${"0".repeat(5000)}`), 414);
await refused("a folded header", `GET /?token=${token} HTTP/1.1\r\nHost: ${here}\r\n folded\r\n\r\n`, 400);
await refused("a header without a name", `GET /?token=${token} HTTP/1.1\r\nHost: ${here}\r\n: x\r\n\r\n`, 400);
await refused("another version", request(`GET /?token=${token} HTTP/2.0`), 505);
await refused("no HTTP", "\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03\r\n\r\n", 400);
for (const [what, headers] of Object.entries({"ranges": {Range: `bytes=${"0-,".repeat(2000)}0-1`}, "an encoding": {"Accept-Encoding": "gzip, br"}, "an upgrade": {Connection: "Upgrade", Upgrade: "websocket"}}))
  check(/^HTTP\/1\.1 200/.test(await raw(get_text(`/?token=${token}`, headers))) && !/content-encoding|content-range/i.test((await raw(get_text(`/?token=${token}`, headers))).split("\r\n\r\n")[0]), `${what} in the headers changes nothing`);

// Much. Gigabytes that really come, announced and in chunks, from several at once.
const flood = (head) => new Promise((done) => {
  const socket = connect(port, "127.0.0.1", () => { socket.write(head); more(); });
  const part = Buffer.alloc(1 << 20, 0x78);
  let sent = 0, text = "", over = false;
  const end = () => { if (!over) { over = true; socket.destroy(); done({sent, text}); } };
  const more = () => { while (!over && sent < 1e9 && socket.write(part)) sent += part.length; };
  socket.on("drain", more);
  socket.on("data", (d) => { text += d; });
  socket.on("error", end);
  socket.on("close", end);
  setTimeout(end, 20000);
});
const floods = [...Array(4)].flatMap(() => [
  flood(`POST /evaluate HTTP/1.1\r\nHost: ${here}\r\nX-Flexopt-Token: ${token}\r\nContent-Length: 1000000000\r\n\r\n`),
  flood(`POST /evaluate HTTP/1.1\r\nHost: ${here}\r\nX-Flexopt-Token: ${token}\r\nTransfer-Encoding: chunked\r\n\r\n40000000\r\n`)]);
await still_good("beside floods");
for (const {sent, text} of await Promise.all(floods)) check(sent < 1e8 && (text === "" || [413, 501].includes(status_of(text))), "a gigabyte is cut off", [sent, text.slice(0, 60)]);

// Slowly. Many sockets that send a letter now and then, or nothing; heads and bodies.
const slow = [];
for (let k = 0; k < 600; ++k) {
  const socket = connect(port, "127.0.0.1");
  socket.on("error", () => {});
  socket.resume();
  slow.push(socket);
  const text = k % 3 === 0 ? "" : k % 3 === 1 ? get_text(`/?token=${token}`) : post_text("/evaluate", "x".repeat(60000));
  let sent = k % 3 === 2 ? 200 : 0;
  socket.on("connect", () => socket.write(text.slice(0, sent)));
  socket.drip = setInterval(() => { if (sent < text.length && !socket.destroyed) socket.write(text[sent++]); }, 150);
}
await pause(500);
const times = [];
for (let k = 0; k < 15; ++k) { times.push(await still_good("beside 600 slow sockets")); await pause(300); }
const evaluated = await post(server, "/evaluate", good_move);
check(evaluated.status === 200 && JSON.parse(evaluated.text).ok, "an evaluation too", evaluated.status);
console.log(`beside 600 slow sockets a good request took at most ${(1e3 * Math.max(...times)).toFixed(0)} ms`);
for (let k = 0; k < 40 && slow.some((s) => !s.destroyed); ++k) await pause(250);
check(slow.every((s) => s.destroyed || s.readyState !== "open"), "slow sockets are closed", slow.filter((s) => !s.destroyed).length);
for (const socket of slow) { clearInterval(socket.drip); socket.destroy(); }

// Readers that do not read, and many at once.
const deaf = [...Array(12)].map(() => { const s = connect(port, "127.0.0.1", () => s.write(get_text(`/?token=${token}`))); s.pause(); s.on("error", () => {}); return s; });
await pause(200);
await still_good("beside readers that do not read");
for (const socket of deaf) socket.destroy();
const crowd = await Promise.all([...Array(150)].map(() => post(server, "/job", good_move).catch(() => ({status: 0}))));
check(crowd.every((a) => a.status === 200 || a.status === 503), "a crowd is answered", [...new Set(crowd.map((a) => a.status))]);
const moves = await Promise.all([...Array(30)].map((_, k) => post(server, "/evaluate", {parameters: {length: 0.05 + 1e-4 * k}})));
const done = moves.filter((a) => a.status === 200).length;
check(moves.every((a) => [200, 409].includes(a.status)) && done >= 1 && done <= 10, "of many moves few are evaluated", moves.map((a) => a.status));
await still_good("at last");
check(!existsSync("/tmp/flexopt_test_hostile_out"), "no file was made");
check(await server.closed() === 0, "and Ctrl-C ends it with exit code 0");
finish();
