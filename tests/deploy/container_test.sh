#!/usr/bin/env bash
# deploy/container: the image is built with buildah on a base made by debootstrap, where no registry can be reached, and
# a coordinator and two workers run from it (by podman, or where there is none isolated by chroot) evolve the serial
# result. Takes minutes, so it is run by hand:
#   tests/deploy/container_test.sh SOURCE      needs root, buildah, debootstrap and a Debian mirror
set -euo pipefail
source=$(cd "$1" && pwd)
[ "$(id -u)" -eq 0 ] || { echo "skipped: needs root"; exit 77; }
# crun refuses where both generations of cgroups are mounted; here they may look as if there were one only.
if mountpoint -q /sys/fs/cgroup/unified; then
  exec unshare --mount bash -c 'umount /sys/fs/cgroup/unified && exec "$0" "$@"' "$0" "$source"
fi
for program in buildah debootstrap; do
  command -v $program > /dev/null || { echo "skipped: no $program"; exit 77; }
done
work=${COPPICE_CONTAINER_FOLDER:-$(mktemp -d /var/tmp/coppice-container.XXXXXX)}
rm -rf "$work/data"
mkdir -p "$work/store" "$work/run" "$work/data"
store=(--root "$work/store" --runroot "$work/run" --storage-driver vfs)
workers=()
finish() {
  for worker in "${workers[@]}"; do kill -- "-$worker" 2> /dev/null || true; done
  wait
  [ -n "${COPPICE_CONTAINER_FOLDER:-}" ] || rm -rf "$work"
}
trap finish EXIT

[ -d "$work/base/usr" ] || debootstrap --variant=minbase bookworm "$work/base" "${MIRROR:-http://deb.debian.org/debian}" > /dev/null
base=$(buildah "${store[@]}" from scratch)
buildah "${store[@]}" add -q "$base" "$work/base" / > /dev/null
buildah "${store[@]}" commit -q "$base" localhost/debian-base > /dev/null
buildah "${store[@]}" build --isolation chroot --build-arg BASE=localhost/debian-base -t coppice \
  -f "$source/deploy/container/Containerfile" "$source"

# No cgroups and no limits above what this shell may set: a container's host often is one itself.
podman=(podman --cgroup-manager cgroupfs "${store[@]}" run --rm --cgroups disabled --network host
  --ulimit "nofile=$(ulimit -n):$(ulimit -n)" --ulimit nproc=4096:4096 -v "$work/data:/work")
if command -v podman > /dev/null; then
  way=podman
  inside=("${podman[@]}" coppice)
else
  way="buildah and chroot"
  container=$(buildah "${store[@]}" from coppice)
  inside=(buildah "${store[@]}" run --isolation chroot -v "$work/data:/work" "$container")
fi
echo "run by $way"
coppice() { "${inside[@]}" coppice "$@"; }
coppice learn -o study.coppice --episodes 400 --seed 5
cp "$work/data/study.coppice" "$work/data/serial.coppice"
coppice evolve serial.coppice --serial --seed 4 --config thesis --set ga.generations=60
for _ in 1 2; do
  # In a process group of its own, to be ended as a whole.
  setsid "${inside[@]}" coppice-worker --coordinator 127.0.0.1 --domain 207 & workers+=($!)
done
coppice evolve study.coppice --remote --domain 207 --seed 4 --config thesis --set ga.generations=60
figures() { coppice info "$1" --json | sed -E 's/"(started|ended|evaluator|study)":"[^"]*",?//g; s/"seconds":[^,}]*,?//g; s/"dispatch":\{[^}]*\},?//g'; }
diff <(figures serial.coppice) <(figures study.coppice)
echo "containers evolved the serial result"
