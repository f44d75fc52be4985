#!/usr/bin/env bash
# deploy/systemd: the unit is valid, exposes little, and its command line with its environment makes a worker that serves,
# with an identity as security.conf hands it over.
#   systemd_test.sh SOURCE BIN      exit 77: skipped
set -euo pipefail
source=$1
bin=$2
command -v systemd-analyze > /dev/null || { echo "skipped: no systemd-analyze"; exit 77; }
folder=$(mktemp -d)
worker=
trap 'kill $worker 2> /dev/null || true; wait; rm -rf "$folder"' EXIT

# The verifier wants programs and files where the unit has them.
sed "s|^ExecStart=coppice-worker|ExecStart=$bin/coppice-worker|; s|/etc/coppice|$folder|" \
  "$source/deploy/systemd/coppice-worker@.service" > "$folder/coppice-worker@.service"
cp "$source/deploy/systemd/worker.conf" "$folder/"
said=$(systemd-analyze verify "$folder/coppice-worker@3.service" 2>&1 | grep "coppice-worker" || true)
[ -z "$said" ] || { echo "$said"; exit 1; }

# Tenths; 10.0 would be a service without any protection. Older versions cannot tell without a running systemd.
if systemd-analyze security --help | grep -q -- --offline; then
  systemd-analyze security --offline=true --threshold=15 "$folder/coppice-worker@.service" > "$folder/exposure" 2>&1 ||
    { tail -n 1 "$folder/exposure"; echo "expected an exposure of at most 1.5"; exit 1; }
fi
# security.conf names each file of an identity, and no other.
"$source/deploy/security/make-certificates.sh" "$folder/keys" > "$folder/log" 2>&1
named=$(sed -n 's/^LoadCredential=\([^:]*\):.*/\1/p' "$source/deploy/systemd/security.conf" | sort)
diff <(echo "$named") <(cd "$folder/keys/worker" && ls)

# What ExecStart says, in a domain of the test's own and with this machine as coordinator.
. <(sed 's/=\(.*\)/="\1"/' "$folder/worker.conf")
COPPICE_COORDINATOR=127.0.0.1
CACHE_DIRECTORY=$folder/cache
COPPICE_SECURITY="--security $folder/keys/worker" # as security.conf has it, with systemd's folder for %d
line=$(sed -n 's/^ExecStart=//p' "$folder/coppice-worker@.service")
line=${line//%i/206}
eval "exec $line" 2> "$folder/log" & worker=$!
"$bin/coppice" learn -o "$folder/study.coppice" --episodes 200 > /dev/null 2>&1
"$bin/coppice" evolve "$folder/study.coppice" --remote --domain 206 --wait 60 \
  --security "$folder/keys/coordinator" --config thesis --set ga.generations=10 > /dev/null 2>&1
grep -q "serving the coordinator" "$folder/log"
ls "$folder"/cache/*.chain > /dev/null
echo "the unit is valid and its command serves"
