#!/usr/bin/python3
"""What `coppice evolve` gives without a flag: makes problems (rooms of several shapes, the windy grid, toy problems of Gymnasium,
models), evolves with several seeds, and prints a Markdown table of what the answers are worth against the policy. With --agreement a
second evolution of each asks for the tree that does most often what the policy does.

    tests/bench/quality.py default hall pillars maze small dense windy lake-4 lake-8 cliff taxi MODEL.drn... --seeds 5

A problem is a name from the list above (lake-4, lake-8, cliff and taxi need Gymnasium and deploy/python), a .room file, a .drn file
(solved with discount 0.99), or a study. Rewards are shares of the policy's: 100 % + (tree's - policy's) / |policy's|. In a room they
are means of 500 episodes in the simulator, which chose nothing; of a model that was solved they are exact.
"""
import argparse
import json
import os
import random
import statistics
import subprocess
import sys
import tempfile
import time

# width, height, walls in the middle as (x, y, width, height), pieces of trash
ROOMS = {
    "hall": (40, 8, [(12, 3, 2, 2), (26, 1, 2, 3)], 18),
    "pillars": (24, 24, [(x, y, 2, 2) for x in (5, 11, 17) for y in (5, 11, 17)], 24),
    "maze": (21, 15, [(4, 1, 1, 9), (9, 5, 1, 9), (14, 1, 1, 9), (17, 5, 1, 6)], 16),
    "small": (10, 10, [(4, 4, 2, 1)], 6),
    "dense": (30, 16, [(8, 4, 3, 1), (18, 10, 4, 2)], 60),
}
TABLES = {
    "lake-4": ("FrozenLake-v1", {}),
    "lake-8": ("FrozenLake-v1", {"map_name": "8x8"}),
    "cliff": ("CliffWalking-v1", {}),
    "cliff-slippery": ("CliffWalking-v1", {"is_slippery": True}),
    "taxi": ("Taxi-v4", {}),
}
DISCOUNT = "0.99"


def room_text(name):
    width, height, walls, trash = ROOMS[name]
    cells = [["#" if x in (0, width - 1) or y in (0, height - 1) else "." for x in range(width)] for y in range(height)]
    for left, top, wide, high in walls:
        for y in range(top, top + high):
            for x in range(left, left + wide):
                cells[y][x] = "#"
    free = [(x, y) for y in range(height) for x in range(width) if cells[y][x] == "."]
    chosen = random.Random(name).sample(free, trash + 1)
    for x, y in chosen[1:]:
        cells[y][x] = "*"
    cells[chosen[0][1]][chosen[0][0]] = "^"
    return "\n".join("".join(row) for row in cells) + "\n"


def run(arguments):
    done = subprocess.run([str(word) for word in arguments], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(str(word) for word in arguments)}: {done.stderr.strip()}")
    return done.stdout


def make(problem, folder, coppice):
    """The study of a problem."""
    study = os.path.join(folder, os.path.basename(problem) + ".study")
    if problem.endswith(".coppice"):
        run(["cp", problem, study])
    elif problem.endswith(".drn"):
        run([coppice, "import", problem, "-o", study, "--solve", "--gamma", DISCOUNT, "--without", "__random__"])
    elif problem in TABLES:
        import coppice as package
        import gymnasium
        name, settings = TABLES[problem]
        source = os.path.join(folder, problem + ".json")
        package.tables(gymnasium.make(name, **settings), source)
        run([coppice, "import", source, "-o", study, "--solve", "--gamma", DISCOUNT])
    elif problem == "default":
        run([coppice, "learn", "-o", study])
    elif problem == "windy":
        run([coppice, "learn", "-o", study, "--world", "windy"])
    elif problem in ROOMS:
        room = os.path.join(folder, problem + ".room")
        with open(room, "w", encoding="utf-8") as out:
            out.write(room_text(problem))
        run([coppice, "learn", "-o", study, "--world", room])
    elif problem.endswith(".room"):
        run([coppice, "learn", "-o", study, "--world", problem])
    else:
        sys.exit(f"{problem}: expected one of default, windy, {', '.join([*ROOMS, *TABLES])}, or a file .room, .drn or .coppice")
    return study


def percent(values, digits=1):
    spread = f" ({min(values):.{digits}f} to {max(values):.{digits}f})" if len(values) > 1 else ""
    return f"{statistics.median(values):.{digits}f}{spread}"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("problems", nargs="+", metavar="PROBLEM")
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--agreement", type=int, default=0, metavar="SEEDS", help="evolve with --prefer agreement too, with so many seeds")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE")
    parser.add_argument("--trees", action="store_true", help="print each answer")
    parser.add_argument("--coppice", default="build/release/bin/coppice", metavar="PROGRAM")
    options = parser.parse_args()
    settings = [word for setting in options.set for word in ("--set", setting)]

    print("| problem | policy | % of it | its action in % of the steps | in % of all states | collisions, policy's | nodes | seconds "
          "| agreement asked for: % of the steps | % of the reward |")
    print("|---|---|---|---|---|---|---|---|---|---|", flush=True)
    with tempfile.TemporaryDirectory() as folder:
        for problem in options.problems:
            study = make(problem, folder, options.coppice)

            def evolve(seed, words):
                begin = time.monotonic()
                answer = json.loads(run([options.coppice, "evolve", study, "--serial", "--json", "--seed", seed] + words + settings))
                seconds = time.monotonic() - begin
                worth = answer["answer"]
                policy = worth["policy"]["reward"]["mean"]
                states = float("nan")  # of a model without a simulator there is nothing to score
                if worth["simulated"]:
                    score = json.loads(run([options.coppice, "score", study, "--json", "--episodes", 2, "--tree", answer["tree"]]))
                    states = 100 * score["pruned"]["agreement_over_states"]
                found = {"policy": policy, "seconds": seconds, "nodes": answer["nodes"], "simulated": worth["simulated"],
                         "reward": 100 + 100 * (worth["tree"]["reward"]["mean"] - policy) / max(abs(policy), 1e-12),
                         "agreement": 100 * (worth["tree"]["agreement"]["mean"] or 0.0),
                         "states": states,
                         "collisions": worth["tree"]["collisions"]["mean"], "policy's": worth["policy"]["collisions"]["mean"]}
                if options.trees:
                    print(f"<!-- {problem}, seed {seed}: {found['reward']:.1f} %, {found['agreement']:.1f} %: {answer['tree']} -->")
                return found

            rows = [evolve(seed, []) for seed in range(1, options.seeds + 1)]
            asked = [evolve(seed, ["--prefer", "agreement"]) for seed in range(1, options.agreement + 1)]

            def column(key, of):
                return percent([row[key] for row in of])

            steps = column("agreement", rows) if max(row["agreement"] for row in rows) > 0 else ""
            collisions = f"{max(row['collisions'] for row in rows):.3g}, {max(row['policy' + chr(39) + 's'] for row in rows):.3g}"
            print(f"| {problem} | {rows[0]['policy']:.5g} | {column('reward', rows)} | {steps} | {column('states', rows) if rows[0]['simulated'] else ''} | {collisions} "
                  f"| {percent([row['nodes'] for row in rows], 0)} | {statistics.median(row['seconds'] for row in rows):.1f} "
                  f"| {column('agreement', asked) if asked else ''} | {column('reward', asked) if asked else ''} |", flush=True)


if __name__ == "__main__":
    main()
