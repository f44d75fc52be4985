// Section 6: where tree and policy differ, ranked by cost, the branches that would mend most of it, and rules proved or
// broken.
import type { Branch, Disagreements } from "../data";
import { number, percent } from "../format";
import { live, need, open, selected, shownText } from "../state";
import { parseTree } from "../tree";
import { actionWords, observationWords, sentences } from "../words";
import { applyBranch } from "../studio/editor";
import { StudioRules } from "../studio/rules";
import { suggestions } from "../studio/session";
import { RuleText } from "./rule_text";

export function Trust() {
  const data = need();
  const disagreements = suggestions.value?.found ?? data.disagreements;
  const about = suggestions.value?.tree ?? data.answer.tree.text;
  const isAnswer = shownText.value === about;
  return (
    <section id="trust" aria-labelledby="h-trust">
      <h2 id="h-trust">6. Where tree and policy differ, and what is proved</h2>
      {!isAnswer && (
        <p class="warning">
          What follows is about {about === data.answer.tree.text ? "the answer" : "an earlier tree"}, not about the tree that is shown.{" "}
          {live.value ? (
            "\"Suggest branches\" asks about the tree that is shown."
          ) : (
            <button type="button" onClick={() => open(data.answer.tree.text, data.answer.from)}>
              Show the answer
            </button>
          )}
        </p>
      )}
      <p>
        They differ in {number(disagreements.total)} of {number(data.study.states)} states; together that costs {number(disagreements.cost)} in a walk of {disagreements.steps} steps. Cost
        is visits × regret: how often the tree is there, times how much worse its action is by the learned Q-table.
      </p>
      <div class="scroll tall" tabIndex={0} role="region" aria-label="The costliest disagreements">
        <table>
          <caption>The costliest</caption>
          <thead>
            <tr>
              <th scope="col">what is seen</th>
              <th scope="col">tree</th>
              <th scope="col">policy</th>
              <th scope="col">visits a walk</th>
              <th scope="col">regret</th>
              <th scope="col">cost</th>
              <th scope="col">node</th>
            </tr>
          </thead>
          <tbody>
            {disagreements.costliest.map((d) => (
              <tr key={d.state}>
                <td>{observationWords(d.features, data.vocabulary)}</td>
                <td>{actionWords(d.tree, data.vocabulary)}</td>
                <td>{actionWords(d.policy, data.vocabulary)}</td>
                <td>{number(d.visits)}</td>
                <td>{number(d.regret)}</td>
                <td>
                  {number(d.cost)} <small>{disagreements.cost > 0 ? percent(d.cost / disagreements.cost) : ""}</small>
                </td>
                <td>
                  {d.node === null ? (
                    "none"
                  ) : (
                    <button type="button" onClick={() => (selected.value = d.node)} aria-label={`Show node ${d.node}`}>
                      {d.node}
                    </button>
                  )}
                </td>
              </tr>
            ))}
          </tbody>
        </table>
      </div>
      <h3>Branches that would mend most of it</h3>
      {!disagreements.searched ? (
        <p class="quiet">Not searched: the chain is too large.</p>
      ) : disagreements.branches.length === 0 ? (
        <p>No branch of so few tests saves anything worth it.</p>
      ) : (
        <ol class="branches">
          {disagreements.branches.map((branch) => (
            <li key={branch.branch}>
              <BranchText branch={branch} all={disagreements} />
            </li>
          ))}
        </ol>
      )}
      <h3>Rules</h3>
      <p class="quiet">A rule is proved for every observation there can be, or an observation that breaks it is shown.</p>
      {live.value ? (
        <StudioRules />
      ) : (
        <ul class="rules">
          {data.answer.rules.map((rule) => (
            <li key={rule.rule}>
              <RuleText rule={rule} />
            </li>
          ))}
        </ul>
      )}
    </section>
  );
}

function BranchText(props: { branch: Branch; all: Disagreements }) {
  const data = need();
  const { branch } = props;
  const apply = applyBranch.value;
  return (
    <>
      <b>{sentences(parseTree(branch.branch, data.vocabulary), data.vocabulary).text}</b> — saves {number(branch.saved)}
      {props.all.cost > 0 ? ` (${percent(branch.saved / props.all.cost)} of the cost)` : ""}: {number(branch.differing)} of {number(branch.states)} states differ now, it
      mends {number(branch.mended)} and spoils {number(branch.spoilt)}. With it alone: agreement along the chain {percent(branch.agreement)}, over all states {percent(branch.coverage)}, reward{" "}
      {number(branch.reward)}. {apply ? (
        <button type="button" onClick={() => apply(branch.branch)}>
          Add this branch
        </button>
      ) : (
        <code class="text">coppice edit {data.study.name} {branch.edit} -o better.tree</code>
      )}
    </>
  );
}
