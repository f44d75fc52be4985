// The studio's server under requests that mean it no good: it gives nothing away, loses nothing, and still answers its
// own page.
import assert from "node:assert/strict";
import { createConnection } from "node:net";
import { after, before, test } from "node:test";
import { api, kThesisTree, removeFolder, startStudio, thesisStudy } from "./harness.mjs";

let studio;
before(async () => {
  studio = await startStudio(await thesisStudy(), "--tree", kThesisTree);
});
after(async () => {
  await studio?.stop();
  removeFolder();
});

// Sends bytes as they are; what came back until the other side closed or was silent.
function raw(bytes, { silence = 3000 } = {}) {
  return new Promise((resolve) => {
    let answer = "";
    const socket = createConnection(studio.port, "127.0.0.1", () => socket.write(bytes));
    socket.setTimeout(silence, () => socket.destroy());
    socket.on("data", (data) => {
      answer += data;
    });
    socket.on("error", () => undefined);
    socket.on("close", () => resolve(answer));
  });
}
const lines = (...all) => `${all.join("\r\n")}\r\n\r\n`;
const status = (answer) => Number(/^HTTP\/1\.1 (\d+)/.exec(answer)?.[1] ?? 0);
const host = () => `Host: 127.0.0.1:${studio.port}`;
const token = () => `X-Coppice-Token: ${studio.token}`;

async function stillServes() {
  const answer = await api(studio, "score", { tree: kThesisTree });
  assert.equal(answer.status, 200);
  assert.equal((await answer.json()).text, kThesisTree);
}

function givesNothingAway(answer) {
  assert.doesNotMatch(answer, /coppice-data|turn_left|\.coppice|root:/);
  assert.doesNotMatch(answer, new RegExp(studio.token));
}

test("nobody without the token gets anything, wherever it is put", async () => {
  for (const request of [
    lines("GET / HTTP/1.1", host(), "Connection: close"),
    lines("GET /?token=00000000000000000000000000000000 HTTP/1.1", host(), "Connection: close"),
    lines(`GET /?token=${studio.token.slice(0, -1)} HTTP/1.1`, host(), "Connection: close"),
    lines(`GET /?token=${studio.token}0 HTTP/1.1`, host(), "Connection: close"),
    lines("POST /api/status HTTP/1.1", host(), "Content-Type: application/json", "Content-Length: 2", "Connection: close") + "{}",
    lines(`POST /api/status?token=${studio.token} HTTP/1.1`, host(), "Content-Type: application/json", "Content-Length: 2", "Connection: close") + "{}",
  ]) {
    const answer = await raw(request);
    assert.equal(status(answer), 403, request);
    givesNothingAway(answer);
  }
  await stillServes();
});

test("another host or origin is refused even with the token", async () => {
  const page = `GET /?token=${studio.token} HTTP/1.1`;
  for (const [expected, ...headers] of [
    [421, "Host: evil.example"],
    [421, `Host: evil.example:${studio.port}`],
    [421, "Host: 127.0.0.1"],
    [421, `Host: 127.0.0.1:${studio.port}.evil.example`],
    [403, host(), "Origin: http://evil.example"],
    [403, host(), "Origin: null"],
    [403, host(), "Sec-Fetch-Site: cross-site"],
    [403, host(), "Sec-Fetch-Site: same-site"],
  ]) {
    const answer = await raw(lines(page, ...headers, "Connection: close"));
    assert.equal(status(answer), expected, headers.join(" "));
    givesNothingAway(answer);
  }
  const preflight = await raw(lines("OPTIONS /api/keep HTTP/1.1", host(), "Origin: http://evil.example", "Access-Control-Request-Method: POST", "Connection: close"));
  assert.doesNotMatch(preflight, /Access-Control-Allow/i);
});

test("paths lead nowhere but to what is served", async () => {
  for (const path of ["/../../etc/passwd", "/%2e%2e/%2e%2e/etc/passwd", "/api/../../etc/passwd", "/api/", "/api/page/", "/api/no_such", "//", "/api/status%00", "/page.html", `/${"a".repeat(8000)}`]) {
    const answer = await raw(lines(`POST ${path} HTTP/1.1`, host(), token(), "Content-Type: application/json", "Content-Length: 2", "Connection: close") + "{}");
    assert.ok([403, 404].includes(status(answer)), `${path.slice(0, 40)}: ${answer.slice(0, 80)}`);
    givesNothingAway(answer);
  }
  await stillServes();
});

test("bodies that are too large, endless, cut off or nonsense are refused", async () => {
  const post = (length, body, type = "application/json") => raw(lines("POST /api/score HTTP/1.1", host(), token(), `Content-Type: ${type}`, `Content-Length: ${length}`, "Connection: close") + body);
  assert.equal(status(await post(3_000_000, "x".repeat(1000))), 413);
  assert.equal(status(await post("99999999999999999999999", "x")), 413);
  assert.notEqual(status(await post(-1, "x")), 200);
  assert.equal(status(await post(2, "{}", "text/plain")), 415);
  assert.equal(status(await post(4, "nope")), 400);
  assert.equal(status(await post(2, "[]")), 400);
  assert.equal(status(await post(2, "{}")), 400);
  const deep = "[".repeat(100_000);
  assert.equal(status(await post(deep.length, deep)), 400);
  for (const body of [{ tree: 5 }, { tree: "" }, { tree: "(".repeat(5000) }, { tree: `(selector ${"move ".repeat(5000)})` }, { tree: "(selector s9=0 move)" }, { tree: "\u0000\ud800" }, { tree: null }]) {
    assert.equal((await api(studio, "score", body)).status, 400, JSON.stringify(body).slice(0, 60));
  }
  for (const [name, body] of [
    ["keep", { tree: "move", name: "", note: "" }],
    ["keep", { tree: "move", name: "x".repeat(300), note: "" }],
    ["keep", { tree: "move", name: "x", note: "y".repeat(30_000) }],
    ["keep", { tree: "move", name: 5, note: {} }],
    ["forget", { id: 10 ** 12 }],
    ["forget", { id: "1; DROP TABLE runs" }],
    ["job", { job: -1 }],
    ["walk", { tree: "move", features: [0, 0, 0, 0, 0, 0, 0, 900] }],
    ["walk", { tree: "move", features: "all" }],
    ["rules", { tree: "move", rules: new Array(1000).fill("never none") }],
    ["write", { tree: "move", format: "../../../etc/passwd" }],
    ["breed", { tree: "move", settings: { set: ["no.such=1"] } }],
    ["breed", { tree: "move", settings: { set: "all" } }],
    ["prune", { tree: "move", states: "yes" }],
  ]) {
    const answer = await api(studio, name, body);
    assert.ok(answer.status >= 400 || ["breed", "prune"].includes(name), `${name} ${JSON.stringify(body).slice(0, 60)}: ${answer.status}`);
    assert.doesNotMatch(await answer.text(), /root:/);
  }
  await stillServes();
});

test("an upload without an end, and a header without one, are cut off", async () => {
  const chunk = "10000\r\n" + "x".repeat(65536) + "\r\n";
  const endless = lines("POST /api/score HTTP/1.1", host(), token(), "Content-Type: application/json", "Transfer-Encoding: chunked") + chunk.repeat(60);
  assert.notEqual(status(await raw(endless)), 200);
  assert.notEqual(status(await raw(`GET / HTTP/1.1\r\n${host()}\r\nX-Long: ${"a".repeat(200_000)}`)), 200);
  assert.notEqual(status(await raw("\u0000\u0001\u0002 not http at all\r\n\r\n")), 200);
  await stillServes();
});

test("a thousand connections that say nothing, or half a request, keep nobody else waiting", async () => {
  const sockets = [];
  for (let i = 0; i < 1000; ++i) {
    const socket = createConnection(studio.port, "127.0.0.1");
    socket.on("error", () => undefined);
    if (i % 2 === 0) {
      socket.write(`POST /api/score HTTP/1.1\r\n${host()}\r\nContent-Length: 1000\r\n\r\n{`);
    }
    sockets.push(socket);
  }
  await stillServes();
  await stillServes();
  for (const socket of sockets) {
    socket.destroy();
  }
  await stillServes();
});

test("every answer forbids framing, sniffing, caching and a referrer", async () => {
  const page = await fetch(studio.address);
  assert.equal(page.headers.get("x-frame-options"), "DENY");
  assert.equal(page.headers.get("x-content-type-options"), "nosniff");
  assert.equal(page.headers.get("cache-control"), "no-store");
  assert.equal(page.headers.get("referrer-policy"), "no-referrer");
  assert.match(page.headers.get("content-security-policy") ?? "", /frame-ancestors 'none'/);
  assert.match(await page.text(), /default-src 'none'; script-src 'sha256-[^;]*; style-src 'sha256-[^;]*; img-src data: blob:; connect-src 'self'/);
});
