#!/usr/bin/python3
"""A few columns of a sweep's settings.csv as one small SVG: means with 95 % intervals. `coppice sweep` draws them all; this is for a
page that shows some, labelled in words.

    tests/bench/sweep_svg.py acting/settings.csv --columns coverage simulated_agreement reward collisions \\
        --labels 'tree' 'tree, then half' ... > acting.svg
"""
import argparse
import csv
import html
import sys

ROW, TOP, PANEL, LABEL = 22, 46, 190, 190


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("settings")
    parser.add_argument("--columns", nargs="+", required=True)
    parser.add_argument("--labels", nargs="+", help="one for each setting (default: the values of its keys)")
    parser.add_argument("--title", default="means and 95 % intervals")
    options = parser.parse_args()
    with open(options.settings) as file:
        rows = list(csv.DictReader(file))
    keys = list(rows[0])[:list(rows[0]).index("runs")]
    labels = options.labels or [" ".join(row[key] for key in keys) for row in rows]
    if len(labels) != len(rows):
        sys.exit(f"--labels: {len(labels)} found: expected {len(rows)}")
    width, height = LABEL + PANEL * len(options.columns), TOP + ROW * len(rows) + 24
    print(f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" font-family="Helvetica" font-size="12">')
    print(f'<rect width="{width}" height="{height}" fill="white"/><text x="{width / 2}" y="16" text-anchor="middle">'
          f"{html.escape(options.title)}</text>")
    for i, label in enumerate(labels):
        print(f'<text x="{LABEL - 12}" y="{TOP + ROW * i + 16}" text-anchor="end">{html.escape(label)}</text>')
    for p, column in enumerate(options.columns):
        means = [float(row[f"{column}_mean"]) for row in rows]
        margins = [float(row[f"{column}_interval"]) for row in rows]
        low = min(m - d for m, d in zip(means, margins))
        high = max(m + d for m, d in zip(means, margins))
        left, scale = LABEL + PANEL * p, (PANEL - 24) / ((high - low) or 1.0)
        bottom = TOP + ROW * len(rows)
        print(f'<text x="{left + PANEL / 2 - 12}" y="36" text-anchor="middle">{html.escape(column.replace("_", " "))}</text>'
              f'<rect x="{left}" y="{TOP}" width="{PANEL - 24}" height="{ROW * len(rows)}" fill="none" stroke="gray"/>')
        for value, anchor in ((low, "start"), (high, "end")):
            print(f'<text x="{left + (value - low) * scale:.1f}" y="{bottom + 16}" text-anchor="{anchor}">{value:.3g}</text>')
        for i, (mean, margin) in enumerate(zip(means, margins)):
            x, y, half = left + (mean - low) * scale, TOP + ROW * i + ROW / 2, margin * scale
            print(f'<path d="M{x - half:.1f},{y}H{x + half:.1f}" stroke="#1f5fa8"/><circle cx="{x:.1f}" cy="{y}" r="3" fill="#1f5fa8"/>')
    print("</svg>")


if __name__ == "__main__":
    main()
