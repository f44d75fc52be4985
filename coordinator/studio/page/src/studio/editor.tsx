// The tools of the editor, above the drawing: everything that can be done to the selected node, by mouse and by key.
import { computed, signal, useSignal } from "@preact/signals";
import type { Vocabulary } from "../data";
import { need, selected, shown, shownText } from "../state";
import {
  type Condition,
  type Leaf,
  type Op,
  TreeError,
  type TreeNode,
  action,
  composite,
  condition,
  insertAfter,
  insertChild,
  isComposite,
  leafText,
  moveNode,
  moveTo,
  nodeNumber,
  parseTree,
  pathOf,
  indexOf,
  removeNode,
  replaceNode,
  setKind,
  toText,
  unwrapNode,
  valueText,
  wrapNode,
} from "../tree";
import { actionWords, conditionWords } from "../words";
import { addBranch, apply, applyText, clipboard, history, mayRedo, mayUndo, say, sayError, step } from "./session";
import { fromXml } from "./xml";

export interface Editing {
  onKey: (event: KeyboardEvent) => boolean;
  onDropOn: (from: number, to: number) => void;
}

// Only in the studio, once it began.
export const editing = computed<Editing | null>(() => (history.value ? { onKey, onDropOn } : null));
export const applyBranch = computed<((branch: string) => void) | null>(() => (history.value ? addBranch : null));

const current = (): { tree: TreeNode; index: number } | null => {
  const tree = shown.value;
  const index = selected.value ?? 0;
  return tree && index < tree.size ? { tree, index } : null;
};

// Into a composite as its last child, behind a leaf.
function insert(node: TreeNode, label: string): void {
  const at = current();
  if (!at) {
    return;
  }
  const target = nodeNumber(at.tree, at.index);
  apply(isComposite(target) ? insertChild(at.tree, at.index, target.children.length, node) : insertAfter(at.tree, at.index, node), label);
}

const firstCondition = (vocabulary: Vocabulary): Condition => {
  const f = vocabulary.features[0];
  return condition(0, f?.equal === false ? "<=" : "=", f?.values[0] ?? 0);
};

function copy(): void {
  const at = current();
  if (at) {
    const node = nodeNumber(at.tree, at.index);
    clipboard.value = node;
    const text = toText(node, need().vocabulary);
    navigator.clipboard?.writeText(text).catch(() => undefined); // the studio's own clipboard has it in any case
    say(`Copied: ${text}`);
  }
}

function remove(): void {
  const at = current();
  if (at) {
    apply(removeNode(at.tree, at.index), "delete");
  }
}

function paste(): void {
  if (clipboard.value) {
    insert(clipboard.value, "paste");
  } else {
    say("Nothing was copied yet.", true);
  }
}

const move = (by: -1 | 1): void => {
  const at = current();
  if (at) {
    apply(moveNode(at.tree, at.index, by), by < 0 ? "move up" : "move down");
  }
};

const wrap = (kind: "sequence" | "selector"): void => {
  const at = current();
  if (at) {
    apply(wrapNode(at.tree, at.index, kind), `wrap in a ${kind}`);
  }
};

const unwrap = (): void => {
  const at = current();
  if (at) {
    apply(unwrapNode(at.tree, at.index), "unwrap");
  }
};

function onKey(event: KeyboardEvent): boolean {
  const control = event.ctrlKey || event.metaKey;
  const key = event.key.toLowerCase();
  if (control && key === "z") {
    step(event.shiftKey ? "redo" : "undo");
  } else if (control && key === "y") {
    step("redo");
  } else if (control && key === "c") {
    copy();
  } else if (control && key === "x") {
    copy();
    remove();
  } else if (control && key === "v") {
    paste();
  } else if (control || event.metaKey) {
    return false;
  } else if (event.altKey && event.key === "ArrowUp") {
    move(-1);
  } else if (event.altKey && event.key === "ArrowDown") {
    move(1);
  } else if (event.altKey) {
    return false;
  } else if (event.key === "Delete" || event.key === "Backspace") {
    remove();
  } else if (key === "c") {
    insert(firstCondition(need().vocabulary), "add a condition");
  } else if (key === "a") {
    insert(action(0), "add an action");
  } else if (key === "q") {
    wrap("sequence");
  } else if (key === "s") {
    wrap("selector");
  } else if (key === "u") {
    unwrap();
  } else {
    return false;
  }
  return true;
}

// A node that is dropped on a composite becomes its last child; on a leaf, it goes in front of it.
function onDropOn(from: number, to: number): void {
  const tree = shown.value;
  if (!tree) {
    return;
  }
  const target = nodeNumber(tree, to);
  if (isComposite(target)) {
    apply(moveTo(tree, from, to, target.children.length), "move");
    return;
  }
  const path = pathOf(tree, to);
  const last = path[path.length - 1];
  if (last !== undefined) {
    apply(moveTo(tree, from, indexOf(tree, path.slice(0, -1)), last), "move");
  }
}

// The leaf's parts as menus that know the vocabulary.
function LeafMenus(props: { tree: TreeNode; index: number; leaf: Leaf }) {
  const { vocabulary } = need();
  const { leaf, tree, index } = props;
  const set = (node: Leaf): void => apply(replaceNode(tree, index, node), `change to ${leafText(node, vocabulary)}`, `leaf ${index}`);
  if (leaf.kind === "action") {
    return (
      <label>
        action{" "}
        <select value={leaf.action} onChange={(e) => set(action(Number(e.currentTarget.value)))}>
          {vocabulary.actions.map((_, i) => (
            <option key={i} value={i}>
              {actionWords(i, vocabulary)}
            </option>
          ))}
        </select>
      </label>
    );
  }
  const feature = vocabulary.features[leaf.feature];
  if (!feature) {
    return null;
  }
  const ops: Op[] = [...(feature.equal ? (["="] as const) : []), ...(feature.less_equal ? (["<="] as const) : [])];
  return (
    <>
      <label>
        feature{" "}
        <select
          value={leaf.feature}
          onChange={(e) => {
            const f = Number(e.currentTarget.value);
            const next = vocabulary.features[f];
            if (next) {
              set(condition(f, next.equal ? "=" : "<=", next.values.includes(leaf.value) ? leaf.value : (next.values[0] ?? 0)));
            }
          }}
        >
          {vocabulary.features.map((f, i) => (
            <option key={f.name} value={i}>
              {f.label ? `${f.name}: ${f.label}` : f.name}
            </option>
          ))}
        </select>
      </label>
      {ops.length > 1 && (
        <label>
          test{" "}
          <select value={leaf.op} onChange={(e) => set(condition(leaf.feature, e.currentTarget.value as Op, leaf.value))}>
            {ops.map((op) => (
              <option key={op} value={op}>
                {op === "=" ? "is" : "is at most"}
              </option>
            ))}
          </select>
        </label>
      )}
      <label>
        value{" "}
        <select value={leaf.value} onChange={(e) => set(condition(leaf.feature, leaf.op, Number(e.currentTarget.value)))}>
          {feature.values.map((value, i) => (
            <option key={value} value={value}>
              {feature.labels?.[i] ? `${valueText(feature, value)}: ${feature.labels[i]}` : valueText(feature, value)}
            </option>
          ))}
        </select>
      </label>
    </>
  );
}

export const pasteOpen = signal(false);

function PasteBox() {
  const text = useSignal("");
  const problem = useSignal("");
  const take = (how: "whole" | "insert"): void => {
    const { vocabulary } = need();
    try {
      const given = text.value.trim();
      const tree = given.startsWith("<") ? fromXml(given, vocabulary) : parseTree(given, vocabulary);
      if (how === "whole") {
        applyText(toText(tree, vocabulary), "paste a tree");
      } else {
        insert(tree, "paste a branch");
      }
      pasteOpen.value = false;
    } catch (error) {
      problem.value = error instanceof TreeError ? `column ${error.column}: ${error.message}` : error instanceof Error ? error.message : String(error);
    }
  };
  return (
    <div class="detail">
      <label>
        A tree as text, or as BehaviorTree.CPP XML
        <textarea rows={4} value={text.value} onInput={(e) => { text.value = e.currentTarget.value; problem.value = ""; }} spellcheck={false} />
      </label>
      {problem.value !== "" && (
        <p class="bad" role="alert">
          {problem.value}
        </p>
      )}
      <div class="toolbar">
        <button type="button" class="main" onClick={() => take("whole")}>
          Replace the tree
        </button>
        <button type="button" onClick={() => take("insert")}>
          Insert at the selected node
        </button>
        <button type="button" onClick={() => { pasteOpen.value = false; }}>
          Close
        </button>
      </div>
    </div>
  );
}

export function Editor() {
  const { vocabulary } = need();
  const tree = shown.value;
  const index = Math.min(selected.value ?? 0, (tree?.size ?? 1) - 1);
  if (!tree) {
    return null;
  }
  const node = nodeNumber(tree, index);
  const isRoot = index === 0;
  const copyText = (): void => {
    navigator.clipboard?.writeText(shownText.value).then(
      () => say("The whole tree is in the clipboard, as text."),
      (error: unknown) => sayError(error),
    );
  };
  return (
    <div class="editor" role="group" aria-label="Edit the tree">
      <div class="toolbar" role="toolbar" aria-label="Edit">
        <button type="button" onClick={() => step("undo")} disabled={!mayUndo.value} title="Ctrl+Z">
          Undo
        </button>
        <button type="button" onClick={() => step("redo")} disabled={!mayRedo.value} title="Ctrl+Shift+Z">
          Redo
        </button>
        <button type="button" onClick={() => insert(firstCondition(vocabulary), "add a condition")} title="key C">
          Add condition
        </button>
        <button type="button" onClick={() => insert(action(0), "add an action")} title="key A">
          Add action
        </button>
        <button type="button" onClick={() => insert(composite("sequence", [firstCondition(vocabulary), action(0)]), "add a branch")}>
          Add branch
        </button>
        <button type="button" onClick={() => wrap("sequence")} title="key Q">
          Wrap in →
        </button>
        <button type="button" onClick={() => wrap("selector")} title="key S">
          Wrap in ?
        </button>
        <button type="button" onClick={unwrap} disabled={!isComposite(node)} title="key U">
          Unwrap
        </button>
        <button type="button" onClick={() => move(-1)} disabled={isRoot} title="Alt+↑">
          Up
        </button>
        <button type="button" onClick={() => move(1)} disabled={isRoot} title="Alt+↓">
          Down
        </button>
        <button type="button" onClick={copy} title="Ctrl+C">
          Copy
        </button>
        <button type="button" onClick={paste} disabled={!clipboard.value} title="Ctrl+V">
          Paste
        </button>
        <button type="button" onClick={remove} disabled={isRoot} title="Del">
          Delete
        </button>
        <button type="button" onClick={() => { pasteOpen.value = !pasteOpen.value; }} aria-expanded={pasteOpen.value}>
          Text or XML…
        </button>
        <button type="button" onClick={copyText}>
          Copy as text
        </button>
      </div>
      <div class="toolbar" role="group" aria-label="The selected node">
        <span>
          Node {index}: <b>{node.kind === "condition" ? conditionWords(node, vocabulary) : node.kind === "action" ? actionWords(node.action, vocabulary) : node.kind}</b>
        </span>
        {isComposite(node) ? (
          <label>
            kind{" "}
            <select value={node.kind} onChange={(e) => apply(setKind(tree, index, e.currentTarget.value as "sequence" | "selector"), "change the kind")}>
              <option value="sequence">→ sequence: all in turn</option>
              <option value="selector">? selector: first that succeeds</option>
            </select>
          </label>
        ) : (
          <LeafMenus tree={tree} index={index} leaf={node} />
        )}
      </div>
      {pasteOpen.value && <PasteBox />}
      <details class="numbers">
        <summary>keys, with the focus in the drawing</summary>
        <p>
          Arrows, Home and Escape go from node to node; Enter folds. C adds a condition, A an action; Q wraps in a sequence, S in a selector, U unwraps; Alt with ↑ or ↓ moves; Del
          deletes; Ctrl+Z undoes, Ctrl+Shift+Z or Ctrl+Y redoes; Ctrl+C, X and V copy, cut and paste. A node can also be dragged: onto a composite it becomes its last child, onto a leaf it
          goes in front of it.
        </p>
      </details>
    </div>
  );
}
