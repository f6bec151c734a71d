//! The scripts of job arrays in `examples/sweeps`, with a queue that runs each task at once, in an order of its own: the merged
//! file has the bytes of one sweep. Slurm and HyperQueue are played by scripts which take what theirs take.

use std::os::unix::fs::PermissionsExt;
use std::process::Command;

use super::*;

/// `sbatch` with the options that the script uses: it runs the tasks from the last to the first, each twice, as if it were requeued.
const SBATCH: &str = r#"#!/bin/sh
set -eu
array= wrap= depends=
while [ $# -gt 0 ]; do
    case "$1" in
        --array=*) array=${1#--array=} ;;
        --wrap=*) wrap=${1#--wrap=} ;;
        --dependency=afterok:*) depends=${1#--dependency=afterok:} ;;
        --parsable | --export=ALL | --requeue | --job-name=* | --output=*) ;;
        --*) echo "unknown option $1" >&2; exit 1 ;;
        *) break ;;
    esac
    shift
done
if [ -n "$wrap" ]; then
    [ "$depends" = 4711 ] && sh -c "$wrap" >&2
    exit
fi
last=${array#0-}
index=$last
while [ "$index" -ge 0 ]; do
    SLURM_ARRAY_TASK_ID=$index SLURM_ARRAY_TASK_COUNT=$((last + 1)) "$@" >&2
    SLURM_ARRAY_TASK_ID=$index SLURM_ARRAY_TASK_COUNT=$((last + 1)) "$@" >&2
    index=$((index - 1))
done
echo 4711
"#;

/// `hq submit` with the options that the script uses.
const HQ: &str = r#"#!/bin/sh
set -eu
[ "$1" = submit ] && shift
last=
while [ "$1" != -- ]; do
    case "$1" in
        --array) last=${2#0-}; shift ;;
        --env) export "$2"; shift ;;
        --name | --crash-limit | --stdout | --stderr) shift ;;
        --wait) ;;
        *) echo "unknown option $1" >&2; exit 1 ;;
    esac
    shift
done
shift
index=$last
while [ "$index" -ge 0 ]; do
    HQ_TASK_ID=$index HQ_NUM_CPUS=2 "$@" >&2
    index=$((index - 1))
done
"#;

#[test]
fn job_arrays_give_the_bytes_of_one_sweep() {
    let dir = folder("arrays");
    let queue = dir.join("queue");
    std::fs::create_dir(&queue).expect("writable");
    for (name, script) in [("sbatch", SBATCH), ("hq", HQ)] {
        std::fs::write(queue.join(name), script).expect("writable");
        std::fs::set_permissions(queue.join(name), std::fs::Permissions::from_mode(0o755)).expect("own");
    }
    hierarq(&dir, &varied(&["--out", "one.parquet"]));
    let path = format!("{}:{}", queue.display(), std::env::var("PATH").expect("a path"));
    for (script, out) in [("slurm.sh", "slurm.parquet"), ("hyperqueue.sh", "hq.parquet")] {
        let done = Command::new(common::example("sweeps").join(script))
            .current_dir(&dir)
            .env("PATH", &path)
            .env("HIERARQ", env!("CARGO_BIN_EXE_hierarq"))
            .args(["4", out])
            .args(&VARIED[1..])
            .output()
            .expect("a shell");
        let text = String::from_utf8_lossy(&done.stderr).into_owned();
        // Some of the runs fail, which the merged file says like one sweep.
        assert!(dir.join(out).exists(), "{script}: {text}");
        assert_eq!(bytes(&dir, out), bytes(&dir, "one.parquet"), "{script}: {text}");
    }
    let alone = Command::new(common::example("sweeps").join("shard.sh"))
        .env_remove("SLURM_ARRAY_TASK_ID")
        .args([".", "spec.hq"])
        .output()
        .expect("a shell");
    assert_eq!(alone.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&alone.stderr).contains("task of a job array"));
}
