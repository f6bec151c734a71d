"""Sweeps on a cluster, by Ray.

The sweep is cut into shards. Each is a task of one processor, which writes its part as a file of its own and returns its bytes; a task whose
worker dies is started again by Ray. The driver keeps the parts in the folder ``OUT.parts`` and merges them into the bytes that a single
machine would have written. With ``resume``, parts that are there are not run again.

Workers need the package ``hierarq`` in the same version, and the spec with its files at the same path: on a cluster, a shared file system.
"""

from __future__ import annotations

import math
import os
import shutil
import tempfile
from pathlib import Path
from typing import Any

from . import _hierarq
from .diagnostics import SpecError
from .sweeps import Sweep, _run, merge

# Shards for each processor: the last ones to end keep the others idle for a sixteenth of their share at most.
SHARDS = 16
# Times that a task is started again whose worker has died.
RETRIES = 5


def part(wanted: dict[str, Any], folder: str) -> bytes:
    """Runs a shard of a sweep that was begun in this folder, and returns its file."""
    before = os.getcwd()
    os.chdir(folder)
    try:
        with tempfile.TemporaryDirectory() as own:
            out = Path(own) / "part.parquet"
            _run({**wanted, "out": str(out), "jobs": 1, "resume": False})
            return out.read_bytes()
    finally:
        os.chdir(before)


def sweep(wanted: dict[str, Any]) -> Sweep:
    """Runs a sweep on the cluster to which Ray is connected; starts Ray on this machine if there is none."""
    try:
        import ray
    except ImportError:
        raise ImportError("the backend `ray` needs Ray: python -m pip install ray") from None
    runs, report = _hierarq.sweep_runs(wanted)
    if report is not None:
        raise SpecError._of([report])
    out = Path(wanted["out"])
    folder = out.with_name(out.name + ".parts")
    if folder.exists() and not wanted["resume"]:
        raise FileExistsError(f"{folder} has the parts of an earlier sweep: continue it by `resume=True`, or delete it")
    folder.mkdir(parents=True, exist_ok=True)
    if not ray.is_initialized():
        ray.init(include_dashboard=False, log_to_driver=False)
    # A sweep that is continued keeps the shards with which it began, on whatever cluster that was.
    begun = folder / "shards"
    if not begun.exists():
        processors = math.floor(ray.cluster_resources().get("CPU", 1))
        begun.write_text(str(min(runs, SHARDS * max(1, processors))))
    count = int(begun.read_text())
    files = {f"{i}/{count}": folder / f"{i}.parquet" for i in range(1, count + 1)}
    task = ray.remote(num_cpus=1, max_retries=RETRIES)(part)
    pending = {
        task.remote({**wanted, "shard": shard}, os.getcwd()): file for shard, file in files.items() if not file.exists()
    }
    try:
        while pending:
            (ended,), _ = ray.wait(list(pending), num_returns=1)
            file = pending.pop(ended)
            # A part that is there is a whole one.
            partial = file.with_suffix(".partial")
            partial.write_bytes(ray.get(ended))
            partial.rename(file)
    finally:
        for unfinished in pending:
            ray.cancel(unfinished, force=True)
    result = merge(files.values(), out)
    shutil.rmtree(folder)
    return result
