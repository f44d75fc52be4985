#!/usr/bin/env bash
# What encryption costs on this machine: `coppice bench` with and without it, in turn, and the medians.
#   deploy/security/cost.sh [ROUNDS]     needs a release build (deploy/quickstart.sh makes one)
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
coppice=${COPPICE:-$here/../../build/release/bin/coppice}
rounds=${1:-5}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"$here/make-certificates.sh" "$folder/sec" > /dev/null

# Of every workload: its name, seconds of a generation on two workers, and seconds of the same batches on bare DDS.
bench() {
  "$coppice" bench --workers 2 --repetitions 5 "$@" | awk '
    function seconds(value, unit) { return unit == "us" ? value / 1e6 : unit == "ms" ? value / 1e3 : value }
    / individuals, / { name = $1; sub(":", "", name) }
    $1 == 2 && $2 == "workers" {
      n = 0
      for (i = 3; i < NF; ++i) if ($(i + 1) ~ /^(us|ms|s)$/) time[n++] = seconds($i, $(i + 1))
      if (n >= 3) print name, time[0], time[2] # not the verdict below the table
    }'
}
for _ in $(seq "$rounds"); do
  bench >> "$folder/plain"
  bench --security "$folder/sec" >> "$folder/secured"
done

median() { # file, workload, column
  awk -v name="$2" -v column="$3" '$1 == name { print $column }' "$folder/$1" | sort -g | sed -n "$(((rounds + 1) / 2))p"
}
echo "two workers, medians of $rounds; a generation, and its batches alone"
for workload in empty light medium heavy; do
  awk -v name="$workload" -v p="$(median plain "$workload" 2)" -v s="$(median secured "$workload" 2)" \
    -v bp="$(median plain "$workload" 3)" -v bs="$(median secured "$workload" 3)" \
    'BEGIN { printf "  %-7s plain %8.3f ms, secured %8.3f ms: %.2f times   bare DDS %.3f ms, %.3f ms: %.2f times\n",
             name, p * 1e3, s * 1e3, s / p, bp * 1e3, bs * 1e3, bs / bp }'
done
