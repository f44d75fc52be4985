// Rules in the studio: typed in, proved while typing, kept in the study; a counterexample is shown in the room.
import type { RuleAnswer } from "../data";
import { need, shownText } from "../state";
import { RuleText } from "../sections/rule_text";
import { ask } from "./api";
import { forgetRule, keepRule, offer, ruleAnswers, rules, sayError, typedRule } from "./session";
import { shownWalk } from "./walk";

function showBroken(answer: RuleAnswer): void {
  const features = answer.seen?.features ?? answer.broken_by?.features;
  if (features) {
    ask("walk", { tree: shownText.value, features })
      .then((replay) => {
        shownWalk.value = { replay, features };
      })
      .catch(sayError);
  }
}

export function StudioRules() {
  const { vocabulary } = need();
  const typed = typedRule.value.trim();
  const preview = ruleAnswers.value.get(typed);
  const example = `never ${vocabulary.actions[0]?.name ?? "none"} when ${vocabulary.features[0]?.name ?? "s0"}=${vocabulary.features[0]?.values[0] ?? 0}`;
  const add = (): void => {
    if (typed === "") {
      return;
    }
    keepRule(typed)
      .then(() => {
        typedRule.value = "";
      })
      .catch(sayError);
  };
  return (
    <>
      <ul class="rules">
        {rules.value.map((rule) => {
          const answer = ruleAnswers.value.get(rule);
          return (
            <li key={rule}>
              {answer ? <RuleText rule={answer} /> : <code>{rule}</code>}{" "}
              {answer?.holds === false && offer.value?.has_simulator && (
                <button type="button" onClick={() => showBroken(answer)}>
                  Show it in the room
                </button>
              )}{" "}
              <button type="button" onClick={() => { forgetRule(rule).catch(sayError); }} aria-label={`Forget the rule ${rule}`}>
                Forget
              </button>
            </li>
          );
        })}
      </ul>
      <form
        class="toolbar"
        onSubmit={(event) => {
          event.preventDefault();
          add();
        }}
      >
        <label>
          A rule{" "}
          <input type="text" size={44} value={typedRule.value} placeholder={example} spellcheck={false} onInput={(e) => { typedRule.value = e.currentTarget.value; }} />
        </label>
        <button type="submit" disabled={typed === ""}>
          Keep the rule
        </button>
      </form>
      <div aria-live="polite" class="preview">
        {typed !== "" && (preview ? <RuleText rule={preview} /> : <span class="quiet">proving…</span>)}{" "}
        {typed !== "" && preview?.holds === false && offer.value?.has_simulator && (
          <button type="button" onClick={() => showBroken(preview)}>
            Show it in the room
          </button>
        )}
      </div>
    </>
  );
}
