#!/usr/bin/env python3
"""Writes random temporal formulas with their robustness, computed by rtamt, that the monitors are tested against.

Needs the PyPI package `rtamt` (`pip install rtamt`).  From the repository root:

    python3 runtime/tests/oracle/rtamt_oracle.py

writes runtime/tests/data/oracle_rtamt.json: {"rtamt", "cases"}; a case is {"text", "nodes", "log", "robustness"}.

- text        the formula as rtamt reads it; one tick is one second, each predicate is `x >= 0`.
- nodes       the same in the form of a compiled program (`Formula::nodes`).
- log         a series for each signal x0, x1, x2.
- robustness  at the first tick, rtamt's discrete time, offline.

rtamt evaluates what is left of a window that the end cuts off; Hierarq gives an interval there, in which rtamt's number
must lie.  The same seed gives the same file.
"""
import json
import random
from importlib.metadata import version
from pathlib import Path

import rtamt

DATA = Path(__file__).resolve().parents[1] / "data"
SIGNALS = 3
CASES = 160


def grow(rng, depth, nodes):
    """A random formula: appends its nodes, returns its text and the index of its root."""
    kinds = ["predicate"] if depth == 0 else [
        "predicate", "not", "and", "or", "implies", "always", "eventually", "until",
        "always_window", "eventually_window", "until_window",
    ]
    kind = rng.choice(kinds)
    if kind == "predicate":
        k = rng.randrange(SIGNALS)
        nodes.append({"predicate": k})
        return f"(x{k} >= 0)", len(nodes) - 1
    operands = [grow(rng, depth - 1, nodes) for _ in range(1 if kind in
                ("not", "always", "eventually", "always_window", "eventually_window") else 2)]
    texts, places = [o[0] for o in operands], [o[1] for o in operands]
    first = rng.randrange(4)
    last = first + rng.randrange(4)
    name = kind.removesuffix("_window")
    bounds = f"[{first}:{last}]" if name != kind else ""
    window = {"first": first, "last": last} if bounds else {"first": 0, "last": None}
    if kind == "not":
        nodes.append({"not": places[0]})
        text = f"(not {texts[0]})"
    elif kind in ("and", "or", "implies"):
        nodes.append({kind: places})
        text = f"({texts[0]} {kind} {texts[1]})"
    elif name == "until":
        nodes.append({"until": [window, places]})
        text = f"({texts[0]} until{bounds} {texts[1]})"
    else:
        nodes.append({name: [window, places[0]]})
        text = f"({name}{bounds} {texts[0]})"
    return text, len(nodes) - 1


def robustness(text, log):
    spec = rtamt.StlDiscreteTimeSpecification()
    for k in range(SIGNALS):
        spec.declare_var(f"x{k}", "float")
    spec.declare_var("out", "float")
    spec.spec = f"out = {text}"
    spec.parse()
    data = {"time": list(range(len(log[0])))} | {f"x{k}": series for k, series in enumerate(log)}
    return spec.evaluate(data)[0][1]


def case(rng):
    while True:
        nodes = []
        text, _ = grow(rng, 4, nodes)
        if len(nodes) >= 3:
            break
    ticks = rng.choice([6, 12, 30, 30])
    log = [[round(rng.gauss(0.0, 1.0), 2) for _ in range(ticks)] for _ in range(SIGNALS)]
    return {"text": text, "nodes": nodes, "log": log, "robustness": robustness(text, log)}


def main():
    rng = random.Random(7)
    cases = [case(rng) for _ in range(CASES)]
    # An infinite number has no place in JSON: it stands as a text.
    for c in cases:
        if c["robustness"] in (float("inf"), float("-inf")):
            c["robustness"] = str(c["robustness"])
    DATA.mkdir(exist_ok=True)
    lines = ",\n".join(json.dumps(c) for c in cases)
    (DATA / "oracle_rtamt.json").write_text(f'{{"rtamt": "{version("rtamt")}", "cases": [\n{lines}\n]}}\n')


if __name__ == "__main__":
    main()
