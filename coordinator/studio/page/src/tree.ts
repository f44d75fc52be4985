// Behaviour trees as immutable values: read, written, ticked and edited. The same semantics as common/tree/tick.hpp and
// the same text as common/tree/text.hpp. A node is named by its place in prefix order, the root being 0. An edit copies
// the way from the root and shares the rest; whatever an edit returns is a valid tree.
import type { Feature, Vocabulary } from "./data";

export const kMaxNodes = 4096;
export const kMaxDepth = 64; // in edges from the root

export type Op = "=" | "<=";

export type Composite = { readonly kind: "sequence" | "selector"; readonly children: readonly TreeNode[]; readonly size: number };
export type Condition = { readonly kind: "condition"; readonly feature: number; readonly op: Op; readonly value: number; readonly size: 1 };
export type ActionNode = { readonly kind: "action"; readonly action: number; readonly size: 1 };
export type Leaf = Condition | ActionNode;
export type TreeNode = Composite | Leaf;

export const composite = (kind: Composite["kind"], children: readonly TreeNode[]): Composite => ({
  kind,
  children,
  size: children.reduce((sum, child) => sum + child.size, 1),
});
export const condition = (feature: number, op: Op, value: number): Condition => ({ kind: "condition", feature, op, value, size: 1 });
export const action = (index: number): ActionNode => ({ kind: "action", action: index, size: 1 });
export const isComposite = (node: TreeNode): node is Composite => node.kind === "sequence" || node.kind === "selector";

export function depthOf(node: TreeNode): number {
  return isComposite(node) ? 1 + Math.max(...node.children.map(depthOf)) : 0;
}

export function counts(tree: TreeNode): { nodes: number; conditions: number; actions: number } {
  let conditions = 0;
  let actions = 0;
  walk(tree, (node) => {
    conditions += node.kind === "condition" ? 1 : 0;
    actions += node.kind === "action" ? 1 : 0;
  });
  return { nodes: tree.size, conditions, actions };
}

export function walk(tree: TreeNode, visit: (node: TreeNode, index: number, depth: number, parent: number | null) => void): void {
  let index = 0;
  const go = (node: TreeNode, depth: number, parent: number | null): void => {
    const mine = index++;
    visit(node, mine, depth, parent);
    if (isComposite(node)) {
      for (const child of node.children) {
        go(child, depth + 1, mine);
      }
    }
  };
  go(tree, 0, null);
}

// --- text -----------------------------------------------------------------------------------------------------------

export class TreeError extends Error {
  constructor(
    message: string,
    readonly column: number, // from 1
  ) {
    super(message);
  }
}

// A value as conditions of this feature write it.
export const valueText = (feature: Feature | undefined, value: number): string => feature?.texts?.[feature.values.indexOf(value)] ?? String(value);

function valueOf(feature: Feature, text: string): number | undefined {
  const same = (written: string): boolean => written === text || (text !== "" && Number(written) === Number(text));
  return feature.values.find((value) => same(valueText(feature, value)));
}

export function leafText(node: Leaf, vocabulary: Vocabulary): string {
  return node.kind === "action"
    ? (vocabulary.actions[node.action]?.name ?? "?")
    : `${vocabulary.features[node.feature]?.name ?? "?"}${node.op}${valueText(vocabulary.features[node.feature], node.value)}`;
}

export function nodeText(node: TreeNode, vocabulary: Vocabulary): string {
  return isComposite(node) ? node.kind : leafText(node, vocabulary);
}

export function toText(node: TreeNode, vocabulary: Vocabulary): string {
  return isComposite(node)
    ? `(${node.kind} ${node.children.map((child) => toText(child, vocabulary)).join(" ")})`
    : leafText(node, vocabulary);
}

export function parseLeaf(word: string, vocabulary: Vocabulary, column = 1): Leaf {
  const index = vocabulary.actions.findIndex((a) => a.name === word);
  if (index >= 0) {
    return action(index);
  }
  const match = /^([A-Za-z_][A-Za-z0-9_]*)(<=|=)([-+.0-9A-Za-z]+)$/.exec(word);
  const feature = match ? vocabulary.features.findIndex((f) => f.name === match[1]) : -1;
  const declared = vocabulary.features[feature];
  if (!match || !declared) {
    const names = [...vocabulary.actions.map((a) => a.name), ...vocabulary.features.map((f) => `${f.name}=…`)];
    throw new TreeError(`found '${word}': expected ${names.join(", ")}`, column);
  }
  const op = match[2] as Op;
  if (op === "=" ? !declared.equal : !declared.less_equal) {
    throw new TreeError(`${declared.name} is not asked with '${op}'`, column);
  }
  const value = valueOf(declared, match[3] ?? "");
  if (value === undefined) {
    throw new TreeError(`${declared.name} never reads ${match[3]}: expected ${declared.values.map((v) => valueText(declared, v)).join(", ")}`, column);
  }
  return condition(feature, op, value);
}

export function parseTree(text: string, vocabulary: Vocabulary): TreeNode {
  let at = 0;
  let nodes = 0;
  const blank = (): void => {
    while (at < text.length && /\s/.test(text[at] as string)) {
      ++at;
    }
  };
  const word = (): string => {
    const from = at;
    while (at < text.length && !/[\s()]/.test(text[at] as string)) {
      ++at;
    }
    return text.slice(from, at);
  };
  const node = (depth: number): TreeNode => {
    blank();
    const column = at + 1;
    if (++nodes > kMaxNodes) {
      throw new TreeError(`more than ${kMaxNodes} nodes`, column);
    }
    if (depth > kMaxDepth) {
      throw new TreeError(`deeper than ${kMaxDepth}`, column);
    }
    if (at >= text.length) {
      throw new TreeError("found the end: expected a tree", column);
    }
    if (text[at] !== "(") {
      const leaf = word();
      if (leaf === "") {
        throw new TreeError(`found '${text[at]}': expected a tree`, column);
      }
      return parseLeaf(leaf, vocabulary, column);
    }
    ++at;
    blank();
    const kindColumn = at + 1;
    const kind = word();
    if (kind !== "sequence" && kind !== "selector") {
      throw new TreeError(`found '${kind}': expected sequence or selector`, kindColumn);
    }
    const children: TreeNode[] = [];
    for (;;) {
      blank();
      if (text[at] === ")") {
        ++at;
        break;
      }
      children.push(node(depth + 1));
    }
    if (children.length === 0) {
      throw new TreeError(`a ${kind} without children`, column);
    }
    return composite(kind, children);
  };
  const tree = node(0);
  blank();
  if (at < text.length) {
    throw new TreeError(`found '${text.slice(at, at + 10)}' behind the tree`, at + 1);
  }
  return tree;
}

// --- meaning --------------------------------------------------------------------------------------------------------

export const holds = (node: Condition, value: number): boolean => (node.op === "=" ? value === node.value : value <= node.value);

export interface Ticked {
  action: number; // -1: none
  writer: number | null; // the node with the last word
  path: Map<number, boolean>; // ticked nodes, and whether they succeeded
}

export function tick(tree: TreeNode, feature: (index: number) => number): Ticked {
  const result: Ticked = { action: -1, writer: null, path: new Map() };
  let next = 0;
  const go = (node: TreeNode): boolean => {
    const mine = next++;
    let succeeded = true;
    if (node.kind === "condition") {
      succeeded = holds(node, feature(node.feature));
    } else if (node.kind === "action") {
      result.action = node.action;
      result.writer = mine;
    } else {
      const until = node.kind === "selector"; // stops at the first child that answers so
      succeeded = !until;
      for (const child of node.children) {
        const before = next;
        if (go(child) === until) {
          succeeded = until;
          break;
        }
        next = before + child.size;
      }
      next = mine + node.size;
    }
    result.path.set(mine, succeeded);
    return succeeded;
  };
  go(tree);
  return result;
}

// --- places and edits -----------------------------------------------------------------------------------------------

// The numbers of the children to go through, from the root.
export type Path = readonly number[];

export function pathOf(tree: TreeNode, index: number): Path {
  const path: number[] = [];
  let node = tree;
  let at = 0;
  while (at !== index) {
    if (!isComposite(node)) {
      throw new RangeError(`no node ${index}`);
    }
    let child = 0;
    ++at;
    for (;;) {
      const candidate: TreeNode | undefined = node.children[child];
      if (!candidate) {
        throw new RangeError(`no node ${index}`);
      }
      if (index < at + candidate.size) {
        path.push(child);
        node = candidate;
        break;
      }
      at += candidate.size;
      ++child;
    }
  }
  return path;
}

export function nodeAt(tree: TreeNode, path: Path): TreeNode {
  let node = tree;
  for (const child of path) {
    const next: TreeNode | undefined = isComposite(node) ? node.children[child] : undefined;
    if (!next) {
      throw new RangeError("no such node");
    }
    node = next;
  }
  return node;
}

export const nodeNumber = (tree: TreeNode, index: number): TreeNode => nodeAt(tree, pathOf(tree, index));

export function indexOf(tree: TreeNode, path: Path): number {
  let node = tree;
  let index = 0;
  for (const child of path) {
    if (!isComposite(node)) {
      throw new RangeError("no such node");
    }
    index += 1;
    for (let i = 0; i < child; ++i) {
      index += node.children[i]?.size ?? 0;
    }
    node = nodeAt(node, [child]);
  }
  return index;
}

function withNode(tree: TreeNode, path: Path, change: (node: TreeNode) => TreeNode): TreeNode {
  const [first, ...rest] = path;
  if (first === undefined) {
    return change(tree);
  }
  if (!isComposite(tree) || !tree.children[first]) {
    throw new RangeError("no such node");
  }
  return composite(
    tree.kind,
    tree.children.map((child, i) => (i === first ? withNode(child, rest, change) : child)),
  );
}

// What an edit gives: the tree, and the node that a person wants selected then. null: the edit is not possible.
export interface Edited {
  tree: TreeNode;
  selected: number;
}

const checked = (tree: TreeNode, path: Path): Edited | null =>
  tree.size > kMaxNodes || depthOf(tree) > kMaxDepth ? null : { tree, selected: indexOf(tree, path) };

export function replaceNode(tree: TreeNode, index: number, subtree: TreeNode): Edited | null {
  const path = pathOf(tree, index);
  return checked(
    withNode(tree, path, () => subtree),
    path,
  );
}

// A new child of a composite, in front of its child of this number.
export function insertChild(tree: TreeNode, parent: number, position: number, subtree: TreeNode): Edited | null {
  const path = pathOf(tree, parent);
  const node = nodeAt(tree, path);
  if (!isComposite(node) || position < 0 || position > node.children.length) {
    return null;
  }
  const children = [...node.children.slice(0, position), subtree, ...node.children.slice(position)];
  return checked(
    withNode(tree, path, () => composite(node.kind, children)),
    [...path, position],
  );
}

// Behind a node, as its next sibling; a root gets a selector around it.
export function insertAfter(tree: TreeNode, index: number, subtree: TreeNode): Edited | null {
  const path = pathOf(tree, index);
  const last = path[path.length - 1];
  if (last === undefined) {
    return checked(composite("selector", [tree, subtree]), [1]);
  }
  return insertChild(tree, indexOf(tree, path.slice(0, -1)), last + 1, subtree);
}

// A composite that would be left without children goes too, and so on upwards; the last node stays.
export function removeNode(tree: TreeNode, index: number): Edited | null {
  const path = pathOf(tree, index);
  const last = path[path.length - 1];
  if (last === undefined) {
    return null;
  }
  const parentPath = path.slice(0, -1);
  const parent = nodeAt(tree, parentPath);
  if (!isComposite(parent)) {
    return null;
  }
  if (parent.children.length === 1) {
    return removeNode(tree, indexOf(tree, parentPath));
  }
  const children = parent.children.filter((_, i) => i !== last);
  const next = Math.min(last, children.length - 1);
  return checked(
    withNode(tree, parentPath, () => composite(parent.kind, children)),
    [...parentPath, next],
  );
}

export function wrapNode(tree: TreeNode, index: number, kind: Composite["kind"]): Edited | null {
  const path = pathOf(tree, index);
  return checked(
    withNode(tree, path, (node) => composite(kind, [node])),
    path,
  );
}

// The children take the composite's place; of the root only if there is one.
export function unwrapNode(tree: TreeNode, index: number): Edited | null {
  const path = pathOf(tree, index);
  const node = nodeAt(tree, path);
  const last = path[path.length - 1];
  if (!isComposite(node)) {
    return null;
  }
  if (last === undefined) {
    const only = node.children[0];
    return node.children.length === 1 && only ? { tree: only, selected: 0 } : null;
  }
  const parentPath = path.slice(0, -1);
  const parent = nodeAt(tree, parentPath) as Composite;
  const children = [...parent.children.slice(0, last), ...node.children, ...parent.children.slice(last + 1)];
  return checked(
    withNode(tree, parentPath, () => composite(parent.kind, children)),
    path,
  );
}

// One place up (-1) or down (+1) among its siblings.
export function moveNode(tree: TreeNode, index: number, by: -1 | 1): Edited | null {
  const path = pathOf(tree, index);
  const last = path[path.length - 1];
  if (last === undefined) {
    return null;
  }
  const parentPath = path.slice(0, -1);
  const parent = nodeAt(tree, parentPath) as Composite;
  const to = last + by;
  const mine = parent.children[last];
  const other = parent.children[to];
  if (!mine || !other) {
    return null;
  }
  const children = parent.children.map((child, i) => (i === last ? other : i === to ? mine : child));
  return checked(
    withNode(tree, parentPath, () => composite(parent.kind, children)),
    [...parentPath, to],
  );
}

// To another place: in front of child `position` of the composite `parent`, both as numbered before the move.
export function moveTo(tree: TreeNode, index: number, parent: number, position: number): Edited | null {
  const from = pathOf(tree, index);
  const to = pathOf(tree, parent);
  const last = from[from.length - 1];
  if (last === undefined || from.every((child, i) => to[i] === child)) {
    return null; // the root, or into itself
  }
  const moved = nodeAt(tree, from);
  const fromParent = from.slice(0, -1);
  const source = nodeAt(tree, fromParent) as Composite;
  if (source.children.length === 1) {
    return null; // it would leave a composite without children
  }
  const same = fromParent.length === to.length && fromParent.every((child, i) => to[i] === child);
  const without = withNode(tree, fromParent, () =>
    composite(
      source.kind,
      source.children.filter((_, i) => i !== last),
    ),
  );
  // The way to the new parent, when the node before it on some level went.
  const shifted = to.map((child, level) =>
    level === fromParent.length && fromParent.every((c, i) => to[i] === c) && child > last ? child - 1 : child,
  );
  const at = same && position > last ? position - 1 : position;
  return insertChild(without, indexOf(without, shifted), at, moved);
}

export function setKind(tree: TreeNode, index: number, kind: Composite["kind"]): Edited | null {
  const path = pathOf(tree, index);
  const node = nodeAt(tree, path);
  return isComposite(node)
    ? checked(
        withNode(tree, path, () => composite(kind, node.children)),
        path,
      )
    : null;
}
