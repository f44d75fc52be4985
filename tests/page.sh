#!/usr/bin/env bash
# The tests of the page of report and studio (coordinator/studio/page). Each argument is a step; none: all of them.
#   packages   npm ci
#   types      strict TypeScript
#   unit       what needs no browser
#   built      the committed page is what its source gives
#   e2e        the real program in Chromium: COPPICE=build/release/bin/coppice
# Ends with 77, and says what is missing, where Node, npm's registry or Chromium cannot be had: ctest names it as not run.
set -euo pipefail
cd "$(dirname "$0")/../coordinator/studio/page"

not_run() {
  echo "not run: $*" >&2
  exit 77
}
command -v node >/dev/null && command -v npm >/dev/null || not_run "node and npm are not here"
[ "$(node -p 'Number(process.versions.node.split(".")[0]) >= 20')" = true ] || not_run "node $(node --version): 20 or newer is needed"

for step in "${@:-packages types unit built e2e}"; do
  for each in $step; do
    if [ "$each" = packages ]; then
      if ! cmp -s package-lock.json node_modules/.installed; then
        npm ci --no-progress || not_run "npm cannot install what package-lock.json names"
        cp package-lock.json node_modules/.installed
      fi
      continue
    fi
    [ -e node_modules/.installed ] || not_run "the packages of package-lock.json are not installed (tests/page.sh packages)"
    case $each in
      types) npx --no-install tsc --noEmit ;;
      unit) npx --no-install vitest run ;;
      built) node build.mjs --check ;;
      e2e)
        [ -x "${COPPICE_CHROMIUM:-/usr/bin/chromium}" ] || not_run "chromium is not here (deploy/install-packages.sh page)"
        node --test --test-concurrency=1 --test-reporter=spec e2e/*.e2e.mjs
        ;;
      *) echo "tests/page.sh: no step '$each': expected packages, types, unit, built or e2e" >&2; exit 2 ;;
    esac
  done
done
