"""Against the real program where COPPICE names it."""

import os
import sqlite3
import subprocess
from pathlib import Path

import numpy as np
import pytest

import coppice

PROGRAM = os.environ.get("COPPICE")


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    if not PROGRAM:
        pytest.skip("COPPICE does not name the program")
    study = tmp_path_factory.mktemp("study") / "grid.coppice"

    def run(*arguments: object) -> None:
        subprocess.run([PROGRAM, *map(str, arguments)], check=True, capture_output=True, timeout=300)

    run("learn", "--world", "windy", "-o", study, "--episodes", 2000)
    run("evolve", study, "--serial", "--seed", 3, "--set", "ga.generations=20")
    return study


def test_it_reads_runs_generations_and_trees(path: Path) -> None:
    study = coppice.Study(path)
    assert study.world == "windy" and len(study.chain_hash) == 32
    (run,) = study.runs()
    assert run.status == "finished" and run.seed == 3 and run.tree is not None
    generations = study.generations()
    assert list(generations["generation"]) == list(range(len(generations["generation"])))
    assert generations["best_fitness"].dtype == np.float64 and generations["best_nodes"].dtype.kind == "i"
    assert study.tree()({"x": 0, "y": 3}) in ("up", "down", "left", "right", None)
    front = study.front()
    assert all(len(values) == len(front) and values.dtype == np.float64 for values in front.measures.values())
    assert all(coppice.Tree.parse(tree) for tree in front.trees)
    with pytest.raises(coppice.CoppiceError, match="has no run 7"):
        study.run(7)


def test_it_writes_nothing(path: Path) -> None:
    before = path.read_bytes()
    coppice.Study(path).generations()
    assert path.read_bytes() == before
    assert [p.name for p in path.parent.iterdir()] == [path.name]


def test_what_is_no_study_is_refused_by_name(tmp_path: Path) -> None:
    with pytest.raises(coppice.CoppiceError, match="no such file"):
        coppice.Study(tmp_path / "none")
    (tmp_path / "text").write_text("hello" * 300)
    with pytest.raises(coppice.CoppiceError, match="not a study"):
        coppice.Study(tmp_path / "text")
    other = sqlite3.connect(tmp_path / "other")
    other.execute("CREATE TABLE t(x)")
    other.close()
    with pytest.raises(coppice.CoppiceError, match="some other program"):
        coppice.Study(tmp_path / "other")
