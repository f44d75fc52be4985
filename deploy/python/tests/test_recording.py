import json
from pathlib import Path

import gymnasium
import numpy as np
import pytest

import coppice
import environments


def lines(path: Path) -> list[dict]:  # type: ignore[type-arg]
    return [json.loads(line) for line in path.read_text().splitlines()]


def test_a_log_names_the_problem_first_and_has_a_line_a_step(tmp_path: Path) -> None:
    env = gymnasium.make("CartPole-v1")
    steps = coppice.record(env, lambda o: int(o[2] > 0), 3, tmp_path / "log", seed=5, discount=0.99)
    head, *rest = lines(tmp_path / "log")
    assert head["format"] == "coppice-log-1" and head["title"] == "CartPole-v1" and head["discount"] == 0.99
    assert [f["name"] for f in head["features"]] == ["cart_position", "cart_velocity", "pole_angle", "pole_velocity"]
    assert head["features"][2]["unit"] == "rad" and head["actions"] == ["left", "right"]
    assert len(rest) == steps and {line["episode"] for line in rest} == {0, 1, 2}
    for before, after in zip(rest, rest[1:]):
        if before["episode"] == after["episode"]:
            assert after["step"] == before["step"] + 1 and after["observation"] == before["next_observation"]
            assert not before["terminated"] and not before["truncated"]
        else:
            assert before["terminated"]


def test_the_same_seed_writes_the_same_file_and_another_seed_another(tmp_path: Path) -> None:
    env = gymnasium.make("CartPole-v1")
    for name, seed in (("a", 1), ("b", 1), ("c", 2)):
        coppice.record(env, lambda o: 0, 5, tmp_path / name, seed=seed, exploration=0.5)
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes() != (tmp_path / "c").read_bytes()


class Tensor:
    """What a torch module gives, as far as it matters: no array until it is detached."""

    def __init__(self, values: list[float]) -> None:
        self.values = values

    def detach(self) -> "Tensor":
        return self

    def cpu(self) -> "Tensor":
        return self

    def numpy(self) -> np.ndarray:  # type: ignore[type-arg]
        return np.array(self.values, np.float32)

    def __array__(self, *_: object) -> np.ndarray:  # type: ignore[type-arg]
        raise RuntimeError("can't call numpy() on a tensor that requires grad")


class Fitted:
    """A fitted scikit-learn classifier, as far as it matters: rows in, a label a row out."""

    n_features_in_ = 4

    def predict(self, rows: np.ndarray) -> np.ndarray:  # type: ignore[type-arg]
        assert rows.ndim == 2
        return (rows[:, 2] > 0).astype(np.int64)


class Agent:
    """A model of stable-baselines3: an observation in, the action and a state out."""

    def predict(self, observation: np.ndarray) -> tuple[np.ndarray, None]:  # type: ignore[type-arg]
        return np.array(int(observation[2] > 0)), None


def test_models_and_scores_do_as_policies(tmp_path: Path) -> None:
    env = gymnasium.make("CartPole-v1")
    policies = {
        "plain": lambda o: int(o[2] > 0),
        "scores": lambda o: np.array([0.0, o[2]]),
        "tensor": lambda o: Tensor([0.0, float(o[2])]),
        "fitted": Fitted(),
        "agent": Agent(),
    }
    for name, policy in policies.items():
        coppice.record(env, policy, 3, tmp_path / name, seed=4)
    assert len({(tmp_path / name).read_bytes() for name in policies}) == 1
    with pytest.raises(coppice.CoppiceError, match="or 2 scores"):
        coppice.record(env, lambda o: [0.1, 0.2, 0.3], 1, tmp_path / "log")
    with pytest.raises(coppice.CoppiceError, match="or a model with predict"):
        coppice.record(env, 3, 1, tmp_path / "log")


def test_a_cut_episode_is_truncated_and_an_ended_one_terminated(tmp_path: Path) -> None:
    coppice.record(environments.Corridor(), lambda o: 1, 2, tmp_path / "ends", steps=50)
    assert [line["terminated"] for line in lines(tmp_path / "ends")[1:] if line["next_observation"] == [4.0]] == [True] * 2
    coppice.record(environments.Corridor(), lambda o: 0, 1, tmp_path / "cut", steps=3)
    last = lines(tmp_path / "cut")[-1]
    assert last["step"] == 2 and last["truncated"] and not last["terminated"]


def test_dictionaries_are_laid_flat_by_sorted_key(tmp_path: Path) -> None:
    problem = coppice.problem_of(environments.Mixed())
    assert problem.feature_names == ["flags_0", "flags_1", "gear", "pose_0", "pose_1"]
    assert problem.decode(environments.Mixed().reset()[0]) == [1.0, 0.0, 2.0, 0.5, -0.5]


def test_tuples_are_numbered_parts_of_x() -> None:
    space = gymnasium.spaces
    env = environments.Mixed()
    env.observation_space = space.Tuple((space.Box(0, 9, (2,)), space.Tuple((space.Discrete(2), space.MultiDiscrete([3, 3])))))
    assert coppice.problem_of(env).feature_names == ["x_0_0", "x_0_1", "x_1_0", "x_1_1_0", "x_1_1_1"]
    tree = coppice.Tree.parse("(sequence x_1_1_0<=1 go)")
    assert tree({"x_1_1_0": 1}) == "go"


def test_what_cannot_be_recorded_is_refused_and_leaves_no_file(tmp_path: Path) -> None:
    with pytest.raises(coppice.CoppiceError, match="not finite"):
        coppice.record(environments.Mixed(), lambda o: 0, 1, tmp_path / "log")
    with pytest.raises(coppice.CoppiceError, match="the policy chose 7"):
        coppice.record(environments.Corridor(), lambda o: 7, 1, tmp_path / "log")
    with pytest.raises(coppice.CoppiceError, match="expected a Discrete, MultiDiscrete"):
        coppice.record(gymnasium.make("Pendulum-v1"), lambda o: 0, 1, tmp_path / "log")
    with pytest.raises(coppice.CoppiceError, match="expected names that differ"):
        coppice.record(environments.Corridor(), lambda o: 0, 1, tmp_path / "log", actions=["a", "a"])
    assert list(tmp_path.iterdir()) == []


def test_an_action_with_parts_is_one_action_a_combination(tmp_path: Path) -> None:
    env = environments.Crane()
    assert coppice.problem_of(env).actions == ["a_0_1", "a_0_2", "a_1_1", "a_1_2", "a_2_1", "a_2_2"]
    problem = coppice.problem_of(env, actions=["drive", "hook"])
    assert problem.actions[4:] == ["drive_2_hook_1", "drive_2_hook_2"]
    for number in range(6):
        assert env.action_space.contains(problem.to_env(number))
        assert problem.from_env(problem.to_env(number)) == number
    right, down = np.array([2, 1]), np.array([1, 2])
    for policy in (
        lambda o: down if o == 3 else right,  # as the environment takes it
        lambda o: (1, 2) if o == 3 else (2, 1),
        lambda o: (down if o == 3 else right, None),  # as predict() gives it
        lambda o: 3 if o == 3 else 4,  # the number of the combination
    ):
        assert coppice.record(env, policy, 1, tmp_path / "log", actions=["drive", "hook"]) == 4
        steps = lines(tmp_path / "log")
        assert steps[0]["actions"] == problem.actions
        assert [step["action"] for step in steps[1:]] == [4, 4, 4, 3] and steps[-1]["terminated"]
    with pytest.raises(coppice.CoppiceError, match="the policy chose"):
        coppice.record(env, lambda o: [3, 1], 1, tmp_path / "none")


def test_bits_are_parts_and_too_many_combinations_are_refused() -> None:
    env = environments.Crane()
    env.action_space = gymnasium.spaces.MultiBinary(3)
    problem = coppice.problem_of(env, actions=["a", "b", "c"])
    assert len(problem.actions) == 8 and problem.actions[5] == "a_1_b_0_c_1"
    assert problem.to_env(5).tolist() == [1, 0, 1]
    env.action_space = gymnasium.spaces.MultiDiscrete([16, 16])
    with pytest.raises(coppice.CoppiceError, match="256 combinations: expected at most 254"):
        coppice.problem_of(env)


def test_tables_hold_what_the_environment_holds(tmp_path: Path) -> None:
    env = gymnasium.make("Taxi-v4" if "Taxi-v4" in gymnasium.registry else "Taxi-v3")
    assert coppice.tables(env, tmp_path / "taxi.json", discount=0.9) == 500
    table = json.loads((tmp_path / "taxi.json").read_text())
    assert table["format"] == "coppice-tables-1"
    assert [f["name"] for f in table["features"]] == ["row", "column", "passenger", "destination"]
    assert abs(sum(table["initial"]) - 1.0) < 1e-9 and sum(p > 0 for p in table["initial"]) == 300
    for state in (0, 123, 499):
        row, column, passenger, destination = table["observations"][state]
        assert env.unwrapped.encode(row, column, passenger, destination) == state
        for action in range(6):
            assert table["P"][state][action] == [
                [float(p), int(n), float(r), bool(t)] for p, n, r, t in env.unwrapped.P[state][action]
            ]
    with pytest.raises(coppice.CoppiceError, match="no transition table"):
        coppice.tables(gymnasium.make("CartPole-v1"), tmp_path / "cart.json")


def test_a_minari_data_set_becomes_a_log(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    minari = pytest.importorskip("minari")
    pytest.importorskip("h5py")
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(tmp_path / "sets"))
    pytest.importorskip("PIL")
    from minari.data_collector.episode_buffer import EpisodeBuffer

    env = gymnasium.make("CartPole-v1")
    buffers = []
    for seed in range(3):
        observation, _ = env.reset(seed=seed)
        episode: dict[str, list] = {k: [] for k in ("actions", "rewards", "terminations", "truncations")}  # type: ignore[type-arg]
        observations = [observation]
        ended = False
        while not ended:
            observation, reward, terminated, truncated, _ = env.step(0)
            observations.append(observation)
            for key, value in zip(episode, (0, reward, terminated, truncated)):
                episode[key].append(value)
            ended = terminated or truncated
        buffers.append(EpisodeBuffer(id=seed, observations=np.array(observations), **{k: np.array(v) for k, v in episode.items()}))
    dataset = minari.create_dataset_from_buffers(
        "cartpole/always-left-v0", buffers, env=env, algorithm_name="left", author="a", author_email="a@example.org",
        code_permalink="none")
    steps = coppice.from_minari(dataset, tmp_path / "log")
    head, *rest = lines(tmp_path / "log")
    assert head["title"] == "CartPole-v1" and head["features"][0]["name"] == "cart_position"
    assert len(rest) == steps == dataset.total_steps
    assert sum(line["terminated"] for line in rest) == 3
    assert all(line["action"] == 0 and len(line["observation"]) == 4 for line in rest)
