"""Gymnasium's own tables, imported and solved, against a value iteration that shares no code with the project."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from judging import coppice

gymnasium = pytest.importorskip("gymnasium", reason="Gymnasium is not installed")

GAMMA = 0.99
Table = list[list[list[tuple[float, int, float, bool]]]]


def optimum(table: Table, initial: list[float]) -> float:
    """Plain value iteration, cut where a step terminates."""
    values = [0.0] * len(table)
    for _ in range(100_000):
        new = [
            max(sum(p * (r + (0.0 if end else GAMMA * values[s])) for p, s, r, end in row) for row in actions if row)
            for actions in table
        ]
        moved = max(abs(a - b) for a, b in zip(new, values))
        values = new
        if moved < 1e-12:
            break
    return sum(p * v for p, v in zip(initial, values))


def table_of(env: Any) -> tuple[Table, list[float]]:
    inner = env.unwrapped
    table = [
        [[(float(p), int(s), float(r), bool(end)) for p, s, r, end in inner.P[state][a]] for a in range(len(inner.P[0]))]
        for state in range(len(inner.P))
    ]
    return table, [float(p) for p in inner.initial_state_distrib]


def blackjack() -> tuple[Table, list[float]]:
    """Gymnasium's Blackjack (natural off, sab off) written out from its rules: infinite deck, dealer hits below 17."""
    cards = {c: 1 / 13 for c in range(1, 10)} | {10: 4 / 13}

    def add(total: int, ace: bool, card: int) -> tuple[int, bool]:
        """Sum of a hand with aces as 1, and whether it has one."""
        return total + card, ace or card == 1

    def best(total: int, ace: bool) -> int:
        return total + 10 if ace and total + 10 <= 21 else total

    def dealer(total: int, ace: bool) -> dict[int, float]:
        if best(total, ace) >= 17:
            return {min(best(total, ace), 22): 1.0}
        ends: dict[int, float] = {}
        for card, p in cards.items():
            for end, q in dealer(*add(total, ace, card)).items():
                ends[end] = ends.get(end, 0.0) + p * q
        return ends

    shown = {card: {} for card in cards}
    for card in cards:
        for other, p in cards.items():
            for end, q in dealer(*add(*add(0, False, card), other)).items():
                shown[card][end] = shown[card].get(end, 0.0) + p * q
    hands = [(total, ace) for total in range(2, 22) for ace in (False, True)]
    number = {(hand, card): i for i, (hand, card) in enumerate((h, c) for h in hands for c in cards)}
    over = len(number)
    table: Table = []
    for (total, ace), card in number:
        mine = best(total, ace)
        stick = [
            (p, over, 1.0 if end == 22 or mine > end else (0.0 if mine == end else -1.0), True)
            for end, p in shown[card].items()
        ]
        hit = []
        for drawn, p in cards.items():
            new = add(total, ace, drawn)
            hit.append((p, over, -1.0, True) if new[0] > 21 else (p, number[(new, card)], 0.0, False))
        table.append([stick, hit])
    table.append([[(1.0, over, 0.0, True)], [(1.0, over, 0.0, True)]])
    initial = [0.0] * len(table)
    for first, p in cards.items():
        for second, q in cards.items():
            for card, r in cards.items():
                initial[number[(add(*add(0, False, first), second), card)]] += p * q * r
    return table, initial


@pytest.mark.parametrize("name", ["FrozenLake-v1", "FrozenLake8x8-v1", "Taxi", "CliffWalking", "Blackjack"])
def test_tables_reach_the_optimum(name: str, tmp_path: Path) -> None:
    if name == "Blackjack":
        table, initial = blackjack()
    else:
        known = sorted(spec for spec in gymnasium.registry if spec.startswith(name.removesuffix("-v1")))
        env = gymnasium.make(name if name in gymnasium.registry else known[-1])
        table, initial = table_of(env)
    source = tmp_path / "tables.json"
    source.write_text(json.dumps({"format": "coppice-tables-1", "initial": initial, "P": table}))
    report = json.loads(
        coppice("import", source, "-o", tmp_path / "study.coppice", "--solve", "--gamma", GAMMA, "--json")
    )
    wanted = optimum(table, initial)
    assert abs(report["value"] - wanted) < 1e-7, (report["value"], wanted)
    assert abs(report["count_error"]) < 1e-6
    assert report["value"] != 0.0


def test_blackjack_is_gymnasiums_own(tmp_path: Path) -> None:
    """The rules written out above, against 20,000 hands of the environment: sticking at once."""
    table, initial = blackjack()
    wanted = sum(p * sum(q * r for q, _, r, _ in table[s][0]) for s, p in enumerate(initial))
    env = gymnasium.make("Blackjack-v1")
    total = 0.0
    for hand in range(20_000):
        env.reset(seed=hand)
        total += float(env.step(0)[1])
    assert abs(total / 20_000 - wanted) < 0.03, (total / 20_000, wanted)


def test_storm_and_tables_say_the_same_of_a_lake(tmp_path: Path) -> None:
    table, initial = table_of(gymnasium.make("FrozenLake-v1"))
    source = tmp_path / "tables.json"
    source.write_text(json.dumps({"initial": initial, "P": table}))
    coppice("import", source, "-o", tmp_path / "a.coppice", "--solve", "--gamma", GAMMA)
    info = json.loads(coppice("info", tmp_path / "a.coppice", "--json"))
    assert info["terminal_states"] == 5
    assert info["no_action"] == "worst"
    assert info["discount"] == GAMMA
