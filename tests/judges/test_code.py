"""The C++ header, the Python function, py_trees and coppice.Tree, run over every state of a study."""

from __future__ import annotations

import importlib.util
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest

from judging import exported, room_trees, states


def imported(path: Path) -> Any:
    spec = importlib.util.spec_from_file_location(path.stem, path)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_python_function_returns_what_the_tree_does(room: Path, tmp_path: Path) -> None:
    for number, text in enumerate(room_trees(100, seed=11)):
        names, rows = states(room, text)
        path = tmp_path / f"policy_{number}.py"
        exported(room, text, "python", path)
        action = imported(path).action
        for row in rows:
            assert (action({n: int(row[n]) for n in names}) or "") == row["tree_action"], (text, row)


def test_the_cpp_header_compiles_without_warnings_and_returns_what_the_tree_does(room: Path, tmp_path: Path) -> None:
    compiler = shutil.which("c++") or shutil.which("g++")
    if compiler is None:
        pytest.skip("no C++ compiler")
    for number, text in enumerate(room_trees(12, seed=12)):
        names, rows = states(room, text)
        exported(room, text, "cpp", tmp_path / "policy.hpp")
        reads = " >> ".join(f"o.{name}" for name in names)
        (tmp_path / "main.cpp").write_text(
            '#include "policy.hpp"\n#include <iostream>\n'
            "static_assert(noexcept(policy::action(policy::Observation{})));\n"
            "constexpr policy::Action kAtCompileTime = policy::action(policy::Observation{});\n"
            "int main() { policy::Observation o; (void)kAtCompileTime;\n"
            f"  while (std::cin >> {reads}) std::cout << policy::name_of(policy::action(o)) << '\\n'; }}\n"
        )
        program = tmp_path / f"main_{number}"
        subprocess.run(
            [compiler, "-std=c++17", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Werror",
             "-o", program, tmp_path / "main.cpp"],
            check=True,
        )
        states_text = "\n".join(" ".join(row[n] for n in names) for row in rows)
        out = subprocess.run([program], input=states_text, capture_output=True, text=True, check=True).stdout
        assert out.split("\n")[: len(rows)] == [row["tree_action"] for row in rows], text


@pytest.mark.parametrize("flags", [(), ("--as-given",)], ids=["guarded", "as_given"])
def test_py_trees_ticks_to_the_same_action(room: Path, tmp_path: Path, flags: tuple[str, ...]) -> None:
    pytest.importorskip("py_trees", reason="py_trees is not installed")
    for number, text in enumerate(room_trees(25, seed=13)):
        names, rows = states(room, text)
        path = tmp_path / f"tree_{number}.py"
        exported(room, text, "py-trees", path, *flags)
        policy = imported(path).Policy()
        for row in rows[::9] + rows[::-13]:
            action = policy.action({n: int(row[n]) for n in names})
            assert (action or "") == row["tree_action"], (text, row)


def test_the_python_package_acts_by_json_and_by_text(room: Path, tmp_path: Path) -> None:
    coppice = pytest.importorskip("coppice", reason="deploy/python is not installed")
    for text in room_trees(50, seed=14):
        names, rows = states(room, text)
        exported(room, text, "json", tmp_path / "t.json", "--as-given")
        exported(room, text, "text", tmp_path / "t.tree")
        from_json = coppice.Tree.load(tmp_path / "t.json")
        from_text = coppice.Tree.load(tmp_path / "t.tree")
        assert from_json.features == names
        for row in rows[::5]:
            values = [int(row[n]) for n in names]
            assert (from_json(values) or "") == row["tree_action"], (text, row)
            assert (from_text(dict(zip(names, values))) or "") == row["tree_action"], (text, row)
