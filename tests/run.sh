#!/usr/bin/env bash
# Installs what the tests need, builds a release and runs every test. Arguments go to ctest (-R NAME, -V, ...).
set -euo pipefail
cd "$(dirname "$0")/.."

deploy/install-packages.sh tests page
tests/judges/venv.sh
deploy/configure.sh release -DCOPPICE_TESTS=ON
cmake --build --preset release
ctest --preset release "$@"
