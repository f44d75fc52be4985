// Section 2: the tree drawn with heat, and what is known of the node that is pointed at.
import { useComputed, useSignal } from "@preact/signals";
import { statesAtNode } from "../analysis";
import { number, percent } from "../format";
import { beside, besideName, besideText, lit, need, putBeside, selected, shown, shownName, shownText, shownView, weighted } from "../state";
import { isComposite, leafText, nodeNumber, walk } from "../tree";
import { TreeDrawing } from "../tree_drawing";
import { actionWords, nodeWords, observationWords } from "../words";
import { Editor, editing } from "../studio/editor";
import { Jobs, KeptTrees, Messages, WholeTree } from "../studio/panels";
import { Scores } from "../studio/scores";
import { ruleAnswers } from "../studio/session";
import { WalkBox } from "../studio/walk";

const kMostListed = 8;

export function NodeDetail() {
  const data = need();
  const tree = shown.value;
  const view = shownView.value;
  const index = selected.value;
  const listed = useComputed(() => {
    const t = shown.value;
    const i = selected.value;
    if (!t || i === null || i >= t.size) {
      return [];
    }
    const isAnswer = shownText.value === data.answer.tree.text;
    return statesAtNode(t, i, data.states, data.vocabulary, isAnswer ? data.states.tree_visits : data.states.policy_visits);
  });
  if (!tree || !view || index === null || index >= tree.size) {
    return <p class="quiet">Point at a node, or go there with the arrow keys: what reaches it, what it decides and where it disagrees with the policy.</p>;
  }
  const node = nodeNumber(tree, index);
  const share = (list: number[]): number => (view.view.steps > 0 ? (list[index] ?? 0) / view.view.steps : 0);
  const ticked = share(view.view.ticked);
  const decides = share(view.view.decides);
  const differs = share(view.view.differs);
  const states = listed.value;
  return (
    <div class="detail" aria-live="polite">
      <h3>
        Node {index}: {nodeWords(node, data.vocabulary)}
      </h3>
      <ul class="facts">
        <li>
          A tick comes here in <b>{percent(ticked)}</b> of the steps{node.kind === "condition" && ticked > 0 ? `; it holds in ${percent(share(view.view.succeeded) / ticked)} of those` : ""}.
        </li>
        {node.kind === "action" && (
          <>
            <li>
              It has the last word in <b>{percent(decides)}</b> of the steps and in {number(view.view.states[index] ?? 0)} states.
            </li>
            <li>
              There the policy does something else in <b>{percent(differs)}</b> of the steps ({number(view.view.differing_states[index] ?? 0)} states), which costs {number(view.view.cost[index] ?? 0)} a walk.
            </li>
          </>
        )}
        {isComposite(node) && (
          <li>
            {node.children.length} branches, {node.size} nodes.
          </li>
        )}
      </ul>
      {states.length > 0 && (
        <div class="scroll" tabIndex={0} role="region" aria-label="The most visited states that come to this node">
          <table>
            <caption>
              {states.length > kMostListed ? `The ${kMostListed} most visited of ${number(states.length)} states that come here` : "The states that come here"}
              {data.states.index.length < data.states.total ? ` (of the ${number(data.states.index.length)} that the page holds)` : ""}
            </caption>
            <thead>
              <tr>
                <th scope="col">what is seen</th>
                <th scope="col">visits a walk</th>
                <th scope="col">tree</th>
                <th scope="col">policy</th>
              </tr>
            </thead>
            <tbody>
              {states.slice(0, kMostListed).map((s) => {
                const width = data.vocabulary.features.length;
                const features = data.states.features.slice(s.state * width, (s.state + 1) * width);
                return (
                  <tr key={s.state} class={s.action === s.policy ? "" : "differs"}>
                    <td>{observationWords(features, data.vocabulary)}</td>
                    <td>{number(s.visits)}</td>
                    <td>
                      {actionWords(s.action, data.vocabulary)}
                      {s.decides || node.kind !== "action" ? "" : " (decided elsewhere)"}
                    </td>
                    <td>
                      {s.action === s.policy ? "the same" : <b>≠ {actionWords(s.policy, data.vocabulary)}</b>}
                    </td>
                  </tr>
                );
              })}
            </tbody>
          </table>
        </div>
      )}
    </div>
  );
}

export function TreeSection() {
  const data = need();
  const scale = useSignal(1);
  const collapsed = useSignal<ReadonlySet<number>>(new Set());
  const query = useSignal("");
  const box = useSignal<HTMLDivElement | null>(null);
  const tree = shown.value;
  const second = beside.value;
  if (!tree) {
    return null;
  }
  const asked = query.value.trim().toLowerCase();
  const matches = new Set<number>();
  if (asked !== "") {
    walk(tree, (node, index) => {
      const text = isComposite(node) ? node.kind : nodeWords(node, data.vocabulary);
      const raw = isComposite(node) ? "" : leafText(node, data.vocabulary);
      if (text.toLowerCase().includes(asked) || raw.toLowerCase().includes(asked)) {
        matches.add(index);
      }
    });
  }
  const collapse = (node: number): void => {
    const next = new Set(collapsed.value);
    if (!next.delete(node)) {
      next.add(node);
    }
    collapsed.value = next;
  };
  const fit = (): void => {
    const svg = box.value?.querySelector("svg");
    if (svg && box.value) {
      scale.value = Math.min(1.5, Math.max(0.3, (box.value.clientWidth - 4) / svg.viewBox.baseVal.width));
    }
  };
  const view = shownView.value;
  // Where a rule is broken: the node that chooses what it forbids.
  const answers = editing.value ? [...ruleAnswers.value.values()] : shownText.value === data.answer.tree.text ? data.answer.rules : [];
  const marks = new Map<number, string>();
  for (const answer of answers) {
    if (answer.broken_by && answer.broken_by.node !== null) {
      marks.set(answer.broken_by.node, "broken");
    }
  }
  return (
    <section id="tree" aria-labelledby="h-tree">
      <h2 id="h-tree">2. The tree, and how often each branch decides</h2>
      <p class="quiet">
        {view?.exact
          ? `Weighted with the tree's own walk of ${data.study.steps} steps through the chain, exact.`
          : "Weighted with the policy's walk through the states that this page holds: the tree's own walk was not computed."}{" "}
        Behind an action: the share of the steps that it decides, and ≠ where the policy does something else.
      </p>
      <div class="toolbar" role="toolbar" aria-label="The drawing">
        <button type="button" onClick={() => (scale.value = Math.min(3, scale.value * 1.25))} aria-label="Zoom in">
          +
        </button>
        <button type="button" onClick={() => (scale.value = Math.max(0.3, scale.value / 1.25))} aria-label="Zoom out">
          −
        </button>
        <button type="button" onClick={fit}>
          Fit
        </button>
        <button type="button" onClick={() => (scale.value = 1)}>
          1:1
        </button>
        <button type="button" onClick={() => (collapsed.value = new Set())} disabled={collapsed.value.size === 0}>
          Expand all
        </button>
        <label>
          Search{" "}
          <input type="search" value={query.value} onInput={(e) => (query.value = e.currentTarget.value)} placeholder="wall, move, s3=0" />
        </label>
        {asked !== "" && <span role="status">{matches.size} found</span>}
      </div>
      {editing.value && (
        <>
          <WholeTree />
          <Editor />
          <Messages />
        </>
      )}
      <div class={editing.value ? "workbench" : ""}>
        <div class="drawing" tabIndex={0} role="region" aria-label="The drawing of the tree" ref={(element) => { box.value = element; }} onClick={() => (selected.value = null)}>
          <TreeDrawing
            tree={tree}
            vocabulary={data.vocabulary}
            title={`The tree: ${shownName.value}`}
            view={view?.view ?? null}
            selected={selected.value}
            onSelect={(node) => (selected.value = node)}
            lit={lit.value}
            matches={matches}
          marks={marks}
            collapsed={collapsed.value}
            onCollapse={collapse}
            scale={scale.value}
            {...(editing.value ? { onKey: editing.value.onKey, onDropOn: editing.value.onDropOn } : {})}
          />
        </div>
        {editing.value && <Scores />}
      </div>
      {editing.value && (
        <>
          <WalkBox />
          <Jobs />
        </>
      )}
      <NodeDetail />
      {editing.value && <KeptTrees />}
      {second && besideText.value !== null && (
        <div class="beside">
          <h3>
            Beside it: {besideName.value}{" "}
            <button type="button" onClick={() => putBeside(null)}>
              Close
            </button>
          </h3>
          <div class="drawing" tabIndex={0} role="region" aria-label="The drawing of the tree beside it">
            <TreeDrawing
              tree={second}
              vocabulary={data.vocabulary}
              title={`Beside it: ${besideName.value}`}
              view={weighted(besideText.value, second, data).view}
              selected={null}
              onSelect={() => undefined}
              scale={scale.value}
            />
          </div>
        </div>
      )}
    </section>
  );
}
