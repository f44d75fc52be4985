#!/usr/bin/python3
"""From a policy for a continuous problem of Gymnasium to a small tree, and what that earns in the real environment: records the
policy, imports the log, evolves, exports, and plays 100 fresh episodes with each. Prints a line of Markdown a problem.

    pip install ./deploy/python 'gymnasium[classic-control]' Box2D      # the last for LunarLander
    tests/bench/continuous.py CartPole-v1 --tests 2
    tests/bench/continuous.py MountainCar-v0 --tests 3
    tests/bench/continuous.py Acrobot-v1 --tests 3
    tests/bench/continuous.py LunarLander-v3 --tests 46

The policies: CartPole's and Acrobot's are linear rules written by hand; MountainCar's is value iteration on a grid; LunarLander's is the
heuristic that comes with Gymnasium.
"""
import argparse
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
import types

import gymnasium
import numpy

import coppice as package


def cart_pole(o):
    return int(o[2] + 0.3 * o[3] + 0.05 * o[1] + 0.02 * o[0] > 0)


class MountainCar:
    """Value iteration on a grid, values interpolated between its points; the equations are Gymnasium's."""

    def __init__(self, points=(151, 121), sweeps=400):
        self.low, self.high, self.points = numpy.array([-1.2, -0.07]), numpy.array([0.6, 0.07]), numpy.array(points)
        axes = [numpy.linspace(self.low[i], self.high[i], points[i]) for i in range(2)]
        x, v = numpy.meshgrid(*axes, indexing="ij")
        self.values = numpy.zeros(points)
        for _ in range(sweeps):
            self.values = numpy.max([self.after(x, v, action) for action in range(3)], axis=0)

    def after(self, x, v, action):
        v = numpy.clip(v + (action - 1) * 0.001 - numpy.cos(3 * x) * 0.0025, -0.07, 0.07)
        x = numpy.clip(x + v, -1.2, 0.6)
        v = numpy.where((x <= -1.2) & (v < 0), 0.0, v)
        place = [numpy.clip((value - self.low[i]) / (self.high[i] - self.low[i]) * (self.points[i] - 1), 0, self.points[i] - 1.000001)
                 for i, value in enumerate((x, v))]
        i, j = (numpy.floor(p).astype(int) for p in place)
        a, b = place[0] - i, place[1] - j
        value = ((1 - a) * (1 - b) * self.values[i, j] + a * (1 - b) * self.values[i + 1, j] + (1 - a) * b * self.values[i, j + 1]
                 + a * b * self.values[i + 1, j + 1])
        return numpy.where(x >= 0.5, -1.0, -1.0 + value)

    def __call__(self, o):
        return int(numpy.argmax([self.after(numpy.float64(o[0]), numpy.float64(o[1]), action) for action in range(3)]))


def acrobot(o):
    return 2 if o[5] - o[4] > 0 else 0


def lunar_lander(o):
    from gymnasium.envs.box2d.lunar_lander import heuristic
    discrete = types.SimpleNamespace(unwrapped=types.SimpleNamespace(continuous=False))
    return heuristic(discrete, o)


# policy, episodes recorded, share of random actions, steps of an episode, settings of the evolution
PROBLEMS = {
    "CartPole-v1": (cart_pole, 200, 0.2, 500, []),
    "MountainCar-v0": (MountainCar, 300, 0.1, 200, []),
    "Acrobot-v1": (acrobot, 200, 0.1, 500, []),
    "LunarLander-v3": (lunar_lander, 300, 0.05, 1000, []),
}
FRESH = 1_000_000  # where the seeds of the fresh episodes begin


def play(name, act, episodes):
    env = gymnasium.make(name)
    rewards = []
    for episode in range(episodes):
        observation, _ = env.reset(seed=FRESH + episode)
        total, ended = 0.0, False
        while not ended:
            observation, reward, terminated, truncated, _ = env.step(act(observation))
            total += reward
            ended = terminated or truncated
        rewards.append(total)
    return rewards


def mean(rewards):
    return f"{statistics.mean(rewards):.1f} +- {1.96 * statistics.stdev(rewards) / len(rewards) ** 0.5:.1f}"


def run(arguments):
    done = subprocess.run([str(word) for word in arguments], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(str(word) for word in arguments)}: {done.stderr.strip()}")
    return done.stdout


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("problem", choices=PROBLEMS)
    parser.add_argument("--tests", type=int, required=True)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--problem-file", metavar="FILE.toml", help="of coppice import, for bins of your own")
    parser.add_argument("--discount", default="0.99")
    parser.add_argument("--config", default="best")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE")
    parser.add_argument("--policy-only", action="store_true")
    parser.add_argument("--coppice", default="build/release/bin/coppice", metavar="PROGRAM")
    options = parser.parse_args()
    policy, episodes, exploration, steps, settings = PROBLEMS[options.problem]
    policy = policy() if isinstance(policy, type) else policy
    of_policy = mean(play(options.problem, policy, 100))
    if options.policy_only:
        print(f"{options.problem}: the policy earns {of_policy}", flush=True)
        return
    begin = time.monotonic()
    with tempfile.TemporaryDirectory() as folder:
        log, study, exported = (os.path.join(folder, name) for name in ("log.jsonl", "study.coppice", "tree.json"))
        env = gymnasium.make(options.problem)
        package.record(env, policy, episodes, log, exploration=exploration)
        recorded = time.monotonic()
        problem_file = ["--problem", options.problem_file] if options.problem_file else []
        run([options.coppice, "import", log, "-o", study, "--gamma", options.discount, "--simulator",
             f"{sys.executable} -m coppice.gym {options.problem}"] + problem_file)
        words = [word for setting in settings + options.set for word in ("--set", setting)]
        answer = json.loads(run([options.coppice, "evolve", study, "--serial", "--json", "--config", options.config, "--seed", options.seed,
                                 "--set", f"ga.max_conditions={options.tests}", "--set", f"ga.max_nodes={4 * options.tests + 1}",
                                 "--set", f"front.max_nodes={4 * options.tests + 1}", "--set", f"rollout.steps={steps}"] + words))
        run([options.coppice, "export", study, "-o", exported])
        seconds = time.monotonic() - begin
        tree = package.Tree.load(exported)
        rewards = play(options.problem, lambda observation: tree.index(numpy.asarray(observation)) or 0, 100)
        conditions = tree.text.count("=")
        print(f"| {options.problem} | {of_policy} | {mean(rewards)} | {conditions} | {answer['nodes']} | {seconds:.0f} "
              f"(recording {recorded - begin:.0f}) | `{tree.text}` |", flush=True)


if __name__ == "__main__":
    main()
