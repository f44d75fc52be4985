"""Two tiny environments with known answers."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np


class Corridor(gymnasium.Env[Any, int]):
    """Five cells; action 1 goes right, 0 left; the last cell ends it with reward 1. Prints, as environments do."""

    observation_space = gymnasium.spaces.Discrete(5)
    action_space = gymnasium.spaces.Discrete(2)

    def __init__(self) -> None:
        self.cell = 0

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        super().reset(seed=seed)
        print("a line that must not reach the protocol")
        self.cell = int(self.np_random.integers(2))
        return self.cell, {}

    def step(self, action: int) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        self.cell = max(0, self.cell + (1 if action == 1 else -1))
        ended = self.cell == 4
        return self.cell, 1.0 if ended else 0.0, ended, False, {}


class Broken(Corridor):
    """Fails in its third step."""

    def __init__(self) -> None:
        super().__init__()
        self.steps = 0

    def step(self, action: int) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        self.steps += 1
        if self.steps == 3:
            raise RuntimeError("the motor is gone")
        return super().step(action)


class Mixed(gymnasium.Env[Any, int]):
    """Observes a dictionary of an array, a number and a pair."""

    observation_space = gymnasium.spaces.Dict(
        {
            "pose": gymnasium.spaces.Box(-1.0, 1.0, (2,)),
            "gear": gymnasium.spaces.Discrete(3),
            "flags": gymnasium.spaces.MultiBinary(2),
        }
    )
    action_space = gymnasium.spaces.Discrete(3)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        super().reset(seed=seed)
        return {"pose": np.array([0.5, -0.5], np.float32), "gear": 2, "flags": np.array([1, 0], np.int8)}, {}

    def step(self, action: int) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        return self.reset()[0], float("nan"), False, True, {}


class Crane(gymnasium.Env[Any, Any]):
    """A place on a line of four and a hook; an action is (go left, stay or go right; hook up or down, counted from 1). Let
    down at the right end it is done."""

    observation_space = gymnasium.spaces.Discrete(4)
    action_space = gymnasium.spaces.MultiDiscrete([3, 2], start=[0, 1])

    def __init__(self) -> None:
        self.place = 0

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        super().reset(seed=seed)
        self.place = 0
        return self.place, {}

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        assert self.action_space.contains(action)
        done = self.place == 3 and action[1] == 2
        self.place = min(3, max(0, self.place + int(action[0]) - 1))
        return self.place, 1.0 if done else 0.0, bool(done), False, {}


gymnasium.register("Crane-v0", entry_point="environments:Crane", max_episode_steps=20)
gymnasium.register("Corridor-v0", entry_point="environments:Corridor", max_episode_steps=20)
gymnasium.register("Broken-v0", entry_point="environments:Broken")
