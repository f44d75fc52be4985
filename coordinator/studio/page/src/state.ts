// The page's state: one signal for each thing that views show, in one place. Documents are immutable values; what
// follows from them is computed; views only read these and call the functions below.
import { computed, signal } from "@preact/signals";
import { meaningOf, viewOf } from "./analysis";
import type { PageData, TreePart, TreeView } from "./data";
import { type TreeNode, parseTree } from "./tree";

export const page = signal<PageData | null>(null);
// Where the data are from: inside the page, or a server that lives.
export const live = signal(false);

// The tree that is shown: the answer, or another that was opened (of the front, a run, kept), or one being edited.
export const shownText = signal("");
export const shownName = signal("");
// A second one beside it.
export const besideText = signal<string | null>(null);
export const besideName = signal("");
export const selected = signal<number | null>(null); // a node of the shown tree
export const lit = signal<ReadonlyMap<number, boolean> | null>(null); // the active path of the replay, if it is of the shown tree

// What the server computed, by the tree's text; a late answer stays true for its text.
export const known = signal<ReadonlyMap<string, TreePart>>(new Map());

export function need(): PageData {
  const data = page.value;
  if (!data) {
    throw new Error("the page has no data yet");
  }
  return data;
}

export const shown = computed<TreeNode | null>(() => {
  const data = page.value;
  return data && shownText.value !== "" ? parseTree(shownText.value, data.vocabulary) : null;
});

export const beside = computed<TreeNode | null>(() => {
  const data = page.value;
  return data && besideText.value !== null ? parseTree(besideText.value, data.vocabulary) : null;
});

export const shownMeaning = computed(() => {
  const data = page.value;
  const tree = shown.value;
  return data && tree ? meaningOf(tree, data.states, data.vocabulary) : null;
});

export interface Weighted {
  view: TreeView;
  exact: boolean; // over the tree's own walk; else over the policy's, in the shown states
}

export function weighted(text: string, tree: TreeNode, data: PageData): Weighted {
  const part = known.value.get(text);
  return part ? { view: part.view, exact: true } : { view: viewOf(tree, data.states, data.vocabulary), exact: false };
}

export const shownView = computed<Weighted | null>(() => {
  const data = page.value;
  const tree = shown.value;
  return data && tree ? weighted(shownText.value, tree, data) : null;
});

export function load(data: PageData, isLive: boolean): void {
  known.value = new Map([[data.answer.tree.text, data.answer.tree]]);
  shownName.value = data.answer.from;
  shownText.value = data.answer.tree.text;
  live.value = isLive;
  page.value = data;
}

export function remember(part: TreePart): void {
  known.value = new Map([...known.value, [part.text, part]]);
}

export function open(text: string, name: string): void {
  shownText.value = text;
  shownName.value = name;
  selected.value = null;
  lit.value = null;
}

export function putBeside(text: string | null, name = ""): void {
  besideText.value = text;
  besideName.value = name;
}
