#!/usr/bin/python3
"""Reads metrics as Prometheus would, with the parser of its Python client, and by promtool's rules where that is there.

    scrape.py URL|FILE      prints {"name": [[{label: value}, value], ...], ...}; complains, with exit code 1
"""
import json
import shutil
import subprocess
import sys
import urllib.request

from prometheus_client.parser import text_string_to_metric_families

where = sys.argv[1]
if where.startswith("http"):
    with urllib.request.urlopen(where, timeout=60) as answer:
        kind = answer.headers["Content-Type"]
        text = answer.read().decode("utf-8")
    if not kind.startswith("text/plain; version=0.0.4"):
        sys.exit(f"{where}: of type {kind}")
else:
    with open(where, encoding="utf-8") as file:
        text = file.read()

samples = {}
for family in text_string_to_metric_families(text):
    if not family.documentation:
        sys.exit(f"{family.name}: without help")
    if family.type not in ("counter", "gauge"):
        sys.exit(f"{family.name}: of type {family.type}")
    for sample in family.samples:
        samples.setdefault(sample.name, []).append([sample.labels, sample.value])
if shutil.which("promtool"):
    checked = subprocess.run(["promtool", "check", "metrics"], input=text, text=True, capture_output=True)
    if checked.returncode != 0 or checked.stdout or checked.stderr:
        sys.exit(f"promtool: {checked.stdout}{checked.stderr}")
print(json.dumps(samples))
