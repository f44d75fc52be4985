#!/usr/bin/env bash
# From nothing to a readable tree on a fresh Debian 12: installs what is missing, builds a release, and runs the main
# job at the thesis' full scale with two worker processes, by the recipe `best` and seed 1. Arguments go to `coppice run`.
set -euo pipefail
cd "$(dirname "$0")/.."

deploy/install-packages.sh
deploy/configure.sh release -DCOPPICE_TESTS=OFF
cmake --build --preset release
exec build/release/bin/coppice run --workers 2 "$@"
