"""Sweeps in memory, in files, cut and merged, and on a cluster."""

import os
import pickle
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest

import hierarq

SCENARIO = "found at second sight"
VARY = {"near": "2mm..8mm"}


def test_a_sweep_is_a_table(examples, tmp_path):
    kept = hierarq.sweep(examples / "tested.hq", scenario=SCENARIO, vary=VARY, runs=6, out=tmp_path / "whole.parquet")
    loose = hierarq.sweep(examples / "tested.hq", scenario=SCENARIO, vary=VARY, runs=6, jobs=1)
    assert list(kept) == list(loose) and len(kept["run"]) == 6
    for name in kept:
        np.testing.assert_array_equal(kept[name], loose[name])
    near = kept["param_near"]
    assert np.all((near >= 0.002) & (near <= 0.008)) and len(set(near)) == 6
    assert kept.ok == bool(np.all(kept["holds"])) and kept.summary["runs"] == 6
    assert list(kept.to_pandas().columns) == list(kept)


def test_parts_are_merged_to_the_same_bytes(examples, tmp_path):
    def run(name: str, **kwargs):
        return hierarq.sweep(examples / "tested.hq", scenario=SCENARIO, vary=VARY, runs=5, out=tmp_path / name, **kwargs)

    run("whole.parquet")
    for i in (1, 2):
        run(f"{i}.parquet", shard=f"{i}/2")
    hierarq.merge([tmp_path / "1.parquet", tmp_path / "2.parquet"], tmp_path / "merged.parquet")
    assert (tmp_path / "merged.parquet").read_bytes() == (tmp_path / "whole.parquet").read_bytes()
    with pytest.raises(ValueError, match="missing"):
        hierarq.merge([tmp_path / "1.parquet"], tmp_path / "half.parquet")


def test_values_are_listed(examples):
    swept = hierarq.sweep(examples / "tested.hq", scenario=SCENARIO, vary={"near": ["3 mm", "5 mm"]})
    np.testing.assert_allclose(swept["param_near"], [0.003, 0.005])


def test_a_wrong_sweep_is_not_run(examples, tmp_path):
    with pytest.raises(hierarq.SpecError, match="did you mean `near`"):
        hierarq.sweep(examples / "tested.hq", scenario=SCENARIO, vary={"nar": "2mm..8mm"})
    with pytest.raises(ValueError, match="A..B"):
        hierarq.sweep(examples / "tested.hq", scenario=SCENARIO, vary={"near": ""})
    with pytest.raises(ValueError, match="I/N"):
        hierarq.sweep(examples / "tested.hq", scenario=SCENARIO, shard="3/2")
    with pytest.raises(ValueError, match="give `out`"):
        hierarq.sweep(examples / "tested.hq", scenario=SCENARIO, resume=True)
    with pytest.raises(ValueError, match="backend"):
        hierarq.sweep(examples / "tested.hq", scenario=SCENARIO, backend="mpi")
    (tmp_path / "wrong.hq").write_text("hierarq 1\nrobot arm { urdf \"none.urdf\"  rate 100 Hz }\n")
    for backend in ("threads", "ray"):
        if backend == "ray":
            pytest.importorskip("ray")
        with pytest.raises(hierarq.SpecError, match="none.urdf") as raised:
            hierarq.sweep(tmp_path / "wrong.hq", out=tmp_path / "out.parquet", backend=backend)
        assert raised.value.diagnostics[0].line == 2
        again = pickle.loads(pickle.dumps(raised.value))
        assert str(again) == str(raised.value) and again.diagnostics == raised.value.diagnostics


def test_an_interrupted_sweep_is_continued(examples, tmp_path):
    out = tmp_path / "long.parquet"
    text = (
        "import hierarq, sys\n"
        "hierarq.sweep(sys.argv[1], scenario=sys.argv[2], runs=100000, out=sys.argv[3])\n"
    )
    arguments = [sys.executable, "-c", text, str(examples / "tested.hq"), SCENARIO, str(out)]
    child = subprocess.Popen(arguments, stderr=subprocess.PIPE, text=True)
    journal = Path(f"{out}.journal")
    while not (journal.exists() and journal.read_bytes().count(b"\n") > 3):
        assert child.poll() is None
        time.sleep(0.05)
    child.send_signal(signal.SIGINT)
    _, errors = child.communicate(timeout=60)
    assert "KeyboardInterrupt" in errors and not out.exists()
    assert journal.read_bytes().count(b"\n") > 3


def test_a_cluster_gives_the_same_bytes_though_a_worker_dies(examples, tmp_path):
    ray = pytest.importorskip("ray")
    psutil = pytest.importorskip("psutil")
    wanted = {"scenario": SCENARIO, "vary": VARY, "runs": 120}
    hierarq.sweep(examples / "tested.hq", out=tmp_path / "here.parquet", **wanted)
    # Workers are processes of their own and find the package where this one does.
    environment = {"env_vars": {"PYTHONPATH": os.pathsep.join(p for p in sys.path if p)}}
    ray.init(num_cpus=2, include_dashboard=False, log_to_driver=False, runtime_env=environment)
    killed = []

    def kill() -> None:
        while not killed:
            for process in psutil.Process().children(recursive=True) + list(psutil.process_iter()):
                try:
                    if "ray::part" in " ".join(process.cmdline()):
                        process.kill()
                        killed.append(process.pid)
                        return
                except psutil.Error:
                    pass
            time.sleep(0.01)

    killer = threading.Thread(target=kill, daemon=True)
    killer.start()
    try:
        there = hierarq.sweep(examples / "tested.hq", out=tmp_path / "there.parquet", backend="ray", **wanted)
    finally:
        ray.shutdown()
    assert killed and there.summary["runs"] == 120
    assert (tmp_path / "there.parquet").read_bytes() == (tmp_path / "here.parquet").read_bytes()
    assert not (tmp_path / "there.parquet.parts").exists()
