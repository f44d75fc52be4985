// What the edit changed: figures before and after, exact and at once; the simulator when asked; the states that were
// mended and spoilt, and a walk that shows one.
import { computed, signal } from "@preact/signals";
import { type Difference, differences, featuresOf, meaningOf } from "../analysis";
import { number, percent, plusMinus } from "../format";
import { known, need, page, shown, shownMeaning, shownText } from "../state";
import { counts, parseTree } from "../tree";
import { actionWords, observationWords } from "../words";
import { ask } from "./api";
import { baseline, baselineName, jobs, offer, sayError, scoredIn, simulate, simulations } from "./session";
import { shownWalk } from "./walk";

const kMostListed = 6;

const baselineMeaning = computed(() => {
  const data = page.value;
  return data && baseline.value !== "" ? meaningOf(parseTree(baseline.value, data.vocabulary), data.states, data.vocabulary) : null;
});

const found = computed(() => {
  const data = page.value;
  const before = baselineMeaning.value;
  const after = shownMeaning.value;
  return data && before && after ? differences(before, after, data.states) : null;
});

function Bar(props: { before: number; after: number; most: number }) {
  const width = (value: number): string => `${Math.max(0, Math.min(100, props.most > 0 ? (100 * value) / props.most : 0))}`;
  return (
    <svg class="bar" viewBox="0 0 100 12" preserveAspectRatio="none" aria-hidden="true">
      <rect class="before" y="1" height="4" width={width(props.before)} />
      <rect class="after" y="7" height="4" width={width(props.after)} />
    </svg>
  );
}

function Line(props: { name: string; before: number | null; after: number | null; most: number; show: (v: number) => string; lessIsBetter?: boolean }) {
  const { before, after } = props;
  const change = before !== null && after !== null ? after - before : 0;
  const better = change === 0 ? "" : change > 0 !== (props.lessIsBetter ?? false) ? "good" : "bad";
  return (
    <tr>
      <th scope="row">{props.name}</th>
      <td>{before === null ? "…" : props.show(before)}</td>
      <td data-figure={props.name}>{after === null ? "…" : props.show(after)}</td>
      <td class={better}>{before === null || after === null || change === 0 ? "" : `${change > 0 ? "▲ +" : "▼ −"}${props.show(Math.abs(change))}`}</td>
      <td class="bars">{before !== null && after !== null && <Bar before={before} after={after} most={props.most} />}</td>
    </tr>
  );
}

function States(props: { title: string; list: Difference[] }) {
  const data = need();
  if (props.list.length === 0) {
    return null;
  }
  const showWalk = (d: Difference): void => {
    const features = featuresOf(data.states, data.vocabulary, d.state);
    ask("walk", { tree: shownText.value, features })
      .then((replay) => {
        shownWalk.value = { replay, features };
      })
      .catch(sayError);
  };
  return (
    <details class="numbers">
      <summary>
        {props.title}: {number(props.list.length)}
      </summary>
      <ul>
        {props.list.slice(0, kMostListed).map((d) => (
          <li key={d.state}>
            {observationWords(featuresOf(data.states, data.vocabulary, d.state), data.vocabulary)}: {actionWords(d.before, data.vocabulary)} → {actionWords(d.after, data.vocabulary)} (policy:{" "}
            {actionWords(d.policy, data.vocabulary)}; {number(d.visits)} visits a walk){" "}
            {offer.value?.has_simulator && (
              <button type="button" onClick={() => showWalk(d)}>
                Show a walk
              </button>
            )}
          </li>
        ))}
      </ul>
      {props.list.length > kMostListed && <p class="quiet">and {number(props.list.length - kMostListed)} more, which the policy visits less</p>}
    </details>
  );
}

export const expanded = signal(true);

export function Scores() {
  const data = need();
  const tree = shown.value;
  if (!tree) {
    return null;
  }
  const text = shownText.value;
  const before = known.value.get(baseline.value);
  const after = known.value.get(text);
  const simBefore = simulations.value.get(baseline.value)?.promise.tree ?? null;
  const simAfter = simulations.value.get(text)?.promise.tree ?? null;
  const running = jobs.value.find((job) => job.kind === "simulate" && job.state === "running" && job.about?.tree === text);
  const most = (...values: (number | undefined | null)[]): number => Math.max(0, ...values.map((v) => v ?? 0));
  const lists = found.value;
  const shortfalls = simulations.value.get(text)?.shortfalls;
  const value = (v: number | undefined | null): number | null => v ?? null;
  return (
    <div class="detail scores" aria-label="Scores" role="group">
      <h3>
        Before and after <small>{after ? `(scored in ${scoredIn.value === null ? "–" : Math.round(scoredIn.value)} ms)` : "(scoring…)"}</small>
      </h3>
      <div class="scroll" tabIndex={0} role="region" aria-label="Scores before and after">
        <table>
          <thead>
            <tr>
              <td />
              <th scope="col">{baselineName.value}</th>
              <th scope="col">now</th>
              <th scope="col">change</th>
              <td />
            </tr>
          </thead>
          <tbody>
            <Line name="nodes" before={value(before?.size.nodes)} after={counts(tree).nodes} most={most(before?.size.nodes, tree.size)} show={number} lessIsBetter />
            <Line name="agreement along the chain" before={value(before?.figures.agreement)} after={value(after?.figures.agreement)} most={1} show={(v) => percent(v)} />
            <Line name="agreement over all states" before={value(before?.figures.coverage)} after={value(after?.figures.coverage)} most={1} show={(v) => percent(v)} />
            <Line
              name="reward along the chain"
              before={value(before?.figures.reward)}
              after={value(after?.figures.reward)}
              most={most(data.answer.policy.reward, before?.figures.reward, after?.figures.reward)}
              show={number}
            />
            {(simBefore || simAfter) && (
              <>
                <Line
                  name="reward in simulation"
                  before={value(simBefore?.reward.mean)}
                  after={value(simAfter?.reward.mean)}
                  most={most(data.answer.promise.policy?.reward.mean, simBefore?.reward.mean, simAfter?.reward.mean)}
                  show={(v) => v.toFixed(1)}
                />
                <Line name="agreement in simulation" before={value(simBefore?.agreement.mean)} after={value(simAfter?.agreement.mean)} most={1} show={(v) => percent(v)} />
                <Line
                  name="collisions in simulation"
                  before={value(simBefore?.total_collisions)}
                  after={value(simAfter?.total_collisions)}
                  most={most(simBefore?.total_collisions, simAfter?.total_collisions)}
                  show={number}
                  lessIsBetter
                />
              </>
            )}
          </tbody>
        </table>
      </div>
      {simAfter && (
        <p class="quiet">
          Simulated now: reward {plusMinus(simAfter.reward.mean, simAfter.reward.margin)}, agreement {plusMinus(100 * simAfter.agreement.mean, 100 * simAfter.agreement.margin)} %, {number(simAfter.episodes)} episodes; the policy earns{" "}
          {number(data.answer.promise.policy?.reward.mean ?? NaN)}.
        </p>
      )}
      {offer.value?.has_simulator && !simAfter && (
        <div class="toolbar">
          <button type="button" class="main" disabled={running !== undefined} onClick={() => simulate(text).catch(sayError)}>
            Simulate
          </button>
          {running && <progress max="1" value={running.share} aria-label="The simulator" />}
        </div>
      )}
      {shortfalls && shortfalls.length > 0 && (
        <div class="warning">
          <ul>
            {shortfalls.map((s) => (
              <li key={s}>{s}</li>
            ))}
          </ul>
        </div>
      )}
      {lists && text !== baseline.value && (
        <>
          <States title="states mended (now as the policy)" list={lists.mended} />
          <States title="states spoilt (no longer as the policy)" list={lists.spoilt} />
          <States title="states changed otherwise" list={lists.other} />
        </>
      )}
    </div>
  );
}
