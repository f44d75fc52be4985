#!/usr/bin/env bash
# The test suite under the address and undefined-behaviour sanitizers, then its threaded parts under the thread sanitizer.
# (libddsc itself is not instrumented.)
set -euo pipefail
cd "$(dirname "$0")/.."

deploy/install-packages.sh tests
for preset in asan tsan; do
  cmake --preset "$preset"
  cmake --build --preset "$preset"
done
ctest --preset asan
ctest --preset tsan -L threads
