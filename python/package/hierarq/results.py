"""Results of runs and plans."""

from __future__ import annotations

import html
import json
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    import pandas
    import polars


@dataclass(frozen=True, repr=False)
class Result:
    """Every tick of a run: ``table[i, j]`` is the number of column ``names[j]`` at tick ``i``, in SI units.

    The columns are those of ``log.csv``: ``time``, ``q.JOINT``, ``v.JOINT``, ``cmd.JOINT``, ``margin.TASK``, ``error.TASK``,
    ``signal.NAME``. A number that is not defined is not finite. ``states`` has the state of the machine at each tick, and ``faults`` the kind
    of a fault or an empty text.
    """

    names: list[str]
    table: NDArray[np.float64]
    states: list[str] | None
    faults: list[str]
    ok: bool
    summary: dict[str, Any]
    _page: str

    @classmethod
    def _of(cls, data: dict[str, Any]) -> Result:
        keys = ("names", "table", "states", "faults", "ok")
        return cls(*(data[k] for k in keys), json.loads(data["summary"]), data["page"])

    def __getitem__(self, name: str) -> NDArray[np.float64]:
        """The column of this name."""
        try:
            return self.table[:, self.names.index(name)]
        except ValueError:
            raise KeyError(f"there is no column `{name}`; see `names`") from None

    def __len__(self) -> int:
        return len(self.table)

    def _columns(self, prefix: str) -> NDArray[np.float64]:
        chosen = [i for i, name in enumerate(self.names) if name.startswith(prefix)]
        return self.table[:, chosen]

    @property
    def time(self) -> NDArray[np.float64]:
        """Times of the ticks (s), shape ``(ticks,)``."""
        return self["time"]

    @property
    def q(self) -> NDArray[np.float64]:
        """True configurations, shape ``(ticks, nq)``."""
        return self._columns("q.")

    @property
    def v(self) -> NDArray[np.float64]:
        """Velocities that the hierarchy chose, shape ``(ticks, nv)``."""
        return self._columns("v.")

    @property
    def expectations(self) -> list[dict[str, Any]]:
        """Expectations of the scenario with their outcomes; empty without a scenario."""
        return self.summary.get("expectations", [])

    def _data(self) -> dict[str, Any]:
        data: dict[str, Any] = {name: self.table[:, i] for i, name in enumerate(self.names)}
        if self.states is not None:
            data["state"] = self.states
        data["fault"] = self.faults
        return data

    def to_pandas(self) -> pandas.DataFrame:
        """The ticks as a data frame of pandas."""
        import pandas

        return pandas.DataFrame(self._data())

    def to_polars(self) -> polars.DataFrame:
        """The ticks as a data frame of polars."""
        import polars

        return polars.DataFrame(self._data())

    def to_html(self) -> str:
        """The report of the run, a page of its own."""
        return self._page

    def _repr_html_(self) -> str:
        return f'<iframe srcdoc="{html.escape(self._page)}" width="100%" height="720" style="border:0"></iframe>'

    def __repr__(self) -> str:
        end = self.time[-1] if len(self) else 0.0
        return f"<hierarq.Result {'ok' if self.ok else 'FAILED'}, {len(self)} ticks to {end:.3f} s>"


class ScenarioResult(dict[str, Any]):
    """The outcome of a scenario, with the keys of ``hierarq test --json``."""

    @property
    def ok(self) -> bool:
        """True if everything is as expected."""
        return bool(self["ok"])

    def __repr__(self) -> str:
        return f"<hierarq.ScenarioResult {self['spec']}: {self['scenario']}: {'ok' if self.ok else 'FAILED'}>"


class Plan(dict[str, Any]):
    """A plan of a mission, with the keys of ``hierarq plan --json``."""

    def __init__(self, data: dict[str, Any], chart: str) -> None:
        super().__init__(data)
        self.chart = chart

    def _repr_svg_(self) -> str:
        return self.chart
