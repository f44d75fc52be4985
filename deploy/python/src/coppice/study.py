"""Reads a study, the one SQLite file of a problem, its chain and its runs, into arrays. Nothing is written to it."""

from __future__ import annotations

import json
import os
import sqlite3
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import quote

import numpy as np
import numpy.typing as npt

from coppice.errors import CoppiceError
from coppice.tree import Tree

APPLICATION_ID = 0x436F7070
OLDEST_SCHEMA = 3

Columns = dict[str, npt.NDArray[Any]]


@dataclass(frozen=True)
class Run:
    """One run of evolution. tree, pruned: text, None while there is none."""

    id: int
    seed: int
    status: str
    started: str
    ended: str | None
    config: dict[str, Any]
    evaluator: str
    tree: str | None
    pruned: str | None
    result: dict[str, Any]


@dataclass(frozen=True)
class Front:
    """The trees of a run's front, small ones first. measures: an array for each, parallel to trees."""

    trees: list[str]
    measures: dict[str, npt.NDArray[np.float64]]

    def __len__(self) -> int:
        return len(self.trees)


class Study:
    """What a study file holds. The file may be in use meanwhile; each call sees one moment of it."""

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = Path(path)
        if not self.path.is_file():
            raise CoppiceError(f"{self.path}: no such file: expected a study")
        with self._open() as database:
            try:
                application = database.execute("PRAGMA application_id").fetchone()[0]
                self.schema: int = database.execute("PRAGMA user_version").fetchone()[0]
            except sqlite3.DatabaseError as error:
                raise CoppiceError(f"{self.path}: not a study: {error}") from None
            if application != APPLICATION_ID:
                raise CoppiceError(f"{self.path}: an SQLite database of some other program: expected a study")
            if self.schema < OLDEST_SCHEMA:
                raise CoppiceError(f"{self.path}: schema {self.schema}: expected {OLDEST_SCHEMA} or later")
            row = _rows(database, "SELECT * FROM study")[0]
        self.created = str(row["created"])
        self.chain_hash = str(row["chain_hash"])
        self.world = str(row["world_kind"])
        self.learning: dict[str, Any] = json.loads(row["learn_settings"])
        self.learned: dict[str, Any] = json.loads(row["learn_outcome"])
        self.problem: dict[str, Any] = json.loads(row.get("problem") or "{}")

    def runs(self) -> list[Run]:
        """By number."""
        with self._open() as database:
            rows = _rows(database, "SELECT * FROM runs ORDER BY id")
        return [
            Run(
                id=row["id"],
                seed=int(row["seed"]),
                status=row["status"],
                started=row["started"],
                ended=row["ended"],
                config=json.loads(row["config"]),
                evaluator=row["evaluator"],
                tree=row["tree"],
                pruned=row["pruned"],
                result=json.loads(row["result"]),
            )
            for row in rows
        ]

    def run(self, number: int | None = None) -> Run:
        """That run; without a number the last that has finished, else the last."""
        runs = self.runs()
        if not runs:
            raise CoppiceError(f"{self.path}: has no run yet: expected 'coppice evolve' first")
        if number is None:
            return next((run for run in reversed(runs) if run.status == "finished"), runs[-1])
        for run in runs:
            if run.id == number:
                return run
        raise CoppiceError(f"{self.path}: has no run {number}: expected one of {', '.join(str(r.id) for r in runs)}")

    def generations(self, number: int | None = None) -> Columns:
        """The statistics of a run's generations, a column a name: generation, best_fitness, best_agreement, best_nodes,
        mean_fitness, mean_agreement, mean_nodes, distinct_trees, evaluations, seconds and best_tree (text)."""
        run = self.run(number).id
        with self._open() as database:
            cursor = database.execute("SELECT * FROM generations WHERE run = ? ORDER BY generation", (run,))
            names = [column[0] for column in cursor.description]
            rows = cursor.fetchall()
        columns = list(zip(*rows)) if rows else [()] * len(names)
        return {name: np.array(column) for name, column in zip(names, columns) if name != "run"}

    def front(self, number: int | None = None) -> Front:
        """A run's front; without members where it has none."""
        run = self.run(number).id
        with self._open() as database:
            rows = _rows(database, "SELECT * FROM fronts WHERE run = ? ORDER BY position", (run,))
        measures = [json.loads(row["measures"]) for row in rows]
        names = list(measures[0]) if measures else []
        return Front(
            [row["tree"] for row in rows],
            {name: np.array([each[name] for each in measures], dtype=np.float64) for name in names},
        )

    def tree(self, number: int | None = None, *, pruned: bool = True) -> Tree:
        """A run's tree, as it was pruned on the chain, or as it was evolved. It acts on mappings from feature names."""
        run = self.run(number)
        text = (run.pruned or run.tree) if pruned else run.tree
        if text is None:
            raise CoppiceError(f"{self.path}: run {run.id} has no tree yet")
        return Tree.parse(text)

    @contextmanager
    def _open(self) -> Iterator[sqlite3.Connection]:
        database = sqlite3.connect(f"file:{quote(str(self.path.absolute()))}?mode=ro", uri=True, timeout=10.0)
        try:
            yield database
        finally:
            database.close()


def _rows(database: sqlite3.Connection, query: str, values: tuple[Any, ...] = ()) -> list[dict[str, Any]]:
    cursor = database.execute(query, values)
    names = [column[0] for column in cursor.description]
    return [dict(zip(names, row)) for row in cursor.fetchall()]
