// The page: with data inside a report; without, the studio.
import { render } from "preact";
import { readData } from "./data";
import { Answer } from "./sections/answer";
import { Curves } from "./sections/curves";
import { FrontSection } from "./sections/front";
import { Provenance } from "./sections/provenance";
import { TreeSection } from "./sections/tree_section";
import { Trust } from "./sections/trust";
import { WorldSection } from "./sections/world";
import { live, load, need } from "./state";
import { start as startStudio } from "./studio/session";

const kSections: [string, string][] = [
  ["answer", "Answer"],
  ["tree", "Tree"],
  ["front", "Front"],
  ["curves", "Learning"],
  ["world", "World"],
  ["trust", "Differences"],
  ["provenance", "Provenance"],
];

function Page() {
  const data = need();
  return (
    <>
      <header>
        <a class="skip" href="#answer">
          To the answer
        </a>
        <h1>
          Coppice{live.value ? " studio" : ""} <small>{data.study.name}</small>
        </h1>
        <nav aria-label="Sections">
          {kSections.map(([id, name]) => (
            <a key={id} href={`#${id}`}>
              {name}
            </a>
          ))}
        </nav>
      </header>
      <main>
        <Answer />
        <TreeSection />
        <FrontSection />
        <Curves />
        <WorldSection />
        <Trust />
        <Provenance />
      </main>
    </>
  );
}

function ready(root: HTMLElement): void {
  document.title = `Coppice${live.value ? " studio" : ""}: ${need().study.name}`;
  render(<Page />, root);
  document.documentElement.dataset["ready"] = "yes";
}

function fail(root: HTMLElement, error: unknown): void {
  render(<p role="alert">{error instanceof Error ? error.message : String(error)}</p>, root);
  document.documentElement.dataset["ready"] = "no";
}

async function start(root: HTMLElement): Promise<void> {
  const inside = document.getElementById("coppice-data");
  if (inside) {
    load(readData(inside.textContent ?? ""), false);
  } else {
    const waiting = (share: number): void =>
      render(
        <p>
          Computing the page… <progress max="1" value={share} aria-label="Computing the page" />
        </p>,
        root,
      );
    waiting(0);
    await startStudio(waiting);
  }
  ready(root);
}

const root = document.getElementById("page");
if (root) {
  root.replaceChildren();
  start(root).catch((error: unknown) => fail(root, error));
}
