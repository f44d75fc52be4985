// Section 5: the world replayed, step by step, with the way through the tree lit; for studies without a room, a walk
// through the chain as a table.
import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import type { Replay, World } from "../data";
import { number } from "../format";
import { lit, need, shown } from "../state";
import { tick } from "../tree";
import { TreeDrawing } from "../tree_drawing";
import { actionWords, observationWords, readingWords } from "../words";
import { wallPath } from "./curves";

const kPlayEvery = 350; // ms a step

interface Scene {
  cell: number;
  heading: number;
  trash: ReadonlySet<number>;
  reward: number;
}

// Where everything is before step `at`.
export function sceneAt(replay: Replay, at: number): Scene {
  const trash = new Set(replay.trash);
  let { cell, heading } = replay;
  let reward = 0;
  for (const step of replay.steps.slice(0, at)) {
    cell = step[1];
    heading = step[2];
    reward += step[3];
    if (step[5] >= 0) {
      trash.delete(cell);
      trash.add(step[5]);
    }
  }
  return { cell, heading, trash, reward };
}

export function Room(props: { world: World; scene: Scene; trail: number[]; label: string }) {
  const { world, scene } = props;
  const x = scene.cell % world.width;
  const y = Math.floor(scene.cell / world.width);
  const center = (cell: number): string => `${(cell % world.width) + 0.5},${Math.floor(cell / world.width) + 0.5}`;
  return (
    <svg class="room" viewBox={`0 0 ${world.width} ${world.height}`} role="img" aria-label={props.label}>
      <rect class="floor" width={world.width} height={world.height} />
      <path class="wall" d={wallPath(world)} />
      {world.goal !== null && <rect class="goal" x={world.goal % world.width} y={Math.floor(world.goal / world.width)} width="1" height="1" />}
      {props.trail.length > 1 && <polyline class="trail" points={props.trail.map(center).join(" ")} />}
      {[...scene.trash].map((cell) => (
        <path key={cell} class="trash" transform={`translate(${cell % world.width} ${Math.floor(cell / world.width)})`} d="M.5,.12L.88,.5L.5,.88L.12,.5z" />
      ))}
      {world.has_heading ? (
        <path class="agent" transform={`translate(${x + 0.5} ${y + 0.5}) rotate(${scene.heading * 90})`} d="M0,-.46L.38,.4L0,.22L-.38,.4z" />
      ) : (
        <circle class="agent" cx={x + 0.5} cy={y + 0.5} r="0.38" />
      )}
    </svg>
  );
}

export function WorldSection() {
  const data = need();
  return (
    <section id="world" aria-labelledby="h-world">
      <h2 id="h-world">5. {data.world ? "The world replayed" : "A walk through the chain"}</h2>
      {data.world ? <Replays world={data.world} /> : <Walks />}
    </section>
  );
}

function Replays(props: { world: World }) {
  const { world } = props;
  const data = need();
  const which = useSignal(0);
  const at = useSignal(0);
  const playing = useSignal(false);
  const replay = world.replays[which.value] ?? world.replays[0];
  const tree = shown.value;
  const steps = replay?.steps.length ?? 0;
  const step = replay?.steps[Math.min(at.value, steps - 1)];

  useEffect(() => {
    if (!playing.value) {
      return undefined;
    }
    const timer = setInterval(() => {
      if (at.value + 1 >= steps) {
        playing.value = false;
      } else {
        at.value += 1;
      }
    }, kPlayEvery);
    return () => clearInterval(timer);
  }, [playing.value, steps]);

  // The way through the shown tree for what is seen now.
  const ticked = step && tree ? tick(tree, (f) => step[6][f] ?? 0) : null;
  const used = useSignal(false);
  useEffect(() => {
    if (used.value) {
      lit.value = ticked?.path ?? null;
    }
  }, [ticked, used.value]);

  if (!replay || !step) {
    return null;
  }
  const go = (to: number): void => {
    used.value = true;
    at.value = Math.max(0, Math.min(steps - 1, to));
  };
  const choose = (i: number): void => {
    used.value = true;
    playing.value = false;
    which.value = i;
    at.value = 0;
  };
  const scene = sceneAt(replay, at.value);
  const trail = [replay.cell, ...replay.steps.slice(0, at.value).map((s) => s[1])].slice(-40);
  const treeAction = ticked?.action ?? -1;
  return (
    <>
      <p class="quiet">
        Whole episodes, and motions found in the simulated episodes: what the thesis shows of its UAV. The way through the tree is lit: a full frame succeeded, a dashed one failed, the rest was not asked.
      </p>
      <div class="toolbar" role="group" aria-label="Which replay">
        {world.replays.map((r, i) => (
          <button type="button" key={i} aria-pressed={which.value === i} onClick={() => choose(i)}>
            {r.who === "tree" ? "answer" : "policy"}: {r.title}
          </button>
        ))}
      </div>
      <div class="replay">
        <figure class="chart">
          <figcaption>
            {replay.who === "tree" ? "The answer" : "The policy"}: {replay.title}, episode {replay.episode}, step {replay.first_step + at.value}
          </figcaption>
          <Room world={world} scene={scene} trail={trail} label={`The room before step ${replay.first_step + at.value}: ${observationWords(step[6], data.vocabulary)}`} />
        </figure>
        <div>
          <div class="toolbar" role="group" aria-label="Steps">
            <button type="button" onClick={() => go(0)} disabled={at.value === 0}>
              First
            </button>
            <button type="button" onClick={() => go(at.value - 1)} disabled={at.value === 0}>
              Back
            </button>
            <button type="button" onClick={() => { used.value = true; playing.value = !playing.value; }} aria-pressed={playing.value}>
              {playing.value ? "Pause" : "Play"}
            </button>
            <button type="button" onClick={() => go(at.value + 1)} disabled={at.value + 1 >= steps}>
              Forward
            </button>
            <input type="range" min="0" max={steps - 1} value={at.value} aria-label="Step" onInput={(e) => go(Number(e.currentTarget.value))} />
          </div>
          <dl class="facts">
            <dt>it sees</dt>
            <dd>{observationWords(step[6], data.vocabulary)}</dd>
            <dt>{replay.who === "tree" ? "the answer does" : "the policy does"}</dt>
            <dd>
              {actionWords(step[0], data.vocabulary)}
              {step[4] ? " — and collides" : step[5] >= 0 ? " — and collects trash" : ""} ({step[3] > 0 ? "+" : ""}
              {number(step[3])})
            </dd>
            <dt>the shown tree would</dt>
            <dd>
              {actionWords(treeAction, data.vocabulary)}
              {ticked?.writer !== null && ticked ? `, by node ${ticked.writer}` : ""}
              {treeAction !== step[0] ? <b> ≠</b> : ""}
            </dd>
            <dt>earned since here began</dt>
            <dd>{number(scene.reward)}</dd>
          </dl>
          <p class="quiet">▲ the agent, ◆ trash, filled: wall.</p>
        </div>
      </div>
      {tree && (
        <div class="drawing" tabIndex={0} role="region" aria-label="The way through the tree">
          <TreeDrawing
            tree={tree}
            vocabulary={data.vocabulary}
            title="The way through the tree in this step"
            view={null}
            selected={null}
            onSelect={() => undefined}
            lit={ticked?.path ?? null}
            scale={0.85}
          />
        </div>
      )}
    </>
  );
}

function Walks() {
  const data = need();
  const which = useSignal(0);
  const used = useSignal<number | null>(null);
  const walk = data.walks[which.value];
  if (!walk) {
    return <p class="quiet">No walk was made.</p>;
  }
  const show = (row: number): void => {
    used.value = row;
    const step = walk.steps[row];
    const tree = shown.value;
    lit.value = step && tree ? tick(tree, (f) => step[4][f] ?? 0).path : null;
  };
  return (
    <>
      <p class="quiet">This study has no room to show. A walk from the initial state, drawn with seed {walk.seed}; point at a row to see its way through the tree.</p>
      <div class="toolbar">
        {data.walks.map((w, i) => (
          <button type="button" key={i} aria-pressed={which.value === i} onClick={() => { which.value = i; used.value = null; }}>
            {w.who === "tree" ? "the answer's walk" : "the policy's walk"}
          </button>
        ))}
      </div>
      <div class="scroll tall" tabIndex={0} role="region" aria-label="Steps of the walk">
        <table>
          <thead>
            <tr>
              <th scope="col">step</th>
              {data.vocabulary.features.map((f) => (
                <th scope="col" key={f.name}>
                  {f.label ?? f.name}
                </th>
              ))}
              <th scope="col">action</th>
              <th scope="col">policy</th>
              <th scope="col">mean reward</th>
            </tr>
          </thead>
          <tbody>
            {walk.steps.map((step, i) => (
              <tr key={i} class={`${used.value === i ? "selected" : ""}${step[0] !== step[3] ? " differs" : ""}`}>
                <td>
                  <button type="button" onClick={() => show(i)} aria-pressed={used.value === i}>
                    {i}
                  </button>
                </td>
                {step[4].map((value, f) => (
                  <td key={f}>{readingWords(data.vocabulary.features[f], value)}</td>
                ))}
                <td>{actionWords(step[0], data.vocabulary)}</td>
                <td>{step[0] === step[3] ? "the same" : actionWords(step[3], data.vocabulary)}</td>
                <td>{number(step[2])}</td>
              </tr>
            ))}
          </tbody>
        </table>
      </div>
    </>
  );
}
