// A walk that shows one state, or what breaks a rule: the steps around it, in the room.
import { signal, useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import type { Replay } from "../data";
import { Room, sceneAt } from "../sections/world";
import { need } from "../state";
import { number } from "../format";
import { actionWords, observationWords } from "../words";

export const shownWalk = signal<{ replay: (Replay & { at: number }) | null; features: number[] } | null>(null);

export function WalkBox() {
  const data = need();
  const at = useSignal(0);
  const walk = shownWalk.value;
  useEffect(() => {
    at.value = walk?.replay?.at ?? 0;
  }, [walk]);
  if (!walk) {
    return null;
  }
  const { replay } = walk;
  const step = replay?.steps[Math.min(at.value, replay.steps.length - 1)];
  return (
    <div class="detail" role="group" aria-label="A walk that shows it">
      <h3>
        A walk that shows it{" "}
        <button type="button" onClick={() => { shownWalk.value = null; }}>
          Close
        </button>
      </h3>
      <p>Looked for: {observationWords(walk.features, data.vocabulary)}.</p>
      {!replay || !data.world || !step ? (
        <p>No simulated episode of this tree comes there.</p>
      ) : (
        <div class="replay">
          <Room world={data.world} scene={sceneAt(replay, at.value)} trail={[replay.cell, ...replay.steps.slice(0, at.value).map((s) => s[1])]} label="The room on the way there" />
          <div>
            <div class="toolbar">
              <button type="button" disabled={at.value === 0} onClick={() => { at.value -= 1; }}>
                Back
              </button>
              <button type="button" disabled={at.value + 1 >= replay.steps.length} onClick={() => { at.value += 1; }}>
                Forward
              </button>
            </div>
            <p>
              Episode {replay.episode}, step {replay.first_step + at.value}
              {at.value === replay.at ? " — here" : ""}: it sees {observationWords(step[6], data.vocabulary)} and chooses {actionWords(step[0], data.vocabulary)}
              {step[4] ? " — and collides" : ""} ({number(step[3])}).
            </p>
          </div>
        </div>
      )}
    </div>
  );
}
