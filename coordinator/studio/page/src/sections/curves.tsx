// Section 4: how the policy was learned, how trees got better over the generations, and where tree and policy go.
import { useSignal } from "@preact/signals";
import { Lines, Numbers, type Series } from "../charts";
import type { DemeCurves, Generations, World } from "../data";
import { counted, number } from "../format";
import { need } from "../state";

const xOf = (generations: Generations, by: string): number[] => (by === "evaluations" ? generations.evaluations : generations.generation);

export function Curves() {
  const data = need();
  const withRows = data.runs.filter((run) => run.generations.generation.length > 0);
  const chosen = useSignal<number | null>(null);
  const by = useSignal("generation");
  const run = withRows.find((r) => r.run === chosen.value) ?? withRows[withRows.length - 1];
  const curve = data.learning.outcome?.curve;
  const x = run ? xOf(run.generations, by.value) : [];
  return (
    <section id="curves" aria-labelledby="h-curves">
      <h2 id="h-curves">4. Learning and evolution</h2>
      {curve ? (
        <div class="charts">
          <Lines
            title="Learning: reward of an episode, exploration included"
            xName="episode"
            yName="reward"
            series={[{ name: `mean of ${counted(curve.episodes_per_point, "episode")}`, x: curve.reward.map((_, i) => (i + 1) * curve.episodes_per_point), y: curve.reward, style: "a" }]}
          />
          <Lines
            title="Learning: collisions of an episode"
            xName="episode"
            yName="collisions"
            zero
            series={[{ name: `mean of ${counted(curve.episodes_per_point, "episode")}`, x: curve.collisions.map((_, i) => (i + 1) * curve.episodes_per_point), y: curve.collisions, style: "b" }]}
          />
        </div>
      ) : (
        <p class="quiet">The study keeps no curve of learning: its policy was imported, made up, or learned before curves were kept.</p>
      )}
      {run ? (
        <>
          <div class="toolbar">
            <label>
              run{" "}
              <select value={run.run} onChange={(e) => (chosen.value = Number(e.currentTarget.value))}>
                {withRows.map((r) => (
                  <option key={r.run} value={r.run}>
                    {r.run} ({r.status}, seed {r.seed})
                  </option>
                ))}
              </select>
            </label>
            <label>
              over{" "}
              <select value={by.value} onChange={(e) => (by.value = e.currentTarget.value)}>
                <option value="generation">generations</option>
                <option value="evaluations">evaluations</option>
              </select>
            </label>
          </div>
          {run.generations.every > 1 && (
            <p class="quiet">
              Shown is every {number(run.generations.every)}th of {number(run.generations.total)} generations.
            </p>
          )}
          <div class="charts">
            <Lines
              title="Evolution: fitness"
              xName={by.value}
              yName="fitness"
              series={[
                { name: "best", x, y: run.generations.best_fitness, style: "a" },
                { name: "mean", x, y: run.generations.mean_fitness, style: "b" },
              ]}
              bands={[{ x, low: run.generations.mean_fitness, high: run.generations.best_fitness, style: "a" }]}
            />
            <Lines
              title="Evolution: size"
              xName={by.value}
              yName="nodes"
              zero
              series={[
                { name: "of the best", x, y: run.generations.best_nodes, style: "a" },
                { name: "mean", x, y: run.generations.mean_nodes, style: "b" },
              ]}
            />
            <Lines
              title="Evolution: agreement along the walks"
              xName={by.value}
              yName="agreement"
              series={[
                { name: "of the best", x, y: run.generations.best_agreement, style: "a" },
                { name: "mean", x, y: run.generations.mean_agreement, style: "b" },
              ]}
            />
            <Lines
              title="Evolution: different trees in a generation"
              xName={by.value}
              yName="trees"
              zero
              series={[{ name: "different trees", x, y: run.generations.distinct_trees, style: "c" }]}
            />
          </div>
          {run.demes && <Demes key={run.run} curves={run.demes} by={by.value} />}
        </>
      ) : (
        <p class="quiet">No run of evolution kept a generation.</p>
      )}
      {data.world && <Maps world={data.world} />}
    </section>
  );
}

// One deme's curves before those of all the others.
function Demes(props: { curves: DemeCurves; by: string }) {
  const { generation, demes, every, total } = props.curves;
  const leading = demes.reduce((best, deme, i) => ((deme.best_fitness.at(-1) ?? -Infinity) > (demes[best]?.best_fitness.at(-1) ?? -Infinity) ? i : best), 0);
  const chosen = useSignal(leading);
  const shown = demes[chosen.value];
  if (!shown) {
    return null;
  }
  const xOfDeme = (deme: DemeCurves["demes"][number]): number[] => (props.by === "evaluations" ? deme.evaluations : generation);
  const x = xOfDeme(shown);
  const others = (of: "best_fitness" | "best_nodes"): Series[] =>
    demes.flatMap((deme, i) => (i === chosen.value ? [] : [{ name: `deme ${i + 1}, best`, x: xOfDeme(deme), y: deme[of], style: "faint" as const, inLegend: false }]));
  return (
    <>
      <h3>Each deme</h3>
      <div class="toolbar">
        <label>
          deme{" "}
          <select aria-label="deme" value={chosen.value} onChange={(e) => (chosen.value = Number(e.currentTarget.value))}>
            {demes.map((_, i) => (
              <option key={i} value={i}>
                {i + 1} of {demes.length}
                {i === leading ? ", which leads in the end" : ""}
              </option>
            ))}
          </select>
        </label>{" "}
        <span class="quiet">Thin lines are the best of the other demes.{every > 1 && ` Shown is every ${number(every)}th of ${number(total)} generations.`}</span>
      </div>
      <div class="charts">
        <Lines
          title={`Deme ${chosen.value + 1}: fitness`}
          xName={props.by}
          yName="fitness"
          series={[
            ...others("best_fitness"),
            { name: "best", x, y: shown.best_fitness, style: "a" },
            { name: "mean", x, y: shown.mean_fitness, style: "b" },
          ]}
        />
        <Lines
          title={`Deme ${chosen.value + 1}: size`}
          xName={props.by}
          yName="nodes"
          zero
          series={[
            ...others("best_nodes"),
            { name: "of the best", x, y: shown.best_nodes, style: "a" },
            { name: "mean", x, y: shown.mean_nodes, style: "b" },
          ]}
        />
      </div>
    </>
  );
}

function Maps(props: { world: World }) {
  const { world } = props;
  const most = Math.max(1, ...world.maps.tree, ...world.maps.policy);
  return (
    <>
      <h3>Where they go</h3>
      <p class="quiet">
        Steps that ended in each cell, {counted(world.maps.episodes, "episode")} of {number(world.maps.steps)} steps. A stronger colour is more, by the square root; the most is {number(most)}.
      </p>
      <div class="charts">
        <Map world={world} visits={world.maps.policy} most={most} name="the policy" />
        <Map world={world} visits={world.maps.tree} most={most} name="the tree" />
      </div>
    </>
  );
}

export const wallPath = (world: World): string => {
  let path = "";
  for (let cell = 0; cell < world.cells.length; ++cell) {
    if (world.cells[cell] === "#") {
      path += `M${cell % world.width},${Math.floor(cell / world.width)}h1v1h-1z`;
    }
  }
  return path;
};

// Cells of one shade are one path: a large room stays a small document.
const kShades = 12;

function Map(props: { world: World; visits: number[]; most: number; name: string }) {
  const { world, visits, most } = props;
  const paths = new Array<string>(kShades + 1).fill("");
  let visited = 0;
  let floor = 0;
  for (let cell = 0; cell < visits.length; ++cell) {
    const count = visits[cell] ?? 0;
    floor += world.cells[cell] === "#" ? 0 : 1;
    if (count > 0) {
      ++visited;
      const shade = Math.max(1, Math.round(kShades * Math.sqrt(count / most)));
      paths[shade] += `M${cell % world.width},${Math.floor(cell / world.width)}h1v1h-1z`;
    }
  }
  const busiest = visits
    .map((count, cell) => ({ count, cell }))
    .sort((a, b) => b.count - a.count)
    .slice(0, 20);
  return (
    <figure class="chart">
      <figcaption>
        Visits by {props.name}: {number(visited)} of {number(floor)} cells
      </figcaption>
      <svg class="room" viewBox={`0 0 ${world.width} ${world.height}`} role="img" aria-label={`Map of visits by ${props.name}: ${visited} of ${floor} cells visited`}>
        <rect class="floor" width={world.width} height={world.height} />
        {paths.map((d, shade) => d !== "" && <path key={shade} class="visits" d={d} fill-opacity={shade / kShades} />)}
        <path class="wall" d={wallPath(world)} />
        {world.goal !== null && <rect class="goal" x={world.goal % world.width} y={Math.floor(world.goal / world.width)} width="1" height="1" />}
      </svg>
      <Numbers
        summary="the busiest cells"
        of={`Visits by ${props.name}`}
        heads={["column", "row", "visits"]}
        rows={busiest.filter((b) => b.count > 0).map((b) => [String(b.cell % world.width), String(Math.floor(b.cell / world.width)), b.count])}
      />
    </figure>
  );
}
