// What the page asks of the studio's server: ../../../README.md, "what the studio answers".
import type { Disagreements, PageData, Promised, Replay, RuleAnswer, Run, TreePart } from "../data";

export interface Job {
  job: number;
  kind: string;
  about: { tree?: string; settings?: unknown } | null;
  state: "running" | "done" | "stopped" | "failed";
  share: number;
  text: string;
  detail: unknown;
  error: string;
  result?: unknown;
}

export interface Kept {
  id: number;
  name: string;
  note: string;
  tree: string;
  kept: string;
}

export interface Status {
  changes: string;
  kept: Kept[];
  rules: string[];
  jobs: Job[];
}

export interface PageAnswer {
  state: Job["state"];
  share: number;
  error: string;
  can_breed: boolean;
  has_simulator: boolean;
  exports: { format: string; what: string }[];
  data: PageData | null;
}

export interface Answers {
  page: PageAnswer;
  status: Status;
  runs: Run[];
  score: TreePart;
  rules: RuleAnswer[];
  explain: Disagreements;
  prune: { tree: string; removals: { what: string; reason: string; nodes: number }[] };
  guard: { tree: string; nodes: number };
  walk: (Replay & { at: number }) | null;
  keep: { id: number };
  forget: Record<string, never>;
  keep_rule: Record<string, never>;
  forget_rule: Record<string, never>;
  simulate: { job: number };
  breed: { job: number };
  job: Job;
  stop: { stopped: boolean };
  write: { name: string; text: string };
}

export interface Simulation {
  promise: Promised;
  shortfalls: string[];
}

const token = (): string => new URLSearchParams(location.search).get("token") ?? "";

// Throws with the server's sentence, or with one that says that it cannot be reached.
export async function ask<Name extends keyof Answers>(name: Name, body: object = {}): Promise<Answers[Name]> {
  let response: Response;
  try {
    response = await fetch(`/api/${name}`, {
      method: "POST",
      headers: { "Content-Type": "application/json", "X-Coppice-Token": token() },
      body: JSON.stringify(body),
      cache: "no-store",
    });
  } catch {
    throw new Error("the studio does not answer: it has ended, or is on its way out. What you kept is in the study; what you edited is here");
  }
  const answer = (await response.json()) as Answers[Name] & { error?: string };
  if (!response.ok) {
    throw new Error(answer.error ?? `the studio answered ${response.status}`);
  }
  return answer;
}
