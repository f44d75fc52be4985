#!/usr/bin/python3
"""What closing the loop does (coppice refine), and what other starts of the walks do, to the states that the thesis' tree missed.
Evolves a front with several seeds, refines each answer, and prints medians over the seeds: of the tree in the room and on the
chain, and its agreement in named groups of states, of the study's own chain. What is in the folder already is not run again.

    coppice learn -o uav.coppice
    tests/bench/refine_seeds.py uav.coppice -o refined --seeds 10 --episodes 2 100000
"""
import argparse
import csv
import io
import json
import os
import shutil
import statistics
import subprocess
import sys

SENSORS = [f"s{i}" for i in range(8)]


def trash(row, sensors):
    return any(row[sensor] == "3" for sensor in sensors)


# Thesis VI-F: collect trash on the right, trash ahead before trash aside, turn before a corner.
GROUPS = {
    "trash on the right": lambda r: trash(r, ("s4", "s5", "s6")) and not trash(r, ("s0", "s1", "s2", "s3", "s7")),
    "trash ahead first": lambda r: trash(r, ("s3", "s7")) and trash(r, ("s0", "s1", "s2", "s4", "s5", "s6")),
    "before a corner": lambda r: not trash(r, SENSORS) and r["s3"] == "1" and r["s7"] == "0" and r["policy_action"] != "move",
    "turns in the open": lambda r: not trash(r, SENSORS) and r["s3"] == "1" and r["policy_action"] != "move",
}


def run(arguments, **more):
    done = subprocess.run(arguments, capture_output=True, text=True, **more)
    if done.returncode != 0:
        sys.exit(f"{' '.join(arguments)}: {done.stderr.strip()}")
    return done.stdout


class Measured:
    def __init__(self, options):
        self.options = options

    def figures(self, tree, on_chain=None):
        coppice, study = self.options.coppice, self.options.study
        score = json.loads(run([coppice, "score", study, "--exact", "--json", "--tree", tree]))
        rows = list(csv.DictReader(io.StringIO(run([coppice, "table", study, "--tree", tree]))))
        collisions = json.loads(run([coppice, "evaluate", on_chain or study, "--serial", "--objective", "collisions", "--exact",
                                     "--steps", "150"], input=tree + "\n").splitlines()[0])
        found = {"nodes": score["nodes"]["pruned"],
                 "states %": 100 * score["tree"]["agreement_over_states"],
                 "simulated %": 100 * score["tree"]["agreement"]["mean"],
                 "reward": score["tree"]["reward"]["mean"],
                 "chain - room": self.expected(tree, on_chain or study) - score["tree"]["reward"]["mean"],
                 "collisions": score["tree"]["collisions"],
                 "on the chain": 500 * self.value(collisions)}
        for name, holds in GROUPS.items():
            group = [row for row in rows if holds(row)]
            agree = [row for row in group if row["policy_action"] == row["tree_action"]]
            found[name + " %"] = 100 * len(agree) / len(group)
            found[name + " visits %"] = 100 * sum(int(r["visits"]) for r in agree) / sum(int(r["visits"]) for r in group)
        return found

    def expected(self, tree, study):
        return json.loads(run([self.options.coppice, "score", study, "--exact", "--json", "--episodes", "2", "--tree",
                               tree]))["exact"]["tree"]["reward"]

    @staticmethod
    def value(answer):
        return answer["objectives"]["collisions"]["per_step"] * 150


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("study")
    parser.add_argument("-o", "--output", required=True, metavar="FOLDER")
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--rounds", type=int, default=2)
    parser.add_argument("--episodes", type=int, nargs="+", default=[2, 100000], help="of each round; 2 is next to nothing")
    parser.add_argument("--generations", type=int, default=150, help="of each round")
    parser.add_argument("--config", default="coordinator/evolution/front.toml")
    parser.add_argument("--coppice", default="build/release/bin/coppice", metavar="PROGRAM")
    options = parser.parse_args()
    measured = Measured(options)
    os.makedirs(options.output, exist_ok=True)

    def kept(name, arguments):
        path = os.path.join(options.output, name + ".json")
        if not os.path.exists(path):
            report = run(arguments())
            with open(path, "w") as file:
                file.write(report)
        with open(path) as file:
            return json.load(file)

    def evolved(name, settings):
        study = os.path.join(options.output, name + ".coppice")
        if not os.path.exists(study):
            shutil.copyfile(options.study, study)
        return study, [kept(f"{name}-{seed}", lambda: [options.coppice, "evolve", study, "--config", options.config, "--serial",
                                                       "--json", "--seed", str(seed)] + settings)
                       for seed in range(1, options.seeds + 1)]

    front, answers = evolved("front", [])
    trees = {"front.toml": [(answer["pruned"], None) for answer in answers]}
    for episodes in options.episodes:
        name = f"refine, {episodes} episodes"
        trees[name] = []
        for seed, answer in enumerate(answers, 1):
            folder = os.path.join(options.output, f"refine-{episodes}-{seed}")
            report = kept(f"refine-{episodes}-{seed}", lambda: [
                options.coppice, "refine", front, "-o", folder, "--run", str(answer["run"]), "--rounds", str(options.rounds),
                "--episodes", str(episodes), "--config", options.config, "--set", f"ga.generations={options.generations}",
                "--seed", str(seed), "--serial", "--json"])
            last = report["rounds"][-1]
            trees[name].append((last["pruned"], last["study"]))
    for start in ("uniform", "visits"):
        trees[f"start={start}"] = [(answer["pruned"], None)
                                   for answer in evolved(f"start-{start}", ["--set", f"rollout.start={start}"])[1]]

    columns = {}
    for name, chosen in trees.items():
        rows = [measured.figures(tree, study) for tree, study in chosen]
        columns[name] = rows
        for seed, row in enumerate(rows, 1):
            print(f"{name}, seed {seed}: " + ", ".join(f"{key} {value:.1f}" for key, value in row.items()), flush=True)
    print(f"\nmedians of {options.seeds} seeds (lowest to highest)")
    print(f"{'':32}" + "".join(f"{name:>28}" for name in columns))
    for key in columns["front.toml"][0]:
        cells = []
        for rows in columns.values():
            values = [row[key] for row in rows]
            cells.append(f"{statistics.median(values):.1f} ({min(values):.1f} to {max(values):.1f})")
        print(f"{key:32}" + "".join(f"{cell:>28}" for cell in cells))


if __name__ == "__main__":
    main()
