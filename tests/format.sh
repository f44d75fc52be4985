#!/usr/bin/env bash
# Holds the code to .clang-format. `tests/format.sh fix` rewrites what differs.
set -euo pipefail
cd "$(dirname "$0")/.."

deploy/install-packages.sh format
mapfile -t files < <(git ls-files '*.cpp' '*.hpp')
if [ "${1:-}" = fix ]; then
  clang-format-14 -i "${files[@]}"
else
  clang-format-14 --dry-run --Werror "${files[@]}"
fi
