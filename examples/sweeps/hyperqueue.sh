#!/bin/sh
# A sweep on HyperQueue: hyperqueue.sh SHARDS OUT SPEC [OPTIONS OF SWEEP ..]
#
#   examples/sweeps/hyperqueue.sh 64 sweep.parquet examples/tested.hq --scenario "found at second sight" --vary near=2mm..8mm --runs 10000
#
# Needs a server and workers: `hq server start`, `hq worker start`. The tasks compute parts in the folder OUT.parts, and are merged when
# all have succeeded. The merged file has the same bytes as that of one machine.
set -eu
shards=$1
out=$2
shift 2
parts=$out.parts
here=$(dirname "$0")
mkdir -p "$parts"
last=$((shards - 1))
hq submit --wait --name sweep --array "0-$last" --crash-limit 5 --env "SHARDS=$shards" --env "HIERARQ=${HIERARQ:-hierarq}" \
    --stdout "$parts/part-%{TASK_ID}.log" --stderr "$parts/part-%{TASK_ID}.err" -- sh "$here/shard.sh" "$parts" "$@"
set --
for index in $(seq 0 "$last"); do set -- "$@" "$parts/part-$index.parquet"; done
"${HIERARQ:-hierarq}" sweep --merge "$@" --out "$out"
