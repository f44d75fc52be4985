// What is known of one rule, in a sentence.
import type { RuleAnswer } from "../data";
import { number } from "../format";
import { need, selected } from "../state";
import { actionWords, observationWords } from "../words";

export function RuleText(props: { rule: RuleAnswer }) {
  const data = need();
  const { rule } = props;
  if (rule.error !== undefined) {
    return (
      <>
        <code>{rule.rule}</code>: <span class="bad">{rule.error}</span>
      </>
    );
  }
  if (rule.holds) {
    return (
      <>
        <span class="good">✓ proved</span> <code>{rule.rule}</code> — for every observation; it is about {number(rule.states ?? 0)} states of the chain.
      </>
    );
  }
  const broken = rule.broken_by;
  return (
    <>
      <span class="bad">✗ broken</span> <code>{rule.rule}</code>
      {broken && (
        <>
          {" "}
          — it chooses {actionWords(broken.action, data.vocabulary)}
          {broken.node !== null && (
            <>
              {" "}
              (node{" "}
              <button type="button" onClick={() => { selected.value = broken.node; }} aria-label={`Show node ${broken.node}`}>
                {broken.node}
              </button>
              )
            </>
          )}{" "}
          when {observationWords(broken.features, data.vocabulary, broken.matters)}; the rest may be anything.{" "}
          {rule.seen ? `Learning met such a state ${number(rule.seen.visits)} times: ${observationWords(rule.seen.features, data.vocabulary)}.` : "Learning never met such a state."}
        </>
      )}
    </>
  );
}
