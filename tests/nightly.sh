#!/usr/bin/env bash
# What takes too long for every change: the whole lint, the whole suite under the sanitizers, an hour of faults, and the
# fuzzers. Each goes on whatever the others say. Logs: build/nightly/DATE/NAME.log, the last kept_nights of them.
#   tests/nightly.sh [NAME...]   suite, lint, sanitizers, soak, fuzz, simulation; all without NAME
# Ends with one line each, and with 1 if any failed. From cron: 0 1 * * * /path/to/coppice/tests/nightly.sh
set -euo pipefail
cd "$(dirname "$0")/.."

readonly soak_minutes=60
readonly fuzz_seconds=600 # for each target
readonly kept_nights=14
readonly simulated_seeds=0:200000
readonly all=(suite lint sanitizers soak fuzz simulation)

command_of() {
  case $1 in
    suite) echo tests/run.sh ;;
    lint) echo tests/lint.sh ;;
    sanitizers) echo tests/sanitizers.sh ;;
    soak) echo tests/e2e/soak --minutes $soak_minutes --seed "$(date +%Y%m%d)" ;;
    simulation) echo build/release/bin/simulate --seeds $simulated_seeds ;;
    fuzz) echo tests/fuzz/run.sh $fuzz_seconds ;;
    *) echo "tests/nightly.sh: '$1': expected ${all[*]}" >&2; return 2 ;;
  esac
}

parts=("$@")
[ ${#parts[@]} -gt 0 ] || parts=("${all[@]}")
for part in "${parts[@]}"; do
  command_of "$part" >/dev/null
done

logs=build/nightly/$(date +%Y-%m-%dT%H%M%S)
mkdir -p "$logs"
find build/nightly -mindepth 1 -maxdepth 1 -type d | sort | head -n -$kept_nights | xargs -r rm -r --
summary=()
failed=0
for part in "${parts[@]}"; do
  read -ra command <<<"$(command_of "$part")"
  began=$SECONDS
  echo "${command[*]} > $logs/$part.log"
  if "${command[@]}" >"$logs/$part.log" 2>&1; then
    outcome=passed
  else
    outcome="failed with $?, see $logs/$part.log"
    failed=1
  fi
  summary+=("$part: $outcome ($(((SECONDS - began) / 60)) min)")
done
printf '%s\n' "${summary[@]}" | tee "$logs/summary"
exit $failed
