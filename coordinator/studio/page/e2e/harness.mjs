// What the end-to-end tests share: the real program, a real study, a real browser. Needs COPPICE (the program; default:
// build/release/bin/coppice) and Debian's Chromium (COPPICE_CHROMIUM). Screenshots go to COPPICE_SCREENSHOTS, if set.
// Whatever the page logs as an error, throws, or asks of anybody else fails the test that saw it.
import assert from "node:assert/strict";
import { execFile, spawn } from "node:child_process";
import { existsSync, mkdirSync, mkdtempSync, readFileSync, rmSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { createInterface } from "node:readline";
import { fileURLToPath } from "node:url";
import { promisify } from "node:util";
import { chromium } from "playwright-core";

const run = promisify(execFile);
const root = fileURLToPath(new URL("../../../../", import.meta.url));
const program = process.env.COPPICE ?? join(root, "build/release/bin/coppice");
const browserProgram = process.env.COPPICE_CHROMIUM ?? "/usr/bin/chromium";
const axeSource = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");
const screenshots = process.env.COPPICE_SCREENSHOTS;

export const folder = mkdtempSync(join(tmpdir(), "coppice-page-"));
export const removeFolder = () => rmSync(folder, { recursive: true, force: true });

export async function coppice(...words) {
  const { stdout } = await run(program, words, { cwd: folder, maxBuffer: 1 << 28 });
  return stdout;
}

// A command line as the page prints it, `coppice ...`, by a shell, with more words behind it.
export async function commandLine(line, ...more) {
  assert.match(line, /^coppice /);
  const { stdout } = await run("sh", ["-c", `"$0" ${line.slice("coppice ".length)} "$@"`, program, ...more], { cwd: folder });
  return stdout;
}

// How a command that must fail ends: {code, stderr}.
export async function failing(...words) {
  try {
    await run(program, words, { cwd: folder });
  } catch ({ code, stderr }) {
    return { code, stderr };
  }
  return { code: 0, stderr: "" };
}

// The tree that the thesis' recipe evolves on the default room with seed 28, pruned: README.md, "Start".
export const kThesisTree =
  "(selector (sequence s1=3 turn_left) (sequence turn_left s3=1 s0=3) (sequence turn_right s3=0) (sequence s3=1 s5=3) (sequence s3=1 s0=0) move)";

// A study of the default room at full scale, once for all tests.
let study;
export async function thesisStudy() {
  if (!study) {
    study = join(folder, "uav.coppice");
    await coppice("learn", "-o", study);
    await coppice("evolve", study, "--serial", "--set", "ga.search=front", "--set", "ga.generations=40", "--seed", "1");
  }
  return study;
}

export async function openBrowser() {
  assert.ok(existsSync(browserProgram), `${browserProgram} is missing: deploy/install-packages.sh page`);
  return chromium.launch({
    executablePath: browserProgram,
    args: ["--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync", "--font-render-hinting=none"],
  });
}

// A page that fails the test on any error, and on any request but those that `allowed` is true for.
export async function openPage(browser, { width = 1280, height = 900, colorScheme = "light", allowed = () => false, offline = false, clipboard = false } = {}) {
  const context = await browser.newContext({ viewport: { width, height }, colorScheme, reducedMotion: "reduce", offline, acceptDownloads: true, permissions: clipboard ? ["clipboard-read", "clipboard-write"] : [] });
  const page = await context.newPage();
  const wrong = [];
  page.on("console", (line) => line.type() === "error" && wrong.push(`console: ${line.text()}`));
  page.on("pageerror", (error) => wrong.push(`error: ${error.message}`));
  page.on("request", (request) => !allowed(request.url()) && wrong.push(`request: ${request.url()}`));
  page.check = () => assert.deepEqual(wrong, []);
  page.forgive = (pattern) => {
    for (let i = wrong.length - 1; i >= 0; --i) {
      if (pattern.test(wrong[i])) {
        wrong.splice(i, 1);
      }
    }
  };
  return page;
}

export const ready = (page) => page.waitForFunction(() => document.documentElement.dataset.ready !== undefined, null, { timeout: 120_000 });

export async function shot(page, name, options = {}) {
  if (screenshots) {
    mkdirSync(screenshots, { recursive: true });
    await page.screenshot({ path: join(screenshots, `${name}.png`), ...options });
  }
}

export async function accessible(page) {
  await page.evaluate(axeSource); // not a script element: the page's policy would refuse it
  const { violations } = await page.evaluate(() => globalThis.axe.run());
  assert.deepEqual(
    violations.map((v) => `${v.id}: ${v.help}: ${v.nodes.slice(0, 3).map((n) => `${n.target} ${n.any.map((a) => a.message).join("; ")}`).join(" | ")}`),
    [],
  );
}

// `coppice studio`, until stop(). Its address is the first line that it prints.
export async function startStudio(studyPath, ...words) {
  const child = spawn(program, ["studio", studyPath, ...words], { cwd: folder, stdio: ["ignore", "pipe", "pipe"] });
  const errors = [];
  child.stderr.on("data", (text) => errors.push(String(text)));
  const ended = new Promise((resolve) => child.once("exit", (code, signal) => resolve({ code, signal })));
  const address = await Promise.race([
    new Promise((resolve) => createInterface({ input: child.stdout }).once("line", resolve)),
    ended.then(({ code }) => {
      throw new Error(`coppice studio ended with ${code}: ${errors.join("")}`);
    }),
  ]);
  const url = new URL(address);
  return {
    address,
    origin: url.origin,
    port: Number(url.port),
    token: url.searchParams.get("token"),
    allowed: (asked) => asked.startsWith(url.origin) || asked.startsWith("blob:"),
    child,
    stop: async () => {
      child.kill("SIGINT");
      return ended;
    },
  };
}

export const api = (studio, name, body = {}, headers = {}) =>
  fetch(`${studio.origin}/api/${name}`, {
    method: "POST",
    headers: { "Content-Type": "application/json", "X-Coppice-Token": studio.token, ...headers },
    body: typeof body === "string" ? body : JSON.stringify(body),
  });
