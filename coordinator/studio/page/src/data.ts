// The document that the page shows: what ../../page_data.hpp writes and ../../README.md explains, field by field.
// Version 1. A figure of the chain is exact unless it says otherwise.

export interface Feature {
  name: string;
  label?: string; // what it measures: "ahead"
  unit?: string;
  values: number[]; // ascending
  labels?: (string | null)[]; // [values] what a value means: "wall"
  texts?: string[]; // [values] as conditions write them, where that is not the value itself: "0.0419"
  readings?: string[]; // [values] what a state reads: "pole_angle in (-0.1, 0.0419]"
  equal: boolean; // conditions "name=value" are allowed
  less_equal: boolean;
}

export interface Action {
  name: string;
  label?: string;
}

export interface Vocabulary {
  features: Feature[];
  actions: Action[];
}

export interface Size {
  nodes: number;
  conditions: number;
  actions: number;
  depth: number;
}

export interface Figures {
  matching_states: number;
  coverage: number; // share of all states in which it does what the policy does
  agreement: number; // share of the steps of a walk
  reward: number; // of a walk
}

// A list a figure, an entry a node, in prefix order.
export interface TreeView {
  steps: number;
  undecided: number;
  ticked: number[];
  succeeded: number[];
  decides: number[];
  differs: number[];
  cost: number[];
  states: number[];
  differing_states: number[];
}

export interface TreePart {
  text: string;
  size: Size;
  figures: Figures;
  view: TreeView;
}

export interface Estimate {
  mean: number;
  margin: number; // half of the 95 % interval
}

export interface Simulated {
  episodes: number;
  steps: number;
  agreement: Estimate;
  reward: Estimate;
  collisions: Estimate;
  total_collisions: number;
  unknown_steps: number;
}

export interface Figure {
  value: number;
  low: number;
  high: number;
}

export interface EventFigures {
  name: string;
  test: string;
  within: Figure;
  ever: Figure | null;
  steps: Figure | null;
}

export interface ChainPromise {
  steps: number;
  resamples: number;
  reached: number;
  reward_per_episode: Figure;
  reward_per_step: Figure | null;
  events: EventFigures[];
  leaves_by_untried_pair: EventFigures;
}

export interface Promised {
  chain: ChainPromise | null; // null: the chain is too large, or nobody asked yet
  tree: Simulated | null; // null: the study has no simulator, or nobody asked yet
  policy: Simulated | null;
}

export interface RuleAnswer {
  rule: string;
  error?: string;
  holds?: boolean;
  states?: number; // of the chain, that it is about
  roles?: number[]; // [nodes] 0 never ticked where it applies, 1 ticked, 2 has the last word
  broken_by?: { features: number[]; matters: boolean[]; action: number; node: number | null };
  seen?: { state: number; features: number[]; visits: number } | null;
}

export interface States {
  total: number;
  index: number[]; // [shown]
  features: number[]; // [shown x features]
  policy: number[]; // [shown]
  tree_visits: number[]; // expected in a walk of the tree
  policy_visits: number[];
  learning_visits: number[];
  q: number[]; // [shown x actions]
  terminal: number[]; // places in the lists above of states that end an episode: nothing is decided there
  tree_share: number; // of the tree's visits, that the shown states hold
  policy_share: number;
}

export interface Disagreement {
  state: number;
  features: number[];
  visits: number;
  regret: number;
  cost: number;
  policy: number;
  tree: number; // -1: no action
  node: number | null;
}

export interface Branch {
  branch: string;
  saved: number;
  states: number;
  differing: number;
  mended: number;
  spoilt: number;
  edit: string;
  agreement: number; // with this branch alone added in front
  coverage: number;
  reward: number;
}

export interface Disagreements {
  total: number;
  cost: number;
  steps: number;
  costliest: Disagreement[];
  branches: Branch[];
  complete: boolean;
  searched: boolean; // branches were searched for
}

export interface Generations {
  every: number;
  total: number;
  generation: number[];
  best_fitness: number[];
  mean_fitness: number[];
  best_agreement: number[];
  mean_agreement: number[];
  best_nodes: number[];
  mean_nodes: number[];
  distinct_trees: number[];
  evaluations: number[]; // so far
}

export interface FrontMember {
  tree: string;
  fitness: number;
  values: number[];
}

export interface Front {
  measures: { name: string; is_cost: boolean }[];
  members: FrontMember[];
}

export interface Run {
  run: number;
  status: string;
  abandoned: boolean;
  evaluator: string;
  started: string;
  ended: string;
  seed: number;
  configuration: unknown;
  result: unknown;
  tree: string | null;
  pruned: string | null;
  command: string;
  demes: DemeCurves | null; // of several demes
  generations: Generations;
  front: Front | null;
}

export interface DemeCurves {
  every: number;
  total: number;
  generation: number[];
  // evaluations: of this deme so far
  demes: { best_fitness: number[]; mean_fitness: number[]; best_nodes: number[]; mean_nodes: number[]; evaluations: number[] }[];
}

export interface LearningCurve {
  episodes_per_point: number;
  reward: number[];
  collisions: number[];
}

// [action (-1: none), cell, heading, reward, collided, cell where trash came (-1), features before the step]
export type ReplayStep = [number, number, number, number, number, number, number[]];

export interface Replay {
  who: "tree" | "policy";
  title: string;
  episode: number;
  first_step: number;
  cell: number;
  heading: number;
  trash: number[];
  steps: ReplayStep[];
}

export interface World {
  kind: string;
  width: number;
  height: number;
  cells: string; // # wall, . free, * trash; row by row from the top
  has_heading: boolean;
  goal: number | null;
  maps: { episodes: number; steps: number; seed: number; tree: number[]; policy: number[] };
  replays: Replay[];
}

// [action (-1: none), state, reward, the policy's action, features]
export type WalkStep = [number, number, number, number, number[]];

export interface Walk {
  who: "tree" | "policy";
  title: string;
  seed: number;
  steps: WalkStep[];
}

export interface PageData {
  format: "coppice page";
  version: number;
  study: {
    path: string;
    name: string;
    chain_hash: string;
    states: number;
    transitions: number;
    initial_state: number;
    world: string;
    title: string;
    source: string;
    steps: number;
  };
  vocabulary: Vocabulary;
  answer: {
    from: string;
    tree: TreePart;
    policy: Figures;
    promise: Promised;
    shortfalls: string[];
    rules: RuleAnswer[];
  };
  states: States;
  disagreements: Disagreements;
  runs: Run[];
  learning: {
    settings: Record<string, unknown> | null;
    outcome: (Record<string, unknown> & { curve?: LearningCurve }) | null;
  };
  world: World | null;
  walks: Walk[];
  provenance: {
    version: string;
    machine: string;
    seed: number;
    episodes: number;
    resamples: number;
    commands: { what: string; command: string }[];
  };
}

export const kVersion = 1;

// Throws with a sentence that a person can act on.
export function readData(text: string): PageData {
  const data = JSON.parse(text) as PageData;
  if (data.format !== "coppice page") {
    throw new Error("the data inside this page is not a coppice page");
  }
  if (data.version !== kVersion) {
    throw new Error(`the data inside this page has version ${data.version}: this page reads version ${kVersion}`);
  }
  return data;
}
