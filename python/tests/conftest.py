"""The specs of the examples, and small ones of the tests."""

from pathlib import Path

import pytest

import hierarq

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"

REACH = """hierarq 1
robot arm { urdf "robots/arm7.urdf"  rate 100 Hz  arms { only { tip tool } }  home { all [0, 0.40, 0, 1.60, 0, 1.14, 0] rad } }
param speed = 3 /s
signal goal : point  timeout 0.5 s
signal push : flag?
signal go : event
human worker { points [hand]  lost fault }
task reach = frame_position(only) { position goal  gain speed }
stack limits { level limits hard { joint_position_limits  joint_velocity_limits  joint_acceleration_limits } }
stack reaching from limits { add motion { reach } }
machine m {
  initial wait
  blend 0.2 s
  on fault(any) -> stopped
  state wait { stack limits  on go -> work  when worker.hand.x < 0 m -> stopped }
  state work { stack reaching  when push -> done }
  final state done
  final state stopped
}
run { duration 2 s }
"""


@pytest.fixture
def examples() -> Path:
    return EXAMPLES


@pytest.fixture
def text() -> str:
    return REACH


@pytest.fixture
def program(text: str) -> hierarq.Program:
    return hierarq.load(text, folder=EXAMPLES)
