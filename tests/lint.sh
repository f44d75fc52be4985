#!/usr/bin/env bash
# Holds the code to .clang-tidy.
set -euo pipefail
cd "$(dirname "$0")/.."

deploy/install-packages.sh tests lint
cmake --preset release -DCOPPICE_TESTS=ON >/dev/null
cmake --build --preset release --target coppice_idl # the generated headers
mapfile -t sources < <(git ls-files 'common/*.cpp' 'coordinator/*.cpp' 'worker/*.cpp')
printf '%s\n' "${sources[@]}" | xargs -P "$(nproc)" -n 4 clang-tidy-19 -p build/release --quiet --warnings-as-errors='*'
