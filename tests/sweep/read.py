"""Reads the file of a sweep with pyarrow, works its summary out anew, and compares.

No part of the tests, which need no Python. By hand, in the folder in which the sweep was run:

    python -m venv v && v/bin/pip install pyarrow
    hierarq sweep spec.hq .. --out s.parquet --json > s.json
    v/bin/python tests/sweep/read.py s.parquet s.json
"""

import json
import sys

import pyarrow.parquet as pq

table = pq.read_table(sys.argv[1])
said = json.load(open(sys.argv[2]))
metadata = {k.decode(): v.decode() for k, v in table.schema.metadata.items()}
rows = table.to_pylist()
head = json.loads(metadata["sweep"])
columns = json.loads(metadata["columns"])

assert [c["name"] for c in columns] == table.schema.names
assert metadata["command"] == said["command"] and metadata["program"] == said["program"]
assert [r["run"] for r in rows] == sorted(r["run"] for r in rows) and len(rows) == said["runs"]
assert sum(r["holds"] for r in rows) == said["hold"]
for p in head["params"]:
    unit = next(c["unit"] for c in columns if c["name"] == f"param_{p['name']}")
    assert unit == p["unit"]

RANK = {"fails": 0, "undecided": 1, "holds": 2}


def worst(of, rank):
    key = lambda r: (rank(r), r[f"{of}_margin"] if r[f"{of}_margin"] is not None else float("inf"), r["run"])
    return min(rows, key=key)


def same(figure, row, of):
    w = figure["worst"]
    assert (w["run"], w["seed"], w["margin"], w["at_s"]) == (row["run"], row["seed"], row[f"{of}_margin"], row[f"{of}_at"])
    assert all(w["values"][p["name"]]["value"] == row[f"param_{p['name']}"] for p in head["params"])


for k, e in enumerate(said["expectations"], 1):
    of = f"expect_{k}"
    rank = lambda r: RANK[r[f"{of}_verdict"]]
    assert e["hold"] == sum(r[f"{of}_verdict"] == "holds" for r in rows)
    same(e, worst(of, rank), of)
for l in said["limits"]:
    of = f"limit_{l['task']}"
    if l["worst"] is not None:
        same(l, worst(of, lambda r: 0), of)
print(f"{len(rows)} rows, {len(columns)} columns: the summary is right")
