#!/usr/bin/env bash
# Makes the Debian package of a release build: build/package/coppice_VERSION_ARCHITECTURE.deb.
#   deploy/package/build.sh [BUILD]      a folder that was built before (default: build/release, built first)
set -euo pipefail
cd "$(dirname "$0")/../.."

deploy/install-packages.sh package
build=${1:-build/release}
if [ $# -eq 0 ]; then
  deploy/configure.sh release
  cmake --build "$build" --target coppice coppice-worker
fi
cmake --build "$build" --target pages
(cd "$build" && cpack -G DEB -B "$PWD/package" >/dev/null)
mkdir -p build/package
rm -f build/package/coppice_*.deb
cp "$build"/package/coppice_*.deb build/package/
ls build/package/coppice_*.deb
