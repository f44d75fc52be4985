// A tree in words, with the legend of its study: "wall ahead" where the vocabulary says what s3=0 means, the name and
// the value where it does not.
import type { Feature, Vocabulary } from "./data";
import { type Composite, type Condition, type TreeNode, isComposite, leafText, valueText } from "./tree";

export const hasLegend = (vocabulary: Vocabulary): boolean =>
  vocabulary.features.some((f) => f.label !== undefined || f.labels !== undefined);

export function valueWords(vocabulary: Vocabulary, feature: number, value: number): string {
  const f = vocabulary.features[feature];
  if (!f) {
    return "?";
  }
  const label = f.labels?.[f.values.indexOf(value)];
  if (label && f.label) {
    return `${label} ${f.label}`;
  }
  return `${f.label ?? f.name} = ${label ?? valueText(f, value)}${f.unit ? ` ${f.unit}` : ""}`;
}

export function conditionWords(node: Condition, vocabulary: Vocabulary): string {
  const f = vocabulary.features[node.feature];
  if (!f) {
    return "?";
  }
  if (node.op === "=") {
    return valueWords(vocabulary, node.feature, node.value);
  }
  const label = f.labels?.[f.values.indexOf(node.value)];
  return `${f.label ?? f.name} ≤ ${label ?? valueText(f, node.value)}${f.unit ? ` ${f.unit}` : ""}`;
}

export const actionWords = (index: number, vocabulary: Vocabulary): string => {
  const a = vocabulary.actions[index];
  return index < 0 || !a ? "no action" : (a.label ?? a.name.replaceAll("_", " "));
};

export function nodeWords(node: TreeNode, vocabulary: Vocabulary): string {
  switch (node.kind) {
    case "sequence":
      return "all in turn";
    case "selector":
      return "first that succeeds";
    case "condition":
      return conditionWords(node, vocabulary);
    case "action":
      return actionWords(node.action, vocabulary);
  }
}

// What a state reads of one feature, without its name: a label, an interval in the feature's unit, a number.
export const readingWords = (feature: Feature | undefined, value: number): string => {
  const at = feature?.values.indexOf(value) ?? -1;
  const reading = feature?.readings?.[at];
  const bare = reading?.startsWith(feature?.name ?? "") ? reading.slice(feature?.name.length).trim().replace(/^(=|in)\s*/, "") : reading;
  return feature?.labels?.[at] ?? bare ?? String(value);
};

export const observationWords = (features: readonly number[], vocabulary: Vocabulary, matters?: readonly boolean[]): string =>
  features
    .map((value, f) => {
      const feature = vocabulary.features[f];
      const reading = feature?.readings?.[feature.values.indexOf(value)];
      return matters && !matters[f] ? "" : (reading ?? (hasLegend(vocabulary) ? valueWords(vocabulary, f, value) : `${feature?.name}=${value}`));
    })
    .filter((text) => text !== "")
    .join(", ") || "anything";

// A sentence, and under it those of its parts. `node` is the number of the node that it is about.
export interface Sentence {
  text: string;
  node: number;
  parts: Sentence[];
}

// Of a subtree that only asks: its words as one condition; null: it chooses something.
function asked(node: TreeNode, vocabulary: Vocabulary, inside = false): string | null {
  if (node.kind === "condition") {
    return conditionWords(node, vocabulary);
  }
  if (node.kind === "action") {
    return null;
  }
  const parts = node.children.map((child) => asked(child, vocabulary, true));
  if (parts.some((part) => part === null)) {
    return null;
  }
  const text = parts.join(node.kind === "sequence" ? " and " : " or ");
  return inside && parts.length > 1 ? `(${text})` : text;
}

// What can be said in one sentence: conditions and one action, in either order, or conditions alone.
function plainSequence(node: Composite, vocabulary: Vocabulary): string | null {
  const words = node.children.map((child) => asked(child, vocabulary, true));
  const at = words.indexOf(null);
  const chosen = node.children[at];
  if (!chosen || chosen.kind !== "action" || words.indexOf(null, at + 1) >= 0) {
    return null;
  }
  const what = actionWords(chosen.action, vocabulary);
  const before = words.slice(0, at).join(" and ");
  const after = words.slice(at + 1).join(" and ");
  const choice = after === "" ? what : `${what}; it stands if ${after}, else a later branch may replace it`;
  return before === "" ? choice : `if ${before}: ${choice}`;
}

// `place`: what the parent does with it.
export function sentences(tree: TreeNode, vocabulary: Vocabulary): Sentence {
  let next = 0;
  const go = (node: TreeNode, place: "root" | "in turn" | "first" | "alternative"): Sentence => {
    const mine = next++;
    const only = asked(node, vocabulary);
    if (only !== null) {
      next = mine + node.size;
      return { text: place === "in turn" ? `go on only if ${only}` : `if ${only}: keep what was chosen so far`, node: mine, parts: [] };
    }
    if (!isComposite(node)) {
      const text = node.kind === "action" ? actionWords(node.action, vocabulary) : "";
      return { text: place === "alternative" ? `otherwise: ${text}` : text, node: mine, parts: [] };
    }
    const plain = node.kind === "sequence" ? plainSequence(node, vocabulary) : null;
    if (plain !== null) {
      next = mine + node.size;
      return { text: plain, node: mine, parts: [] };
    }
    const parts = node.children.map((child, i) => go(child, node.kind === "sequence" ? "in turn" : i === 0 ? "first" : "alternative"));
    return {
      text: node.kind === "selector" ? "The first of these that succeeds:" : "All of these, in turn, until one fails:",
      node: mine,
      parts,
    };
  };
  return go(tree, "root");
}

export const rawText = (node: TreeNode, vocabulary: Vocabulary): string =>
  isComposite(node) ? node.kind : leafText(node, vocabulary);
