// Undo and redo without limit: a list of immutable trees and where one stands in it. Entries share all that an edit
// left alone, so a thousand of them are small. Rules: an edit that changes nothing makes no entry; an edit behind an
// undo forgets what was undone; edits of one gesture (a number typed digit by digit) are one entry; a change of the
// selection alone is none.
import type { TreeNode } from "./tree";

export interface Entry {
  tree: TreeNode;
  selected: number | null;
  label: string; // what made it: "delete"
  gesture: string | null;
}

export interface History {
  entries: readonly Entry[]; // at least one
  at: number;
}

export const begin = (tree: TreeNode, label: string): History => ({ entries: [{ tree, selected: null, label, gesture: null }], at: 0 });

export const now = (history: History): Entry => history.entries[history.at] as Entry;

export function edited(history: History, entry: Entry): History {
  const current = now(history);
  if (entry.tree === current.tree) {
    return history;
  }
  const replaces = entry.gesture !== null && entry.gesture === current.gesture;
  const before = history.entries.slice(0, replaces ? history.at : history.at + 1);
  return { entries: [...before, entry], at: before.length };
}

// The selection belongs to the entry, so that undo shows where something happened.
export function withSelection(history: History, selected: number | null): History {
  const current = now(history);
  return current.selected === selected
    ? history
    : { entries: history.entries.map((entry, i) => (i === history.at ? { ...entry, selected } : entry)), at: history.at };
}

export const canUndo = (history: History): boolean => history.at > 0;
export const canRedo = (history: History): boolean => history.at + 1 < history.entries.length;
export const undo = (history: History): History => (canUndo(history) ? { ...history, at: history.at - 1 } : history);
export const redo = (history: History): History => (canRedo(history) ? { ...history, at: history.at + 1 } : history);
