"""Written files in the hands of the tools they are for: PRISM explicit files in Storm's reader of them, the controller in
dtControl's own loader, the drawing in LaTeX."""

from __future__ import annotations

import random
import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest

from judging import coppice, exported, random_tree, room_trees, states, verified

STEPS = 150
TOLERANCE = 1e-6
TREE = "(selector (sequence s3=0 turn_left) (sequence s4=3 turn_right) move)"


def storm() -> Any:
    return pytest.importorskip("stormpy", reason="stormpy is not installed")


def prism_model(stem: Path, part: str) -> Any:
    """What Storm makes of the PRISM files at `stem`, with the rewards of `part`: gain or cost. Storm's explicit files are
    PRISM's but for their heads: the kind of model in place of the counts, and labels declared by name. Every number is
    read by Storm itself."""
    counts, *transitions = stem.with_suffix(".tra").read_text().splitlines()
    is_mdp = len(counts.split()) == 3
    assert int(counts.split()[-1]) == len(transitions)
    heads, *labelled = stem.with_suffix(".lab").read_text().splitlines()
    names = dict(re.findall(r'(\d+)="(\w+)"', heads))
    of_state = [(line.split(":")[0], [names[i] for i in line.split(":")[1].split()]) for line in labelled]
    rewards = stem.with_suffix(f".{part}.{'trew' if is_mdp else 'srew'}").read_text().splitlines()[1:]
    written = {
        "tra": ["mdp" if is_mdp else "dtmc", *(" ".join(line.split()[: 4 if is_mdp else 3]) for line in transitions)],
        "lab": ["#DECLARATION", " ".join(names.values()), "#END", *(" ".join([s, *of]) for s, of in of_state)],
        "rew": rewards,
    }
    paths = {}
    for kind, lines in written.items():
        paths[kind] = str(stem.with_suffix(f".storm.{kind}"))
        Path(paths[kind]).write_text("\n".join(lines) + "\n")
    given = {"transition_rewards" if is_mdp else "state_rewards": paths["rew"]} if rewards else {}
    return storm().build_model_from_explicit(paths["tra"], paths["lab"], **given)


def ask(model: Any, formula: str) -> float:
    found = storm().model_checking(model, storm().parse_properties(formula)[0])
    return float(found.get_value(model.initial_states[0]))


def near(ours: float, theirs: float) -> None:
    assert abs(ours - theirs) <= TOLERANCE * max(1.0, abs(theirs)), (ours, theirs)


def test_storm_reads_the_chain_under_a_tree_from_prism_files_as_verify_says(room: Path, tmp_path: Path) -> None:
    stormpy = storm()
    compared = 0
    for tree in [TREE, "(selector (sequence s3=0 turn_left) move)", *room_trees(6, seed=31)]:
        exported(room, tree, "prism-tree", tmp_path / "t.tra")
        exported(room, tree, "drn-tree", tmp_path / "t.drn")
        gain, cost = (prism_model(tmp_path / "t.tra", part) for part in ("gain", "cost"))
        drn = stormpy.build_model_from_drn(str(tmp_path / "t.drn"))
        assert (gain.nr_states, gain.nr_transitions) == (drn.nr_states, drn.nr_transitions)
        for label in drn.labeling.get_labels():
            assert drn.labeling.get_states(label) == gain.labeling.get_states(label), label
        figures = verified(room, tree, "--steps", STEPS, "--resamples", 20)
        for event in figures["events"]:
            if gain.labeling.contains_label(event["name"]):  # else no state has it
                near(event["within"]["value"], ask(gain, f'P=? [F<={STEPS - 1} "{event["name"]}"]'))
                near(event["ever"]["value"], ask(gain, f'P=? [F "{event["name"]}"]'))
                compared += 1
        leaves = figures["leaves_by_untried_pair"]
        near(leaves["ever"]["value"], ask(gain, 'P=? [F "unknown"]'))
        # Rewards: what the same walk earns in the DRN, which is held against `verify` elsewhere.
        for part, model in (("gain", gain), ("cost", cost)):
            earned = ask(model, f"R=? [C<={STEPS}]") if model.reward_models else 0.0
            near(ask(drn, f'R{{"{part}"}}=? [C<={STEPS}]'), earned)
    assert compared >= 8


def test_storm_reads_the_mdp_from_prism_files_as_from_drn(room: Path, tmp_path: Path) -> None:
    stormpy = storm()
    exported(room, TREE, "prism", tmp_path / "m.tra")
    exported(room, TREE, "drn", tmp_path / "m.drn")
    drn = stormpy.build_model_from_drn(str(tmp_path / "m.drn"))
    for part in ("gain", "cost"):
        model = prism_model(tmp_path / "m.tra", part)
        assert str(model.model_type) == "ModelType.MDP"
        assert (model.nr_states, model.nr_choices) == (drn.nr_states, drn.nr_choices)
        for best in ("min", "max"):
            near(ask(drn, f'R{{"{part}"}}{best}=? [C<={STEPS}]'), ask(model, f"R{best}=? [C<={STEPS}]"))
            near(ask(drn, f'P{best}=? [F<=20 "unknown"]'), ask(model, f'P{best}=? [F<=20 "unknown"]'))


def test_dtcontrol_loads_the_policy_of_every_state(room: Path, tmp_path: Path) -> None:
    loading = pytest.importorskip("dtcontrol.dataset.csv_dataset_loader", reason="dtControl is not installed")
    coppice("export", room, "--tree", TREE, "--format", "dtcontrol", "-o", tmp_path / "policy.csv")
    observed, described, chosen, _, names = loading.CSVDatasetLoader()._load_dataset(str(tmp_path / "policy.csv"))
    features, rows = states(room, TREE)
    assert len(described["variables"]) == len(features)
    actions = ["move", "turn_left", "turn_right"]
    theirs = {tuple(int(v) for v in row): actions[names[int(c[0])]] for row, c in zip(observed, chosen)}
    assert theirs == {tuple(int(row[n]) for n in features): row["policy_action"] for row in rows}


def test_latex_draws_every_tree(room: Path, tmp_path: Path) -> None:
    pdflatex = shutil.which("pdflatex")
    found = shutil.which("kpsewhich") and subprocess.run(["kpsewhich", "forest.sty"], capture_output=True).returncode == 0
    if pdflatex is None or not found:
        pytest.skip("no pdflatex with the package forest")
    draw = random.Random(32)
    grid = tmp_path / "odd.coppice"
    # Names and words that TeX would take for its own.
    log = tmp_path / "odd.jsonl"
    log.write_text(
        '{"format":"coppice-log-1","features":[{"name":"p_q","label":"50 % of $x_1$ & {more}","unit":"m^2~#"}],'
        '"actions":[{"name":"go_on","label":"go \\\\textbf{on} <now>"},{"name":"stop"}],"discount":0.9}\n'
        '{"episode":0,"observation":[0.25],"action":0,"reward":1,"next_observation":[1.5]}\n'
        '{"episode":0,"observation":[1.5],"action":1,"reward":0,"next_observation":[0.25],"truncated":true}\n'
    )
    coppice("import", log, "-o", grid)
    values = ["0.25", "1.5"]
    trees = [(room, tree) for tree in [TREE, *room_trees(3, seed=32)]]
    trees += [(grid, random_tree(draw, {"p_q": values}, ["go_on", "stop"], 3)) for _ in range(2)]
    trees.append((grid, "(selector (sequence p_q=0.25 go_on) stop)"))
    for number, (study, tree) in enumerate(trees):
        source = tmp_path / f"tree_{number}.tex"
        exported(study, tree, "tikz", source, "--as-given")
        done = subprocess.run(
            [pdflatex, "-interaction=nonstopmode", "-halt-on-error", source.name],
            cwd=tmp_path, capture_output=True, text=True, timeout=120,
        )
        assert done.returncode == 0, (tree, done.stdout[-1500:])
        assert "Missing character" not in source.with_suffix(".log").read_text(errors="replace"), tree
        assert source.with_suffix(".pdf").stat().st_size > 1000
