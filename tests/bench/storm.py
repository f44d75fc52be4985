#!/usr/bin/env python3
"""A storm of arrivals: how long standing workers take to join a coordinator that starts, and what they cost it.

    storm.py WORKERS [--bin FOLDER] [--security FOLDER] [--domain D]

Starts so many coppice-worker processes on this machine, waits until all of them look for a coordinator, starts one, and
prints the seconds from its start until all were there, its resident memory then, processor time of both sides, and how
many workers were lost within the run.
"""
import argparse
import json
import os
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

PATIENCE = 180  # seconds


def seconds_of(pid):
    fields = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def memory_of(pid, name):
    return int(re.search(rf"{name}:\s+(\d+)", Path(f"/proc/{pid}/status").read_text())[1]) / 1024


def main():
    arguments = argparse.ArgumentParser()
    arguments.add_argument("workers", type=int)
    arguments.add_argument("--bin", default=str(Path(__file__).parents[2] / "build/release/bin"))
    arguments.add_argument("--security")
    arguments.add_argument("--domain", default="213")
    arguments.add_argument("--generations", default="40")
    arguments.add_argument("--trace", action="store_true")
    options = arguments.parse_args()
    secured = lambda role: ["--security", f"{options.security}/{role}"] if options.security else []

    with tempfile.TemporaryDirectory() as folder:
        coppice = f"{options.bin}/coppice"
        study = f"{folder}/study.coppice"
        subprocess.run([coppice, "learn", "-o", study, "--episodes", "300"], check=True, capture_output=True)
        log = open(f"{folder}/workers.log", "w+")
        workers = [
            subprocess.Popen([f"{options.bin}/coppice-worker", "--domain", options.domain, "--pace", "2ms", *secured("worker")],
                             stderr=log)
            for _ in range(options.workers)
        ]
        try:
            begin = time.monotonic()
            while Path(log.name).read_text().count("looks for a coordinator") < options.workers:
                if time.monotonic() - begin > PATIENCE:
                    sys.exit("storm.py: the workers did not start")
                time.sleep(0.1)
            time.sleep(2)  # they settle: their own start is not what is measured
            before = sum(seconds_of(worker.pid) for worker in workers)
            begin = time.monotonic()
            run = subprocess.Popen(
                [coppice, "evolve", study, "--remote", "--domain", options.domain, "--set",
                 f"ga.generations={options.generations}", "--set", "ga.population=2000", "--lines-every", "1", "--json",
                 *secured("coordinator")],
                stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
            there = None
            most = 0
            for line in run.stderr:
                found = re.search(r", (\d+) workers?", line)
                if not found:
                    continue
                count = int(found[1])
                most = max(most, count)
                if options.trace:
                    print(f"{time.monotonic() - begin:.2f} s: {count} workers, {memory_of(run.pid, 'VmRSS'):.0f} MB",
                          file=sys.stderr)
                if count == options.workers:
                    there = time.monotonic() - begin
                    cost = (seconds_of(run.pid), sum(seconds_of(worker.pid) for worker in workers) - before)
                    memory = memory_of(run.pid, "VmRSS")
                    break
                if time.monotonic() - begin > PATIENCE:
                    break
            peak = memory_of(run.pid, "VmHWM") if run.poll() is None else float("nan")
            rest, _ = run.communicate()
            if there is None:
                print(f"{options.workers} workers: only {most} were there at once; ended with {run.returncode}")
                return
            report = json.loads(rest)["dispatch"]
            print(f"{options.workers} workers: all there {there:.2f} s after the coordinator's start; its memory {memory:.0f} MB "
                  f"(most {peak:.0f}); processor time {cost[0]:.1f} s there, {cost[1]:.1f} s at the workers; "
                  f"lost {report['workers_lost']}")
        finally:
            for worker in workers:
                worker.terminate()
            for worker in workers:
                worker.wait()


main()
