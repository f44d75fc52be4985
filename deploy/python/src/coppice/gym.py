"""python -m coppice.gym ENV: a Gymnasium environment as the simulator of `coppice score --simulator`.

    coppice score cartpole.coppice --simulator 'python -m coppice.gym CartPole-v1'
    coppice score lake.coppice --simulator 'python -m coppice.gym FrozenLake-v1 --set map_name=8x8'
"""

from __future__ import annotations

import argparse
import importlib
import json
import sys
from collections.abc import Sequence
from typing import Any

from coppice.errors import CoppiceError
from coppice.simulator import EPISODES, serve


def main(arguments: Sequence[str] | None = None) -> int:
    """Returns the exit code."""
    parser = argparse.ArgumentParser(prog="python -m coppice.gym", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("env", help="what gymnasium.make() takes: CartPole-v1, or module:Name-v0")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE",
                        help="an argument of gymnasium.make(), its value as JSON or else as text; may be repeated")
    parser.add_argument("--import", action="append", default=[], dest="modules", metavar="MODULE",
                        help="import this first, which registers the environment; may be repeated")
    parser.add_argument("--features", metavar="A,B,...", help="names of what is observed")
    parser.add_argument("--actions", metavar="A,B,...", help="names of the actions")
    parser.add_argument("--episodes", type=int, default=EPISODES, help="at once (default %(default)s)")
    parser.add_argument("--collision-reward", type=float, metavar="R",
                        help="a step of this reward or less is a collision")
    parser.add_argument("--timeout", type=float, metavar="SECONDS", help="that one answer may take (default 60)")
    options = parser.parse_args(arguments)
    try:
        import gymnasium
    except ImportError:
        print("coppice.gym: Gymnasium is missing: expected 'pip install gymnasium'", file=sys.stderr)
        return 1
    settings: dict[str, Any] = {}
    for pair in options.set:
        key, equals, value = pair.partition("=")
        if not equals:
            parser.error(f"--set {pair}: expected KEY=VALUE")
        try:
            settings[key] = json.loads(value)
        except json.JSONDecodeError:
            settings[key] = value
    bound = options.collision_reward
    try:
        for module in options.modules:
            importlib.import_module(module)
        serve(
            lambda: gymnasium.make(options.env, **settings),
            episodes=options.episodes,
            features=options.features.split(",") if options.features else None,
            actions=options.actions.split(",") if options.actions else None,
            collides=None if bound is None else lambda before, action, reward, after: reward <= bound,
            timeout=options.timeout,
        )
    except (CoppiceError, gymnasium.error.Error, ImportError, TypeError) as error:
        print(f"coppice.gym: {error}", file=sys.stderr)
        return 1
    except BrokenPipeError:
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
