"""A stock BehaviorTree.CPP 4 (its Python bindings) runs the XML and chooses the same action in every state."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from judging import ROOM_ACTIONS, exported, room_trees, states

bt = pytest.importorskip("behaviortreepy", reason="the bindings of BehaviorTree.CPP are not installed")


def chosen(tree: Any, features: list[str], row: dict[str, str]) -> str:
    board = tree.root_blackboard()
    for name in features:
        board.set_int(name, int(row[name]))
    board.set_int("action", -1)
    tree.tick_exactly_once()
    action = board.get_int("action")
    return ROOM_ACTIONS[action] if action >= 0 else ""


@pytest.mark.parametrize("flags", [(), ("--as-given",)], ids=["guarded", "as_given"])
def test_scripts_choose_the_same_action_in_every_state_forwards_and_backwards(
    room: Path, tmp_path: Path, flags: tuple[str, ...]
) -> None:
    compared = 0
    for text in room_trees(150, seed=1):
        names, rows = states(room, text)
        tree = bt.BehaviorTreeFactory().create_tree_from_text(
            exported(room, text, "behaviortree", tmp_path / "t.xml", *flags)
        )
        # Every seventh state, then the same in the reversed order, which would show any memory.
        for row in rows[::7] + rows[::-7]:
            assert chosen(tree, names, row) == row["tree_action"], (text, row)
            compared += 1
    assert compared > 10_000


def test_registered_nodes_act_at_most_once_and_do_what_the_tree_does(room: Path, tmp_path: Path) -> None:
    for text in room_trees(60, seed=2):
        names, rows = states(room, text)
        xml = exported(room, text, "behaviortree-nodes", tmp_path / "t.xml")
        now: dict[str, int] = {}
        done: list[str] = []
        factory = bt.BehaviorTreeFactory()
        for name in names:
            for value in (0, 1, 3):
                factory.register_simple_condition(
                    f"{name}_is_{value}",
                    lambda *_, n=name, v=value: bt.NodeStatus.SUCCESS if now[n] == v else bt.NodeStatus.FAILURE,
                )
        for action in ROOM_ACTIONS:
            factory.register_simple_action(
                action, lambda *_, a=action: (done.append(a), bt.NodeStatus.SUCCESS)[1]
            )
        tree = factory.create_tree_from_text(xml)
        for row in rows[::11]:
            now.update({name: int(row[name]) for name in names})
            done.clear()
            tree.tick_exactly_once()
            assert done == ([row["tree_action"]] if row["tree_action"] else []), (text, row)


def test_what_was_written_is_read_back_as_the_same_tree(room: Path, tmp_path: Path) -> None:
    from judging import coppice

    for text in room_trees(30, seed=3):
        exported(room, text, "behaviortree", tmp_path / "t.xml", "--as-given")
        again = coppice("export", room, "--tree", tmp_path / "t.xml", "--format", "text", "--as-given", "-o", "-").strip()
        assert again == text
