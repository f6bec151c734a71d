"""Examples of the package, as users run them."""

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
