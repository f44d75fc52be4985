import fc from "fast-check";
import { describe, expect, it } from "vitest";
import { type Entry, type History, begin, canRedo, canUndo, edited, now, redo, undo, withSelection } from "../src/history";
import { action } from "../src/tree";

const entry = (n: number, gesture: string | null = null): Entry => ({ tree: action(n), selected: n, label: `edit ${n}`, gesture });
const steps = fc.array(fc.oneof(fc.constant("undo" as const), fc.constant("redo" as const), fc.nat({ max: 9 })), { maxLength: 60 });
const run = (list: (number | "undo" | "redo")[]): History =>
  list.reduce<History>((h, s) => (s === "undo" ? undo(h) : s === "redo" ? redo(h) : edited(h, entry(s))), begin(action(99), "begin"));

describe("a history", () => {
  it("undoes an edit to the very tree that was there, and redoes it to the very one it made", () => {
    fc.assert(
      fc.property(steps, fc.nat({ max: 9 }), (list, n) => {
        const before = run(list);
        const after = edited(before, entry(n));
        expect(now(undo(after)).tree).toBe(now(before).tree);
        expect(now(redo(undo(after)))).toBe(now(after));
        expect(canRedo(after)).toBe(false);
      }),
    );
  });

  it("always stands at one of its entries", () => {
    fc.assert(
      fc.property(steps, (list) => {
        const history = run(list);
        expect(now(history)).toBeDefined();
        expect(canUndo(history)).toBe(history.at > 0);
      }),
    );
  });

  it("takes an edit that changes nothing for none", () => {
    const history = begin(action(1), "begin");
    expect(edited(history, { ...now(history), label: "again" })).toBe(history);
  });

  it("makes one entry of the edits of a gesture", () => {
    const history = edited(edited(edited(begin(action(0), "begin"), entry(1, "typing")), entry(2, "typing")), entry(3));
    expect(history.entries.map((e) => e.label)).toEqual(["begin", "edit 2", "edit 3"]);
  });

  it("remembers the selection without an entry for it", () => {
    const history = withSelection(edited(begin(action(0), "begin"), entry(1)), 5);
    expect(history.entries.length).toBe(2);
    expect(now(history).selected).toBe(5);
  });

  it("keeps a thousand edits", () => {
    let history = begin(action(0), "begin");
    for (let i = 0; i < 1000; ++i) {
      history = edited(history, entry(i));
    }
    for (let i = 0; i < 1000; ++i) {
      history = undo(history);
    }
    expect(now(history).label).toBe("begin");
  });
});
