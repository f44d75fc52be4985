#!/usr/bin/env bash
# Holds the code to .clang-format and .clang-tidy. `tests/lint.sh fix` rewrites what clang-format would.
set -euo pipefail
cd "$(dirname "$0")/.."

deploy/install-packages.sh tests lint
mapfile -t files < <(git ls-files '*.cpp' '*.hpp')
if [ "${1:-}" = fix ]; then
  clang-format-14 -i "${files[@]}"
  exit 0
fi
clang-format-14 --dry-run --Werror "${files[@]}"
cmake --preset release -DCOPPICE_TESTS=ON >/dev/null
cmake --build --preset release --target coppice_idl # the generated headers
mapfile -t sources < <(git ls-files 'common/*.cpp' 'coordinator/*.cpp' 'worker/*.cpp')
printf '%s\n' "${sources[@]}" | xargs -P "$(nproc)" -n 4 clang-tidy-19 -p build/release --quiet --warnings-as-errors='*'
