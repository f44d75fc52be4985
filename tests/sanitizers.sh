#!/usr/bin/env bash
# The test suite under the address and undefined-behaviour sanitizers, then its threaded parts under the thread sanitizer.
# (libddsc itself is not instrumented. verify_asan_link_order=0 in the preset: the tests of jumping clocks preload faketime.)
set -euo pipefail
cd "$(dirname "$0")/.."

deploy/install-packages.sh tests
threaded=(remote_evaluation_test evolution_over_workers_test strangers_test cli_test) # ctest label "threads"
cmake --preset asan
cmake --build --preset asan
ctest --preset asan
cmake --preset tsan
cmake --build --preset tsan --target "${threaded[@]}"
ctest --preset tsan -L threads
