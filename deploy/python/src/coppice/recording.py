"""Writes what a policy meets as a log that `coppice import` reads: JSON lines, names first, then a line a step."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from coppice.errors import CoppiceError
from coppice.files import whole_file
from coppice.spaces import flat, problem_of

# A callable, or an object with predict(): a trained model of scikit-learn or stable-baselines3.
Policy = Callable[[Any], Any] | Any


def record(
    env: Any,
    policy: Policy,
    episodes: int,
    path: str | os.PathLike[str],
    *,
    seed: int = 0,
    exploration: float = 0.0,
    steps: int | None = None,
    features: Sequence[str] | None = None,
    actions: Sequence[str] | None = None,
    discount: float | None = None,
    simulator: str | None = None,
) -> int:
    """Runs `policy` in `env` and writes every step to `path`. Returns the number of steps.

    policy: from an observation to an action: an int, or whatever holds one (arrays, tensors, what predict() gives); where an
        action has parts (MultiDiscrete), those; or to a score for each action, the highest of which is taken. A model with predict() may stand for it.
    seed: episode i is reset with seed + i, so the same call gives the same file.
    exploration: with this probability a step takes a random action instead; a chain needs more than the policy's own.
    steps: an episode is cut there, besides the environment's own limit; it counts as truncated.
    features, actions: names, if those that are known or made up do not suit (coppice.spaces.problem_of).
    discount: that the policy was learned with, in (0, 1].
    simulator: a command that simulates the environment for coppice, kept in the log's first line.
    """
    if episodes < 1:
        raise CoppiceError(f"episodes is {episodes}: expected 1 or more")
    if not 0.0 <= exploration <= 1.0:
        raise CoppiceError(f"exploration is {exploration}: expected 0 to 1")
    problem = problem_of(env, features, actions)
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
    random = np.random.default_rng(seed)
    act = acting(policy)
    total = 0
    with whole_file(path) as out:
        out.write(json.dumps(first, allow_nan=False) + "\n")
        for episode in range(episodes):
            observation, _ = env.reset(seed=seed + episode)
            step = 0
            ended = False
            while not ended:
                if exploration > 0.0 and random.random() < exploration:
                    action = int(random.integers(len(problem.actions)))
                else:
                    action = action_of(problem.from_env(act(observation)), len(problem.actions))
                after, reward, terminated, truncated, _ = env.step(problem.to_env(action))
                cut = steps is not None and step + 1 >= steps
                line = {
                    "episode": episode,
                    "step": step,
                    "observation": problem.decode(observation),
                    "action": action,
                    "reward": float(reward),
                    "next_observation": problem.decode(after),
                    "terminated": bool(terminated),
                    "truncated": bool((truncated or cut) and not terminated),
                }
                try:
                    out.write(json.dumps(line, allow_nan=False) + "\n")
                except ValueError:
                    raise CoppiceError(
                        f"episode {episode}, step {step}: an observation or reward is not finite: {line}"
                    ) from None
                ended = bool(terminated or truncated or cut)
                observation = after
                step += 1
            total += step
    return total


def acting(policy: Policy) -> Callable[[Any], Any]:
    """The policy as a callable. A fitted scikit-learn model is asked for one row of numbers."""
    if callable(policy):
        return policy
    predict = getattr(policy, "predict", None)
    if predict is None:
        raise CoppiceError(f"the policy is {policy!r}: expected a function of the observation, or a model with predict()")
    if hasattr(policy, "n_features_in_"):
        return lambda observation: predict(np.asarray([flat(observation)]))
    return predict  # type: ignore[no-any-return]


def action_of(chosen: Any, actions: int) -> int:
    """The index that a policy chose; of a tuple, as predict() gives, the first; of scores, one an action, the highest (the
    first of those that are equal)."""
    if isinstance(chosen, tuple):
        chosen = chosen[0]
    if hasattr(chosen, "detach"):  # a tensor that may lie elsewhere and know its gradient
        chosen = chosen.detach().cpu().numpy()
    array = np.asarray(chosen)
    if array.dtype.kind == "f" and array.size == actions > 1 and not np.isnan(array).any():
        return int(np.argmax(array))
    if array.size != 1 or array.dtype.kind not in "iub":
        raise CoppiceError(
            f"the policy chose {chosen!r}: expected one whole number, or {actions} scores of which the highest is taken"
        )
    action = int(array.reshape(-1)[0])
    if not 0 <= action < actions:
        raise CoppiceError(f"the policy chose {action}: expected 0 to {actions - 1}")
    return action
