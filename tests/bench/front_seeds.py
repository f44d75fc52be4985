#!/usr/bin/python3
"""What front.toml gives on a study: evolves with several seeds, scores what each rule picks from each front in the simulator,
and prints medians over the seeds. The study is copied, not changed.

    coppice learn -o uav.coppice
    tests/bench/front_seeds.py uav.coppice --seeds 10
"""
import argparse
import json
import os
import shutil
import statistics
import subprocess
import sys
import tempfile

RULES = {
    "the answer": None,
    "best coverage": "best coverage with collisions<=0 and unknown<=0",
    "best agreement": "best agreement with collisions<=0 and unknown<=0",
    "best return": "best return with collisions<=0 and unknown<=0",
}


def coppice(arguments):
    done = subprocess.run(arguments, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(arguments)}: {done.stderr.strip()}")
    return done.stdout


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("study")
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--workers", type=int, default=0, help="local workers (default: serial)")
    parser.add_argument("--config", default="coordinator/evolution/front.toml")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE")
    parser.add_argument("--coppice", default="build/release/bin/coppice", metavar="PROGRAM")
    options = parser.parse_args()

    found = {name: [] for name in RULES}
    seconds = []
    with tempfile.TemporaryDirectory() as folder:
        study = os.path.join(folder, "study.coppice")
        shutil.copyfile(options.study, study)
        evaluator = ["--workers", str(options.workers)] if options.workers else ["--serial"]
        settings = [word for setting in options.set for word in ("--set", setting)]
        for seed in range(1, options.seeds + 1):
            run = json.loads(coppice([options.coppice, "evolve", study, "--config", options.config, "--seed", str(seed),
                                      "--json"] + settings + evaluator))
            seconds.append(run["seconds"])
            for name, rule in RULES.items():
                tree = run["tree"] if rule is None else coppice([options.coppice, "front", study, "--pick", rule]).strip()
                score = json.loads(coppice([options.coppice, "score", study, "--json", "--tree", tree]))
                pruned = score["pruned"]
                found[name].append({"nodes": score["nodes"]["pruned"], "states": 100 * pruned["agreement_over_states"],
                                    "seen": 100 * pruned["agreement_over_seen"],
                                    "simulation": 100 * pruned["agreement"]["mean"],
                                    "reward": pruned["reward"]["mean"],
                                    "of policy": 100 * pruned["reward"]["mean"] / score["policy"]["reward"]["mean"],
                                    "collisions": pruned["collisions"]})
                if rule is None:
                    print(f"seed {seed}: {seconds[-1]:.1f} s, " +
                          ", ".join(f"{key} {value:.1f}" for key, value in found[name][-1].items()) + f"\n  {tree}",
                          flush=True)
    keys = list(found["the answer"][0])
    print(f"\nmedians of {options.seeds} seeds, {statistics.median(seconds):.1f} s an evolution (lowest to highest in brackets)")
    print(f"{'':16}" + "".join(f"{key:>24}" for key in keys))
    for name, rows in found.items():
        cells = []
        for key in keys:
            values = [row[key] for row in rows]
            cells.append(f"{statistics.median(values):.1f} ({min(values):.1f}-{max(values):.1f})")
        print(f"{name:16}" + "".join(f"{cell:>24}" for cell in cells))


if __name__ == "__main__":
    main()
