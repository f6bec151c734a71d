"""Diagnostics of specs as objects."""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Edit:
    """A change of a text: the characters from ``start`` to ``end`` (bytes of the file) become ``new``."""

    file: str | None
    start: int
    end: int
    new: str


@dataclass(frozen=True)
class Fix:
    """A correction as edits; ``certain`` if it needs no thought."""

    title: str
    certain: bool
    edits: tuple[Edit, ...]


@dataclass(frozen=True)
class Diagnostic:
    """An error or a warning about a spec. Lines and columns count from one."""

    code: str
    severity: str
    message: str
    file: str | None
    line: int
    column: int
    end_line: int
    end_column: int
    notes: tuple[str, ...]
    help: str | None
    fixes: tuple[Fix, ...]

    @property
    def is_error(self) -> bool:
        """True if the spec cannot run because of it."""
        return self.severity == "error"

    @classmethod
    def _of(cls, data: dict[str, Any]) -> Diagnostic:
        place = data["place"]
        return cls(
            code=data["code"],
            severity=data["severity"],
            message=data["message"],
            file=place["file"],
            line=place["line"],
            column=place["column"],
            end_line=place["end_line"],
            end_column=place["end_column"],
            notes=tuple(data["notes"]),
            help=data["help"],
            fixes=tuple(_fix(f) for f in data["fixes"]),
        )

    def __str__(self) -> str:
        return f"{self.file}:{self.line}:{self.column}: {self.severity} {self.code}: {self.message}"


def _all(report: dict[str, str]) -> list[Diagnostic]:
    """The diagnostics of a report of the extension."""
    return [Diagnostic._of(d) for d in json.loads(report["json"])["diagnostics"]]


def _fix(data: dict[str, Any]) -> Fix:
    edits = (Edit(e["place"]["file"], e["place"]["start"], e["place"]["end"], e["new"]) for e in data["edits"])
    return Fix(data["title"], data["certain"], tuple(edits))


class SpecError(Exception):
    """A spec with errors; its text is the rendered diagnostics."""

    def __init__(self, text: str, diagnostics: list[Diagnostic]) -> None:
        super().__init__(text)
        self.diagnostics = diagnostics

    @classmethod
    def _of(cls, reports: Iterable[dict[str, str]]) -> SpecError:
        reports = list(reports)
        return cls("\n".join(r["text"] for r in reports), [d for r in reports for d in _all(r)])

    def __reduce__(self) -> tuple[type[SpecError], tuple[str, list[Diagnostic]]]:
        # Otherwise a copy, as another process gets it, would be made of the text alone.
        return SpecError, (str(self), self.diagnostics)
