import { describe, expect, it } from "vitest";
import { differences, matching, meaningOf, statesAtNode, viewOf } from "../src/analysis";
import type { States, Vocabulary } from "../src/data";
import { parseTree } from "../src/tree";

// Four states of two features; by hand.
const vocabulary: Vocabulary = {
  features: [
    { name: "a", values: [0, 1], equal: true, less_equal: false },
    { name: "b", values: [0, 1], equal: true, less_equal: false },
  ],
  actions: [{ name: "go" }, { name: "turn" }],
};
const states: States = {
  total: 4,
  index: [0, 1, 2, 3],
  features: [0, 0, 0, 1, 1, 0, 1, 1],
  policy: [1, 1, 0, 0],
  tree_visits: [1, 2, 3, 4],
  policy_visits: [4, 3, 2, 1],
  learning_visits: [10, 10, 10, 10],
  q: [0, 5, 1, 2, 7, 3, 6, 6],
  terminal: [],
  tree_share: 1,
  policy_share: 1,
};
const tree = parseTree("(selector (sequence a=0 b=0 turn) go)", vocabulary); // 0 selector 1 sequence 2 a=0 3 b=0 4 turn 5 go

describe("what a tree does in the states of the page", () => {
  it("is weighted with the policy's visits, node by node", () => {
    const view = viewOf(tree, states, vocabulary);
    expect(view.steps).toBe(10);
    expect(view.ticked).toEqual([10, 10, 10, 7, 4, 6]); // b=0 is asked where a=0: states 0 and 1
    expect(view.succeeded).toEqual([0, 0, 7, 4, 4, 6]);
    expect(view.decides).toEqual([0, 0, 0, 0, 4, 6]);
    expect(view.states).toEqual([0, 0, 0, 0, 1, 3]);
    expect(view.differs).toEqual([0, 0, 0, 0, 0, 3]); // state 1: go where the policy turns
    expect(view.cost).toEqual([0, 0, 0, 0, 0, 3]); // 3 visits x (2 - 1)
    expect(view.undecided).toBe(0);
  });

  it("counts the steps in which nothing decides", () => {
    expect(viewOf(parseTree("(sequence a=0 turn)", vocabulary), states, vocabulary).undecided).toBe(3);
  });

  it("lists who comes to a node, the most visited first", () => {
    expect(statesAtNode(tree, 5, states, vocabulary, states.policy_visits).map((s) => [s.state, s.decides, s.action === s.policy])).toEqual([
      [1, true, false],
      [2, true, true],
      [3, true, true],
    ]);
  });

  it("tells states that an edit mended from those it spoilt", () => {
    const before = meaningOf(parseTree("go", vocabulary), states, vocabulary);
    const after = meaningOf(parseTree("turn", vocabulary), states, vocabulary);
    const found = differences(before, after, states);
    expect(found.mended.map((d) => d.state)).toEqual([0, 1]);
    expect(found.spoilt.map((d) => d.state)).toEqual([2, 3]);
    expect(found.other).toEqual([]);
    expect(matching(before, states)).toBe(2);
  });
});
