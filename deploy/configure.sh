#!/usr/bin/env bash
# Configures build/PRESET. A first build takes eight sources at a time (CMAKE_UNITY_BUILD), which halves its time; a
# folder that was configured before stays as it is, so that who edits one file compiles one file (CONTRIBUTING.md).
#   deploy/configure.sh PRESET [FLAG...]      flags as cmake takes them
set -euo pipefail
cd "$(dirname "$0")/.."

preset=${1:?expected the name of a preset: release, asan, tsan, ...}
shift
if [ ! -e "build/$preset/CMakeCache.txt" ]; then
  set -- -DCMAKE_UNITY_BUILD=ON "$@"
fi
exec cmake --preset "$preset" "$@"
