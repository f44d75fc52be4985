// Section 1: what the tree is, what it is worth beside the policy, whether it is safe, and what falls short.
import type { Figure, PageData } from "../data";
import { counted, number, percent, plusMinus } from "../format";
import { known, need, selected, shown, shownName, shownText } from "../state";
import { counts, valueText } from "../tree";
import { type Sentence, actionWords, hasLegend, sentences } from "../words";

const interval = (f: Figure, show: (v: number) => string): string => `${show(f.value)} [${show(f.low)}, ${show(f.high)}]`;

function verdict(data: PageData): string {
  const { tree, policy, promise } = data.answer;
  const parts: string[] = [];
  const sim = promise.tree;
  if (sim && promise.policy) {
    const ratio = promise.policy.reward.mean > 0 ? ` (${percent(sim.reward.mean / promise.policy.reward.mean, 0)})` : "";
    parts.push(`does what the policy does in ${percent(sim.agreement.mean)} of its steps`);
    parts.push(`earns ${sim.reward.mean.toFixed(1)} of the policy's ${promise.policy.reward.mean.toFixed(1)} an episode${ratio}`);
    parts.push(
      sim.total_collisions === 0
        ? `never collided in ${counted(sim.episodes, "simulated episode")}`
        : `collided ${counted(sim.total_collisions, "time")} in ${counted(sim.episodes, "simulated episode")}`,
    );
  } else {
    parts.push(`does what the policy does in ${percent(tree.figures.agreement)} of the steps of a walk`);
    parts.push(`earns ${number(tree.figures.reward)} of the policy's ${number(policy.reward)} a walk`);
  }
  return `A tree of ${counted(tree.size.nodes, "node")} that ${parts.slice(0, -1).join(", ")} and ${parts[parts.length - 1]}.`;
}

export function Words(props: { sentence: Sentence }) {
  const { sentence } = props;
  return (
    <>
      <button type="button" class={`sentence${selected.value === sentence.node ? " selected" : ""}`} onClick={() => (selected.value = sentence.node)}>
        {sentence.text}
      </button>
      {sentence.parts.length > 0 && (
        <ol>
          {sentence.parts.map((part) => (
            <li key={part.node}>
              <Words sentence={part} />
            </li>
          ))}
        </ol>
      )}
    </>
  );
}

export function Legend() {
  const { vocabulary } = need();
  return (
    <details class="numbers">
      <summary>legend: what the names mean</summary>
      <table>
        <thead>
          <tr>
            <th scope="col">feature</th>
            <th scope="col">measures</th>
            <th scope="col">values</th>
          </tr>
        </thead>
        <tbody>
          {vocabulary.features.map((f) => (
            <tr key={f.name}>
              <th scope="row">{f.name}</th>
              <td>{f.label ?? "–"}</td>
              <td>
                {f.values.length > 12
                  ? `${valueText(f, f.values[0] ?? 0)} to ${valueText(f, f.values[f.values.length - 1] ?? 0)}`
                  : f.values.map((v, i) => (f.labels?.[i] ? `${valueText(f, v)} ${f.labels[i]}` : valueText(f, v))).join(", ")}
                {f.unit ? ` (${f.unit})` : ""}
              </td>
            </tr>
          ))}
        </tbody>
      </table>
      <p>
        Actions: {vocabulary.actions.map((a) => (a.label ? `${a.name} (${a.label})` : a.name)).join(", ")}.
        {hasLegend(vocabulary) ? "" : " This study gives its features no labels."}
      </p>
      <p>
        In the drawing <b>?</b> asks its branches from top to bottom and stops at the first that succeeds; <b>→</b> goes through its branches and stops at
        the first that fails; round boxes ask, square boxes choose an action. The last action chosen is the one that is taken.
      </p>
    </details>
  );
}

function Row(props: { name: string; hint: string; tree: string; policy: string }) {
  return (
    <tr>
      <th scope="row">
        {props.name}
        <small>{props.hint}</small>
      </th>
      <td>{props.tree}</td>
      <td>{props.policy}</td>
    </tr>
  );
}

export function FiguresTable() {
  const data = need();
  const { policy, promise } = data.answer;
  const isAnswer = shownText.value === data.answer.tree.text;
  const part = known.value.get(shownText.value);
  const tree = shown.value;
  const size = part?.size ?? (tree ? counts(tree) : null);
  const sim = isAnswer ? promise.tree : null;
  const chain = isAnswer ? promise.chain : null;
  return (
    <div class="scroll" tabIndex={0} role="region" aria-label="Figures of the tree and of the policy">
      <table class="figures">
        <thead>
          <tr>
            <td />
            <th scope="col">tree</th>
            <th scope="col">policy</th>
          </tr>
        </thead>
        <tbody>
          <Row
            name="size"
            hint="what somebody has to read"
            tree={size ? `${size.nodes} nodes: ${size.conditions} conditions, ${size.actions} actions` : "–"}
            policy={`${number(data.study.states * data.vocabulary.actions.length)} entries`}
          />
          {part && (
            <>
              <Row name="agreement over all states" hint={`of ${number(data.study.states)} that learning met, however rare`} tree={percent(part.figures.coverage)} policy="100 %" />
              <Row name="agreement along the chain" hint={`walks of ${data.study.steps} steps, exact`} tree={percent(part.figures.agreement)} policy="100 %" />
              <Row
                name="reward along the chain"
                hint={chain ? "of a walk, exact; [ , ] 95 % for what the counts leave open" : "of a walk, exact"}
                tree={chain ? interval(chain.reward_per_episode, (v) => v.toFixed(1)) : number(part.figures.reward)}
                policy={number(policy.reward)}
              />
            </>
          )}
          {sim && (
            <>
              <Row
                name="agreement in simulation"
                hint={`${number(sim.episodes)} episodes; ± 95 % for the episodes`}
                tree={`${plusMinus(100 * sim.agreement.mean, 100 * sim.agreement.margin)} %`}
                policy={promise.policy ? `${plusMinus(100 * promise.policy.agreement.mean, 100 * promise.policy.agreement.margin)} %` : "–"}
              />
              <Row
                name="reward in simulation"
                hint="of an episode"
                tree={plusMinus(sim.reward.mean, sim.reward.margin)}
                policy={promise.policy ? plusMinus(promise.policy.reward.mean, promise.policy.reward.margin) : "–"}
              />
              <Row
                name="collisions in simulation"
                hint="in all episodes"
                tree={number(sim.total_collisions)}
                policy={promise.policy ? number(promise.policy.total_collisions) : "–"}
              />
            </>
          )}
          {chain?.events.map((event) => (
            <Row
              key={event.name}
              name={`${event.name} on the chain`}
              hint={`probability within ${chain.steps} steps; ${event.test}`}
              tree={interval(event.within, (v) => percent(v))}
              policy=""
            />
          ))}
          {chain && (
            <Row name="leaves the model" hint="takes an action that learning never tried there; add it for an upper bound" tree={interval(chain.leaves_by_untried_pair.within, (v) => percent(v, 2))} policy="" />
          )}
        </tbody>
      </table>
    </div>
  );
}

export function Answer() {
  const data = need();
  const tree = shown.value;
  const isAnswer = shownText.value === data.answer.tree.text;
  return (
    <section id="answer" aria-labelledby="h-answer">
      <h2 id="h-answer">1. The answer</h2>
      {isAnswer ? (
        <p class="verdict">{verdict(data)}</p>
      ) : (
        <p class="verdict">
          Shown is {shownName.value || "another tree"}, not the answer. What simulations and intervals say below is known of the answer only.
        </p>
      )}
      {isAnswer &&
        (data.answer.shortfalls.length > 0 ? (
          <div class="warning" role="note">
            <h3>What falls short, or must be known</h3>
            <ul>
              {data.answer.shortfalls.map((text) => (
                <li key={text}>{text}</li>
              ))}
            </ul>
          </div>
        ) : (
          <p>
            Nothing was found that falls short: it earns at least 90 % of what the policy earns, is as safe as the policy, always decides, and the chain keeps its
            promise.
          </p>
        ))}
      <FiguresTable />
      {!data.answer.promise.chain && <p class="quiet">This chain of {number(data.study.states)} states is too large for intervals.</p>}
      <h3>In words</h3>
      {tree && <div class="words">{<Words sentence={sentences(tree, data.vocabulary)} />}</div>}
      <Legend />
      <details class="numbers">
        <summary>as text</summary>
        <p>
          <code class="text">{shownText.value}</code>
        </p>
        <p class="quiet">
          From {shownName.value}. Actions: {data.vocabulary.actions.map((_, i) => actionWords(i, data.vocabulary)).join(", ")}.
        </p>
      </details>
    </section>
  );
}
