#!/usr/bin/python3
"""CART against the genetic search, at the same number of nodes: trains scikit-learn's DecisionTreeClassifier on the states of
a study (features one-hot, the policy's action as the class), turns it into a behaviour tree, prunes it with `coppice prune`
and scores it with `coppice score`. Of each weighting of the states the largest tree within --nodes is printed.

    apt-get install python3-sklearn
    tests/bench/cart.py uav.coppice --nodes 20

With --founders it prints the trees instead, for an evolution to begin with:
    coppice evolve uav.coppice --config FILE.toml --set ga.founders="$(tests/bench/cart.py uav.coppice --founders)"
"""
import argparse
import csv
import io
import json
import subprocess
import sys

import numpy
from sklearn.tree import DecisionTreeClassifier


def coppice(arguments):
    done = subprocess.run(arguments, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(arguments[:2])}: {done.stderr.strip()}")
    return done.stdout


def behaviour_tree(cart, conditions, actions):
    """(selector (sequence condition then) otherwise): every subtree succeeds, so the first that holds decides."""
    tree = cart.tree_

    def subtree(node):
        if tree.children_left[node] == -1:
            return actions[cart.classes_[int(numpy.argmax(tree.value[node]))]]
        # One-hot columns are split at 1/2: right is where the condition holds.
        holds, otherwise = subtree(tree.children_right[node]), subtree(tree.children_left[node])
        return f"(selector (sequence {conditions[tree.feature[node]]} {holds}) {otherwise})"

    return subtree(0)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("study")
    parser.add_argument("--nodes", type=int, default=20, help="of the behaviour tree after pruning (default: 20)")
    parser.add_argument("--seeds", type=int, default=10, help="CART breaks ties by chance (default: 10 seeds)")
    parser.add_argument("--coppice", default="build/release/bin/coppice", metavar="PROGRAM")
    parser.add_argument("--founders", action="store_true", help="print the trees, with ; between, and nothing else")
    options = parser.parse_args()

    table = coppice([options.coppice, "table", options.study, "--tree",
                     json.loads(coppice([options.coppice, "info", options.study, "--json"]))["actions"][0]])
    rows = list(csv.DictReader(io.StringIO(table)))
    features = [name for name in rows[0] if name not in ("visits", "policy_action", "tree_action")]
    conditions = [f"{feature}={value}" for feature in features for value in sorted({row[feature] for row in rows}, key=int)]
    inputs = numpy.array([[f"{f}={row[f]}" == c for f in features for c in conditions if c.startswith(f + "=")]
                          for row in rows], dtype=float)
    actions = sorted({row["policy_action"] for row in rows})
    classes = numpy.array([actions.index(row["policy_action"]) for row in rows])
    visits = numpy.array([float(row["visits"]) for row in rows])
    weightings = {"states alike": numpy.ones(len(rows)), "by visits": visits, "by root of visits": numpy.sqrt(visits)}

    if not options.founders:
        print(f"{'states weigh':18} {'leaves':>6} {'nodes':>5} {'over states':>11} {'simulation':>10} {'reward':>7} {'collisions':>10}"
              f"   medians of {options.seeds} seeds")
    founders = set()
    for name, weights in weightings.items():
        results = []
        for seed in range(1, options.seeds + 1):
            best = None
            for leaves in range(2, options.nodes + 1):
                cart = DecisionTreeClassifier(max_leaf_nodes=leaves, random_state=seed).fit(inputs, classes, weights)
                text = behaviour_tree(cart, conditions, actions)
                pruned = json.loads(coppice([options.coppice, "prune", options.study, "--json", "--tree", text]))
                if pruned["pruned_nodes"] <= options.nodes:
                    best = (leaves, pruned["pruned_nodes"], pruned["pruned"])
            founders.add(best[2])
            if options.founders:
                continue
            score = json.loads(coppice([options.coppice, "score", options.study, "--json", "--tree", best[2]]))["tree"]
            results.append([best[0], best[1], 100 * score["agreement_over_states"], 100 * score["agreement"]["mean"],
                            score["reward"]["mean"], score["collisions"]])
        if options.founders:
            continue
        median = numpy.median(numpy.array(results), axis=0)
        print(f"{name:18} {median[0]:6.0f} {median[1]:5.0f} {median[2]:9.1f} % {median[3]:8.1f} % {median[4]:7.1f} "
              f"{median[5]:10.0f}")
    if options.founders:
        print(";".join(sorted(founders)))


if __name__ == "__main__":
    main()
