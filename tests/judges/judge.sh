#!/usr/bin/env bash
# Runs one file of tests by pytest in build/venv (tests/judges/venv.sh). Exit code 77, "skipped" to ctest: there is no such
# environment, or every test skipped because its package is missing; the output says which.
#   judge.sh COPPICE FILE
set -uo pipefail
cd "$(dirname "$0")/../.."

export COPPICE=$1
python=build/venv/bin/python
if [ ! -x "$python" ]; then
  echo "not run: there is no build/venv (tests/judges/venv.sh makes it)"
  exit 77
fi
report=$(mktemp)
trap 'rm -f "$report"' EXIT
"$python" -m pytest -q -rs -p no:cacheprovider --rootdir "$(dirname "$2")" "$2" 2>&1 | tee "$report"
code=${PIPESTATUS[0]}
if [ "$code" -eq 5 ] || { [ "$code" -eq 0 ] && ! grep -Eq '[0-9]+ passed' "$report"; }; then
  exit 77
fi
exit "$code"
