"""Writes the transition table of a toy-text environment, P[s][a] = [(probability, next, reward, terminated), ...], for
`coppice import`."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from typing import Any

import numpy as np

from coppice.errors import CoppiceError
from coppice.files import whole_file
from coppice.spaces import problem_of


def tables(
    env: Any,
    path: str | os.PathLike[str],
    *,
    features: Sequence[str] | None = None,
    actions: Sequence[str] | None = None,
    discount: float | None = None,
    simulator: str | None = None,
) -> int:
    """Writes P, where episodes start, and the names, as one JSON object. Returns the number of states.

    The environment's time limit is not in its table and is not written. features, actions, discount, simulator: as
    coppice.record().
    """
    inner = getattr(env, "unwrapped", env)
    table = getattr(inner, "P", None)
    if table is None:
        raise CoppiceError(f"{env}: has no transition table P: expected a toy-text environment; coppice.record() takes any")
    problem = problem_of(env, features, actions)
    states = len(table)
    initial = getattr(inner, "initial_state_distrib", None)
    if initial is None:
        raise CoppiceError(f"{env}: has no initial_state_distrib: nothing says where episodes start")
    content: dict[str, Any] = {
        "format": "coppice-tables-1",
        "title": problem.title,
        "features": problem.features,
        "actions": problem.actions,
        "observations": [[int(n) for n in problem.decode(s)] for s in range(states)],
        "initial": [float(p) for p in np.asarray(initial)],
        "P": [
            [
                [[float(p), int(after), float(reward), bool(ended)] for p, after, reward, ended in table[s][a]]
                for a in range(len(problem.actions))
            ]
            for s in range(states)
        ],
    }
    if discount is not None:
        content["discount"] = discount
    if simulator is not None:
        content["simulator"] = simulator
    with whole_file(path) as out:
        json.dump(content, out, allow_nan=False)
        out.write("\n")
    return states
