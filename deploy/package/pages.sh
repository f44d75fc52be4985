#!/usr/bin/env bash
# Manual pages and completions of both programs, from what they say themselves.
#   pages.sh COPPICE WORKER FOLDER      paths of the programs; FOLDER is made anew: man1/, bash/, zsh/, fish/
set -euo pipefail
coppice=$1
worker=$2
folder=$3
command -v help2man >/dev/null || { echo "pages.sh: no help2man: deploy/install-packages.sh package" >&2; exit 1; }
version=$("$coppice" --version | awk '{print $2}')

made=$(mktemp -d)
trap 'rm -rf "$made"' EXIT
mkdir -p "$made"/pages/{man1,bash,zsh,fish} "$made/bin"

# A page from `PROGRAM [COMMAND] --help`. help2man takes "Examples:" for a section of its own only behind a blank line,
# and would flow the lines of an example into one.
page() {
  local name=$1 program=$2
  shift 2
  printf '#!/bin/sh\n"%s" %s --help | sed "s/^Examples\\{0,1\\}:$/\\n*Examples*/; s|^Usage: .*/|Usage: |"\n' "$program" "$*" >"$made/bin/$name"
  chmod +x "$made/bin/$name"
  local purpose
  purpose=$("$program" "$@" --help | head -n 1)
  help2man --no-info --version-string="$version" --name="${purpose%.}" --source="Coppice $version" "$made/bin/$name" |
    awk '/^\.IP$/ { print; print ".nf"; plain = 1; next }
         plain && /^\.[A-Z]/ { print ".fi"; plain = 0 }
         /^\.TH/ { $2 = "\"" toupper(name) "\"" }
         { print }
         END { if (plain) print ".fi" }' name="$name" |
    gzip -9n >"$made/pages/man1/$name.1.gz"
}

page coppice "$coppice"
page coppice-worker "$worker"
"$coppice" --help | sed -n 's/^  \([a-z][a-z-]*\)  .*/\1/p' >"$made/commands"
[ -s "$made/commands" ] || { echo "pages.sh: $coppice --help names no command" >&2; exit 1; }
while read -r command; do
  page "coppice-$command" "$coppice" "$command"
done <"$made/commands"

for shell in bash zsh fish; do
  case $shell in
    bash) file=bash/coppice ;;
    zsh) file=zsh/_coppice ;;
    fish) file=fish/coppice.fish ;;
  esac
  "$coppice" completion "$shell" >"$made/pages/$file"
done

rm -rf "$folder"
mkdir -p "$(dirname "$folder")"
mv "$made/pages" "$folder"
