"""Sweeps: one scenario over ranges of params and seeds, on this machine or on a Ray cluster."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from . import _hierarq
from .diagnostics import SpecError

if TYPE_CHECKING:
    import pandas
    import polars

Spec = str | os.PathLike[str]


class Sweep(Mapping[str, Any]):
    """The runs of a sweep as columns, one entry for each run, in the order of their numbers.

    The columns are those of the Parquet file: ``run``, ``seed``, ``param_NAME``, ``holds``, ``expect_1_margin``,
    ``limit_TASK_margin``, .., in SI units. Numbers are arrays with NaN where a run has none; texts are lists with ``None``.
    """

    def __init__(self, shown: dict[str, Any]) -> None:
        self._columns: dict[str, Any] = shown["columns"]
        self.summary: dict[str, Any] = json.loads(shown["summary"])

    @property
    def ok(self) -> bool:
        """True if all runs have ended and each is as expected."""
        return bool(self.summary["ok"])

    def __getitem__(self, name: str) -> Any:
        return self._columns[name]

    def __iter__(self) -> Any:
        return iter(self._columns)

    def __len__(self) -> int:
        return len(self._columns)

    def to_pandas(self) -> pandas.DataFrame:
        """The runs as a data frame of pandas."""
        import pandas

        return pandas.DataFrame(self._columns)

    def to_polars(self) -> polars.DataFrame:
        """The runs as a data frame of polars."""
        import polars

        return polars.DataFrame(self._columns)

    def __repr__(self) -> str:
        s = self.summary
        return f"<hierarq.Sweep of `{s['scenario']}`: {s['hold']} of {s['runs']} runs hold>"


def sweep(
    spec: Spec,
    *,
    scenario: str | None = None,
    vary: Mapping[str, str | Iterable[Any]] | None = None,
    runs: int | None = None,
    seed: int | None = None,
    set: Mapping[str, str | float] | None = None,
    package_paths: Iterable[Spec] = (),
    out: Spec | None = None,
    resume: bool = False,
    shard: str | None = None,
    jobs: int | None = None,
    backend: str = "threads",
) -> Sweep:
    """Runs a scenario of a file many times, as ``hierarq sweep`` does.

    ``vary`` maps params to ``"2mm..8mm"`` (drawn for each run), ``"2mm..8mm:4"`` (equal steps) or ``"2mm,5mm"`` (listed; a sequence
    does the same). ``runs`` is the number of runs at each point of the grid, ``seed`` the seed of the first. With ``out``, a Parquet file,
    runs that have ended are kept beside it, and ``resume`` continues after an interruption; without, they are in memory alone.
    ``shard="1/4"`` runs the first of four parts, for :func:`merge`. ``jobs`` is the number of threads, by default one for each
    processor.

    ``backend="ray"`` spreads the runs over the cluster to which Ray is connected, or over this machine; see :mod:`hierarq.cluster`. The
    result does not depend on the backend, bit for bit.

    Raises :class:`SpecError` if the spec has errors with one of the values.
    """
    wanted = {
        "spec": os.fspath(spec),
        "set": [(name, str(value)) for name, value in (set or {}).items()],
        "package_paths": [os.fspath(p) for p in package_paths],
        "scenario": scenario,
        "vary": [(name, _values(values)) for name, values in (vary or {}).items()],
        "runs": runs,
        "seed": seed,
        "shard": shard,
        "out": None if out is None else os.fspath(out),
        "jobs": jobs,
        "resume": resume,
    }
    if resume and out is None:
        raise ValueError("`resume` continues the sweep of a file: give `out`")
    if backend == "threads":
        return _run(wanted)
    if backend == "ray":
        if shard is not None or jobs is not None or out is None:
            raise ValueError("Ray cuts the sweep itself, and writes a file: give `out`, and neither `shard` nor `jobs`")
        from . import cluster

        return cluster.sweep(wanted)
    raise ValueError(f"there is no backend `{backend}`: there are threads and ray")


def merge(files: Iterable[Spec], out: Spec) -> Sweep:
    """Merges the files of all shards of a sweep into ``out``: the same bytes as those of a sweep that was not cut."""
    return Sweep(_hierarq.merged([Path(f) for f in files], Path(out)))


def _run(wanted: dict[str, Any]) -> Sweep:
    shown, report = _hierarq.sweep(wanted)
    if report is not None:
        raise SpecError._of([report])
    return Sweep(shown)


def _values(values: str | Iterable[Any]) -> str:
    return values if isinstance(values, str) else ",".join(str(v) for v in values)
