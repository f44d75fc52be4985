import io
import json
import subprocess
import sys
from pathlib import Path

import pytest

import coppice
import environments

HERE = Path(__file__).parent


def talk(make, requests: list[str], **settings):  # type: ignore[no-untyped-def]
    out = io.StringIO()
    coppice.serve(make, source=io.StringIO("".join(r + "\n" for r in requests)), out=out, **settings)
    return [json.loads(line) for line in out.getvalue().splitlines()]


def test_it_says_who_it_is_and_answers_several_episodes_a_line() -> None:
    hello, reset, step, last = talk(
        environments.Corridor,
        [
            '{"id": 1, "reset": [0, 1], "seeds": [3, 4]}',
            '{"id": 2, "step": [0, 1], "actions": [1, 0]}',
            '{"id": 3, "step": [1], "actions": [1]}',
        ],
        episodes=8,
        features=["cell"],
        actions=["left", "right"],
        collides=lambda before, action, reward, after: after == before,
    )
    assert hello == {"coppice_simulator": 1, "features": ["cell"], "actions": ["left", "right"], "episodes": 8,
                     "collisions": True}
    first, second = (int(o[0]) for o in reset["observations"])
    assert reset["id"] == 1 and {first, second} <= {0, 1}
    assert step == {"id": 2, "observations": [[first + 1.0], [max(0.0, second - 1.0)]], "rewards": [0.0, 0.0],
                    "terminated": [False, False], "truncated": [False, False], "collisions": [False, second == 0]}
    assert last["id"] == 3


def test_an_action_with_parts_is_asked_for_by_its_number() -> None:
    hello, first, *answers = talk(
        environments.Crane,
        ['{"id": 0, "reset": [0], "seeds": [1]}']
        + ['{"id": %d, "step": [0], "actions": [%d]}' % (i, a) for i, a in enumerate((4, 4, 4, 3), 1)],
    )
    assert len(hello["actions"]) == 6
    assert [answer["observations"] for answer in answers] == [[[1.0]], [[2.0]], [[3.0]], [[3.0]]]
    assert answers[-1]["terminated"] == [True]


def test_the_same_seed_begins_the_same_episode() -> None:
    answers = talk(environments.Corridor, ['{"id": 1, "reset": [0], "seeds": [%d]}' % seed for seed in (5, 6, 5, 7, 5)])
    observed = [a["observations"] for a in answers[1:]]
    assert observed[0] == observed[2] == observed[4]


def test_what_goes_wrong_is_an_answer_and_the_next_request_is_heard(capsys: pytest.CaptureFixture[str]) -> None:
    answers = talk(
        environments.Broken,
        ["nonsense", '{"id": 1, "fly": 1}', '{"id": 2, "reset": [0], "seeds": [1]}']
        + ['{"id": %d, "step": [0], "actions": [0]}' % i for i in (3, 4, 5, 6)],
    )
    assert "JSONDecodeError" in answers[1]["error"] and answers[1]["id"] is None
    assert "expected reset or step" in answers[2]["error"]
    assert answers[6] == {"id": 5, "error": "RuntimeError: the motor is gone"}
    assert "observations" in answers[7]
    assert "the motor is gone" in capsys.readouterr().err


def test_a_number_that_json_does_not_have_is_an_error_not_a_broken_line() -> None:
    answers = talk(environments.Mixed, ['{"id": 1, "reset": [0], "seeds": [1]}', '{"id": 2, "step": [0], "actions": [0]}'])
    assert answers[2]["id"] == 2 and "not finite" in answers[2]["error"]


def test_the_program_keeps_its_output_for_the_protocol_whatever_the_environment_prints() -> None:
    done = subprocess.run(
        [sys.executable, "-m", "coppice.gym", "Corridor-v0", "--import", "environments"],
        input='{"id": 1, "reset": [0, 5], "seeds": [1, 2]}\n', capture_output=True, text=True, cwd=HERE, timeout=120,
    )
    assert done.returncode == 0, done.stderr
    hello, reset = (json.loads(line) for line in done.stdout.splitlines())
    assert hello["episodes"] == 64 and len(reset["observations"]) == 2
    assert "must not reach the protocol" in done.stderr


def test_the_program_names_an_environment_that_is_not_there() -> None:
    done = subprocess.run([sys.executable, "-m", "coppice.gym", "Nowhere-v0"], capture_output=True, text=True, timeout=120)
    assert done.returncode == 1 and done.stdout == "" and "Nowhere" in done.stderr
