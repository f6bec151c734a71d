"""Hierarq in the loop of a MuJoCo simulation: an arm with velocity servos, gravity, inertia and torque limits follows a target.

MuJoCo has a step of 1 ms, and the controller runs at 100 Hz on the joints that it measures: the spec knows nothing of masses.

    pip install ./python mujoco
    python python/examples/mujoco_loop.py
"""

from pathlib import Path

import mujoco
import numpy as np

import hierarq

ROBOTS = Path(__file__).resolve().parents[2] / "examples" / "robots"

SPEC = """hierarq 1
robot arm { urdf "arm7.urdf"  rate 100 Hz  tracking_gain 10 /s  arms { only { tip tool } }  home { all [0, 0.40, 0, 1.60, 0, 1.14, 0] rad } }
signal goal : point { timeout 0.1 s  velocity estimated  cutoff 5 Hz }
param floor = 20 cm
task reach = frame_position(only) { position goal  gain 4 /s }
task above = keep(frame(tool).position.z) { min floor  gain 8 /s }
stack follow {
  level limits hard { joint_position_limits  joint_velocity_limits  joint_acceleration_limits  above }
  level motion { reach }
}
"""


def simulated(program: hierarq.Program) -> tuple[mujoco.MjModel, mujoco.MjData]:
    """The same URDF in MuJoCo, with a velocity servo at each joint and the gravity of the arm compensated."""
    spec = mujoco.MjSpec.from_file(str(ROBOTS / "arm7.urdf"))
    spec.option.timestep = 0.001
    # Stiff servos at light links: the explicit rule of MuJoCo would need steps of microseconds.
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.compiler.discardvisual = True
    for body in spec.bodies[1:]:
        body.gravcomp = 1.0
    for name in program.robot.q_names:
        servo = spec.add_actuator(name=name, target=name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
        servo.set_to_velocity(kv=200.0)
    model = spec.compile()
    # Parts that touch at the joints are no contacts.
    model.geom_contype[:] = 0
    data = mujoco.MjData(model)
    data.qpos[:] = program.robot.home
    mujoco.mj_forward(model, data)
    return model, data


def follow(program: hierarq.Program, seconds: float) -> dict[str, float]:
    """Lets the tool follow a circle that dips below the floor; returns what was measured in MuJoCo."""
    model, data = simulated(program)
    controller = program.controller()
    robot = program.robot
    centre = robot.pose(robot.home, "tool")[:3, 3] + [0.0, 0.0, -0.06]
    steps = round(program.period / model.opt.timestep)
    worst = {"height": np.inf, "lag": 0.0, "error": 0.0}
    for tick in range(round(seconds / program.period)):
        angle = 0.8 * tick * program.period
        goal = centre + 0.12 * np.array([0.0, np.sin(angle), np.cos(angle)])
        command = controller.step(data.qpos, signals={"goal": goal})
        if command.fault:
            raise RuntimeError(command.fault_text)
        data.ctrl[:] = command.velocity
        mujoco.mj_step(model, data, nstep=steps)
        tool = robot.pose(data.qpos, "tool")[:3, 3]
        worst["height"] = min(worst["height"], tool[2])
        worst["lag"] = max(worst["lag"], np.abs(controller.reference - data.qpos).max())
        if tick * program.period > 2.0 and goal[2] > 0.22:
            worst["error"] = max(worst["error"], np.linalg.norm(tool - goal))
    return worst


if __name__ == "__main__":
    found = follow(hierarq.load(SPEC, folder=ROBOTS), 12.0)
    print(f"lowest tool          {1e3 * found['height']:7.1f} mm (the floor is at 200 mm)")
    print(f"largest lag          {1e3 * found['lag']:7.2f} mrad between reference and joint")
    print(f"error above 220 mm   {1e3 * found['error']:7.1f} mm")
