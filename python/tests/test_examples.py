"""Examples of the package, as users run them."""

import ast
import json
import runpy
from pathlib import Path

import pytest

import hierarq

FOLDER = Path(__file__).resolve().parents[1] / "examples"


def test_the_arm_in_mujoco_keeps_above_its_floor():
    pytest.importorskip("mujoco")
    example = runpy.run_path(str(FOLDER / "mujoco_loop.py"))
    program = hierarq.load(example["SPEC"], folder=example["ROBOTS"])
    found = example["follow"](program, 6.0)
    # The circle is below the floor for a part of the way, and servos lag: physics may lose what a servo's error is worth.
    assert 0.199 < found["height"] < 0.202
    assert found["lag"] < 0.02 and found["error"] < 0.004


def test_the_notebook_runs(monkeypatch, capsys):
    cells = json.loads((FOLDER / "first_steps.ipynb").read_text())["cells"]
    monkeypatch.chdir(FOLDER)
    shown = []
    names: dict[str, object] = {}
    for cell in cells:
        if cell["cell_type"] == "code":
            tree = ast.parse("".join(cell["source"]))
            last = tree.body.pop() if isinstance(tree.body[-1], ast.Expr) else None
            exec(compile(tree, "notebook", "exec"), names)
            if last is not None:
                shown.append(eval(compile(ast.Expression(last.value), "notebook", "eval"), names))
    printed = capsys.readouterr().out
    assert "HQ0301" in printed and "mm after 2 s" in printed
    run, plan = (value for value in shown if value is not None)
    assert "<iframe" in run._repr_html_() and plan._repr_svg_().startswith("<svg")
    assert names["errors"][-1] < 1e-3
