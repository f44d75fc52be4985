#!/usr/bin/env bash
# deploy/package: the Debian package holds what it says, and its programs run from where it puts them.
#   package_test.sh SOURCE BIN      exit 77: skipped
set -euo pipefail
source=$1
bin=$2
for program in help2man dpkg-shlibdeps; do
  command -v $program > /dev/null || { echo "skipped: no $program (deploy/install-packages.sh package)"; exit 77; }
done
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
complain() { echo "$1" >&2; exit 1; }

"$source/deploy/package/pages.sh" "$bin/coppice" "$bin/coppice-worker" "$(dirname "$bin")/pages"
(cd "$(dirname "$bin")" && cpack -G DEB -B "$folder/made" > "$folder/log") || { cat "$folder/log"; exit 1; }
package=$(ls "$folder"/made/coppice_*.deb)
depends=$(dpkg-deb -f "$package" Depends)
for library in libddsc libsqlite3 libspdlog libfmt; do
  [[ $depends == *$library* ]] || complain "the package does not depend on $library: $depends"
done

dpkg-deb -x "$package" "$folder/root"
usr=$folder/root/usr
version=$("$usr/bin/coppice" --version)
[ "$version" = "coppice $(dpkg-deb -f "$package" Version | sed 's/-.*//')" ] || complain "$version"
"$usr/bin/coppice-worker" --version > /dev/null
"$usr/bin/coppice" learn -o "$folder/study.coppice" --episodes 200 > /dev/null 2>&1
# The installed program finds the installed worker.
"$usr/bin/coppice" evolve "$folder/study.coppice" --workers 1 --config thesis --set ga.generations=3 > /dev/null 2>&1

for command in $("$usr/bin/coppice" --help | sed -n 's/^  \([a-z][a-z-]*\)  .*/\1/p'); do
  page=$usr/share/man/man1/coppice-$command.1.gz
  [ -s "$page" ] || complain "no manual page of coppice $command"
  for section in NAME SYNOPSIS OPTIONS; do
    zcat "$page" | grep -q "^\.SH $section" || complain "the page of coppice $command has no $section"
  done
done
for file in man/man1/coppice.1.gz man/man1/coppice-worker.1.gz bash-completion/completions/coppice \
  zsh/vendor-completions/_coppice fish/vendor_completions.d/coppice.fish doc/coppice/copyright; do
  [ -s "$usr/share/$file" ] || complain "the package lacks share/$file"
done
[ -s "$usr/lib/systemd/system/coppice-worker@.service" ] || complain "the package lacks the unit"
bash -n "$usr/share/bash-completion/completions/coppice"
echo "the package holds what it says, and its programs run"
