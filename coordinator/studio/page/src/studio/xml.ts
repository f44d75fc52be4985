// Trees in the XML of BehaviorTree.CPP 4, as `coppice export` writes it with its scripting nodes: Sequence and Fallback
// (or their Reactive forms, which mean the same where nothing runs for several ticks), ScriptCondition and Script. What
// has no counterpart is refused by name.
import type { Vocabulary } from "../data";
import { type TreeNode, action, composite, parseLeaf } from "../tree";

const kComposites: Record<string, "sequence" | "selector"> = {
  Sequence: "sequence",
  ReactiveSequence: "sequence",
  Fallback: "selector",
  ReactiveFallback: "selector",
};

function actionOf(code: string, vocabulary: Vocabulary): TreeNode {
  const match = /^\s*action\s*:?=\s*'?([A-Za-z0-9_]+)'?\s*$/.exec(code);
  const word = match?.[1] ?? "";
  const index = /^\d+$/.test(word) ? Number(word) : vocabulary.actions.findIndex((a) => a.name === word);
  if (!match || !vocabulary.actions[index]) {
    throw new Error(`Script code="${code}": expected action:=NUMBER or action:=NAME with an action of this study`);
  }
  return action(index);
}

function conditionOf(code: string, vocabulary: Vocabulary): TreeNode {
  const match = /^\s*([A-Za-z_]\w*)\s*(==|<=)\s*([-+.0-9A-Za-z]+)\s*$/.exec(code);
  if (!match) {
    throw new Error(`ScriptCondition code="${code}": expected FEATURE==VALUE or FEATURE<=VALUE`);
  }
  return parseLeaf(`${match[1]}${match[2] === "==" ? "=" : "<="}${match[3]}`, vocabulary);
}

export function fromXml(text: string, vocabulary: Vocabulary): TreeNode {
  const xml = new DOMParser().parseFromString(text, "application/xml");
  if (xml.querySelector("parsererror")) {
    throw new Error("this is no well-formed XML");
  }
  const node = (element: Element): TreeNode => {
    const kind = kComposites[element.tagName];
    if (kind) {
      const children = [...element.children].map(node);
      if (children.length === 0) {
        throw new Error(`${element.tagName} without children`);
      }
      return composite(kind, children);
    }
    const code = element.getAttribute("code") ?? "";
    if (element.tagName === "Script") {
      return actionOf(code, vocabulary);
    }
    if (element.tagName === "ScriptCondition") {
      return conditionOf(code, vocabulary);
    }
    throw new Error(`'${element.tagName}' has no counterpart here: expected Sequence, Fallback, ScriptCondition or Script`);
  };
  const root = xml.documentElement;
  const main = root.getAttribute("main_tree_to_execute");
  const trees = root.tagName === "BehaviorTree" ? [root] : [...root.getElementsByTagName("BehaviorTree")];
  const chosen = trees.find((t) => t.getAttribute("ID") === main) ?? (trees.length === 1 ? trees[0] : undefined);
  const only = chosen?.children[0];
  if (!chosen || !only || chosen.children.length !== 1) {
    throw new Error("expected one BehaviorTree with one child, or main_tree_to_execute to name it");
  }
  return node(only);
}
