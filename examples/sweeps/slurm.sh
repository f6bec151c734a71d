#!/bin/sh
# A sweep on Slurm: slurm.sh SHARDS OUT SPEC [OPTIONS OF SWEEP ..]
#
#   examples/sweeps/slurm.sh 64 sweep.parquet examples/tested.hq --scenario "found at second sight" --vary near=2mm..8mm --runs 10000
#
# An array of SHARDS tasks computes the parts, in the folder OUT.parts; a second job merges them when all have succeeded. Tasks that
# were requeued go on where they were. The merged file has the same bytes as that of one machine.
set -eu
shards=$1
out=$2
shift 2
parts=$out.parts
here=$(dirname "$0")
mkdir -p "$parts"
last=$((shards - 1))
array=$(SHARDS=$shards sbatch --parsable --export=ALL --job-name=sweep --array="0-$last" --requeue \
    --output="$parts/part-%a.log" "$here/shard.sh" "$parts" "$@")
list=""
for index in $(seq 0 "$last"); do list="$list '$parts/part-$index.parquet'"; done
sbatch --parsable --job-name=merge --dependency="afterok:$array" --output="$parts/merge.log" \
    --wrap="${HIERARQ:-hierarq} sweep --merge $list --out '$out'"
