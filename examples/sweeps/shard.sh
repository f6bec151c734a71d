#!/bin/sh
# One shard of a sweep, as a task of a job array: shard.sh PARTS SPEC [OPTIONS OF SWEEP ..]
#
# The folder PARTS is on a file system that all machines share. The index of the task, from 0, is that of Slurm or HyperQueue. A task that is started
# again goes on where it was.
set -eu
parts=$1
spec=$2
shift 2
if [ -n "${SLURM_ARRAY_TASK_ID:-}" ]; then
    index=$SLURM_ARRAY_TASK_ID
    count=${SHARDS:-$SLURM_ARRAY_TASK_COUNT}
    jobs=${SLURM_CPUS_PER_TASK:-1}
elif [ -n "${HQ_TASK_ID:-}" ]; then
    index=$HQ_TASK_ID
    count=${SHARDS:?"set SHARDS to the number of tasks: hq does not tell it"}
    jobs=${HQ_NUM_CPUS:-1}
else
    echo "neither SLURM_ARRAY_TASK_ID nor HQ_TASK_ID is set: start this as a task of a job array" >&2
    exit 2
fi
status=0
"${HIERARQ:-hierarq}" sweep "$spec" "$@" --shard "$((index + 1))/$count" --jobs "$jobs" --resume \
    --out "$parts/part-$index.parquet" || status=$?
# 1 says that expectations fail in some runs: a result, and no failure of the task.
[ "$status" -le 1 ]
