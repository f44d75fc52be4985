// Report and studio of a study that is none of ours: a log with continuous readings, several starts, ends, labels and a
// simulator of its own.
import assert from "node:assert/strict";
import { writeFileSync } from "node:fs";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { pathToFileURL } from "node:url";
import { accessible, coppice, folder, openBrowser, openPage, ready, removeFolder, shot, startStudio } from "./harness.mjs";

let browser;
let study;

// A trolley on a rail from -1 to 1, pushed left or right; the right end earns 10, the left one costs 10.
const trolley = `
export const begin = (seed) => ({ x: [-0.5, 0, 0.5][seed % 3], v: 0 });
export const push = ({ x, v }, right) => {
  const speed = Math.max(-0.3, Math.min(0.3, v + (right ? 0.05 : -0.05) - 0.03 * Math.cos(3 * x)));
  const place = Math.max(-1, Math.min(1, x + speed));
  const ended = Math.abs(place) === 1;
  return { next: { x: place, v: speed }, reward: ended ? 10 * place : -0.1, ended, crash: place === -1 };
};
`;
const simulator = `
import { createInterface } from "node:readline";
import { begin, push } from "./trolley.mjs";
const say = (answer) => console.log(JSON.stringify(answer));
const places = [];
say({ coppice_simulator: 1, features: ["place", "speed"], actions: ["left", "right"], episodes: 16, collisions: true });
createInterface({ input: process.stdin }).on("line", (line) => {
  const { id, reset, seeds, step, actions } = JSON.parse(line);
  if (reset) {
    reset.forEach((place, i) => { places[place] = begin(seeds[i]); });
    say({ id, observations: reset.map((place) => [places[place].x, places[place].v]) });
    return;
  }
  const done = step.map((place, i) => push(places[place], actions[i] === 1));
  done.forEach((each, i) => { places[step[i]] = each.next; });
  say({ id, observations: done.map(({ next }) => [next.x, next.v]), rewards: done.map((d) => d.reward), terminated: done.map((d) => d.ended), truncated: done.map(() => false), collisions: done.map((d) => d.crash) });
});
`;

before(async () => {
  browser = await openBrowser();
  writeFileSync(join(folder, "trolley.mjs"), trolley);
  writeFileSync(join(folder, "simulator.mjs"), simulator);
  const { begin, push } = await import(pathToFileURL(join(folder, "trolley.mjs")).href);
  let seed = 1;
  const random = () => (seed = (seed * 48271) % 2147483647) / 2147483647;
  const lines = [
    JSON.stringify({ format: "coppice-log-1", title: "Trolley", features: [{ name: "place", label: "place on the rail", unit: "m" }, { name: "speed", label: "speed", unit: "m/s" }], actions: [{ name: "left", label: "push left" }, { name: "right", label: "push right" }], discount: 0.98 }),
  ];
  for (let episode = 0; episode < 400; ++episode) {
    let state = begin(episode);
    for (let step = 0; step < 100; ++step) {
      // Swings up where a push alone is too weak.
      const right = random() < 0.15 ? random() < 0.5 : state.v >= 0 || state.x > 0.6;
      const { next, reward, ended } = push(state, right);
      lines.push(JSON.stringify({ episode, step, observation: [state.x, state.v], action: right ? 1 : 0, reward, next_observation: [next.x, next.v], terminated: ended, truncated: step === 99 && !ended }));
      if (ended) {
        break;
      }
      state = next;
    }
  }
  writeFileSync(join(folder, "trolley.jsonl"), `${lines.join("\n")}\n`);
  study = join(folder, "trolley.coppice");
  await coppice("import", "trolley.jsonl", "-o", study, "--simulator", "node simulator.mjs");
  await coppice("evolve", study, "--serial", "--seed", "1", "--set", "ga.generations=60");
});
after(async () => {
  await browser?.close();
  removeFolder();
});

test("the report of an imported study speaks in its units and labels, and shows its walks as tables", async () => {
  const file = join(folder, "trolley.html");
  await coppice("report", study, "-o", file);
  for (const [width, colorScheme] of [[1280, "light"], [390, "dark"]]) {
    const page = await openPage(browser, { allowed: (url) => url.startsWith("file:"), offline: true, width, colorScheme });
    await page.goto(pathToFileURL(file).href);
    await ready(page);
    assert.match(await page.locator("#answer").innerText(), /place on the rail|speed/);
    assert.match(await page.locator("#answer").innerText(), /\bm\b|m\/s/);
    assert.match(await page.locator("#provenance").innerText(), /trolley\.jsonl/);
    const world = page.locator("#world");
    assert.equal(await world.locator(".agent").count(), 0, "there is no room");
    assert.match(await world.innerText(), /push (left|right)/);
    assert.equal(await page.evaluate(() => document.documentElement.scrollWidth - document.documentElement.clientWidth), 0);
    await accessible(page);
    page.check();
    await shot(page, `imported-${width}-${colorScheme}`, { fullPage: true });
    await page.context().close();
  }
  const data = JSON.parse(await coppice("report", study, "--json"));
  assert.equal(data.answer.promise.tree.episodes, 500, "by the simulator of the study");
  assert.ok(data.vocabulary.features.every((feature) => feature.texts), "conditions in the features' own units");
});

test("the studio edits it: bins by their edges, scores at once, the simulator of the study when asked", async () => {
  const studio = await startStudio(study);
  const page = await openPage(browser, { allowed: studio.allowed });
  try {
    await page.goto(studio.address);
    await ready(page);
    const tree = page.locator("#tree").getByRole("tree").first();
    const condition = tree.locator('[data-node]').filter({ hasText: "<=" }).first();
    await condition.click();
    const selected = page.getByRole("group", { name: "The selected node" });
    const edges = await selected.getByLabel("value").locator("option").allInnerTexts();
    assert.ok(edges.length > 1 && edges.every((edge) => /-?\d|inf/.test(edge)), edges.join(" "));
    const now = await selected.getByLabel("value").evaluate((select) => select.selectedIndex);
    await selected.getByLabel("value").selectOption({ index: now === 0 ? 1 : 0 });
    await page.getByText(/^\(scored in \d+ ms\)$/).waitFor();
    await page.getByRole("button", { name: "Simulate" }).click();
    await page.locator('[data-figure="reward in simulation"]').filter({ hasNotText: "…" }).waitFor({ timeout: 60_000 });
    await shot(page, "imported-studio", { fullPage: true });
    await accessible(page);
    page.check();
  } finally {
    await page.context().close();
    await studio.stop();
  }
});
