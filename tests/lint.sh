#!/usr/bin/env bash
# Holds the code to .clang-tidy.
#   tests/lint.sh                  every source of the programs; half an hour on two cores
#   tests/lint.sh --changed        those that differ from main, or from the commit before where main is checked out
#   tests/lint.sh --changed BASE   those that differ from BASE
# A changed header is read through the source of its name. --changed reads at most most_changed sources, and says how
# many it left to the whole run.
set -euo pipefail
cd "$(dirname "$0")/.."

readonly most_changed=12

usage() {
  echo "tests/lint.sh: $1: expected no argument, or --changed [BASE]" >&2
  exit 2
}

programs() { git ls-files 'common/*.cpp' 'coordinator/*.cpp' 'worker/*.cpp'; }

# The commit that this work left main at. On main itself: the one before. Nothing where history is not here.
base_of_change() {
  local main base
  for main in origin/main main; do
    if base=$(git merge-base HEAD "$main" 2>/dev/null) && [ "$base" != "$(git rev-parse HEAD)" ]; then
      echo "$base"
      return
    fi
  done
  git rev-parse --verify --quiet 'HEAD^' || true
}

changed_sources() {
  git diff --name-only --diff-filter=d "$1" -- common coordinator worker |
    sed -n 's/\.[ch]pp$/.cpp/p' | sort -u | comm -12 - <(programs | sort)
}

case ${1:-} in
  '')
    mapfile -t sources < <(programs)
    ;;
  --changed)
    [ $# -le 2 ] || usage "'$3'"
    base=${2:-$(base_of_change)}
    if [ -z "$base" ]; then
      echo "tests/lint.sh: this checkout has no earlier commit to compare with, so nothing is read"
      exit 0
    fi
    git rev-parse --verify --quiet "$base^{commit}" >/dev/null || usage "'$base' is no commit"
    mapfile -t sources < <(changed_sources "$base")
    if [ ${#sources[@]} -eq 0 ]; then
      echo "tests/lint.sh: no source differs from $base"
      exit 0
    fi
    if [ ${#sources[@]} -gt $most_changed ]; then
      echo "tests/lint.sh: reads $most_changed of ${#sources[@]} changed sources; tests/lint.sh reads all"
      sources=("${sources[@]:0:most_changed}")
    fi
    ;;
  *) usage "'$1'" ;;
esac

deploy/install-packages.sh tests lint
# Without unity: clang-tidy wants to know how each source is compiled by itself.
cmake --preset release -B build/lint -DCOPPICE_TESTS=OFF -DCMAKE_UNITY_BUILD=OFF >/dev/null
cmake --build build/lint --target coppice_idl # the generated headers
printf '%s\n' "${sources[@]}" | xargs -P "$(nproc)" -n 2 clang-tidy-19 -p build/lint --quiet --warnings-as-errors='*'
