// What a tree does in the states that the page holds: for trees that the program did not compute figures for, and to
// compare two of them. Weights are the policy's expected visits, which are at hand for every tree.
import type { States, TreeView, Vocabulary } from "./data";
import { type TreeNode, tick, walk } from "./tree";

export interface Meaning {
  action: Int16Array; // [shown states], -1: none
  writer: Int16Array; // [shown states], -1: none
}

const featureReader = (states: States, width: number, state: number) => (f: number) => states.features[state * width + f] ?? 0;

export function featuresOf(states: States, vocabulary: Vocabulary, state: number): number[] {
  const width = vocabulary.features.length;
  return states.features.slice(state * width, (state + 1) * width);
}

export function meaningOf(tree: TreeNode, states: States, vocabulary: Vocabulary): Meaning {
  const width = vocabulary.features.length;
  const count = states.index.length;
  const meaning = { action: new Int16Array(count), writer: new Int16Array(count) };
  for (let s = 0; s < count; ++s) {
    const ticked = tick(tree, featureReader(states, width, s));
    meaning.action[s] = ticked.action;
    meaning.writer[s] = ticked.writer ?? -1;
  }
  return meaning;
}

export interface StateAtNode {
  state: number; // in States
  visits: number;
  action: number;
  policy: number;
  decides: boolean;
}

// The states in which a tick comes to a node, the most visited first.
export function statesAtNode(tree: TreeNode, node: number, states: States, vocabulary: Vocabulary, visits: readonly number[]): StateAtNode[] {
  const width = vocabulary.features.length;
  const found: StateAtNode[] = [];
  for (let s = 0; s < states.index.length; ++s) {
    const ticked = tick(tree, featureReader(states, width, s));
    if (ticked.path.has(node)) {
      found.push({ state: s, visits: visits[s] ?? 0, action: ticked.action, policy: states.policy[s] ?? -1, decides: ticked.writer === node });
    }
  }
  return found.sort((a, b) => b.visits - a.visits || a.state - b.state);
}

// As ../../tree_view.hpp, over the shown states and with the policy's visits.
export function viewOf(tree: TreeNode, states: States, vocabulary: Vocabulary): TreeView {
  const width = vocabulary.features.length;
  const actions = vocabulary.actions.length;
  const zeros = (): number[] => new Array<number>(tree.size).fill(0);
  const view: TreeView = {
    steps: 0,
    undecided: 0,
    ticked: zeros(),
    succeeded: zeros(),
    decides: zeros(),
    differs: zeros(),
    cost: zeros(),
    states: zeros(),
    differing_states: zeros(),
  };
  const add = (list: number[], at: number, amount: number): void => {
    list[at] = (list[at] ?? 0) + amount;
  };
  const terminal = new Set(states.terminal);
  const leaf: boolean[] = [];
  walk(tree, (node, index) => {
    leaf[index] = node.kind === "action" || node.kind === "condition";
  });
  for (let s = 0; s < states.index.length; ++s) {
    const weight = states.policy_visits[s] ?? 0;
    const ticked = tick(tree, featureReader(states, width, s));
    view.steps += weight;
    for (const [node, succeeded] of ticked.path) {
      add(view.ticked, node, weight);
      if (leaf[node] && succeeded) {
        add(view.succeeded, node, weight);
      }
    }
    if (ticked.writer === null) {
      view.undecided += weight;
      continue;
    }
    add(view.decides, ticked.writer, weight);
    add(view.states, ticked.writer, 1);
    const policy = states.policy[s] ?? 0;
    if (ticked.action !== policy && !terminal.has(s)) {
      add(view.differs, ticked.writer, weight);
      add(view.differing_states, ticked.writer, 1);
      add(view.cost, ticked.writer, weight * ((states.q[s * actions + policy] ?? 0) - (states.q[s * actions + ticked.action] ?? 0)));
    }
  }
  return view;
}

export interface Difference {
  state: number; // in States
  before: number;
  after: number;
  policy: number;
  visits: number; // of the policy
}

// States in which two trees act differently: mended (now as the policy), spoilt (no longer), other.
export function differences(before: Meaning, after: Meaning, states: States): { mended: Difference[]; spoilt: Difference[]; other: Difference[] } {
  const terminal = new Set(states.terminal);
  const found = { mended: [] as Difference[], spoilt: [] as Difference[], other: [] as Difference[] };
  for (let s = 0; s < states.index.length; ++s) {
    const a = before.action[s] ?? -1;
    const b = after.action[s] ?? -1;
    if (a === b || terminal.has(s)) {
      continue;
    }
    const policy = states.policy[s] ?? -1;
    const entry = { state: s, before: a, after: b, policy, visits: states.policy_visits[s] ?? 0 };
    (b === policy ? found.mended : a === policy ? found.spoilt : found.other).push(entry);
  }
  for (const list of Object.values(found)) {
    list.sort((a, b) => b.visits - a.visits || a.state - b.state);
  }
  return found;
}

// In how many of the shown states it does what the policy does.
export function matching(meaning: Meaning, states: States): number {
  const terminal = new Set(states.terminal);
  return meaning.action.reduce((sum, a, s) => sum + (a === states.policy[s] || terminal.has(s) ? 1 : 0), 0);
}
