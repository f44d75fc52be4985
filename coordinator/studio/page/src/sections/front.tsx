// Section 3: the trees that none other beats in every measure, any two measures against each other. Every point is a
// tree that can be opened, or put beside the one that is shown.
import { useSignal } from "@preact/signals";
import { scaleLinear } from "d3-scale";
import { differences, matching, meaningOf } from "../analysis";
import { Numbers, extent } from "../charts";
import type { Front, PageData, Run } from "../data";
import { number, percent } from "../format";
import { besideText, known, need, open, putBeside, shownMeaning, shownName, shownText } from "../state";
import { parseTree } from "../tree";

const kWidth = 560;
const kHeight = 320;
const kShares = new Set(["agreement", "coverage", "visits", "seen"]);

export const measureText = (name: string, value: number): string => (kShares.has(name) ? percent(value) : number(value));

// The last run that has a front.
export const frontRun = (data: PageData): (Run & { front: Front }) | null =>
  (data.runs.filter((run): run is Run & { front: Front } => run.front !== null).pop() ?? null);

export function FrontSection() {
  const data = need();
  const run = frontRun(data);
  const xName = useSignal("");
  const yName = useSignal("");
  const chosen = useSignal<number | null>(null);
  if (!run) {
    return (
      <section id="front" aria-labelledby="h-front">
        <h2 id="h-front">3. The front</h2>
        <p>
          No run of this study searched a front: each bred for one number. <code>coppice evolve {data.study.name} --config front.toml</code> keeps every tree that no other
          beats in all measures at once.
        </p>
        <Compare />
      </section>
    );
  }
  const { front } = run;
  const names = front.measures.map((m) => m.name);
  const pick = (wanted: string, fallback: string): number => Math.max(0, names.indexOf(names.includes(wanted) ? wanted : fallback));
  const xi = xName.value !== "" ? names.indexOf(xName.value) : pick("agreement", names[0] ?? "");
  const yi = yName.value !== "" ? names.indexOf(yName.value) : pick("return", names[1] ?? "");
  const xs = front.members.map((m) => m.values[xi] ?? 0);
  const ys = front.members.map((m) => m.values[yi] ?? 0);
  const x = scaleLinear(extent(xs), [58, kWidth - 14]);
  const y = scaleLinear(extent(ys), [kHeight - 40, 12]);
  const better = (m: { name: string; is_cost: boolean } | undefined): string => (m?.is_cost ? "less is better" : "more is better");
  const describe = (i: number): string => names.map((name, m) => `${name} ${measureText(name, front.members[i]?.values[m] ?? 0)}`).join(", ");
  const current = chosen.value === null ? null : front.members[chosen.value];
  const axisText = (name: string | undefined, tick: number): string => (name && kShares.has(name) ? percent(tick, 0) : number(tick));
  const key = (event: KeyboardEvent, i: number): void => {
    const order = xs.map((_, j) => j).sort((a, b) => (xs[a] ?? 0) - (xs[b] ?? 0) || (ys[a] ?? 0) - (ys[b] ?? 0));
    const at = order.indexOf(i);
    const next = event.key === "ArrowRight" || event.key === "ArrowUp" ? order[at + 1] : event.key === "ArrowLeft" || event.key === "ArrowDown" ? order[at - 1] : undefined;
    if (next !== undefined) {
      chosen.value = next;
      (event.currentTarget as Element).parentElement?.querySelector<SVGElement>(`[data-member="${next}"]`)?.focus();
      event.preventDefault();
    } else if (event.key === "Enter" || event.key === " ") {
      chosen.value = i;
      event.preventDefault();
    }
  };
  return (
    <section id="front" aria-labelledby="h-front">
      <h2 id="h-front">3. The front: {number(front.members.length)} trees that none other beats</h2>
      <p class="quiet">Run {run.run}. Every point is a tree; measures are those of the run's last comparison, walks of the chain.</p>
      <div class="toolbar">
        <label>
          across{" "}
          <select value={names[xi]} onChange={(e) => (xName.value = e.currentTarget.value)}>
            {names.map((name) => (
              <option key={name}>{name}</option>
            ))}
          </select>
        </label>
        <label>
          upwards{" "}
          <select value={names[yi]} onChange={(e) => (yName.value = e.currentTarget.value)}>
            {names.map((name) => (
              <option key={name}>{name}</option>
            ))}
          </select>
        </label>
      </div>
      <figure class="chart">
        <figcaption>
          {names[yi]} ({better(front.measures[yi])}) over {names[xi]} ({better(front.measures[xi])})
        </figcaption>
        <svg viewBox={`0 0 ${kWidth} ${kHeight}`} role="group" aria-label={`Scatter of ${front.members.length} trees: ${names[yi]} over ${names[xi]}. Arrow keys go from tree to tree, Enter opens.`}>
          <g class="axis" aria-hidden="true">
            {y.ticks(6).filter((tick) => names[yi] !== "nodes" || Number.isInteger(tick)).map((tick) => (
              <g key={tick}>
                <line x1={58} x2={kWidth - 14} y1={y(tick)} y2={y(tick)} />
                <text x={52} y={y(tick) + 4} text-anchor="end">
                  {axisText(names[yi], tick)}
                </text>
              </g>
            ))}
            {x.ticks(7).filter((tick) => names[xi] !== "nodes" || Number.isInteger(tick)).map((tick) => (
              <text key={tick} x={x(tick)} y={kHeight - 22} text-anchor="middle">
                {axisText(names[xi], tick)}
              </text>
            ))}
            <text x={kWidth / 2} y={kHeight - 5} text-anchor="middle">
              {names[xi]}
            </text>
          </g>
          {front.members.map((member, i) => (
            <circle
              key={i}
              class={`point${chosen.value === i ? " chosen" : ""}${member.tree === shownText.value ? " shown" : ""}${member.tree === besideText.value ? " beside" : ""}`}
              data-member={i}
              cx={x(xs[i] ?? 0)}
              cy={y(ys[i] ?? 0)}
              r={chosen.value === i || member.tree === shownText.value ? 7 : 4.5}
              role="button"
              tabindex={i === (chosen.value ?? 0) ? 0 : -1}
              aria-label={`Tree ${i}: ${describe(i)}`}
              onClick={() => (chosen.value = i)}
              onKeyDown={(event) => key(event, i)}
            >
              <title>{`Tree ${i}: ${describe(i)}`}</title>
            </circle>
          ))}
        </svg>
        <Numbers summary="all trees of the front" of="The front" heads={["tree", ...names]} rows={front.members.map((m, i) => [String(i), ...m.values.map((v, j) => measureText(names[j] ?? "", v))])} />
      </figure>
      {current && (
        <div class="detail" aria-live="polite">
          <h3>Tree {chosen.value} of the front</h3>
          <p>{describe(chosen.value ?? 0)}</p>
          <p>
            <code class="text">{current.tree}</code>
          </p>
          <div class="toolbar">
            <button type="button" onClick={() => open(current.tree, `tree ${chosen.value} of the front of run ${run.run}`)}>
              Open
            </button>
            <button type="button" onClick={() => putBeside(current.tree, `tree ${chosen.value} of the front of run ${run.run}`)}>
              Put beside
            </button>
          </div>
        </div>
      )}
      <Compare />
    </section>
  );
}

// The tree that is shown and the one beside it, in figures.
export function Compare() {
  const data = need();
  const mine = shownMeaning.value;
  const answer = data.answer.tree.text;
  const back = shownText.value !== answer && (
    <p>
      Shown is {shownName.value}.{" "}
      <button type="button" onClick={() => open(answer, data.answer.from)}>
        Back to the answer
      </button>{" "}
      {besideText.value !== answer && (
        <button type="button" onClick={() => putBeside(answer, "the answer")}>
          Put the answer beside
        </button>
      )}
    </p>
  );
  if (!mine || besideText.value === null) {
    return <>{back}</>;
  }
  const other = meaningOf(parseTree(besideText.value, data.vocabulary), data.states, data.vocabulary);
  const found = differences(other, mine, data.states);
  const row = (text: string): { nodes: string; reward: string } => {
    const part = known.value.get(text);
    return { nodes: number(parseTree(text, data.vocabulary).size), reward: part ? number(part.figures.reward) : "–" };
  };
  const a = row(shownText.value);
  const b = row(besideText.value);
  return (
    <div class="detail">
      {back}
      <h3>Side by side</h3>
      <table>
        <thead>
          <tr>
            <td />
            <th scope="col">shown</th>
            <th scope="col">beside</th>
          </tr>
        </thead>
        <tbody>
          <tr>
            <th scope="row">nodes</th>
            <td>{a.nodes}</td>
            <td>{b.nodes}</td>
          </tr>
          <tr>
            <th scope="row">states in which it does what the policy does{data.states.index.length < data.states.total ? ", of those held here" : ""}</th>
            <td>{percent(matching(mine, data.states) / data.states.index.length)}</td>
            <td>{percent(matching(other, data.states) / data.states.index.length)}</td>
          </tr>
          <tr>
            <th scope="row">reward along the chain</th>
            <td>{a.reward}</td>
            <td>{b.reward}</td>
          </tr>
        </tbody>
      </table>
      <p>
        They act differently in {number(found.mended.length + found.spoilt.length + found.other.length)} states: the shown tree is right in {number(found.mended.length)}, the other in{" "}
        {number(found.spoilt.length)}, neither in {number(found.other.length)}.
      </p>
    </div>
  );
}
