"""What the judges share: the built programs, a study, random trees, and what our own program says a tree does."""

from __future__ import annotations

import csv
import io
import json
import os
import random
import subprocess
from pathlib import Path
from typing import Any

import pytest

COPPICE = os.environ.get("COPPICE", str(Path(__file__).resolve().parents[2] / "build/release/bin/coppice"))


def coppice(*arguments: object, ok: bool = True, **settings: Any) -> str:
    done = subprocess.run([COPPICE, *map(str, arguments)], capture_output=True, text=True, timeout=300, **settings)
    assert (done.returncode == 0) == ok, f"coppice {arguments}: {done.returncode}\n{done.stderr}{done.stdout[-2000:]}"
    return done.stdout if ok else done.stderr


@pytest.fixture(scope="session")
def room(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A study of our own room, learned for a short while, so that trees also meet pairs that were never tried."""
    path = tmp_path_factory.mktemp("judges") / "room.coppice"
    coppice("learn", "-o", path, "--episodes", "20000")
    return path


def states(study: Path, tree: str) -> tuple[list[str], list[dict[str, str]]]:
    """Feature names, and a row a state: features, policy_action, tree_action."""
    rows = list(csv.DictReader(io.StringIO(coppice("table", study, "--tree", tree))))
    return [n for n in rows[0] if n not in ("visits", "policy_action", "tree_action")], rows


def random_tree(draw: random.Random, features: dict[str, list[str]], actions: list[str], depth: int = 4) -> str:
    """Text of a tree, as wild as evolution's: actions may stand before conditions."""
    if depth == 0 or draw.random() < 0.3:
        if draw.random() < 0.5:
            return draw.choice(actions)
        name = draw.choice(sorted(features))
        return f"{name}={draw.choice(features[name])}"
    children = (random_tree(draw, features, actions, depth - 1) for _ in range(draw.randint(2, 4)))
    return f"({draw.choice(['sequence', 'selector'])} {' '.join(children)})"


ROOM_FEATURES = {f"s{i}": ["0", "1", "3"] for i in range(8)}
ROOM_ACTIONS = ["move", "turn_left", "turn_right"]


def room_trees(count: int, seed: int) -> list[str]:
    draw = random.Random(seed)
    return [random_tree(draw, ROOM_FEATURES, ROOM_ACTIONS) for _ in range(count)]


def exported(study: Path, tree: str, form: str, path: Path, *flags: str) -> str:
    coppice("export", study, "--tree", tree, "--format", form, "-o", path, "--force", *flags)
    return path.read_text()


def verified(study: Path, tree: str, *flags: object) -> dict[str, Any]:
    return json.loads(coppice("verify", study, "--tree", tree, "--json", "--episodes", 0, *flags))


def evaluated(study: Path, tree: str, *flags: object) -> dict[str, Any]:
    return json.loads(coppice("evaluate", study, *flags, input=tree + "\n").splitlines()[0])
