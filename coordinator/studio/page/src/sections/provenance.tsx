// Section 7: from what all this was computed, and the commands that compute it again.
import { need } from "../state";
import { number } from "../format";

const text = (value: unknown): string => (typeof value === "string" ? value : JSON.stringify(value));

function Pairs(props: { object: Record<string, unknown>; leaveOut?: string[] }) {
  return (
    <dl class="pairs">
      {Object.entries(props.object)
        .filter(([key]) => !props.leaveOut?.includes(key))
        .map(([key, value]) => (
          <div key={key}>
            <dt>{key}</dt>
            <dd>{text(value)}</dd>
          </div>
        ))}
    </dl>
  );
}

export function Provenance() {
  const data = need();
  const { provenance, study } = data;
  return (
    <section id="provenance" aria-labelledby="h-provenance">
      <h2 id="h-provenance">7. Where the numbers are from</h2>
      <dl class="pairs">
        <div>
          <dt>study</dt>
          <dd>{study.path}</dd>
        </div>
        <div>
          <dt>problem</dt>
          <dd>{[study.title, study.source].filter((t) => t !== "").join("; ") || study.world}</dd>
        </div>
        <div>
          <dt>chain</dt>
          <dd>
            {study.chain_hash} (XXH3-128): {number(study.states)} states, {number(study.transitions)} transitions; world: {study.world}
          </dd>
        </div>
        <div>
          <dt>program</dt>
          <dd>coppice {provenance.version}</dd>
        </div>
        <div>
          <dt>machine</dt>
          <dd>{provenance.machine}</dd>
        </div>
        <div>
          <dt>simulator</dt>
          <dd>
            {number(provenance.episodes)} episodes of {number(study.steps)} steps, seed {provenance.seed}; {number(provenance.resamples)} draws behind intervals of the chain
          </dd>
        </div>
        {data.states.index.length < data.states.total && (
          <div>
            <dt>states</dt>
            <dd>
              {number(data.states.index.length)} of {number(data.states.total)} are in this page: those most visited by tree, policy and learning. They hold{" "}
              {(100 * data.states.tree_share).toFixed(1)} % of the tree's steps and {(100 * data.states.policy_share).toFixed(1)} % of the policy's. Figures of the chain are over all.
            </dd>
          </div>
        )}
      </dl>
      <h3>Again</h3>
      <p class="quiet">The same commands give the same numbers, on every machine of this kind.</p>
      <dl class="commands">
        {provenance.commands.map((c) => (
          <div key={c.what}>
            <dt>{c.what}</dt>
            <dd>
              <code class="text">{c.command}</code>
            </dd>
          </div>
        ))}
      </dl>
      {data.learning.settings && (
        <details class="numbers">
          <summary>how the policy was learned</summary>
          <Pairs object={data.learning.settings} />
          {data.learning.outcome && <Pairs object={data.learning.outcome} leaveOut={["curve"]} />}
        </details>
      )}
      {data.runs.map((run) => (
        <details class="numbers" key={run.run}>
          <summary>
            run {run.run}: {run.status}, seed {run.seed}, {run.evaluator}, started {run.started}
          </summary>
          <Pairs object={{ configuration: run.configuration, result: run.result, tree: run.tree, pruned: run.pruned }} />
        </details>
      ))}
    </section>
  );
}
