"""Runs, scenarios and plans as functions."""

import numpy as np
import pytest

import hierarq


def test_a_run_is_a_table(examples):
    run = hierarq.simulate(examples / "completion.hq", duration=1.0)
    assert run.table.shape == (100, len(run.names)) and run.q.shape == (100, 7)
    assert np.allclose(np.diff(run.q, axis=0), run.v[:-1] * 0.01, atol=1e-9)
    frame = run.to_pandas()
    assert list(frame["state"]) == run.states and frame["fault"].eq("").all()
    assert run.to_polars().columns == list(frame.columns)
    assert "<iframe" in run._repr_html_() and "<html" in run.to_html()
    with pytest.raises(KeyError, match="no column"):
        run["margin.nothing"]


def test_a_scenario_is_judged(examples):
    program = hierarq.load(examples / "tested.hq")
    run = hierarq.simulate(program, scenario=program.scenarios[0], seed=3)
    again = hierarq.simulate(program, scenario=program.scenarios[0], seed=3)
    assert run.expectations and np.array_equal(run.table, again.table, equal_nan=True)
    with pytest.raises(ValueError, match="no scenario"):
        hierarq.simulate(program, scenario="nothing like it")
    results = hierarq.test(examples / "tested.hq")
    assert [r["scenario"] for r in results] == program.scenarios
    assert all(r.ok for r in results)


def test_a_wrong_spec_is_not_run(tmp_path):
    (tmp_path / "wrong.hq").write_text("hierarq 1\nrobot arm { urdf \"none.urdf\"  rate 100 Hz }\nscenario a { duration 1 s }\n")
    with pytest.raises(hierarq.SpecError, match="none.urdf"):
        hierarq.test(tmp_path)


def test_a_mission_is_planned(examples):
    plan = hierarq.plan(examples / "vineyard.hq")
    assert plan["mission"] and plan.chart.startswith("<svg") and plan._repr_svg_() == plan.chart
    with pytest.raises(ValueError, match="no engine"):
        hierarq.plan(examples / "vineyard.hq", engine="gurobi")
    with pytest.raises(ValueError, match="no mission"):
        hierarq.plan(examples / "vineyard.hq", "nothing")
