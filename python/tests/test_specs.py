"""Diagnostics as objects, and programs."""

import json
import re

import pytest

import hierarq


def test_a_mistake_is_an_object_with_its_place(text, examples):
    wrong = text.replace("gain speed", "gain speeed")
    errors = [d for d in hierarq.check(wrong, folder=examples) if d.is_error]
    assert [d.code for d in errors] == ["HQ0201"]
    line = next(i for i, l in enumerate(wrong.split("\n"), 1) if "speeed" in l)
    column = wrong.split("\n")[line - 1].index("speeed") + 1
    assert (errors[0].line, errors[0].column) == (line, column)
    assert "speed" in errors[0].help
    # The fix, applied to the text, gives the spec without the mistake.
    (edit,) = errors[0].fixes[0].edits
    raw = wrong.encode()
    assert (raw[: edit.start] + edit.new.encode() + raw[edit.end :]).decode() == text


def test_a_spec_with_errors_raises_the_rendered_diagnostics(text, examples):
    with pytest.raises(hierarq.SpecError) as caught:
        hierarq.load(text.replace("rate 100 Hz", "rate 100 m"), folder=examples)
    assert "rate 100 m" in str(caught.value)
    assert any(d.is_error for d in caught.value.diagnostics)


def test_a_missing_file_says_so():
    with pytest.raises(hierarq.SpecError, match="cannot read `nowhere.hq`"):
        hierarq.load("nowhere.hq")


def test_params_are_overridden(text, examples):
    fast = hierarq.load(text, folder=examples, set={"speed": "6 /s"})
    slow = hierarq.load(text, folder=examples)
    q = slow.robot.home
    goal = slow.robot.pose(q, "tool")[:3, 3] + [0.0, 0.0, 0.001]

    def velocity(program):
        return program.controller(stack="reaching").step(q, signals={"goal": goal}).velocity

    assert velocity(fast) == pytest.approx(2 * velocity(slow), rel=1e-6)
    with pytest.raises(hierarq.SpecError, match="speed"):
        hierarq.load(text, folder=examples, set={"speeed": "6 /s"})


def test_both_spellings_give_one_program(examples):
    one, other = (hierarq.load(examples / f"completion.{e}") for e in ("hq", "yaml"))
    assert json.loads(one.to_json()) == json.loads(other.to_json())


def test_a_compiled_program_is_loaded_again(examples, tmp_path):
    path = tmp_path / "completion.json"
    path.write_text(hierarq.load(examples / "completion.hq").to_json())
    again = hierarq.load(path)
    assert again.states == ["go", "look", "back", "done", "stopped"]
    old = re.sub(r'"format": ?\d+', '"format": 1', path.read_text())
    path.write_text(old)
    with pytest.raises(hierarq.SpecError, match="version|format"):
        hierarq.load(path)


def test_a_program_tells_what_a_host_needs(program):
    assert ("goal", "point", 3) in program.signals and ("worker.hand", "point", 3) in program.signals
    assert program.events == ["go"]
    assert program.states == ["wait", "work", "done", "stopped"]
    assert program.period == pytest.approx(0.01)


def test_the_stubs_name_what_there_is():
    import ast
    from pathlib import Path

    from hierarq import _hierarq

    stub = ast.parse((Path(hierarq.__file__).parent / "_hierarq.pyi").read_text())
    for node in stub.body:
        if isinstance(node, ast.ClassDef):
            names = {n.target.id for n in node.body if isinstance(n, ast.AnnAssign)}
            names |= {n.name for n in node.body if isinstance(n, ast.FunctionDef)}
            real = {n for n in vars(getattr(_hierarq, node.name)) if not n.startswith("__") or n == "__len__"}
            assert names == real, node.name
            assert all(getattr(_hierarq, node.name).__dict__[n].__doc__ for n in real), node.name
        elif isinstance(node, ast.FunctionDef):
            assert hasattr(_hierarq, node.name)
