"""Minari data sets as logs that `coppice import` reads."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from typing import Any

import numpy as np

from coppice.errors import CoppiceError
from coppice.files import whole_file
from coppice.recording import action_of
from coppice.spaces import problem_of


class _Spaces:
    """What problem_of() looks at, of a data set."""

    spec = None

    def __init__(self, observation_space: Any, action_space: Any, title: str) -> None:
        self.observation_space = observation_space
        self.action_space = action_space
        self.unwrapped = self
        self.spec = type("Spec", (), {"id": title})()


def from_minari(
    dataset: Any,
    path: str | os.PathLike[str],
    *,
    features: Sequence[str] | None = None,
    actions: Sequence[str] | None = None,
    discount: float | None = None,
    simulator: str | None = None,
) -> int:
    """Writes a data set (a MinariDataset, or the name of one that is installed) to `path`. Returns the number of steps.

    An episode there has one observation more than actions; a last step that neither terminated nor was truncated counts
    as truncated. The other arguments are those of coppice.record().
    """
    if isinstance(dataset, str):
        import minari  # type: ignore[import-untyped]

        dataset = minari.load_dataset(dataset)
    title = getattr(getattr(dataset, "env_spec", None), "id", None) or str(getattr(dataset, "id", "minari"))
    problem = problem_of(_Spaces(dataset.observation_space, dataset.action_space, title), features, actions)
    first: dict[str, Any] = {
        "format": "coppice-log-1",
        "title": problem.title,
        "features": problem.features,
        "actions": problem.actions,
    }
    if discount is not None:
        first["discount"] = discount
    if simulator is not None:
        first["simulator"] = simulator
    total = 0
    with whole_file(path) as out:
        out.write(json.dumps(first, allow_nan=False) + "\n")
        for number, episode in enumerate(dataset.iterate_episodes()):
            count = len(episode.rewards)
            observations = [problem.decode(_at(episode.observations, i)) for i in range(count + 1)]
            for step in range(count):
                terminated = bool(episode.terminations[step])
                if terminated and step + 1 < count:
                    raise CoppiceError(f"episode {number}: terminated at step {step} of {count}: expected at the last")
                line = {
                    "episode": number,
                    "step": step,
                    "observation": observations[step],
                    "action": action_of(problem.from_env(episode.actions[step]), len(problem.actions)),
                    "reward": float(episode.rewards[step]),
                    "next_observation": observations[step + 1],
                    "terminated": terminated,
                    "truncated": step + 1 == count and not terminated,
                }
                out.write(json.dumps(line, allow_nan=False) + "\n")
            total += count
    return total


def _at(observations: Any, i: int) -> Any:
    """Observation i of a batched space: mappings and tuples hold arrays."""
    if isinstance(observations, dict):
        return {key: _at(value, i) for key, value in observations.items()}
    if isinstance(observations, tuple):
        return tuple(_at(value, i) for value in observations)
    return np.asarray(observations[i])
