#!/usr/bin/python3
"""Small trees on published models, beside what others published: imports each model, evolves with the recipe `return` at 1, 3, 7, ...
tests with several seeds, recomputes each tree's expected discounted return by `coppice evaluate`, and prints a Markdown table.

    tests/bench/small_trees.py MODEL.drn... --depths 1 2 3 4 --seeds 3

A model's name is its file's. What is published is for decision trees of depth d, which have at most 2^d - 1 tests: Andriushchenko,
Ceska, Junges and Macak, CAV 2025, artifact, original-logs/final-merge.csv (OMDT: Vos and Verwer, IJCAI 2023; dtPAYNT), discount 0.99,
up to 1200 s a cell on another machine. Ours have as many conditions at most, and at most 4 nodes a test and one. The artifact's models
have an action more, __random__ (all actions with equal probability), which its trees may take; --random leaves it to ours, too.
"""
import argparse
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time

DISCOUNT = 0.99
# By depth from 1 on; the best of OMDT and dtPAYNT. Then the optimum of any policy.
PUBLISHED = {
    "3d_navigation": ([6e-6, .02067, .35185], .35185),
    "blackjack": ([-2.35262, -2.20527, -2.17321], -2.17321),
    "frozenlake_4x4": ([.11040, .36517, .52012, .54203], .54203),
    "frozenlake_8x8": ([.30687, .38702, .39268, .40473, .41452, .41462], .41464),
    "frozenlake_12x12": ([.02066, .11767, .23871, .27576, .30539, .30711], .34872),
    "traffic_intersection": ([-72.067, -.2174, 1.0048, 2.1147, 2.12295, 2.1206], 2.1246),
    "system_administrator_tree": ([377.93, 438.93, 467.74, 536.41, 524.76, 548.14], 557.72),
    "system_administrator_1": ([203.42, 209.95, 212.10, 212.90, 213.83, 213.91], 223.97),
    "system_administrator_2": ([146.65, 182.82, 190.92, 187.9, 203.26, 196.5], 241.15),
    "tictactoe_vs_random": ([-.7553, .287, .3547, .287, .287, .9734], .97341),
    "maze-steps": ([-63.225, -24.556, -19.970, -19.676, -17.232, -18.338], -17.1595),
    "maze-7": ([1.9469, 3.2506, 3.9167, 4.0824, 4.1511, 4.2316], 5.1796),
    "resource-gathering-5": ([-95.14, -53.906, -47.7105], -47.7105),
}


def run(arguments, given=None):
    done = subprocess.run(arguments, capture_output=True, text=True, input=given)
    if done.returncode != 0:
        sys.exit(f"{' '.join(arguments)}: {done.stderr.strip()}")
    return done.stdout


def discounted_return(coppice, study, tree):
    answer = json.loads(run([coppice, "evaluate", study, "--serial", "--discounted", str(DISCOUNT), "--objective", "return"], tree + "\n"))
    return answer["objectives"]["return"]["per_step"] / (1 - DISCOUNT)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("models", nargs="+", metavar="MODEL.drn")
    parser.add_argument("--depths", nargs="+", type=int, default=[1, 2, 3, 4, 5, 6])
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE")
    parser.add_argument("--random", action="store_true", help="keep the action __random__")
    parser.add_argument("--coppice", default="build/release/bin/coppice", metavar="PROGRAM")
    options = parser.parse_args()
    settings = [word for setting in options.set for word in ("--set", setting)]

    print("| model | tests | published | ours, median (lowest to highest) | conditions | nodes | seconds | to the optimum |")
    print("|---|---|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        for path in options.models:
            name = os.path.splitext(os.path.basename(path))[0]
            values, optimum = PUBLISHED.get(name, ([], None))
            study = os.path.join(folder, name + ".coppice")
            run([options.coppice, "import", path, "-o", study, "--solve", "--gamma", str(DISCOUNT)] + ([] if options.random else ["--without", "__random__"]))
            for depth in options.depths:
                tests = 2 ** depth - 1
                found = []
                for seed in range(1, options.seeds + 1):
                    begin = time.monotonic()
                    answer = json.loads(run(
                        [options.coppice, "evolve", study, "--config", "return", "--serial", "--json", "--seed", str(seed),
                         "--set", f"ga.max_conditions={tests}", "--set", f"ga.max_nodes={4 * tests + 1}"] + settings))
                    seconds = time.monotonic() - begin
                    tree = answer["tree"]
                    conditions = sum("=" in word for word in tree.replace("(", " ").replace(")", " ").split())
                    found.append((discounted_return(options.coppice, study, tree), conditions, answer["nodes"], seconds))
                found.sort()
                middle = found[(len(found) - 1) // 2]
                published = f"{values[depth - 1]:.5g}" if depth <= len(values) else ""
                gap = f"{optimum - middle[0]:.3g}" if optimum is not None else ""
                print(f"| {name} | {tests} | {published} | {middle[0]:.6g} ({found[0][0]:.6g} to {found[-1][0]:.6g}) "
                      f"| {middle[1]} | {middle[2]} | {statistics.median(f[3] for f in found):.1f} | {gap} |", flush=True)


if __name__ == "__main__":
    main()
