"""A behaviour tree, as `coppice export --format json` writes it (or its text form), that acts."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from coppice.errors import CoppiceError
from coppice.spaces import flat, named

MAX_NODES = 4096
MAX_DEPTH = 64  # edges from the root


@dataclass(frozen=True)
class Node:
    """kind: "sequence", "selector" (with children), "condition" (feature, op, value) or "action" (action)."""

    kind: str
    children: tuple[Node, ...] = ()
    feature: str = ""
    op: str = ""
    value: float = 0.0
    action: str = ""


class Tree:
    """Acts: tree(observation) is the action's name, or None. `actions` and `features` are the study's, in order, where the
    file says them; then tree.index(observation) is the action's number and an observation may be a plain array."""

    def __init__(self, root: Node, features: Sequence[str] = (), actions: Sequence[str] = ()) -> None:
        self.root = root
        self.features = list(features)
        self.actions = list(actions)
        self.text = to_text(root)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Tree:
        """Reads a file of JSON or of the text form."""
        content = Path(path).read_text(encoding="utf-8")
        try:
            return cls.parse(content)
        except CoppiceError as error:
            raise CoppiceError(f"{os.fspath(path)}: {error}") from None

    @classmethod
    def parse(cls, content: str) -> Tree:
        """The same for what a file holds."""
        if content.lstrip().startswith("{"):
            try:
                document = json.loads(content)
            except (json.JSONDecodeError, RecursionError) as error:
                raise CoppiceError(f"not JSON: {error}") from None
            root = _node_of_json(document.get("tree", document), "tree", 0)
            return cls(
                root,
                [str(f["name"]) for f in document.get("features", [])],
                [str(a["name"]) for a in document.get("actions", [])],
            )
        lines = [line for line in content.splitlines() if line.strip() and not line.lstrip().startswith("#")]
        if len(lines) != 1:
            raise CoppiceError(f"holds {len(lines)} trees: expected one")
        return cls(_node_of_text(lines[0]))

    def __call__(self, observation: Any) -> str | None:
        """The action's name, or None where the tree does not act. observation: a mapping from feature names to values, or,
        where the file names the features, their values in order; what an environment with a Dict or Tuple space gives
        will do too."""
        return self._act(self._mapping(observation))

    def index(self, observation: Any) -> int | None:
        """The action's number, for env.step(). Needs a file that names the actions, as JSON does."""
        action = self(observation)
        if action is None:
            return None
        if action not in self.actions:
            raise CoppiceError(f"nothing says which number action '{action}' has: load the tree as JSON")
        return self.actions.index(action)

    def __len__(self) -> int:
        """Nodes."""
        return _count(self.root)

    def __repr__(self) -> str:
        return f"Tree({self.text!r})"

    def _mapping(self, observation: Any) -> Mapping[str, float]:
        if isinstance(observation, Mapping):
            if not self.features or all(name in observation for name in self.features):
                return observation
            laid_flat = named(observation)  # as an environment with a Dict space gives it
            if any(name in laid_flat for name in self.features) or len(laid_flat) != len(self.features):
                return laid_flat
        values = flat(observation)
        if len(values) != len(self.features):
            raise CoppiceError(
                f"an observation of {len(values)} numbers: expected a mapping from names, or the values of "
                f"{', '.join(self.features) or 'named features (load the tree as JSON)'}; "
                "coppice.problem_of(env).decode(observation) gives them for any environment"
            )
        return dict(zip(self.features, values))

    def _act(self, observation: Mapping[str, float]) -> str | None:
        written: str | None = None

        def tick(node: Node) -> bool:
            nonlocal written
            if node.kind == "condition":
                try:
                    reading = observation[node.feature]
                except KeyError:
                    raise CoppiceError(f"the observation has no '{node.feature}'") from None
                return bool(reading == node.value) if node.op == "=" else bool(reading <= node.value)
            if node.kind == "action":
                written = node.action
                return True
            if node.kind == "sequence":
                return all(tick(child) for child in node.children)
            return any(tick(child) for child in node.children)

        tick(self.root)
        return written


def to_text(node: Node) -> str:
    """The text form."""
    if node.kind == "condition":
        return f"{node.feature}{node.op}{_number_text(node.value)}"
    if node.kind == "action":
        return node.action
    return f"({node.kind} {' '.join(to_text(child) for child in node.children)})"


def _number_text(value: float) -> str:
    return str(int(value)) if value.is_integer() and abs(value) < 1e15 else repr(value)


def _count(node: Node) -> int:
    return 1 + sum(_count(child) for child in node.children)


def _node_of_json(json_node: Any, where: str, depth: int) -> Node:
    if depth > MAX_DEPTH:
        raise CoppiceError(f"{where}: deeper than {MAX_DEPTH} edges")
    kind = json_node.get("type") if isinstance(json_node, dict) else None
    if kind in ("sequence", "selector"):
        children = json_node.get("children")
        if not isinstance(children, list) or not children:
            raise CoppiceError(f"{where}.children: expected a list of one node or more")
        return Node(
            kind,
            tuple(_node_of_json(child, f"{where}.children[{i}]", depth + 1) for i, child in enumerate(children)),
        )
    if kind == "condition":
        op, value = json_node.get("op"), json_node.get("value")
        if op not in ("=", "<="):
            raise CoppiceError(f"{where}.op: found {op!r}: expected = or <=")
        try:
            return Node(kind, feature=str(json_node["feature"]), op=op, value=float(value))
        except (KeyError, TypeError, ValueError):
            raise CoppiceError(f"{where}: found {json_node!r}: expected a feature and a number") from None
    if kind == "action" and isinstance(json_node.get("action"), str):
        return Node(kind, action=json_node["action"])
    raise CoppiceError(f"{where}: found {str(json_node)[:100]}: expected a sequence, selector, condition or action")


_TOKEN = re.compile(r"\s*([()]|[^\s()]+)")
_CONDITION = re.compile(r"([A-Za-z_][A-Za-z0-9_]*)(<=|=)(\S+)")


def _node_of_text(line: str) -> Node:
    open_nodes: list[tuple[str, list[Node]]] = []
    done: Node | None = None
    at = 0
    count = 0
    line = line.rstrip()
    while at < len(line):
        match = _TOKEN.match(line, at)
        if match is None or done is not None:
            raise CoppiceError(f"column {at + 1}: expected the end")
        token, column = match.group(1), match.start(1) + 1
        at = match.end()
        node: Node | None = None
        if token == "(":
            kind = _TOKEN.match(line, at)
            if kind is None or kind.group(1) not in ("sequence", "selector"):
                raise CoppiceError(f"column {column}: expected sequence or selector after '('")
            if len(open_nodes) > MAX_DEPTH:
                raise CoppiceError(f"column {column}: deeper than {MAX_DEPTH} edges")
            open_nodes.append((kind.group(1), []))
            at = kind.end()
            continue
        if token == ")":
            if not open_nodes or not open_nodes[-1][1]:
                raise CoppiceError(f"column {column}: expected a node before ')'")
            kind_name, children = open_nodes.pop()
            node = Node(kind_name, tuple(children))
        else:
            condition = _CONDITION.fullmatch(token)
            try:
                node = (
                    Node("condition", feature=condition[1], op=condition[2], value=float(condition[3]))
                    if condition
                    else Node("action", action=token)
                )
            except ValueError:
                raise CoppiceError(f"column {column}: found {token!r}: expected a number after {token[:40]!r}") from None
        count += 1
        if count > MAX_NODES:
            raise CoppiceError(f"column {column}: more than {MAX_NODES} nodes")
        if open_nodes:
            open_nodes[-1][1].append(node)
        else:
            done = node
    if done is None:
        raise CoppiceError("the tree is not complete: expected ')'" if open_nodes else "empty: expected a tree")
    return done
