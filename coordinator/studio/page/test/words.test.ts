import { describe, expect, it } from "vitest";
import type { Vocabulary } from "../src/data";
import { parseTree } from "../src/tree";
import { observationWords, sentences, readingWords } from "../src/words";

const labelled: Vocabulary = {
  features: [
    { name: "s3", label: "ahead", values: [0, 1, 3], labels: ["wall", "free", "trash"], equal: true, less_equal: false },
    { name: "x", label: "column", unit: "cells", values: [0, 1, 2], equal: true, less_equal: true },
  ],
  actions: [{ name: "move" }, { name: "turn_left", label: "turn left" }],
};
const plain: Vocabulary = { features: labelled.features.map(({ name, values, equal, less_equal }) => ({ name, values, equal, less_equal })), actions: [{ name: "move" }, { name: "turn_left" }] };
const text = (tree: string, vocabulary: Vocabulary): string => {
  const lines: string[] = [];
  const go = (s: ReturnType<typeof sentences>): void => {
    lines.push(`${s.node}: ${s.text}`);
    s.parts.forEach(go);
  };
  go(sentences(parseTree(tree, vocabulary), vocabulary));
  return lines.join("\n");
};

describe("a tree in words", () => {
  it("says what the legend says", () => {
    expect(text("(selector (sequence s3=0 turn_left) move)", labelled)).toBe("0: The first of these that succeeds:\n1: if wall ahead: turn left\n4: otherwise: move");
  });

  it("says names and values where there is no legend", () => {
    expect(text("(sequence s3=0 x<=1 turn_left)", plain)).toBe("0: if s3 = 0 and x ≤ 1: turn left");
  });

  it("says what an action before its conditions means", () => {
    expect(text("(sequence turn_left s3=1)", labelled)).toBe("0: turn left; it stands if free ahead, else a later branch may replace it");
    expect(text("(sequence s3=0 x=1)", labelled)).toBe("0: if wall ahead and column = 1 cells: keep what was chosen so far");
  });

  it("joins what is only asked into one condition", () => {
    expect(text("(selector (sequence (selector s3=0 s3=3) x=1 turn_left) move)", labelled)).toBe(
      "0: The first of these that succeeds:\n1: if (wall ahead or trash ahead) and column = 1 cells: turn left\n7: otherwise: move",
    );
    expect(text("(sequence move s3=1 turn_left)", labelled)).toBe("0: All of these, in turn, until one fails:\n1: move\n2: go on only if free ahead\n3: turn left");
  });

  it("names an observation, whole or what matters of it", () => {
    expect(observationWords([3, 2], labelled)).toBe("trash ahead, column = 2 cells");
    expect(observationWords([3, 2], plain, [false, true])).toBe("x=2");
    expect(observationWords([3, 2], plain, [false, false])).toBe("anything");
  });
});

it("a reading without its name: a label, an interval, a number", () => {
  const plain = { name: "s3", values: [0, 3], equal: true, less_equal: true, labels: ["wall", "trash"] };
  const binned = { name: "speed", values: [0, 1], equal: false, less_equal: true, texts: ["0.5", "inf"], readings: ["speed in (-inf, 0.5]", "speed in (0.5, inf)"] };
  expect(readingWords(plain, 3)).toBe("trash");
  expect(readingWords(binned, 1)).toBe("(0.5, inf)");
  expect(readingWords({ ...plain, labels: [null, null] }, 3)).toBe("3");
});
