#!/usr/bin/env bash
# Fuzzes with libFuzzer under the address and undefined-behaviour sanitizers, one target after the other, until the time
# is over or one finds something.
#   tests/fuzz/run.sh [SECONDS [TARGET...]]     60 seconds each, all targets
# What it learns stays in build/fuzz/corpus/TARGET and is where the next run begins; an input that breaks a property is
# written to build/fuzz/found/TARGET-*.
set -euo pipefail
cd "$(dirname "$0")/../.."

seconds=${1:-60}
shift $(($# > 0 ? 1 : 0))
deploy/install-packages.sh tests lint
cmake --preset fuzz
cmake --build --preset fuzz --target fuzz_targets
targets=("$@")
if [ ${#targets[@]} -eq 0 ]; then
  mapfile -t targets < <(cd build/fuzz/bin && ls -1 fuzz_* | sed 's/^fuzz_//')
fi
for target in "${targets[@]}"; do
  kept=tests/fuzz/corpus/$target
  if [ "$target" = simplified_tree ]; then
    kept=tests/fuzz/corpus/tree_text
  fi
  learned=build/fuzz/corpus/$target
  mkdir -p "$learned" build/fuzz/found
  echo "== $target"
  UBSAN_OPTIONS=print_stacktrace=1 "build/fuzz/bin/fuzz_$target" -max_total_time="$seconds" -timeout=20 -rss_limit_mb=2048 \
    -max_len=65536 -print_final_stats=1 -artifact_prefix="build/fuzz/found/$target-" "$learned" "$kept"
done
