"""Controllers of robots that work beside people: task hierarchies declared, checked and executed.

A spec is compiled with the diagnostics of ``hierarq check``, and runs in the same controller as on the command line::

    import hierarq

    program = hierarq.load("reach.hq", set={"approach": "0.2 m"})
    controller = program.controller()
    q = program.robot.home
    while not controller.is_final:
        command = controller.step(q, signals={"goal": [0.4, 0.1, 0.5]})
        q = command.position

Numbers are in SI units: metres, radians, seconds, newtons. Orientations are quaternions ``w, x, y, z``.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from . import _hierarq
from ._hierarq import Batch, Command, Controller, Mission, Program, Robot
from .diagnostics import Diagnostic, Edit, Fix, SpecError, _all
from .results import Plan, Result, ScenarioResult
from .sweeps import Sweep, merge, sweep

__all__ = [
    "Batch",
    "Command",
    "Controller",
    "Diagnostic",
    "Edit",
    "Fix",
    "Mission",
    "Plan",
    "Program",
    "Result",
    "Robot",
    "ScenarioResult",
    "SpecError",
    "Sweep",
    "check",
    "load",
    "merge",
    "plan",
    "simulate",
    "sweep",
    "test",
]

Spec = str | os.PathLike[str]
Params = Mapping[str, str | float]


def _source(spec: Spec, syntax: str | None, folder: os.PathLike[str] | str | None) -> dict[str, str | None]:
    """A spec as the extension takes it."""
    if isinstance(spec, str) and "\n" in spec:
        syntax = syntax or "hq"
        return {"name": f"<text>.{syntax}", "text": spec, "syntax": syntax, "folder": os.fspath(folder or ".")}
    if syntax is not None or folder is not None:
        raise ValueError("`syntax` and `folder` are of texts; a file has its own")
    return {"name": os.fspath(spec), "text": None, "syntax": "hq", "folder": "."}


def _settings(values: Params | None) -> list[tuple[str, str]]:
    return [(name, str(value)) for name, value in (values or {}).items()]


def _compiled(
    spec: Spec,
    set: Params | None,
    package_paths: Iterable[Spec],
    syntax: str | None,
    folder: Spec | None,
) -> tuple[Program | None, dict[str, str]]:
    paths = [os.fspath(p) for p in package_paths]
    return _hierarq.compile(_source(spec, syntax, folder), _settings(set), paths)


def check(
    spec: Spec,
    *,
    set: Params | None = None,
    package_paths: Iterable[Spec] = (),
    syntax: str | None = None,
    folder: Spec | None = None,
) -> list[Diagnostic]:
    """Errors and warnings of a spec, in the order of their places.

    ``spec`` is the path of a file (``*.hq``, ``*.yaml``), or the text of a spec: a ``str`` with a line break. A text is in the
    ``syntax`` ``"hq"`` (default) or ``"yaml"``, and its files are found from ``folder``, by default the current one. ``set`` overrides
    params, as ``--set`` does: ``{"approach": "0.2 m"}``.
    """
    return _all(_compiled(spec, set, package_paths, syntax, folder)[1])


def load(
    spec: Spec,
    *,
    set: Params | None = None,
    package_paths: Iterable[Spec] = (),
    syntax: str | None = None,
    folder: Spec | None = None,
) -> Program:
    """Compiles a spec; the arguments are those of :func:`check`. ``*.json``, a compiled program, is loaded too.

    Raises :class:`SpecError`, whose text is the rendered diagnostics, if the spec has errors.
    """
    program, report = _compiled(spec, set, package_paths, syntax, folder)
    if program is None:
        raise SpecError._of([report])
    return program


def _program(spec: Program | Spec) -> Program:
    return spec if isinstance(spec, Program) else load(spec)


def simulate(
    spec: Program | Spec,
    *,
    scenario: str | None = None,
    seed: int | None = None,
    duration: float | None = None,
) -> Result:
    """Runs a program on its simulated robot, as ``hierarq run`` does, and returns every tick.

    ``scenario`` names a scenario of the spec, whose expectations are then judged; ``seed`` and ``duration`` (s) replace those of the
    spec.
    """
    return Result._of(_hierarq.simulate(_program(spec), scenario, seed, duration))


def test(
    specs: Spec | Sequence[Spec],
    *,
    scenario: str | None = None,
    seed: int | None = None,
    set: Params | None = None,
) -> list[ScenarioResult]:
    """Runs the scenarios of specs, or of all specs in folders, as ``hierarq test`` does, on all processors.

    Raises :class:`SpecError` if a spec has errors.
    """
    paths = [specs] if isinstance(specs, (str, os.PathLike)) else list(specs)
    results, wrong = _hierarq.test([Path(p) for p in paths], scenario, seed, _settings(set))
    if wrong:
        raise SpecError._of(wrong)
    return [ScenarioResult(r) for r in json.loads(results)]


def plan(
    spec: Program | Spec,
    mission: str | None = None,
    *,
    engine: str = "built-in",
    formulation: str | None = None,
    budget: float | None = None,
) -> Plan:
    """Plans a mission of a spec, as ``hierarq plan`` does; ``mission`` may be left out if there is only one.

    ``budget`` is the time limit of the planner (s). The plan is checked by the validator of its kind before it is returned.
    """
    data, chart = _hierarq.plan(_program(spec), mission, engine, formulation, budget)
    return Plan(json.loads(data), chart)


def __getattr__(name: str) -> Any:
    if name == "__version__":
        from importlib.metadata import version

        return version("hierarq")
    raise AttributeError(f"module `hierarq` has no attribute `{name}`")
