#!/usr/bin/env bash
# deploy/slurm/coppice.sbatch on a Slurm of this machine's own: a real slurmctld and slurmd, a coordinator and three
# workers as a job array; the coordinator is requeued in mid-run, and the result equals the serial one. Needs root and Debian's slurm-wlm.
#   slurm_test.sh SOURCE BIN      exit 77: skipped
set -euo pipefail
source=$1
bin=$2
skip() { echo "skipped: $1"; exit 77; }
[ "$(id -u)" -eq 0 ] || skip "slurmd needs root"
for program in slurmctld slurmd sbatch squeue; do
  command -v $program > /dev/null || skip "no $program: deploy/install-packages.sh slurm installs it"
done
pgrep -x slurmctld > /dev/null && skip "a slurmctld runs here already"

folder=$(mktemp -d /tmp/coppice-slurm.XXXXXX)
daemons=()
finish() {
  code=$?
  [ $code -eq 0 ] || tail -n 20 "$folder"/*.log "$folder"/slurm-* 2>/dev/null || true
  scancel --user root 2>/dev/null || true
  kill "${daemons[@]}" 2>/dev/null || true
  wait
  rm -rf "$folder"
}
trap finish EXIT
export SLURM_CONF=$folder/slurm.conf
host=$(hostname)
mkdir "$folder/state" "$folder/spool"
cat > "$SLURM_CONF" <<CONF
ClusterName=coppice-test
SlurmctldHost=$host(127.0.0.1)
SlurmUser=root
AuthType=auth/none
CredType=cred/none
SlurmctldPort=26817
SlurmdPort=26818
StateSaveLocation=$folder/state
SlurmdSpoolDir=$folder/spool
SlurmctldPidFile=$folder/slurmctld.pid
SlurmdPidFile=$folder/slurmd.pid
ProctrackType=proctrack/pgid
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SlurmdParameters=config_overrides
ReturnToService=2
SchedulerParameters=sched_interval=1,batch_sched_delay=0
NodeName=$host NodeAddr=127.0.0.1 CPUs=4 State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES MaxTime=10 State=UP
CONF
slurmctld -D > "$folder/slurmctld.log" 2>&1 & daemons+=($!)
slurmd -D -N "$host" > "$folder/slurmd.log" 2>&1 & daemons+=($!)
until sinfo -h -o %t 2> /dev/null | grep -q idle; do
  kill -0 "${daemons[@]}" || { echo "Slurm did not start"; exit 1; }
  sleep 0.2
done

"$bin/coppice" learn -o "$folder/study.coppice" --episodes 400 --seed 5 > /dev/null 2>&1
cp "$folder/study.coppice" "$folder/serial.coppice"
settings=(--config thesis --seed 4 --set ga.generations=600 --wait 120)
"$bin/coppice" evolve "$folder/serial.coppice" --serial "${settings[@]:0:6}" > "$folder/serial" 2> /dev/null
cd "$folder"
job=$(COPPICE_BIN=$bin COPPICE_LOOK_EVERY=1 sbatch --requeue --parsable --array=0-3 "$source/deploy/slurm/coppice.sbatch" "$folder/study.coppice" \
  "${settings[@]}")
# Once it has bred a few generations the coordinator is requeued; its workers find it again.
until "$bin/coppice" info study.coppice --json | grep -q '"statistics":\[{'; do sleep 0.2; done
scontrol requeue "${job}_0"
while [ -n "$(squeue -h -j "$job" 2> /dev/null)" ]; do sleep 0.3; done

figures() {
  "$bin/coppice" info "$1" --json |
    sed -E 's/"(started|ended|evaluator|study)":"[^"]*",?//g; s/"seconds":[^,}]*,?//g; s/"dispatch":\{[^}]*\},?//g'
}
figures "$folder/study.coppice" | grep -q '"status":"finished"'
diff <(figures "$folder/serial.coppice") <(figures "$folder/study.coppice")
grep -l "holds chain" "$folder"/slurm-"$job"_[123].out > /dev/null || { echo "no worker took part"; exit 1; }
[ ! -e "$folder/study.coppice.coordinator-$job" ]
echo "a Slurm job array evolved the serial result"
