// Whole-tree actions, trees that are kept, exports, and what is being computed.
import { useSignal } from "@preact/signals";
import { number, percent } from "../format";
import { need, putBeside, shownName, shownText } from "../state";
import { ask } from "./api";
import { applyText, baselineName, connected, edit, jobs, kept, message, offer, poll, say, sayError, suggestions } from "./session";
import { parseTree } from "../tree";

function download(name: string, text: string): void {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([text], { type: "text/plain" }));
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}

export function Messages() {
  const current = message.value;
  return (
    <div role="status" class="messages">
      {!connected.value && <p class="warning">The studio does not answer. What you edit stays here; keep it when the studio is back.</p>}
      {current && <p class={current.bad ? "warning" : "quiet"}>{current.text}</p>}
    </div>
  );
}

export function WholeTree() {
  const data = need();
  const format = useSignal("text");
  const settings = useSignal("");
  const prune = (states: boolean): void => {
    ask("prune", { tree: shownText.value, states })
      .then((answer) => {
        if (answer.removals.length === 0) {
          say("There is nothing to prune.");
          return;
        }
        applyText(answer.tree, states ? "prune on the chain's states" : "prune");
        say(`Pruned: ${answer.removals.map((r) => `${r.what} (${r.reason})`).join("; ")}.`);
      })
      .catch(sayError);
  };
  const guard = (): void => {
    ask("guard", { tree: shownText.value })
      .then((answer) => {
        applyText(answer.tree, "guarded form");
        say(`The guarded form has ${number(answer.nodes)} nodes: every sequence asks before it acts, and it means the same in every state.`);
      })
      .catch(sayError);
  };
  const suggest = (): void => {
    const tree = shownText.value;
    say("Looking for branches…");
    ask("explain", { tree })
      .then((found) => {
        suggestions.value = { tree, found };
        say(`${number(found.branches.length)} branches are suggested in section 6.`);
      })
      .catch(sayError);
  };
  const breed = (): void => {
    const words = settings.value.trim();
    ask("breed", { tree: shownText.value, settings: { set: words === "" ? [] : words.split(/\s+/) } })
      .then(() => poll())
      .catch(sayError);
  };
  const write = (): void => {
    ask("write", { tree: shownText.value, format: format.value })
      .then((answer) => {
        download(answer.name, answer.text);
        say(`Written: ${answer.name}.`);
      })
      .catch(sayError);
  };
  return (
    <div class="toolbar" role="toolbar" aria-label="The whole tree">
      <button type="button" onClick={suggest}>
        Suggest branches
      </button>
      <button type="button" onClick={() => prune(false)}>
        Prune
      </button>
      <button type="button" onClick={() => prune(true)} title="also what holds only in the states that learning met">
        Prune on the chain
      </button>
      <button type="button" onClick={guard}>
        Guarded form
      </button>
      <button type="button" onClick={() => edit(data.answer.tree.text, "the answer")}>
        Back to the answer
      </button>
      <label>
        Export{" "}
        <select value={format.value} onChange={(e) => { format.value = e.currentTarget.value; }}>
          {offer.value?.exports.map((e) => (
            <option key={e.format} value={e.format}>
              {e.format}: {e.what}
            </option>
          ))}
        </select>
      </label>
      <button type="button" onClick={write}>
        Export
      </button>
      {offer.value?.can_breed && (
        <>
          <button type="button" onClick={breed}>
            Breed from here
          </button>
          <label>
            with{" "}
            <input type="text" size={28} value={settings.value} placeholder="ga.generations=200 seed=2" onInput={(e) => { settings.value = e.currentTarget.value; }} spellcheck={false} />
          </label>
        </>
      )}
    </div>
  );
}

interface BreedDetail {
  generation?: number;
  generations?: number;
  best_fitness?: number;
  mean_fitness?: number;
  best_nodes?: number;
  best_tree?: string;
  workers?: { name: string; doing: string }[];
}

export function Jobs() {
  const shown = jobs.value.filter((job) => job.kind !== "page");
  if (shown.length === 0) {
    return null;
  }
  return (
    <div class="detail" role="group" aria-label="Computations">
      <h3>Computations</h3>
      <ul class="jobs">
        {[...shown].reverse().slice(0, 6).map((job) => {
          const detail = (job.detail ?? {}) as BreedDetail;
          const result = job.about;
          return (
            <li key={job.job}>
              {job.kind === "breed" ? "breed from here" : job.kind} {job.job}: <b>{job.state}</b>{" "}
              {job.state === "running" && (
                <>
                  <progress max="1" value={job.share} aria-label={`${job.kind} ${job.job}`} /> {percent(job.share, 0)}{" "}
                  <button type="button" onClick={() => { ask("stop", { job: job.job }).then(() => poll()).catch(sayError); }}>
                    Stop
                  </button>
                </>
              )}{" "}
              {job.text} {job.error !== "" && <span class="bad">{job.error}</span>}
              {detail.best_tree !== undefined && (
                <>
                  {" "}
                  generation {number(detail.generation ?? 0)}, best fitness {number(detail.best_fitness ?? NaN)}, mean {number(detail.mean_fitness ?? NaN)}, {number(detail.best_nodes ?? 0)} nodes{" "}
                  <button type="button" onClick={() => edit(detail.best_tree ?? "", `the best of computation ${job.job}`)}>
                    Open the best so far
                  </button>{" "}
                  {result?.tree !== undefined && (
                    <button type="button" onClick={() => putBeside(detail.best_tree ?? null, `the best of computation ${job.job}`)}>
                      Put it beside
                    </button>
                  )}
                </>
              )}
              {detail.workers && detail.workers.length > 0 && (
                <ul>
                  {detail.workers.map((worker) => (
                    <li key={worker.name}>
                      {worker.name}: {worker.doing}
                    </li>
                  ))}
                </ul>
              )}
            </li>
          );
        })}
      </ul>
    </div>
  );
}

export function KeptTrees() {
  const data = need();
  const name = useSignal("");
  const note = useSignal("");
  const keep = (): void => {
    ask("keep", { tree: shownText.value, name: name.value.trim(), note: note.value.trim() })
      .then(() => {
        say(`'${name.value.trim()}' is kept in ${data.study.name}.`);
        name.value = "";
        note.value = "";
        return poll();
      })
      .catch(sayError);
  };
  const trees = kept.value;
  return (
    <div class="detail" role="group" aria-label="Kept trees">
      <h3>Kept in the study</h3>
      <form
        class="toolbar"
        onSubmit={(event) => {
          event.preventDefault();
          keep();
        }}
      >
        <label>
          Name <input type="text" value={name.value} onInput={(e) => { name.value = e.currentTarget.value; }} />
        </label>
        <label>
          Note <input type="text" size={40} value={note.value} onInput={(e) => { note.value = e.currentTarget.value; }} />
        </label>
        <button type="submit" class="main" disabled={name.value.trim() === ""}>
          Keep this tree
        </button>
      </form>
      {trees.length > 0 && (
        <div class="scroll" tabIndex={0} role="region" aria-label="Trees that are kept">
          <table>
            <thead>
              <tr>
                <th scope="col">name</th>
                <th scope="col">note</th>
                <th scope="col">nodes</th>
                <th scope="col">kept</th>
                <td />
              </tr>
            </thead>
            <tbody>
              {trees.map((tree) => (
                <tr key={tree.id}>
                  <th scope="row">{tree.name}</th>
                  <td>{tree.note}</td>
                  <td>{parseTree(tree.tree, data.vocabulary).size}</td>
                  <td>{tree.kept}</td>
                  <td>
                    <button type="button" onClick={() => edit(tree.tree, tree.name)} aria-label={`Open ${tree.name}`}>
                      Open
                    </button>{" "}
                    <button type="button" onClick={() => putBeside(tree.tree, tree.name)} aria-label={`Put ${tree.name} beside`}>
                      Beside
                    </button>{" "}
                    <button
                      type="button"
                      aria-label={`Forget ${tree.name}`}
                      onClick={() => {
                        ask("forget", { id: tree.id })
                          .then(() => {
                            say(`'${tree.name}' is no longer kept: ${tree.tree}`);
                            return poll();
                          })
                          .catch(sayError);
                      }}
                    >
                      Forget
                    </button>
                  </td>
                </tr>
              ))}
            </tbody>
          </table>
        </div>
      )}
      <p class="quiet">
        Edited is {shownName.value}, compared with {baselineName.value}.
      </p>
    </div>
  );
}

