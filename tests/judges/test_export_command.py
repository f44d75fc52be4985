"""`coppice export` as a stranger uses it: what it writes, what it refuses, and that it overwrites nothing."""

from __future__ import annotations

import json
from pathlib import Path

from judging import coppice, verified

TREE = "(sequence move s4=1 turn_right)"
GUARDED = "(selector (sequence s4=1 turn_right) move)"


def test_the_extension_tells_the_format_and_the_size_is_said(room: Path, tmp_path: Path) -> None:
    for name, start in (("p.xml", "<?xml"), ("p.hpp", "// tree of room.coppice"), ("p.py", "# tree of room.coppice"),
                        ("p.json", "{"), ("p.dot", "digraph"), ("p.tex", "% tree of"), ("p.tree", GUARDED)):
        said = coppice("export", room, "--tree", TREE, "-o", tmp_path / name)
        assert "5 nodes in guarded form, 4 as given" in said
        assert (tmp_path / name).read_text().startswith(start), name


def test_labels_stand_beside_what_they_are_about(room: Path, tmp_path: Path) -> None:
    coppice("export", room, "--tree", "(sequence s3=0 turn_left)", "-o", tmp_path / "p.xml")
    text = (tmp_path / "p.xml").read_text()
    assert "ahead is wall (s3=0)" in text and "s3: ahead (0 wall, 1 free, 3 trash)" in text
    assert "ahead is wall" in coppice("explain", room, "--tree", "(sequence s3=0 turn_left)")
    assert "ahead is wall" in coppice("export", room, "--tree", "(sequence s3=0 turn_left)", "--format", "dot", "-o", "-")
    assert "s3: ahead (0 wall, 1 free, 3 trash)" in coppice("info", room)


def test_a_file_that_exists_is_kept_without_force(room: Path, tmp_path: Path) -> None:
    (tmp_path / "p.xml").write_text("mine")
    said = coppice("export", room, "--tree", TREE, "-o", tmp_path / "p.xml", ok=False)
    assert "p.xml exists: expected another name, or --force" in said
    assert (tmp_path / "p.xml").read_text() == "mine"
    coppice("export", room, "--tree", TREE, "-o", tmp_path / "p.xml", "--force")
    assert (tmp_path / "p.xml").read_text() != "mine"
    (tmp_path / "m.lab").write_text("mine")
    said = coppice("export", room, "--format", "prism", "-o", tmp_path / "m.tra", ok=False)
    assert "m.lab exists" in said and not (tmp_path / "m.tra").exists()
    study = room.read_bytes()
    assert "-o" in coppice("export", room, "--tree", TREE, "--format", "json", "-o", room, "--force", ok=False)
    assert room.read_bytes() == study


def test_what_cannot_be_written_is_refused_by_name(room: Path, tmp_path: Path) -> None:
    assert "its extension says no format" in coppice("export", room, "--tree", TREE, "-o", tmp_path / "p", ok=False)
    assert "expected one of behaviortree" in coppice(
        "export", room, "--tree", TREE, "--format", "word", "-o", tmp_path / "p", ok=False)
    assert "acts before it asks" in coppice(
        "export", room, "--tree", TREE, "--as-given", "-o", tmp_path / "p.hpp", ok=False)
    assert "has no run with a tree yet" in coppice("export", room, "-o", tmp_path / "p.xml", ok=False)
    assert list(tmp_path.iterdir()) == []


def test_a_model_needs_no_tree_and_prism_files_stand_side_by_side(room: Path, tmp_path: Path) -> None:
    coppice("export", room, "-o", tmp_path / "m.drn")
    assert "@type: MDP" in (tmp_path / "m.drn").read_text()
    coppice("export", room, "-o", tmp_path / "policy.csv")
    assert (tmp_path / "policy.csv").read_text().startswith("#NON-PERMISSIVE\n#BEGIN 8 1\n")
    coppice("export", room, "--format", "prism", "-o", tmp_path / "m.tra")
    assert {p.name for p in tmp_path.glob("m.*")} == {
        "m.drn", "m.tra", "m.sta", "m.lab", "m.gain.trew", "m.cost.trew"}


def test_trees_are_read_back_from_json_and_xml_wherever_a_tree_is_read(room: Path, tmp_path: Path) -> None:
    wanted = verified(room, TREE, "--resamples", 20)
    for name in ("p.json", "p.xml"):
        coppice("export", room, "--tree", TREE, "-o", tmp_path / name)
        found = verified(room, str(tmp_path / name), "--resamples", 20)
        assert found.pop("tree") == GUARDED
        assert found == {k: v for k, v in wanted.items() if k != "tree"}
    (tmp_path / "bad.xml").write_text('<root BTCPP_format="4"><BehaviorTree ID="a">\n<Inverter/></BehaviorTree></root>')
    said = coppice("verify", room, "--tree", tmp_path / "bad.xml", ok=False)
    assert "bad.xml: line 2: found a node 'Inverter'" in said


def test_prune_shows_the_guarded_form_and_its_size(room: Path) -> None:
    found = json.loads(coppice("prune", room, "--tree", TREE, "--sound", "--guarded", "--json"))
    assert found["guarded"] == GUARDED and found["guarded_nodes"] == 5
