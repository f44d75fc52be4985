#!/usr/bin/python3
"""Whether demes cost quality: evolves each study with 1, 4, 8, ... demes that share the same number of evaluations, with several
seeds, and prints medians of what the answers are worth, and how the settings differ from the first with a 95 % interval
(bootstrap of the difference of medians).

    coppice learn -o uav.coppice
    tests/bench/deme_quality.py uav.coppice frozenlake.coppice --demes 1 4 8 --seeds 10

A study of a room is evolved with the recipe `best`; what counts is the reward of its answer in 500 episodes that chose nothing, as a
share of the policy's. One that was imported and solved (`coppice import MODEL.drn -o STUDY --solve --gamma 0.99`) is evolved with the
recipe `return` at 15 tests; what counts is the exact discounted return. Studies are copied, not changed.
"""
import argparse
import json
import os
import random
import shutil
import statistics
import subprocess
import sys
import tempfile
import time

DISCOUNT = 0.99
TESTS = 15


def run(arguments, given=None):
    done = subprocess.run(arguments, capture_output=True, text=True, input=given)
    if done.returncode != 0:
        sys.exit(f"{' '.join(arguments)}: {done.stderr.strip()}")
    return done.stdout


def worth_in_room(coppice, study, answer):
    score = json.loads(run([coppice, "score", study, "--json", "--tree", answer["pruned"]]))
    return 100 * score["pruned"]["reward"]["mean"] / score["policy"]["reward"]["mean"]


def worth_in_model(coppice, study, answer):
    said = json.loads(run([coppice, "evaluate", study, "--serial", "--discounted", str(DISCOUNT), "--objective", "return"],
                          answer["tree"] + "\n"))
    return said["objectives"]["return"]["per_step"] / (1 - DISCOUNT)


def interval_of_difference(ours, theirs):
    chance = random.Random(1)
    differences = sorted(statistics.median(chance.choices(ours, k=len(ours))) - statistics.median(chance.choices(theirs, k=len(theirs)))
                         for _ in range(10000))
    return differences[249], differences[9749]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("studies", nargs="+", metavar="STUDY")
    parser.add_argument("--demes", nargs="+", type=int, default=[1, 4, 8])
    parser.add_argument("--larger", action="store_true", help="every deme as large as the only one: more evaluations, not the same")
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE")
    parser.add_argument("--coppice", default="build/release/bin/coppice", metavar="PROGRAM")
    options = parser.parse_args()
    print("| study | demes | evaluations | median (lowest to highest) | mean | against the first, 95 % | seconds |")
    print("|---|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        for path in options.studies:
            study = os.path.join(folder, os.path.basename(path))
            shutil.copyfile(path, study)
            solved = json.loads(run([options.coppice, "info", study, "--json"]))["world"] == "imported"
            recipe, population = ("return", 20) if solved else ("best", 800)
            settings = ["--set", f"ga.max_conditions={TESTS}", "--set", f"ga.max_nodes={4 * TESTS + 1}"] if solved else []
            worth_of = worth_in_model if solved else worth_in_room
            first = None
            for demes in options.demes:
                values, evaluations, seconds = [], [], []
                chosen = ["--set", f"ga.demes={demes}"]
                if options.larger:
                    chosen += ["--set", f"ga.population={population * demes}", "--set", f"ga.tournament={0.1 / demes if solved else 0.01 / demes}"]
                elif solved and demes > 1:  # demes of so few individuals have no room for more
                    chosen += ["--set", "ga.migrants=1"]
                chosen += [word for setting in options.set for word in ("--set", setting)]
                for seed in range(1, options.seeds + 1):
                    begin = time.monotonic()
                    answer = json.loads(run([options.coppice, "evolve", study, "--config", recipe, "--serial", "--json", "--seed", str(seed)]
                                            + settings + chosen))
                    seconds.append(time.monotonic() - begin)
                    evaluations.append(answer["dispatch"]["individuals"])
                    values.append(worth_of(options.coppice, study, answer))
                first = first or values
                low, high = interval_of_difference(values, first)
                print(f"| {os.path.splitext(os.path.basename(path))[0]} | {demes} | {statistics.median(evaluations):,.0f} "
                      f"| {statistics.median(values):.6g} ({min(values):.6g} to {max(values):.6g}) | {statistics.mean(values):.6g} "
                      f"| {'' if values is first else f'{low:+.3g} to {high:+.3g}'} | {statistics.median(seconds):.1f} |", flush=True)


if __name__ == "__main__":
    main()
