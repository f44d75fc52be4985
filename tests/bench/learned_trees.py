#!/usr/bin/python3
"""What learners of decision trees make of published models, beside tests/bench/small_trees.py: trees of at most 2^d - 1 tests from

  CART     scikit-learn's tree on the optimal actions, each state weighted by how often the optimal policy is there
  CART Q   a regression tree on the Q-values of all actions, weighted alike; acts by the largest
  VIPER    Bastani, Pu and Solar-Lezama, NeurIPS 2018: imitation of the optimal policy where the trees themselves go (DAgger), states
           weighted by what a wrong action costs there; 20 rounds, occupancies computed instead of sampled, the best tree kept

Each tree's discounted return is computed here, from the model's own probabilities, by NumPy: no code is shared with the project.

    apt-get install python3-sklearn      # or pip install scikit-learn
    tests/bench/learned_trees.py MODEL.drn... --depths 2 3 4
"""
import argparse
import os
import re
import sys

import numpy
from scipy import sparse
from scipy.sparse.linalg import spsolve
from sklearn.tree import DecisionTreeClassifier, DecisionTreeRegressor

DISCOUNT = 0.99
ROUNDS = 20


class Model:
    """A Storm DRN file with one reward and state valuations in comments."""

    def __init__(self, path, without="__random__"):
        rows, features, self.rewards, names, start = [], {}, {}, [], 0
        state, action = -1, None
        with open(path, encoding="utf-8") as source:
            for line in source:
                line = line.strip()
                if line.startswith("state "):
                    state = int(line.split()[1])
                    reward = re.search(r"\[([^\]]*)\]", line)
                    of_state = float(reward[1].split(",")[0]) if reward else 0.0
                    if " init" in line:
                        start = state
                elif line.startswith("//[") and state >= 0:
                    values = {}
                    for part in re.split(r"\s*&\s*", line[3:].rstrip("]").strip()):
                        name, equals, value = part.partition("=")
                        values[name.strip().lstrip("!")] = float(value) if equals else float(not name.strip().startswith("!"))
                    features[state] = values
                elif line.startswith("action "):
                    found = re.match(r"action (.*?)(?: \[([^\]]*)\])?$", line)
                    action = found[1]
                    if action != without and action not in names:
                        names.append(action)
                    self.rewards[state, action] = of_state + (float(found[2].split(",")[0]) if found[2] else 0.0)
                elif state >= 0 and re.match(r"\d+ : ", line):
                    rows.append((state, action, int(line.split(" : ")[0]), float(line.split(" : ")[1])))
        self.start, self.states = start, state + 1
        self.actions = [name for name in names if name != without]
        shape = (len(self.actions), self.states)
        self.r = numpy.full(shape, -numpy.inf)
        self.p = []  # [actions], states x states
        for name in self.actions:
            of_action = [(s, after, probability) for s, a, after, probability in rows if a == name]
            s, after, probability = (numpy.array(column) for column in zip(*of_action))
            counted = sparse.csr_matrix((probability, (s.astype(int), after.astype(int))), shape=(self.states, self.states))
            sums = numpy.maximum(numpy.asarray(counted.sum(axis=1)).ravel(), 1e-300)  # printed with ten digits
            self.p.append(sparse.diags(1 / numpy.where(sums > 1e-200, sums, 1)) @ counted)
        for (s, a), reward in self.rewards.items():
            if a in self.actions:
                self.r[self.actions.index(a), s] = reward
        names = sorted({name for values in features.values() for name in values})
        self.x = numpy.array([[features.get(s, {}).get(name, 0.0) for name in names] for s in range(self.states)])
        self.acts = numpy.isfinite(self.r).sum(axis=0) > 1  # where there is something to choose

    def solve(self):
        """Q-values of the best policy, by policy iteration."""
        policy = numpy.argmax(self.r, axis=0)
        while True:
            q = self.q_of(self.values(policy))
            better = numpy.argmax(q, axis=0)
            keep = q[policy, numpy.arange(self.states)] >= q[better, numpy.arange(self.states)] - 1e-12
            better = numpy.where(keep, policy, better)
            if (better == policy).all():
                return q
            policy = better

    def q_of(self, values):
        return numpy.where(numpy.isfinite(self.r), self.r + DISCOUNT * numpy.array([p @ values for p in self.p]), -numpy.inf)

    def matrix(self, policy):
        chosen = sum(sparse.diags((policy == a).astype(float)) @ p for a, p in enumerate(self.p))
        return sparse.csc_matrix(sparse.identity(self.states) - DISCOUNT * chosen)

    def values(self, policy):
        return spsolve(self.matrix(policy), self.r[policy, numpy.arange(self.states)])

    def occupancy(self, policy):
        begin = numpy.zeros(self.states)
        begin[self.start] = 1 - DISCOUNT
        return spsolve(sparse.csc_matrix(self.matrix(policy).T), begin)

    def allowed(self, policy):
        """What takes place: where a state lacks the action, its first."""
        lacks = ~numpy.isfinite(self.r[policy, numpy.arange(self.states)])
        return numpy.where(lacks, numpy.argmax(numpy.isfinite(self.r), axis=0), policy)

    def worth(self, policy):
        return self.values(self.allowed(policy))[self.start]


def cart(model, best, weights, tests):
    rows = model.acts & (weights > 0)
    tree = DecisionTreeClassifier(max_leaf_nodes=tests + 1, random_state=0)
    tree.fit(model.x[rows], best[rows], sample_weight=weights[rows])
    return tree.predict(model.x).astype(int), tree.tree_.n_leaves - 1


def cart_q(model, q, weights, tests):
    rows = model.acts & (weights > 0)
    finite = numpy.where(numpy.isfinite(q), q, q[numpy.isfinite(q)].min())
    tree = DecisionTreeRegressor(max_leaf_nodes=tests + 1, random_state=0)
    tree.fit(model.x[rows], finite.T[rows], sample_weight=weights[rows])
    return numpy.argmax(tree.predict(model.x).reshape(model.states, -1), axis=1), tree.tree_.n_leaves - 1


def viper(model, q, best, tests):
    cost = numpy.where(numpy.isfinite(q), q, numpy.inf)
    cost = q.max(axis=0) - numpy.where(numpy.isfinite(cost), cost, numpy.inf).min(axis=0)
    visited = model.occupancy(best)
    found = None
    for _ in range(ROUNDS):
        policy, used = cart(model, best, visited * cost, tests)
        worth = model.worth(policy)
        found = (worth, used) if found is None or worth > found[0] else found
        visited = visited + model.occupancy(model.allowed(policy))
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("models", nargs="+", metavar="MODEL.drn")
    parser.add_argument("--depths", nargs="+", type=int, default=[2, 3, 4])
    options = parser.parse_args()
    print("| model | tests | CART | CART Q | VIPER | optimum |")
    print("|---|---|---|---|---|---|", flush=True)
    for path in options.models:
        model = Model(path)
        q = model.solve()
        best = numpy.argmax(q, axis=0)
        weights = model.occupancy(best)
        for depth in options.depths:
            tests = 2 ** depth - 1
            columns = [model.worth(cart(model, best, weights, tests)[0]), model.worth(cart_q(model, q, weights, tests)[0]),
                       viper(model, q, best, tests)[0]]
            name = os.path.splitext(os.path.basename(path))[0]
            print(f"| {name} | {tests} | " + " | ".join(f"{value:.6g}" for value in columns) + f" | {q.max(axis=0)[model.start]:.6g} |",
                  flush=True)


if __name__ == "__main__":
    sys.exit(main())
