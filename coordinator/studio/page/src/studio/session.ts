// The studio's state beside the page's (../state.ts): the history of edits, what the server said of each tree, what it
// computes, what is kept. One timer asks how things stand; everything else follows from an edit.
import { computed, effect, signal } from "@preact/signals";
import type { Disagreements, PageData, RuleAnswer } from "../data";
import { type Entry, type History, begin, canRedo, canUndo, edited, now, redo, undo, withSelection } from "../history";
import { known, lit, load, open, page, remember, selected, shown, shownName, shownText } from "../state";
import { type Edited, type TreeNode, composite, insertChild, isComposite, parseTree, toText } from "../tree";
import { type Job, type Kept, type PageAnswer, type Simulation, type Status, ask } from "./api";

const kStatusEvery = 700; // ms
const kStartEvery = 150; // ms, while the first page is computed

export const offer = signal<Omit<PageAnswer, "data"> | null>(null); // what this studio can do
export const history = signal<History | null>(null);
export const baseline = signal(""); // text of the tree that edits are compared with
export const baselineName = signal("");
export const jobs = signal<readonly Job[]>([]);
export const kept = signal<readonly Kept[]>([]);
export const message = signal<{ text: string; bad: boolean } | null>(null);
export const connected = signal(true);
export const keptRules = signal<readonly string[]>([]); // in the study
const usualRules = signal<readonly string[]>([]); // of the world, and of the command line; gone with the page
export const rules = computed<readonly string[]>(() => [...new Set([...usualRules.value, ...keptRules.value])]);
export const typedRule = signal("");
export const ruleAnswers = signal<ReadonlyMap<string, RuleAnswer>>(new Map()); // of the shown tree, by the rule's text
export const suggestions = signal<{ tree: string; found: Disagreements } | null>(null);
export const simulations = signal<ReadonlyMap<string, Simulation>>(new Map()); // by the tree's text
export const scoredIn = signal<number | null>(null); // ms, of the last score that was asked
export const clipboard = signal<TreeNode | null>(null);

export const say = (text: string, bad = false): void => {
  message.value = { text, bad };
};
export const sayError = (error: unknown): void => say(error instanceof Error ? error.message : String(error), true);

export const mayUndo = computed(() => history.value !== null && canUndo(history.value));
export const mayRedo = computed(() => history.value !== null && canRedo(history.value));

function show(entry: Entry): void {
  const data = page.value;
  if (!data) {
    return;
  }
  shownText.value = toText(entry.tree, data.vocabulary);
  selected.value = entry.selected;
  lit.value = null;
}

export function apply(change: Edited | null, label: string, gesture: string | null = null): void {
  if (!history.value) {
    return;
  }
  if (!change) {
    say(`Not possible here: ${label}.`, true);
    return;
  }
  message.value = null;
  history.value = edited(withSelection(history.value, selected.value), { tree: change.tree, selected: change.selected, label, gesture });
  shownName.value = "the tree being edited";
  show(now(history.value));
}

export function applyText(text: string, label: string): void {
  const data = page.value;
  if (data) {
    apply({ tree: parseTree(text, data.vocabulary), selected: 0 }, label);
  }
}

export function step(direction: "undo" | "redo"): void {
  if (history.value) {
    history.value = direction === "undo" ? undo(history.value) : redo(history.value);
    show(now(history.value));
  }
}

// A tree from elsewhere becomes the one being edited; undo leads back.
export function edit(text: string, name: string): void {
  applyText(text, `open ${name}`);
  shownName.value = name;
  baseline.value = text;
  baselineName.value = name;
}

// As `coppice edit --insert '0 0 ...'`: in front of everything.
export function addBranch(text: string): void {
  const data = page.value;
  const tree = shown.value;
  if (!data || !tree) {
    return;
  }
  const branch = parseTree(text, data.vocabulary);
  apply(
    isComposite(tree) && tree.kind === "selector" ? insertChild(tree, 0, 0, branch) : { tree: composite("selector", [branch, tree]), selected: 1 },
    "add a branch",
  );
}

export async function keepRule(rule: string): Promise<void> {
  await ask("keep_rule", { rule });
  await poll();
}

export async function forgetRule(rule: string): Promise<void> {
  usualRules.value = usualRules.value.filter((each) => each !== rule);
  if (keptRules.value.includes(rule)) {
    await ask("forget_rule", { rule });
    await poll();
  }
}

// --- what follows from an edit --------------------------------------------------------------------------------------

let asking = "";
effect(() => {
  const text = shownText.value;
  if (!history.value || text === "" || known.value.has(text) || asking === text) {
    return;
  }
  asking = text;
  const from = performance.now();
  ask("score", { tree: text })
    .then((part) => {
      remember(part);
      scoredIn.value = performance.now() - from;
    })
    .catch(sayError);
});

const kRulePause = 60; // ms without a key before a typed rule is proved
let rulesTimer: ReturnType<typeof setTimeout> | undefined;
effect(() => {
  const tree = shownText.value;
  const asked = [...new Set([...rules.value, typedRule.value.trim()].filter((rule) => rule !== ""))];
  clearTimeout(rulesTimer);
  if (!history.value || tree === "") {
    return;
  }
  rulesTimer = setTimeout(() => {
    ask("rules", { tree, rules: asked })
      .then((answers) => {
        if (shownText.value === tree) {
          ruleAnswers.value = new Map(answers.map((answer) => [answer.rule, answer]));
        }
      })
      .catch(sayError);
  }, kRulePause);
});

// --- the server -----------------------------------------------------------------------------------------------------

export async function simulate(text: string): Promise<void> {
  if (jobs.value.some((job) => job.kind === "simulate" && job.state === "running" && job.about?.tree === text)) {
    return;
  }
  await ask("simulate", { tree: text });
  await poll();
}

const collected = new Set<number>();
async function collect(job: Job): Promise<void> {
  if (job.state !== "done" && job.state !== "stopped") {
    if (job.state === "failed" && !collected.has(job.job)) {
      collected.add(job.job);
      say(`${job.kind}: ${job.error}`, true);
    }
    return;
  }
  if (collected.has(job.job) || job.kind === "page") {
    return;
  }
  collected.add(job.job);
  const whole = await ask("job", { job: job.job });
  if (job.kind === "simulate" && job.about?.tree !== undefined && whole.result) {
    simulations.value = new Map([...simulations.value, [job.about.tree, whole.result as Simulation]]);
  }
}

let changes = "";
async function refreshRuns(): Promise<void> {
  const runs = await ask("runs");
  if (page.value) {
    page.value = { ...page.value, runs };
  }
}

function take(status: Status): void {
  connected.value = true;
  jobs.value = status.jobs;
  if (JSON.stringify(status.kept) !== JSON.stringify(kept.value)) {
    kept.value = status.kept;
  }
  if (JSON.stringify(status.rules) !== JSON.stringify(keptRules.value)) {
    // One that was kept when the page was computed is the study's to keep or forget.
    usualRules.value = usualRules.value.filter((rule) => !keptRules.value.includes(rule) && !status.rules.includes(rule));
    keptRules.value = status.rules;
  }
  for (const job of status.jobs) {
    collect(job).catch(sayError);
  }
  if (status.changes !== changes) {
    if (changes !== "") {
      refreshRuns().catch(sayError);
    }
    changes = status.changes;
  }
}

export async function poll(): Promise<void> {
  try {
    take(await ask("status"));
  } catch (error) {
    if (connected.value) {
      connected.value = false;
      sayError(error);
    }
  }
}

const pause = (ms: number): Promise<void> => new Promise((resolve) => setTimeout(resolve, ms));

// Waits for the first page and begins. `progress` hears of the share that is done.
export async function start(progress: (share: number) => void): Promise<PageData> {
  for (;;) {
    const answer = await ask("page");
    if (answer.state === "done" && answer.data) {
      const { data, ...rest } = answer;
      offer.value = rest;
      load(data, true);
      const tree = parseTree(data.answer.tree.text, data.vocabulary);
      baseline.value = data.answer.tree.text;
      baselineName.value = "the answer";
      usualRules.value = data.answer.rules.map((rule) => rule.rule);
      ruleAnswers.value = new Map(data.answer.rules.map((rule) => [rule.rule, rule]));
      simulations.value = new Map([[data.answer.tree.text, { promise: data.answer.promise, shortfalls: data.answer.shortfalls }]]);
      suggestions.value = { tree: data.answer.tree.text, found: data.disagreements };
      history.value = begin(tree, "the answer");
      await poll();
      const again = async (): Promise<void> => {
        await poll();
        setTimeout(() => void again(), kStatusEvery);
      };
      setTimeout(() => void again(), kStatusEvery);
      return data;
    }
    if (answer.state !== "running") {
      throw new Error(answer.error || "the page's data could not be computed");
    }
    progress(answer.share);
    await pause(kStartEvery);
  }
}

export { open };
