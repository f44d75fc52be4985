"""What an environment observes and does, as names and numbers: the features and actions of a coppice problem.

Gymnasium is only duck-typed here (`n`, `nvec`, `shape`, `spaces`), so that importing this package needs NumPy alone.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from coppice.errors import CoppiceError

MAX_FEATURES = 64
MAX_ACTIONS = 254

# What the environments that come with Gymnasium observe and do (their documentation); others are numbered.
KNOWN_FEATURES: dict[str, list[str]] = {
    "CartPole": ["cart_position", "cart_velocity", "pole_angle", "pole_velocity"],
    "MountainCar": ["position", "velocity"],
    "MountainCarContinuous": ["position", "velocity"],
    "Acrobot": ["cos_1", "sin_1", "cos_2", "sin_2", "velocity_1", "velocity_2"],
    "LunarLander": ["x", "y", "vx", "vy", "angle", "spin", "left_leg", "right_leg"],
    "Blackjack": ["player", "dealer", "usable_ace"],
    "FrozenLake": ["row", "column"],
    "FrozenLake8x8": ["row", "column"],
    "CliffWalking": ["row", "column"],
    "Taxi": ["row", "column", "passenger", "destination"],
}
KNOWN_ACTIONS: dict[str, list[str]] = {
    "CartPole": ["left", "right"],
    "MountainCar": ["left", "coast", "right"],
    "Acrobot": ["negative", "none_applied", "positive"],
    "LunarLander": ["coast", "left", "main", "right"],
    "Blackjack": ["stick", "hit"],
    "FrozenLake": ["left", "down", "right", "up"],
    "FrozenLake8x8": ["left", "down", "right", "up"],
    "CliffWalking": ["up", "right", "down", "left"],
    "Taxi": ["south", "north", "east", "west", "pick_up", "drop_off"],
}
KNOWN_LABELS: dict[str, dict[str, dict[str, Any]]] = {
    "CartPole": {
        "cart_position": {"label": "position of the cart", "unit": "m"},
        "cart_velocity": {"label": "velocity of the cart", "unit": "m/s"},
        "pole_angle": {"label": "angle of the pole", "unit": "rad"},
        "pole_velocity": {"label": "angular velocity of the pole", "unit": "rad/s"},
    },
    "Taxi": {
        "passenger": {"values": {"0": "red", "1": "green", "2": "yellow", "3": "blue", "4": "in the taxi"}},
        "destination": {"values": {"0": "red", "1": "green", "2": "yellow", "3": "blue"}},
    },
    "Blackjack": {"usable_ace": {"values": {"0": "no", "1": "yes"}}},
}


@dataclass(frozen=True)
class Problem:
    """Names of what is observed and done. `decode` turns an observation into one number per feature, `to_env` an action's
    number into what the environment's step() takes, `from_env` the other way."""

    title: str
    features: list[dict[str, Any]]  # name, and where known label, unit, values
    actions: list[str]
    shape: tuple[int, ...] = field(default=())  # of a grid behind one discrete number; empty: none
    parts: tuple[int, ...] = field(default=())  # choices of each part of an action (MultiDiscrete); empty: it is one number
    parts_shape: tuple[int, ...] = field(default=())  # of the array that the environment takes
    parts_start: tuple[int, ...] = field(default=())  # the first choice of each part

    @property
    def feature_names(self) -> list[str]:
        return [str(feature["name"]) for feature in self.features]

    def decode(self, observation: Any) -> list[float]:
        """One number per feature."""
        values = flat(observation)
        if self.shape and len(values) == 1:
            values = [float(i) for i in np.unravel_index(int(values[0]), self.shape)]
        if len(values) != len(self.features):
            raise CoppiceError(
                f"{self.title}: an observation has {len(values)} numbers: expected {len(self.features)}, "
                f"one for each of {', '.join(self.feature_names)}"
            )
        return values

    def to_env(self, action: int) -> Any:
        """What step() takes: the number itself, or where an action has parts their array."""
        if not self.parts:
            return action
        choices = np.unravel_index(action, self.parts)
        return np.array([int(c) + s for c, s in zip(choices, self.parts_start)], np.int64).reshape(self.parts_shape)

    def from_env(self, chosen: Any) -> Any:
        """The number of the combination where `chosen` is an action with parts as the environment takes it; whatever else
        as it is."""
        if not self.parts:
            return chosen
        if isinstance(chosen, tuple) and not all(np.ndim(c) == 0 and isinstance(c, (int, np.integer)) for c in chosen):
            chosen = chosen[0]  # of predict()
        array = np.asarray(chosen.detach().cpu().numpy() if hasattr(chosen, "detach") else chosen)
        if array.dtype.kind not in "iub" or array.size != len(self.parts) or array.ndim == 0:
            return chosen
        choices = [int(c) - s for c, s in zip(array.reshape(-1), self.parts_start)]
        if not all(0 <= c < n for c, n in zip(choices, self.parts)):
            raise CoppiceError(
                f"the policy chose {chosen!r}: expected numbers from {list(self.parts_start)} and less than "
                f"{[s + n for s, n in zip(self.parts_start, self.parts)]}"
            )
        return int(np.ravel_multi_index(choices, self.parts))


def identifier(name: str) -> str:
    """The name with whatever a coppice name may not hold replaced by '_'."""
    cleaned = re.sub(r"[^A-Za-z0-9_]", "_", name) or "_"
    if cleaned[0].isdigit():
        cleaned = "_" + cleaned
    if cleaned in ("sequence", "selector"):
        cleaned += "_"
    return cleaned[:64]


def flat(observation: Any) -> list[float]:
    """The numbers of an observation: arrays row by row, mappings by sorted key, as Gymnasium orders its Dict spaces."""
    if isinstance(observation, Mapping):
        return [number for key in sorted(observation) for number in flat(observation[key])]
    if isinstance(observation, (tuple, list)):
        return [number for each in observation for number in flat(each)]
    array = np.asarray(observation)
    if array.dtype.kind not in "biuf":
        raise CoppiceError(f"an observation holds {array.dtype}: expected numbers")
    return [float(number) for number in array.reshape(-1)]


def named(observation: Any) -> dict[str, float]:
    """The numbers of an observation under the names that _names_of_space() makes up for its space."""
    found: dict[str, float] = {}

    def add(part: Any, prefix: str) -> None:
        if isinstance(part, Mapping):
            for key in sorted(part):
                add(part[key], _joined(prefix, str(key)))
        elif isinstance(part, tuple):
            for i, each in enumerate(part):
                add(each, _joined(prefix or "x", str(i)))
        else:
            values = flat(part)
            for i, value in enumerate(values):
                name = (prefix or "state") if len(values) == 1 else _joined(prefix or "x", str(i))
                found[identifier(name)] = value

    add(observation, "")
    return found


def _names_of_space(space: Any, prefix: str) -> list[str]:
    spaces = getattr(space, "spaces", None)
    if isinstance(spaces, Mapping):
        return [n for key in sorted(spaces) for n in _names_of_space(spaces[key], _joined(prefix, str(key)))]
    if isinstance(spaces, Sequence):
        return [n for i, part in enumerate(spaces) for n in _names_of_space(part, _joined(prefix or "x", str(i)))]
    shape = getattr(space, "shape", None) or ()
    size = int(np.prod(shape)) if shape else 1
    if size == 1:
        return [prefix or "state"]
    return [_joined(prefix or "x", str(i)) for i in range(size)]


def _joined(prefix: str, name: str) -> str:
    return f"{prefix}_{name}" if prefix else name


def _grid_shape(env: Any, family: str) -> tuple[int, ...]:
    """How a discrete state of a toy-text environment is made up; empty: it is one number."""
    inner = getattr(env, "unwrapped", env)
    if family == "Taxi":
        return (5, 5, 5, 4)
    if hasattr(inner, "nrow") and hasattr(inner, "ncol"):
        return (int(inner.nrow), int(inner.ncol))
    if family.startswith("CliffWalking") and hasattr(inner, "shape"):
        return tuple(int(n) for n in inner.shape)
    return ()


def _parts_of_actions(env: Any) -> tuple[tuple[int, ...], tuple[int, ...], tuple[int, ...]]:
    """Choices of each part, shape and first choices of a MultiDiscrete or MultiBinary action; all empty: it is one number."""
    space = env.action_space
    shape = tuple(int(n) for n in getattr(space, "shape", None) or ())
    if hasattr(space, "nvec"):
        parts = tuple(int(n) for n in np.asarray(space.nvec).reshape(-1))
        start = np.broadcast_to(np.asarray(getattr(space, "start", 0)), shape).reshape(-1)
        return parts, shape, tuple(int(s) for s in start)
    if shape and hasattr(space, "n"):  # MultiBinary
        size = int(np.prod(shape))
        return (2,) * size, shape, (0,) * size
    return (), (), ()


def _names_of_combinations(parts: Sequence[int], start: Sequence[int], names: Sequence[str] | None) -> list[str]:
    """steer_0_gas_1, or without names of the parts a_0_1; the last part changes first, as in np.ravel_multi_index."""
    combinations = [[c + s for c, s in zip(each, start)] for each in np.ndindex(*parts)]
    if names is None:
        return ["_".join(["a", *map(str, each)]) for each in combinations]
    return ["_".join(f"{name}_{c}" for name, c in zip(names, each)) for each in combinations]


def problem_of(
    env: Any, features: Sequence[str] | None = None, actions: Sequence[str] | None = None
) -> Problem:
    """The problem that a Gymnasium environment is. Names that are not given come from what is known of the environment,
    else they are made up: x_0, x_1, ..., a_0, a_1, ...

    Where an action has parts (MultiDiscrete, MultiBinary) each combination is one action, at most MAX_ACTIONS; `actions`
    names the parts, or all combinations."""
    parts, parts_shape, parts_start = _parts_of_actions(env)
    count = math.prod(parts) if parts else getattr(env.action_space, "n", None)
    if count is None:
        raise CoppiceError(f"{env}: its actions are {env.action_space}: expected a Discrete, MultiDiscrete or MultiBinary space")
    if count > MAX_ACTIONS:
        raise CoppiceError(f"{env}: its actions are {env.action_space}, {count} combinations: expected at most {MAX_ACTIONS}")
    if parts:
        if actions is None or (len(actions) == len(parts) and len(actions) != count):
            actions = _names_of_combinations(parts, parts_start, actions)
    elif int(getattr(env.action_space, "start", 0)) != 0:
        raise CoppiceError(f"{env}: its actions start at {env.action_space.start}: expected 0")
    title = env.spec.id if getattr(env, "spec", None) is not None else type(getattr(env, "unwrapped", env)).__name__
    family = re.sub(r"-v\d+$", "", title.split("/")[-1])
    shape = _grid_shape(env, family)
    found = _names_of_space(env.observation_space, "")
    if shape and len(found) == 1:
        found = [f"x_{i}" for i in range(len(shape))]
    known = KNOWN_FEATURES.get(family, [])
    names = list(features) if features is not None else (known if len(known) == len(found) else found)
    known_actions = KNOWN_ACTIONS.get(family, [])
    if actions is None:
        actions = known_actions if len(known_actions) == int(count) else [f"a_{i}" for i in range(int(count))]
    names = [identifier(name) for name in names]
    action_names = [identifier(name) for name in actions]
    for what, given, wanted, most in (
        ("features", names, len(found), MAX_FEATURES),
        ("actions", action_names, int(count), MAX_ACTIONS),
    ):
        if len(given) != wanted or len(given) > most:
            raise CoppiceError(f"{title}: {len(given)} names of {what}: expected {wanted}, and at most {most}")
        if len(set(given)) != len(given):
            raise CoppiceError(f"{title}: {what} {', '.join(given)}: expected names that differ")
    labels = KNOWN_LABELS.get(family, {}) if features is None else {}
    return Problem(title, [{"name": n, **labels.get(n, {})} for n in names], action_names, shape, parts, parts_shape, parts_start)
