"""The simulator that `coppice score --simulator` talks to: a program that reads and writes JSON lines
(coordinator/learning/simulator.md has the protocol). serve() runs it on any Gymnasium environment."""

from __future__ import annotations

import json
import os
import sys
import traceback
from collections.abc import Callable, Sequence
from typing import Any, TextIO

from coppice.errors import CoppiceError
from coppice.spaces import Problem, problem_of

PROTOCOL = 1
EPISODES = 64  # at once, unless told otherwise
MAX_EPISODES = 4096

Collides = Callable[[Any, int, float, Any], bool]


def serve(
    make: Callable[[], Any],
    *,
    episodes: int = EPISODES,
    features: Sequence[str] | None = None,
    actions: Sequence[str] | None = None,
    collides: Collides | None = None,
    timeout: float | None = None,
    source: TextIO | None = None,
    out: TextIO | None = None,
) -> None:
    """Answers until its input ends. make: a new environment, called once for each place that is used.

    collides: (observation, the action's number, reward, next observation) -> whether the step was a collision.
    timeout: seconds that one answer may take, told to coppice.
    source, out: standard input and output. Whatever the environment prints goes to standard error, so that it cannot
    break a line.
    """
    if not 1 <= episodes <= MAX_EPISODES:
        raise CoppiceError(f"episodes is {episodes}: expected 1 to {MAX_EPISODES}")
    source = source if source is not None else sys.stdin
    out = out if out is not None else _take_standard_output()
    server = _Server(make, make(), episodes, features, actions, collides)
    hello: dict[str, Any] = {
        "coppice_simulator": PROTOCOL,
        "features": server.problem.feature_names,
        "actions": server.problem.actions,
        "episodes": episodes,
        "collisions": collides is not None,
    }
    if timeout is not None:
        hello["timeout"] = timeout
    _write(out, hello)
    for line in source:
        _write(out, server.answer(line))


def _take_standard_output() -> TextIO:
    """Standard output for the protocol alone: descriptor 1 becomes standard error for everybody else."""
    protocol = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)
    sys.stdout = sys.stderr
    return protocol


def _write(out: TextIO, answer: dict[str, Any]) -> None:
    try:
        line = json.dumps(answer, allow_nan=False)
    except ValueError:
        line = json.dumps({"id": answer.get("id"), "error": f"an observation or reward is not finite: {answer}"[:1000]})
    out.write(line + "\n")
    out.flush()


class _Server:
    def __init__(
        self,
        make: Callable[[], Any],
        first: Any,
        episodes: int,
        features: Sequence[str] | None,
        actions: Sequence[str] | None,
        collides: Collides | None,
    ) -> None:
        self._make = make
        self._places: list[Any] = [first] + [None] * (episodes - 1)
        self._observed: list[Any] = [None] * episodes
        self._collides = collides
        self.problem: Problem = problem_of(first, features, actions)

    def answer(self, line: str) -> dict[str, Any]:
        """To one request. What goes wrong is an answer, too."""
        number: Any = None
        try:
            request = json.loads(line)
            number = request["id"]
            if "reset" in request:
                return self._reset(number, request["reset"], request["seeds"])
            if "step" in request:
                return self._step(number, request["step"], request["actions"])
            raise CoppiceError(f"{line.strip()[:200]}: expected reset or step")
        except Exception as error:  # whatever an environment raises: the caller is told, and asks on or not
            traceback.print_exc(file=sys.stderr)
            return {"id": number, "error": f"{type(error).__name__}: {error}"[:1000]}

    def _reset(self, number: Any, places: list[int], seeds: list[int]) -> dict[str, Any]:
        observations = []
        for place, seed in zip(places, seeds):
            if self._places[place] is None:
                self._places[place] = self._make()
            self._observed[place], _ = self._places[place].reset(seed=seed)
            observations.append(self.problem.decode(self._observed[place]))
        return {"id": number, "observations": observations}

    def _step(self, number: Any, places: list[int], actions: list[int]) -> dict[str, Any]:
        answer: dict[str, Any] = {"id": number, "observations": [], "rewards": [], "terminated": [], "truncated": []}
        if self._collides is not None:
            answer["collisions"] = []
        for place, action in zip(places, actions):
            before = self._observed[place]
            after, reward, terminated, truncated, _ = self._places[place].step(self.problem.to_env(action))
            self._observed[place] = after
            answer["observations"].append(self.problem.decode(after))
            answer["rewards"].append(float(reward))
            answer["terminated"].append(bool(terminated))
            answer["truncated"].append(bool(truncated))
            if self._collides is not None:
                answer["collisions"].append(bool(self._collides(before, action, float(reward), after)))
        return answer
