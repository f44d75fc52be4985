#!/usr/bin/env bash
# The test suite under the address and undefined-behaviour sanitizers, then its threaded parts under the thread sanitizer.
#   tests/sanitizers.sh           everything; an hour on two cores
#   tests/sanitizers.sh --short   address and undefined behaviour only, over what walks memory by hand and what reads
#                                 foreign bytes; some minutes
# (libddsc itself is not instrumented. verify_asan_link_order=0 in the preset: the tests of jumping clocks preload faketime.)
set -euo pipefail
cd "$(dirname "$0")/.."

threaded=(remote_evaluation_test evolution_over_workers_test strangers_test cli_test) # ctest label "threads"
short_programs=(tree_test chain_test fitness_test wire_test worker_test)
short_parsers=(tree_text task answer chain_bytes)

case ${1:-} in
  '' | --short) ;;
  *) echo "tests/sanitizers.sh: '$1': expected no argument, or --short" >&2; exit 2 ;;
esac

deploy/install-packages.sh tests
deploy/configure.sh asan
if [ "${1:-}" = --short ]; then
  cmake --build --preset asan --target "${short_programs[@]}" "${short_parsers[@]/%/_fuzz_test}"
  export ASAN_OPTIONS=detect_stack_use_after_return=1:strict_string_checks=1 UBSAN_OPTIONS=print_stacktrace=1
  for program in "${short_programs[@]}"; do
    echo "$program"
    build/asan/bin/"$program" --gtest_brief=1
  done
  ctest --preset asan -R "^Fuzz\\.($(IFS='|'; echo "${short_parsers[*]}"))\$"
  exit 0
fi
cmake --build --preset asan
ctest --preset asan
deploy/configure.sh tsan
cmake --build --preset tsan --target "${threaded[@]}"
ctest --preset tsan -L threads
