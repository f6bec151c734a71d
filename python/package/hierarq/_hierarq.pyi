"""Types of the extension module; `help` shows what each does, with shapes and units."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]
Value = float | bool | ArrayLike | None

class Program:
    name: str
    period: float
    duration: float
    signals: list[tuple[str, str, int]]
    events: list[str]
    stacks: list[str]
    states: list[str]
    scenarios: list[str]
    missions: list[str]
    robot: Robot
    def to_json(self) -> str: ...
    def controller(self, stack: str | None = None, *, interval: float | None = None) -> Controller: ...
    def batch(self, n: int, threads: int | None = None) -> Batch: ...
    def mission(
        self, name: str | None = None, *, reporting: Sequence[str] = (), seed: int | None = None
    ) -> Mission: ...

class Robot:
    name: str
    nq: int
    nv: int
    q_names: list[str]
    v_names: list[str]
    links: list[str]
    home: Floats
    lower: Floats
    upper: Floats
    max_velocity: Floats
    def pose(self, q: ArrayLike, link: str) -> Floats: ...
    def jacobian(self, q: ArrayLike, link: str) -> Floats: ...
    def order(self, names: Sequence[str]) -> NDArray[np.intp]: ...

class Controller:
    state: str
    is_final: bool
    is_halted: bool
    period: float
    measured_rate: float | None
    reference: Floats
    def step(
        self,
        q: ArrayLike,
        *,
        t: float | None = None,
        enabled: bool | None = None,
        signals: Mapping[str, Value] | None = None,
        humans: Mapping[str, Mapping[str, ArrayLike | None]] | None = None,
        events: str | Sequence[str] | None = None,
    ) -> Command: ...
    def restart(self) -> None: ...
    def stop(self) -> None: ...
    def resume(self) -> None: ...
    def relocated(self) -> None: ...
    def value(self, name: str) -> Floats | None: ...

class Command:
    time: float
    velocity: Floats
    position: Floats
    state: str
    fault: str | None
    fault_text: str | None
    late: bool
    at_rest: bool
    is_blending: bool
    is_final: bool
    is_halted: bool
    requests: list[tuple[str, list[str], bool]]
    margins: dict[str, Floats]
    errors: dict[str, Floats]
    active: list[tuple[str, str, str]]
    levels: list[tuple[str, bool, str, float, int]]

class Batch:
    position: Floats
    faulted: NDArray[np.bool_]
    def step(self, q: Floats, *, signals: Mapping[str, Floats] | None = None) -> Floats: ...
    def state(self, index: int) -> str: ...
    def restart(self, indices: Sequence[int] | None = None) -> None: ...
    def __len__(self) -> int: ...

class Mission:
    name: str
    kind: str
    members: list[tuple[str, str]]
    events: dict[str, list[str]]
    time: float
    done: float | None
    stranded: str | None
    activities: list[dict[str, Any]]
    log: list[tuple[float, str]]
    outcome: dict[str, Any]
    def measure(self, name: str, member: str | None = None) -> float | bool | Floats: ...
    def advance(self, to: float) -> None: ...
    def tell(self, event: str, member: str | None = None, **keys: float | Sequence[float]) -> str: ...
    def page(self, member: str) -> dict[str, Any]: ...
    def report(self, member: str, request: dict[str, Any]) -> str: ...
    def _repr_svg_(self) -> str: ...

def compile(
    source: dict[str, str | None], set: list[tuple[str, str]], package_paths: list[str]
) -> tuple[Program | None, dict[str, str]]: ...
def simulate(program: Program, scenario: str | None, seed: int | None, duration: float | None) -> dict[str, Any]: ...
def test(
    paths: Sequence[Any], scenario: str | None, seed: int | None, set: list[tuple[str, str]]
) -> tuple[str, list[dict[str, str]]]: ...
def plan(
    program: Program, mission: str | None, engine: str, formulation: str | None, budget: float | None
) -> tuple[str, str]: ...
def sweep(wanted: dict[str, Any]) -> tuple[dict[str, Any], dict[str, str] | None]: ...
def sweep_runs(wanted: dict[str, Any]) -> tuple[int, dict[str, str] | None]: ...
def merged(files: Sequence[Any], out: Any) -> dict[str, Any]: ...
