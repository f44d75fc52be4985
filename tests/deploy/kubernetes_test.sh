#!/usr/bin/env bash
# deploy/kubernetes: the objects are what the API takes, and the coordinator's script begins, goes on and ends.
#   kubernetes_test.sh SOURCE BIN      exit 77: skipped
set -euo pipefail
source=$1
bin=$2
python3 -c 'import kubernetes_validate, yaml' 2> /dev/null ||
  { echo "skipped: no kubernetes-validate (pip install kubernetes-validate)"; exit 77; }
folder=$(mktemp -d)
worker=
trap 'kill $worker 2> /dev/null || true; wait; rm -rf "$folder"' EXIT

python3 - "$source/deploy/kubernetes/coppice.yaml" "$folder/start" << 'PYTHON'
import sys
import kubernetes_validate
import yaml

objects = list(yaml.safe_load_all(open(sys.argv[1])))
for it in objects:
    kubernetes_validate.validate(it, kubernetes_validate.latest_version(), strict=True)
job = next(it for it in objects if it["kind"] == "Job")
open(sys.argv[2], "w").write(job["spec"]["template"]["spec"]["containers"][0]["args"][0])
PYTHON

# The script as it stands, on this machine's loopback interface and with a small job.
PATH=$bin:$PATH
sed -i 's/--interface eth0/--domain 211/; s/coppice learn/coppice learn --episodes 200/; s/--wait 600/--wait 60 $COPPICE_TEST_FLAGS/' "$folder/start"
cd "$folder"
export COPPICE_TEST_FLAGS="--config thesis --set ga.generations=60 --lines-every 1"
"$bin/coppice-worker" --coordinator 127.0.0.1 --domain 211 --pace 1ms 2> "$folder/log" & worker=$!
sh -e start > out 2> first &
coordinator=$!
grep -q -m 1 "evolve: 5/" <(tail -n +1 --pid=$coordinator -F first 2> /dev/null) # a pod that is lost
kill -9 $coordinator
wait $coordinator 2> /dev/null || true
COPPICE_TEST_FLAGS= sh -e start > out 2> second
"$bin/coppice" info study.coppice --json > info
[ "$(grep -o '"status":"[a-z]*"' info)" = '"status":"finished"' ] || { cat second info; exit 1; }
COPPICE_TEST_FLAGS= sh -e start > out 2> third # made again after its end: nothing is left to do
[ ! -s third ]
echo "the objects are valid, and the coordinator begins, goes on and ends"
