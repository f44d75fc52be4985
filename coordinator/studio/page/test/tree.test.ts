import fc from "fast-check";
import { describe, expect, it } from "vitest";
import type { Vocabulary } from "../src/data";
import {
  type Edited,
  type TreeNode,
  action,
  composite,
  condition,
  depthOf,
  indexOf,
  insertAfter,
  insertChild,
  isComposite,
  kMaxNodes,
  moveNode,
  moveTo,
  nodeNumber,
  parseTree,
  pathOf,
  removeNode,
  replaceNode,
  tick,
  toText,
  unwrapNode,
  walk,
  wrapNode,
} from "../src/tree";

const vocabulary: Vocabulary = {
  features: [
    { name: "s0", values: [0, 1, 3], equal: true, less_equal: false },
    { name: "s1", values: [0, 1, 3], equal: true, less_equal: false },
    { name: "x", values: [0, 1, 2, 3, 4], equal: true, less_equal: true },
  ],
  actions: [{ name: "move" }, { name: "turn_left" }, { name: "turn_right" }],
};

const leaves = fc.oneof(
  fc.integer({ min: 0, max: 2 }).map(action),
  fc.tuple(fc.integer({ min: 0, max: 1 }), fc.constantFrom(0, 1, 3)).map(([f, v]) => condition(f, "=", v)),
  fc.tuple(fc.constantFrom("=" as const, "<=" as const), fc.integer({ min: 0, max: 4 })).map(([op, v]) => condition(2, op, v)),
);
const trees: fc.Arbitrary<TreeNode> = fc.letrec<{ tree: TreeNode }>((tie) => ({
  tree: fc.oneof(
    { maxDepth: 4, depthSize: "small" },
    leaves,
    fc.tuple(fc.constantFrom("sequence" as const, "selector" as const), fc.array(tie("tree"), { minLength: 1, maxLength: 4 })).map(([kind, children]) => composite(kind, children)),
  ),
})).tree;
const observations = fc.tuple(fc.constantFrom(0, 1, 3), fc.constantFrom(0, 1, 3), fc.integer({ min: 0, max: 4 }));

// The reference semantics, written the other way round: recursion that returns what it wrote (common/tree/tick.cpp).
function reference(node: TreeNode, seen: readonly number[]): { ok: boolean; wrote: number } {
  if (node.kind === "action") {
    return { ok: true, wrote: node.action };
  }
  if (node.kind === "condition") {
    const value = seen[node.feature] as number;
    return { ok: node.op === "=" ? value === node.value : value <= node.value, wrote: -1 };
  }
  let wrote = -1;
  for (const child of node.children) {
    const answer = reference(child, seen);
    wrote = answer.wrote >= 0 ? answer.wrote : wrote;
    if (answer.ok !== (node.kind === "sequence")) {
      return { ok: answer.ok, wrote };
    }
  }
  return { ok: node.kind === "sequence", wrote };
}

function valid(tree: TreeNode): void {
  let nodes = 0;
  walk(tree, (node) => {
    ++nodes;
    if (isComposite(node)) {
      expect(node.children.length).toBeGreaterThan(0);
      expect(node.size).toBe(1 + node.children.reduce((sum, child) => sum + child.size, 0));
    }
  });
  expect(nodes).toBe(tree.size);
  expect(parseTree(toText(tree, vocabulary), vocabulary)).toEqual(tree);
}

describe("a tree", () => {
  it("is what its text says, whichever tree it is", () => {
    fc.assert(fc.property(trees, (tree) => valid(tree)));
  });

  it("ticks as the reference does, and names the node with the last word", () => {
    fc.assert(
      fc.property(trees, observations, (tree, seen) => {
        const ticked = tick(tree, (f) => seen[f] as number);
        expect(ticked.action).toBe(reference(tree, seen).wrote);
        expect(ticked.path.get(0)).toBe(reference(tree, seen).ok);
        if (ticked.writer === null) {
          expect(ticked.action).toBe(-1);
        } else {
          expect(nodeNumber(tree, ticked.writer)).toEqual(action(ticked.action));
        }
      }),
    );
  });

  it("finds every node by its number and its number by the way there", () => {
    fc.assert(
      fc.property(trees, (tree) =>
        walk(tree, (node, index) => {
          expect(nodeNumber(tree, index)).toBe(node);
          expect(indexOf(tree, pathOf(tree, index))).toBe(index);
        }),
      ),
    );
  });

  it.each([
    ["", 1, "the end"],
    ["(sequence)", 1, "without children"],
    ["(sequence move", 15, "the end"],
    ["(turn move)", 2, "expected sequence or selector"],
    ["(selector s0=2 move)", 11, "never reads 2"],
    ["(selector s0<=1 move)", 11, "is not asked with '<='"],
    ["move move", 6, "behind the tree"],
    ["jump", 1, "expected move"],
    [")", 1, "expected a tree"],
  ])("refuses '%s' at column %d", (text, column, message) => {
    expect(() => parseTree(text, vocabulary)).toThrow(expect.objectContaining({ column, message: expect.stringContaining(message) }) as Error);
  });

  it("writes and reads conditions in the feature's own unit", () => {
    const binned: Vocabulary = {
      features: [{ name: "angle", values: [0, 1, 2], texts: ["-0.1", "0.0419", "inf"], equal: false, less_equal: true }],
      actions: [{ name: "left" }],
    };
    const tree = parseTree("(sequence angle<=0.0419 left)", binned);
    expect(nodeNumber(tree, 1)).toEqual(condition(0, "<=", 1));
    expect(toText(tree, binned)).toBe("(sequence angle<=0.0419 left)");
    expect(parseTree("(sequence angle<=4.19e-2 left)", binned)).toEqual(tree);
    expect(() => parseTree("angle<=0.05", binned)).toThrow("expected -0.1, 0.0419, inf");
  });

  it("refuses what is too deep or too large", () => {
    expect(() => parseTree("(sequence ".repeat(70) + "move" + ")".repeat(70), vocabulary)).toThrow("deeper");
    expect(() => parseTree(`(selector ${"move ".repeat(kMaxNodes)})`, vocabulary)).toThrow("nodes");
  });
});

describe("an edit", () => {
  const edits = (tree: TreeNode, index: number, subtree: TreeNode, other: number): [string, Edited | null][] => [
    ["replace", replaceNode(tree, index, subtree)],
    ["insert", insertChild(tree, index, 0, subtree)],
    ["insert after", insertAfter(tree, index, subtree)],
    ["remove", removeNode(tree, index)],
    ["wrap", wrapNode(tree, index, "sequence")],
    ["unwrap", unwrapNode(tree, index)],
    ["up", moveNode(tree, index, -1)],
    ["down", moveNode(tree, index, 1)],
    ["move", moveTo(tree, index, other, 0)],
  ];
  it("leaves a valid tree, with the selected node in it, and its argument as it was", () => {
    fc.assert(
      fc.property(trees, leaves, fc.nat(), fc.nat(), (tree, subtree, a, b) => {
        const before = toText(tree, vocabulary);
        for (const [, edited] of edits(tree, a % tree.size, subtree, b % tree.size)) {
          if (edited) {
            valid(edited.tree);
            expect(edited.selected).toBeLessThan(edited.tree.size);
          }
        }
        expect(toText(tree, vocabulary)).toBe(before);
      }),
    );
  });

  it("moves up what it moved down", () => {
    fc.assert(
      fc.property(trees, fc.nat(), (tree, a) => {
        const down = moveNode(tree, a % tree.size, 1);
        if (down) {
          expect(moveNode(down.tree, down.selected, -1)).toEqual({ tree, selected: a % tree.size });
        }
      }),
    );
  });

  it("unwraps what it wrapped", () => {
    fc.assert(
      fc.property(trees, fc.nat(), (tree, a) => {
        const wrapped = wrapNode(tree, a % tree.size, "selector");
        expect(wrapped && unwrapNode(wrapped.tree, wrapped.selected)).toEqual({ tree, selected: a % tree.size });
      }),
    );
  });

  it("moves a node to the place that was meant, whether it stood before or behind", () => {
    const tree = parseTree("(selector (sequence s0=0 move) (sequence s1=0 turn_left) turn_right)", vocabulary);
    const text = (edited: Edited | null): string => (edited ? toText(edited.tree, vocabulary) : "none");
    expect(text(moveTo(tree, 7, 0, 0))).toBe("(selector turn_right (sequence s0=0 move) (sequence s1=0 turn_left))");
    expect(text(moveTo(tree, 1, 0, 3))).toBe("(selector (sequence s1=0 turn_left) turn_right (sequence s0=0 move))");
    expect(text(moveTo(tree, 2, 4, 1))).toBe("(selector (sequence move) (sequence s1=0 s0=0 turn_left) turn_right)");
    expect(text(moveTo(tree, 1, 1, 0))).toBe("none");
  });

  it("keeps a composite from going empty by taking it away too", () => {
    const tree = parseTree("(selector (sequence s0=0) move)", vocabulary);
    const edited = removeNode(tree, 2);
    expect(edited && toText(edited.tree, vocabulary)).toBe("(selector move)");
    expect(removeNode(parseTree("move", vocabulary), 0)).toBeNull();
  });

  it("never makes a tree deeper than the limit", () => {
    let tree: TreeNode = action(0);
    for (let i = 0; i < 64; ++i) {
      tree = composite("sequence", [tree]);
    }
    expect(depthOf(tree)).toBe(64);
    expect(wrapNode(tree, 0, "selector")).toBeNull();
  });
});
