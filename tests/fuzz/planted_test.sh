#!/usr/bin/env bash
# The driver finds a planted bug, shows the input, and what it says makes that input again.
#   planted_test.sh PROGRAM CORPUS FILE
set -euo pipefail
program=$1 corpus=$2 file=$3

fail() { echo "$1" >&2; exit 1; }

"$program" "$corpus" || fail "the corpus alone has no bug in it"
report=$("$program" "$corpus" --inputs 100000 --seed 1 2>&1) && fail "the bug was not found"
[[ $report =~ "stopped at input "[0-9]+" (--seed 1 --only "([0-9]+)")" ]] || fail "no input in: $report"
only=${BASH_REMATCH[1]}
[[ $report == *"(("* && $report == *2828* ]] || fail "the input is not shown in: $report"
rm -f "$file"
again=$("$program" "$corpus" --seed 1 --only "$only" --save "$file" 2>&1) && fail "input $only alone was not stopped at"
[[ $again == *"stopped at"* ]] || fail "no input in: $again"
grep -q '((' "$file" || fail "$file is not that input"
"$program" "$file" >/dev/null 2>&1 && fail "$file was not stopped at"
echo "found at input $only"
