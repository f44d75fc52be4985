"""Storm (stormpy) answers on the exported models what `verify` and `evaluate` say, to 1e-6."""

from __future__ import annotations

import random
import re
from pathlib import Path
from typing import Any

import pytest

from judging import coppice, evaluated, exported, random_tree, room_trees, verified

stormpy = pytest.importorskip("stormpy", reason="stormpy is not installed")

STEPS = 150
TOLERANCE = 1e-6
# What a person would try, and what evolution draws: some collide, some leave the model, some stop acting.
TREES = [
    "(selector (sequence s3=0 turn_left) move)",
    "(selector (sequence (selector s3=0 s3=3) turn_right) (sequence s4=3 turn_right) move)",
    "(selector (sequence s3=3 move) (sequence s1=3 turn_left) (sequence s3=0 s1=1 turn_left) (sequence s3=0 turn_right) move)",
    "move",
    *room_trees(8, seed=21),
]


def ask(model: Any, formula: str, mode: Any = None) -> float:
    # A label that no state has is not in the file, and Storm does not know it: it never happens.
    label = re.search(r'F[^"]*"(\w+)"', formula)
    if label and not model.labeling.contains_label(label[1]):
        return 0.0
    settings = {} if mode is None else {"uncertainty_resolution_mode": mode}
    result = stormpy.model_checking(model, stormpy.parse_properties(formula)[0], **settings)
    return float(result.get_value(model.initial_states[0]))


def signed(model: Any, what: str) -> float:
    return ask(model, f'R{{"gain"}}=? [{what}]') - ask(model, f'R{{"cost"}}=? [{what}]')


def near(ours: float, theirs: float) -> None:
    assert abs(ours - theirs) <= TOLERANCE * max(1.0, abs(theirs)), (ours, theirs)


def compare(study: Path, tree: str, path: Path) -> bool:
    """Whether there were rewards to compare: behind an action that was never tried `evaluate` goes on anywhere and Storm
    stays in `unknown`, so only where the walk never leaves the model is there one figure."""
    exported(study, tree, "drn-tree", path)
    model = stormpy.build_model_from_drn(str(path))
    figures = verified(study, tree, "--steps", STEPS, "--resamples", 20)
    # Storm counts transitions; an event happens in the step that is taken in a labelled state.
    for event in figures["events"]:
        near(event["within"]["value"], ask(model, f'P=? [F<={STEPS - 1} "{event["name"]}"]'))
        near(event["ever"]["value"], ask(model, f'P=? [F "{event["name"]}"]'))
    untried = figures["leaves_by_untried_pair"]
    near(untried["ever"]["value"], ask(model, 'P=? [F "unknown"]'))
    near(untried["within"]["value"], ask(model, f'P=? [F<={STEPS} "unknown"]'))
    if untried["ever"]["value"] > 0.0:
        return False
    near(figures["reward_per_episode"]["value"], signed(model, f"C<={STEPS}"))
    exact = evaluated(study, tree, "--objective", "return", "--exact", "--steps", STEPS)
    near(exact["objectives"]["return"]["per_step"], signed(model, f"C<={STEPS}") / STEPS)
    discounted = evaluated(study, tree, "--objective", "return", "--discounted", 0.99)
    near(discounted["objectives"]["return"]["per_step"], 0.01 * signed(model, "Cdiscount=0.99"))
    return True


@pytest.mark.parametrize("tree", TREES)
def test_the_chain_under_a_tree_has_the_figures_of_verify_and_evaluate(room: Path, tmp_path: Path, tree: str) -> None:
    compare(room, tree, tmp_path / "t.drn")


def test_rewards_agree_where_the_walk_never_leaves_the_model(tmp_path: Path) -> None:
    grid = tmp_path / "grid.coppice"
    coppice("learn", "--world", "windy", "-o", grid, "--episodes", 3000)
    draw = random.Random(22)
    features = {"x": [str(i) for i in range(10)], "y": [str(i) for i in range(7)]}
    trees = ["(selector (sequence x<=8 right) down)", "right", "(selector (sequence x<=3 right) (sequence y<=2 up) down)"]
    trees += [random_tree(draw, features, ["up", "down", "left", "right"], 3) for _ in range(9)]
    assert sum(compare(grid, tree, tmp_path / "t.drn") for tree in trees) >= 4


def test_the_mdp_lets_storm_find_what_is_best(room: Path, tmp_path: Path) -> None:
    exported(room, TREES[0], "drn", tmp_path / "mdp.drn")
    model = stormpy.build_model_from_drn(str(tmp_path / "mdp.drn"))
    assert str(model.model_type) == "ModelType.MDP"
    for tree in TREES[:3]:
        exported(room, tree, "drn-tree", tmp_path / "t.drn")
        under_tree = stormpy.build_model_from_drn(str(tmp_path / "t.drn"))
        best = ask(model, f'Rmax=? [C<={STEPS}]'.replace("R", 'R{"gain"}', 1))
        assert best >= ask(under_tree, f'R{{"gain"}}=? [C<={STEPS}]') - TOLERANCE


def robust(model: Path, label: str, steps: int, pick: Any) -> float:
    """The extreme probability of reaching a label within steps, over all chains in the intervals: our own value iteration
    on the file itself (Givan, Leach and Dean, 2000: fill the best successors first)."""
    rows: list[list[tuple[int, float, float]]] = []
    holds: list[bool] = []
    initial = 0
    for line in model.read_text().splitlines():
        if line.startswith("state "):
            rows.append([])
            holds.append(label in line.split("]")[1].split())
            initial = len(rows) - 1 if "init" in line.split("]")[1].split() else initial
        elif line.startswith("\t\t"):
            to, interval = line.strip().split(" : ")
            low, high = interval.strip("[]").split(", ")
            rows[-1].append((int(to), float(low), float(high)))
    value = [1.0 if h else 0.0 for h in holds]
    for _ in range(steps):
        new = []
        for state, row in enumerate(rows):
            if holds[state]:
                new.append(1.0)
                continue
            rest = 1.0 - sum(low for _, low, _ in row)
            total = sum(low * value[to] for to, low, _ in row)
            for to, low, high in sorted(row, key=lambda t: value[t[0]], reverse=pick is max):
                more = min(high - low, rest)
                total += more * value[to]
                rest -= more
            new.append(total)
        value = new
    return value[initial]


@pytest.mark.parametrize("tree", TREES[:3])
def test_intervals_hold_the_exact_figure_and_storm_reads_them_as_we_mean_them(
    room: Path, tmp_path: Path, tree: str
) -> None:
    exported(room, tree, "drn-tree-intervals", tmp_path / "i.drn")
    exported(room, tree, "drn-tree", tmp_path / "t.drn")
    exact = ask(stormpy.build_model_from_drn(str(tmp_path / "t.drn")), 'P=? [F<=20 "collision"]')
    model = stormpy.build_model_from_drn[stormpy.Interval](str(tmp_path / "i.drn"))
    modes = stormpy.UncertaintyResolutionMode
    low = ask(model, 'P=? [F<=20 "collision"]', modes.MINIMIZE)
    high = ask(model, 'P=? [F<=20 "collision"]', modes.MAXIMIZE)
    assert low <= exact + TOLERANCE and exact <= high + TOLERANCE
    near(robust(tmp_path / "i.drn", "collision", 20, min), low)
    near(robust(tmp_path / "i.drn", "collision", 20, max), high)
