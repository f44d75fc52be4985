#!/usr/bin/env bash
# Makes build/venv, the Python environment of the judges and of deploy/python's tests: the pinned packages, and our own
# package as an editable install. Made anew only when requirements.txt or pyproject.toml changed. Where a package
# cannot be had the judges that need it skip, by name; without Python or a package index there is no environment, which is
# said and is no failure: tests/judges/judge.sh then skips.
set -euo pipefail
cd "$(dirname "$0")/../.."

venv=build/venv
requirements=tests/judges/requirements.txt
stamp=$(cat "$requirements" deploy/python/pyproject.toml | sha256sum | cut -d' ' -f1)
if [ -x "$venv/bin/python" ] && [ "$(cat "$venv/stamp" 2>/dev/null)" = "$stamp" ]; then
  exit 0
fi
mkdir -p build
rm -rf "$venv"
if ! python3 -m venv "$venv"; then
  rm -rf "$venv"
  echo "judges: no Python environment could be made (is python3-venv missing?): they will not run" >&2
  exit 0
fi
pip="$venv/bin/python -m pip --disable-pip-version-check"
if ! $pip install --quiet --requirement "$requirements"; then
  echo "judges: not every package could be had; one after another now" >&2
  while read -r package; do
    case $package in '' | '#'*) continue ;; esac
    $pip install --quiet "$package" || echo "judges: $package could not be had: who needs it will not run" >&2
  done < "$requirements"
fi
# Of dtControl only the loader is wanted, which needs pandas and sympy; as a whole it brings a web server.
$pip install --quiet --no-deps dtcontrol==2.1.15 || echo "judges: dtcontrol could not be had: who needs it will not run" >&2
if ! $pip install --quiet --editable deploy/python; then
  rm -rf "$venv"
  echo "judges: deploy/python could not be installed: they will not run" >&2
  exit 0
fi
echo "$stamp" > "$venv/stamp"
