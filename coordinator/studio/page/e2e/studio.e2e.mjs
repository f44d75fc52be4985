// The studio, clicked through against the real server and a real study.
import assert from "node:assert/strict";
import { copyFileSync, readFileSync } from "node:fs";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { accessible, api, commandLine, coppice, folder, kThesisTree, openBrowser, openPage, ready, removeFolder, shot, startStudio, thesisStudy } from "./harness.mjs";

let browser;
let studyPath;
before(async () => {
  browser = await openBrowser();
  studyPath = await thesisStudy();
});
after(async () => {
  await browser?.close();
  removeFolder();
});

// A studio on a copy of the study of its own, so that no test sees what another kept.
let copies = 0;
async function inStudio(words, body, options = {}) {
  const path = join(folder, `copy-${++copies}.coppice`);
  copyFileSync(studyPath, path);
  const studio = await startStudio(path, ...words);
  const page = await openPage(browser, { allowed: studio.allowed, clipboard: true, ...options });
  try {
    await page.goto(studio.address);
    await ready(page);
    await body(page, studio, path);
    page.check();
  } finally {
    await page.context().close();
    await studio.stop();
  }
}

const thesis = ["--tree", kThesisTree];
const tree = (page) => page.locator("#tree").getByRole("tree").first();
const node = (page, index) => tree(page).locator(`[data-node="${index}"]`);
const tool = (page, name) => page.getByRole("toolbar", { name: "Edit" }).getByRole("button", { name, exact: true });
const selectedNode = (page) => page.getByRole("group", { name: "The selected node" });
const text = async (page) => (await page.locator("#answer code.text").textContent()) ?? "";
const figure = (page, name) => page.locator(`[data-figure="${name}"]`);
const scored = (page) => page.getByText(/^\(scored in (\d+|–) ms\)$/).waitFor();
const numberIn = async (locator) => Number(((await locator.textContent()) ?? "").replaceAll("\u202f", "").replace("−", "-").replace(/[^\d.-]/g, ""));

test("the thesis' hand adjustment: three branches take a tree that earns less than 200 to more than 260", async () => {
  await inStudio(thesis, async (page) => {
    const from = performance.now();
    const before = await numberIn(figure(page, "reward in simulation"));
    // Trash on the right: a branch with three conditions' menus, by hand; the other two by text.
    const addBranch = async (tests, action) => {
      await node(page, 0).click();
      await tool(page, "Text or XML…").click();
      await page.getByRole("textbox", { name: /A tree as text/ }).fill(`(sequence ${tests.map(([f, v]) => `${f}=${v}`).join(" ")} ${action})`);
      await page.getByRole("button", { name: "Insert at the selected node" }).click();
      // It came behind the others; it is to be asked first.
      for (let i = 0; i < 20 && (await selectedNode(page).innerText()).includes("sequence"); ++i) {
        const index = Number(/Node (\d+)/.exec(await selectedNode(page).innerText())?.[1]);
        if (index === 1) {
          break;
        }
        await tool(page, "Up").click();
      }
    };
    // By menus, node by node.
    await node(page, 0).click();
    await tool(page, "Add branch").click();
    let at = Number(/Node (\d+)/.exec(await selectedNode(page).innerText())?.[1]);
    while (at !== 1) {
      await tool(page, "Up").click();
      at = Number(/Node (\d+)/.exec(await selectedNode(page).innerText())?.[1]);
    }
    await node(page, 2).click();
    await selectedNode(page).getByLabel("feature").selectOption("3"); // s3
    await selectedNode(page).getByLabel("value").selectOption("1");
    await tool(page, "Add condition").click(); // behind it
    await selectedNode(page).getByLabel("feature").selectOption("6"); // s6
    await selectedNode(page).getByLabel("value").selectOption("3");
    await node(page, 4).click();
    await selectedNode(page).getByLabel("action").selectOption("2"); // turn_right
    assert.match(await text(page), /^\(selector \(sequence s3=1 s6=3 turn_right\)/);
    await addBranch([["s7", 3]], "move");
    await addBranch([["s0", 3], ["s3", 0]], "turn_left");
    assert.match(await text(page), /^\(selector \(sequence s0=3 s3=0 turn_left\) \(sequence s7=3 move\) \(sequence s3=1 s6=3 turn_right\)/);
    await page.getByRole("button", { name: "Simulate" }).click();
    await figure(page, "reward in simulation").filter({ hasNotText: "…" }).waitFor({ timeout: 120_000 });
    const after = await numberIn(figure(page, "reward in simulation"));
    console.log(`# reward in simulation: ${before} before, ${after} after, in ${((performance.now() - from) / 1000).toFixed(1)} s`);
    assert.ok(before < 200 && after > 260, `${before} and ${after}`);
    await page.getByRole("group", { name: "Scores" }).scrollIntoViewIfNeeded();
    await shot(page, "studio-adjusted");
  });
});

test("every tool of the editor does what it says, by mouse and by key, and undo takes all of it back", async () => {
  await inStudio(["--tree", "(selector (sequence s3=0 turn_left) move)"], async (page) => {
    const begin = await text(page);
    const expect = async (wanted) => assert.equal(await text(page), wanted);
    await node(page, 2).click();
    await tool(page, "Add condition").click();
    await expect("(selector (sequence s3=0 s0=0 turn_left) move)");
    await tool(page, "Up").click();
    await expect("(selector (sequence s0=0 s3=0 turn_left) move)");
    await tool(page, "Down").click();
    await tool(page, "Delete").click();
    await expect("(selector (sequence s3=0 turn_left) move)");
    await node(page, 1).click();
    await selectedNode(page).getByLabel("kind").selectOption("selector");
    await expect("(selector (selector s3=0 turn_left) move)");
    await tool(page, "Unwrap").click();
    await expect("(selector s3=0 turn_left move)");
    await node(page, 2).click();
    await tool(page, "Wrap in →").click();
    await expect("(selector s3=0 (sequence turn_left) move)");
    await tool(page, "Add action").click();
    await expect("(selector s3=0 (sequence turn_left move) move)");
    await node(page, 1).click();
    await tool(page, "Copy").click();
    await node(page, 2).click();
    await tool(page, "Paste").click();
    await expect("(selector s3=0 (sequence turn_left move s3=0) move)");
    // By keys: the focus is in the drawing.
    await node(page, 1).click();
    await page.keyboard.press("Control+x");
    await expect("(selector (sequence turn_left move s3=0) move)");
    await page.keyboard.press("Control+v");
    await page.keyboard.press("Alt+ArrowDown");
    await page.keyboard.press("a");
    await page.keyboard.press("c");
    await page.keyboard.press("s");
    await page.keyboard.press("u");
    await page.keyboard.press("Delete");
    const last = await text(page);
    assert.notEqual(last, begin);
    let undone = 0;
    while (await tool(page, "Undo").isEnabled()) {
      await tool(page, "Undo").click();
      ++undone;
    }
    await expect(begin);
    for (let i = 0; i < undone; ++i) {
      await tool(page, "Redo").click();
    }
    await expect(last);
    await accessible(page);
  });
});

test("a node is moved by dragging it onto another", async () => {
  await inStudio(["--tree", "(selector (sequence s3=0 turn_left) move)"], async (page) => {
    await node(page, 4).scrollIntoViewIfNeeded();
    const from = await node(page, 4).boundingBox();
    const to = await node(page, 2).boundingBox();
    await page.mouse.move(from.x + 5, from.y + 5);
    await page.mouse.down();
    await page.mouse.move(to.x + 5, to.y + 5, { steps: 4 });
    await page.mouse.up();
    assert.equal(await text(page), "(selector (sequence move s3=0 turn_left))");
  });
});

test("a tree is pasted as text or XML; what is wrong with one is said", async () => {
  await inStudio(thesis, async (page) => {
    await tool(page, "Text or XML…").click();
    const box = page.getByRole("textbox", { name: /A tree as text/ });
    await box.fill("(selector (sequence s3=2 turn_left) move)");
    await page.getByRole("button", { name: "Replace the tree" }).click();
    assert.match(await page.getByRole("alert").innerText(), /column 21: s3 never reads 2/);
    await box.fill(
      '<root BTCPP_format="4" main_tree_to_execute="Policy"><BehaviorTree ID="Policy"><Fallback><Sequence><ScriptCondition code="s3==0"/><Script code="action:=1"/></Sequence><Script code="action:=0"/></Fallback></BehaviorTree></root>',
    );
    await page.getByRole("button", { name: "Replace the tree" }).click();
    assert.equal(await text(page), "(selector (sequence s3=0 turn_left) move)");
    await tool(page, "Text or XML…").click();
    await box.fill('<BehaviorTree><Parallel><Script code="action:=1"/></Parallel></BehaviorTree>');
    await page.getByRole("button", { name: "Replace the tree" }).click();
    assert.match(await page.getByRole("alert").innerText(), /'Parallel' has no counterpart/);
  });
});

test("scores come with every edit, with the states that it mended and spoilt and a walk that shows one", async () => {
  await inStudio(thesis, async (page) => {
    await scored(page);
    await node(page, 5).click();
    await selectedNode(page).getByLabel("action").selectOption("2");
    await scored(page);
    const times = [];
    for (const value of ["0", "1", "2", "0"]) {
      await selectedNode(page).getByLabel("action").selectOption(value);
      await scored(page);
      times.push(/\d+/.exec((await page.getByText(/^\(scored in/).textContent()) ?? "")?.[0]);
    }
    console.log(`# scored in ${times.join(", ")} ms`);
    const scores = page.getByRole("group", { name: "Scores" });
    await scores.locator("summary").first().click();
    await scores.getByRole("button", { name: "Show a walk" }).first().click();
    const walk = page.getByRole("group", { name: "A walk that shows it" });
    await walk.waitFor();
    assert.match(await walk.innerText(), /here|No simulated episode/);
  });
});

test("a rule is proved while it is typed; what breaks it is shown in the room; one that is kept is in the study", async () => {
  await inStudio(["--tree", "(selector (sequence s5=3 turn_right) move)"], async (page, studio, path) => {
    const box = page.getByRole("textbox", { name: "A rule" });
    const preview = page.locator(".preview");
    await box.pressSequentially("never move when s3=");
    await preview.getByText("expected", { exact: false }).waitFor();
    await box.pressSequentially("0");
    await preview.getByText("✗ broken").waitFor();
    await preview.getByRole("button", { name: "Show it in the room" }).click();
    await page.getByRole("group", { name: "A walk that shows it" }).waitFor();
    await box.fill("never turn_left");
    await preview.getByText("✓ proved").waitFor();
    await page.getByRole("button", { name: "Keep the rule" }).click();
    await page.locator(".rules").getByText("never turn_left").waitFor();
    // Another browser has it, too, and so has whatever opens the study later; what is no rule is not kept.
    const second = await openPage(browser, { allowed: studio.allowed });
    await second.goto(studio.address);
    await ready(second);
    await second.locator(".rules").getByText("never turn_left").waitFor();
    assert.equal((await api(studio, "keep_rule", { rule: "never fly" })).status, 400);
    const kept = JSON.parse(await coppice("report", path, "--json", "--tree", "move", "--episodes", "2"));
    assert.equal(kept.answer.rules.find((rule) => rule.rule === "never turn_left").holds, true);
    await second.getByRole("button", { name: "Forget the rule never turn_left" }).click();
    await page.locator(".rules").getByText("never turn_left").waitFor({ state: "detached" });
    second.check();
    await second.context().close();
    assert.deepEqual((await (await api(studio, "status")).json()).rules, []);
  });
});

test("suggestions are one click; pruning and the guarded form mean the same and say what they did", async () => {
  await inStudio(thesis, async (page) => {
    const whole = page.getByRole("toolbar", { name: "The whole tree" });
    await whole.getByRole("button", { name: "Suggest branches" }).click();
    await page.getByText(/branches are suggested/).waitFor();
    await page.getByRole("button", { name: "Add this branch" }).first().click();
    assert.match(await text(page), /^\(selector \(sequence s/);
    await scored(page);
    const reward = await figure(page, "reward along the chain").textContent();
    await whole.getByRole("button", { name: "Guarded form" }).click();
    await page.getByText(/The guarded form has \d+ nodes/).waitFor();
    await scored(page);
    assert.equal(await figure(page, "reward along the chain").textContent(), reward);
    await whole.getByRole("button", { name: "Prune on the chain" }).click();
    await page.getByText(/^Pruned|nothing to prune/).waitFor();
    await scored(page);
    assert.equal(await figure(page, "reward along the chain").textContent(), reward);
  });
});

test("trees are kept with name and note, seen by another browser, exported, and forgotten", async () => {
  await inStudio(thesis, async (page, studio, path) => {
    await page.getByLabel("Name").fill("mine");
    await page.getByLabel("Note").fill("<b>before</b> the corner");
    await page.getByRole("button", { name: "Keep this tree" }).click();
    await page.getByText("'mine' is kept").waitFor();
    const second = await openPage(browser, { allowed: studio.allowed });
    await second.goto(studio.address);
    await ready(second);
    await second.getByRole("button", { name: "Open mine" }).waitFor();
    assert.match(await second.getByRole("group", { name: "Kept trees" }).innerText(), /<b>before<\/b> the corner/);
    await second.getByRole("button", { name: "Put mine beside" }).click();
    await second.getByRole("heading", { name: /Beside it: mine/ }).waitFor();
    // The other browser keeps one too; the first sees it.
    await second.getByLabel("Name").fill("theirs");
    await second.getByRole("button", { name: "Keep this tree" }).click();
    await page.getByRole("button", { name: "Open theirs" }).waitFor();
    second.check();
    await second.context().close();
    const whole = page.getByRole("toolbar", { name: "The whole tree" });
    const [download] = await Promise.all([page.waitForEvent("download"), whole.getByRole("button", { name: "Export", exact: true }).click()]);
    assert.equal(readFileSync(await download.path(), "utf8").trim(), kThesisTree);
    for (const { format } of (await (await api(studio, "page")).json()).exports) {
      const answer = await api(studio, "write", { tree: "(selector (sequence s3=0 turn_left) move)", format });
      assert.equal(answer.status, 200, `${format}: ${await answer.text()}`);
    }
    await page.getByRole("button", { name: "Forget theirs" }).click();
    await page.getByText("'theirs' is no longer kept").waitFor();
    assert.match(await coppice("info", path), /run/); // other programs read the study as before
  });
});

test("an evolution that begins with the tree shows how it goes, opens its best, and stops when told to", async () => {
  await inStudio(thesis, async (page) => {
    const whole = page.getByRole("toolbar", { name: "The whole tree" });
    const jobs = page.getByRole("group", { name: "Computations" });
    await whole.getByLabel("with").fill("ga.generations=8 ga.search=scalar seed=5");
    await whole.getByRole("button", { name: "Breed from here" }).click();
    await jobs.getByText("breed from here", { exact: false }).first().waitFor();
    await jobs.getByText("done").waitFor();
    await jobs.getByRole("button", { name: "Put it beside" }).click();
    await page.getByRole("heading", { name: /Beside it: the best of computation/ }).waitFor();
    await whole.getByLabel("with").fill("ga.generations=100000 ga.search=scalar");
    await whole.getByRole("button", { name: "Breed from here" }).click();
    await jobs.getByRole("button", { name: "Open the best so far" }).first().waitFor();
    await jobs.getByRole("button", { name: "Stop" }).click();
    await jobs.getByText("stopped").waitFor();
    await jobs.getByRole("button", { name: "Open the best so far" }).first().click();
    assert.match(await text(page), /^[(a-z]/);
    await page.locator("#provenance").getByText(/run \d+: interrupted/).waitFor();
    await whole.getByLabel("with").fill("ga.no_such=1");
    await whole.getByRole("button", { name: "Breed from here" }).click();
    await page.getByText(/breed: .*ga.no_such/).first().waitFor();
  });
});

test("workers are listed one by one while the studio breeds; one that dies is counted, and changes nothing in the tree", async () => {
  await inStudio([...thesis, "--workers", "2"], async (page, studio, path) => {
    const whole = page.getByRole("toolbar", { name: "The whole tree" });
    const jobs = page.getByRole("group", { name: "Computations" });
    await whole.getByLabel("with").fill("ga.generations=600 ga.search=scalar ga.population=400 ga.demes=4 rollout.rollouts=200 seed=5");
    await whole.getByRole("button", { name: "Breed from here" }).click();
    const worker = jobs.getByText(/pid \d+: evaluating, \d+ batch/);
    await worker.first().waitFor({ timeout: 60_000 });
    await jobs.scrollIntoViewIfNeeded();
    await shot(page, "studio-workers");
    const pid = Number(/pid (\d+)/.exec((await worker.first().textContent()) ?? "")?.[1]);
    process.kill(pid, "SIGKILL");
    await jobs.getByText(/individuals evaluated, [1-9]\d* workers? lost/).waitFor({ timeout: 60_000 });
    await jobs.getByText("done").waitFor({ timeout: 120_000 });
    const runs = await (await api(studio, "runs")).json();
    const bred = runs[runs.length - 1];
    const again = join(folder, "again.coppice");
    copyFileSync(studyPath, again);
    await commandLine(bred.command.replace(path, again), "--serial");
    const alone = JSON.parse(await coppice("info", again, "--json")).runs;
    assert.equal(bred.pruned, alone[alone.length - 1].pruned);
  });
});

test("what another process writes to the study is there without a reload", async () => {
  await inStudio(thesis, async (page, _studio, path) => {
    await coppice("evolve", path, "--serial", "--set", "ga.generations=5", "--set", "ga.search=scalar", "--seed", "77");
    await page.locator("#provenance").getByText("seed 77", { exact: false }).first().waitFor();
  });
});

test("what is edited stays when the studio ends, and the page says so", async () => {
  await inStudio(thesis, async (page, studio) => {
    await node(page, 0).click();
    await tool(page, "Add action").click();
    const before = await text(page);
    await studio.stop();
    await page.getByText(/The studio does not answer/).waitFor();
    assert.equal(await text(page), before);
    await tool(page, "Undo").click();
    page.forgive(/ERR_CONNECTION_REFUSED|Failed to fetch|ERR_EMPTY_RESPONSE|ERR_CONNECTION_RESET/);
  });
});

for (const colorScheme of ["light", "dark"]) {
  for (const width of [1280, 390]) {
    test(`the studio reads well at ${width} pixels, ${colorScheme}`, async () => {
      await inStudio(
        thesis,
        async (page) => {
          await node(page, 5).click();
          await scored(page);
          assert.equal(await page.evaluate(() => document.documentElement.scrollWidth - document.documentElement.clientWidth), 0);
          await accessible(page);
          await page.locator("#tree").scrollIntoViewIfNeeded();
          await shot(page, `studio-${width}-${colorScheme}`, { fullPage: true });
        },
        { width, colorScheme },
      );
    });
  }
}
