// A report, opened from the disk with the network off.
import assert from "node:assert/strict";
import { copyFileSync, existsSync, readFileSync, statSync } from "node:fs";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { pathToFileURL } from "node:url";
import { accessible, coppice, failing, folder, openBrowser, openPage, ready, removeFolder, shot, thesisStudy } from "./harness.mjs";

let browser;
let file;
const own = (url) => url.startsWith("file:");

before(async () => {
  browser = await openBrowser();
  const study = await thesisStudy();
  file = join(folder, "report.html");
  await coppice("report", study, "-o", file);
});
after(async () => {
  await browser?.close();
  removeFolder();
});

async function open(options = {}) {
  const page = await openPage(browser, { allowed: own, offline: true, ...options });
  await page.goto(pathToFileURL(file).href);
  await ready(page);
  return page;
}

test("the report asks the network for nothing and shows its seven sections without an error", async () => {
  const page = await open();
  assert.equal(await page.getByRole("heading", { level: 2 }).count(), 7);
  page.check();
  await page.context().close();
});

for (const colorScheme of ["light", "dark"]) {
  for (const width of [1280, 390]) {
    test(`the report reads well at ${width} pixels, ${colorScheme}: nothing is wider than the page, axe finds nothing`, async () => {
      const page = await open({ width, colorScheme });
      const wider = await page.evaluate(() => document.documentElement.scrollWidth - document.documentElement.clientWidth);
      assert.equal(wider, 0);
      await page.locator("#tree").getByRole("treeitem").nth(2).click();
      for (const summary of await page.locator("summary").all()) {
        await summary.click();
      }
      await accessible(page);
      page.check();
      await page.context().close();
      const fresh = await open({ width, colorScheme });
      await shot(fresh, `report-${width}-${colorScheme}`, { fullPage: true });
      await fresh.context().close();
    });
  }
}

test("a node that is pointed at, by mouse or by key, says what reaches it", async () => {
  const page = await open();
  const tree = page.locator("#tree").getByRole("tree");
  await tree.getByRole("treeitem").first().click();
  const focusBeyond = (node) =>
    page.waitForFunction((least) => Number(document.activeElement?.getAttribute("data-node")) > least, node);
  await page.keyboard.press("ArrowRight");
  await focusBeyond(0); // the page moves the focus once it has drawn
  await page.keyboard.press("ArrowDown");
  await focusBeyond(1);
  const focused = await page.evaluate(() => document.activeElement?.getAttribute("data-node"));
  await page.getByRole("heading", { name: `Node ${focused}:` }).waitFor();
  assert.match(await page.locator("#tree .detail").first().innerText(), /A tick comes here in \d/);
  page.check();
  await page.context().close();
});

test("every point of the front is a tree that opens and stands beside the answer", async () => {
  const page = await open();
  const points = page.locator("#front .point");
  assert.ok((await points.count()) > 3);
  await points.nth(1).click();
  await page.locator("#front").getByRole("button", { name: "Open" }).click();
  assert.match(await page.locator("#answer .verdict").innerText(), /Shown is tree 1 of the front/);
  await page.getByRole("button", { name: "Put the answer beside" }).click();
  assert.match(await page.locator("#front").innerText(), /They act differently in \d/);
  assert.equal(await page.locator("#tree").getByRole("tree").count(), 2);
  await page.locator("#front").getByLabel("upwards").selectOption("coverage");
  await page.getByRole("button", { name: "Back to the answer" }).click();
  page.check();
  await page.context().close();
});

test("a run with demes shows the curves of each", async () => {
  const study = join(folder, "demes.coppice");
  copyFileSync(await thesisStudy(), study);
  await coppice("evolve", study, "--serial", "--seed", "3", "--set", "ga.search=scalar", "--set", "ga.demes=4", "--set", "ga.generations=30", "--set", "ga.population=80");
  // The same curves by workers, in the data of the page.
  const byWorkers = join(folder, "demes-workers.coppice");
  copyFileSync(await thesisStudy(), byWorkers);
  await coppice("evolve", byWorkers, "--workers", "2", "--seed", "3", "--set", "ga.search=scalar", "--set", "ga.demes=4", "--set", "ga.generations=30", "--set", "ga.population=80");
  const demesOf = async (path) => JSON.parse(await coppice("report", path, "--tree", "move", "--json")).runs.at(-1).demes;
  const kept = await demesOf(study);
  assert.equal(kept.generation.length, 30);
  assert.deepEqual(await demesOf(byWorkers), kept);
  const html = join(folder, "demes.html");
  await coppice("report", study, "--tree", "move", "-o", html);
  const page = await openPage(browser, { allowed: own, offline: true });
  await page.goto(pathToFileURL(html).href);
  await ready(page);
  const curves = page.locator("#curves");
  await curves.getByRole("heading", { name: "Each deme" }).waitFor();
  assert.equal(await curves.getByLabel("deme", { exact: true }).locator("option").count(), 4);
  await curves.getByLabel("deme", { exact: true }).selectOption("2");
  await curves.getByText("Deme 3: fitness").first().waitFor();
  assert.equal(await curves.locator("figure").filter({ hasText: "Deme 3: size" }).locator("path.line").count(), 5);
  await curves.getByRole("heading", { name: "Each deme" }).scrollIntoViewIfNeeded();
  await curves.locator("label").filter({ hasText: /^over/ }).locator("select").selectOption("evaluations");
  assert.match(await curves.locator("figure").filter({ hasText: "Deme 3: size" }).textContent(), /evaluations/);
  await shot(page, "report-demes");
  await accessible(page);
  page.check();
  await page.context().close();
});

test("the world is replayed step by step, with the way through the tree lit", async () => {
  const page = await open();
  const world = page.locator("#world");
  const motions = world.getByRole("group", { name: "Which replay" }).getByRole("button");
  assert.ok((await motions.count()) >= 4, "whole episodes and the thesis' motions");
  await motions.nth(1).click();
  await world.getByRole("button", { name: "Forward" }).click();
  const before = await world.locator(".agent").getAttribute("transform");
  assert.ok((await page.locator("#tree .node.lit").count()) > 1);
  for (let i = 0; i < 3; ++i) {
    await world.getByRole("button", { name: "Forward" }).click();
  }
  assert.notEqual(await world.locator(".agent").getAttribute("transform"), before);
  for (let i = 0; i < 3; ++i) {
    await world.getByRole("button", { name: "Back" }).click();
  }
  assert.equal(await world.locator(".agent").getAttribute("transform"), before);
  page.check();
  await page.context().close();
});

test("search finds nodes, zoom and folding change the drawing", async () => {
  const page = await open();
  await page.getByLabel("Search").fill("move");
  await page.getByText(/^\d+ found$/).waitFor();
  assert.ok((await page.locator("#tree .node.found").count()) > 0);
  const tree = page.locator("#tree").getByRole("tree");
  const width = async () => Number(await tree.getAttribute("width"));
  const first = await width();
  await page.getByRole("button", { name: "Zoom in" }).click();
  assert.ok((await width()) > first);
  const nodes = await tree.getByRole("treeitem").count();
  await tree.getByRole("treeitem").nth(1).dblclick();
  assert.ok((await tree.getByRole("treeitem").count()) < nodes);
  await page.getByRole("button", { name: "Expand all" }).click();
  assert.equal(await tree.getByRole("treeitem").count(), nodes);
  page.check();
  await page.context().close();
});

test("wrong use is said, and leaves no file", async () => {
  const study = await thesisStudy();
  const out = join(folder, "wrong.html");
  for (const [words, part, exit = 2] of [
    [["report", study], "-o FILE.html or --json"],
    [["report", join(folder, "none.coppice"), "-o", out], "none.coppice", 3],
    [["report", study, "-o", study], "-o"],
    [["report", study, "--tree", "(selector jump)", "-o", out], "jump"],
    [["report", study, "--run", "99", "-o", out], "99", 3],
    [["report", study, "--episodes", "1", "-o", out], "--episodes"],
    [["studio", study, "--port", "70000"], "--port"],
    [["studio", join(folder, "none.coppice")], "none.coppice", 3],
  ]) {
    const { code, stderr } = await failing(...words);
    assert.equal(code, exit, `${words.join(" ")}: ${stderr}`);
    assert.ok(stderr.includes(part), `${words.join(" ")}: ${stderr}`);
  }
  assert.ok(!existsSync(out));
  assert.equal((await failing("report", study, "-o", file)).code, 2, "it exists, and nobody said --force");
  const nowhere = await failing("report", study, "-o", join(folder, "no", "such", "folder.html"));
  assert.equal(nowhere.code, 1);
});

test("the same study gives the same report, byte for byte", async () => {
  const study = await thesisStudy();
  const first = readFileSync(file);
  await coppice("report", study, "-o", file, "--force");
  assert.ok(first.equals(readFileSync(file)));
  assert.equal(JSON.parse(await coppice("report", study, "--json")).format, "coppice page");
});

test("a study of a million states is a report of at most 10 MB that opens within 3 s", async () => {
  const large = join(folder, "large.coppice");
  await coppice("synth", "-o", large);
  const page = join(folder, "large.html");
  const tree = "(selector (sequence f0=0 f1<=1 a0) (sequence f2=1 a1) a2)";
  await coppice("report", large, "--tree", tree, "-o", page);
  assert.ok(statSync(page).size <= 10_000_000, `${statSync(page).size} bytes`);
  const opened = await openPage(browser, { allowed: own, offline: true });
  const from = performance.now();
  await opened.goto(pathToFileURL(page).href);
  await ready(opened);
  const seconds = (performance.now() - from) / 1000;
  console.log(`# ${statSync(page).size} bytes, open after ${seconds.toFixed(2)} s`);
  assert.match(await opened.locator("#provenance").innerText(), /of 1.000.000 are in this page/);
  assert.match(await opened.locator("#world").innerText(), /A walk from the initial state/);
  await accessible(opened);
  opened.check();
  await opened.context().close();
});
