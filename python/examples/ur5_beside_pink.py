"""A UR5 follows a target that dips below a table, and its tool stays above: by Hierarq and by Pink, in the same MuJoCo simulation.

The robot is `ur5_robot.urdf` of the package `example-robot-data`. Both controllers run at 200 Hz and send positions to the same servos,
with the torque limits of the URDF and without gravity compensation. Hierarq is told where the joints are measured; Pink integrates
what it commands, as its examples do.

    pip install ./python mujoco example-robot-data pin-pink daqp
    python python/examples/ur5_beside_pink.py
"""

import time
from collections.abc import Callable
from importlib.metadata import files

import mujoco
import numpy as np

import hierarq

URDF = next(file.locate() for file in files("example-robot-data") or [] if file.name == "ur5_robot.urdf")
RATE = 200.0  # Hz
TABLE = 0.18  # m

SPEC = f"""hierarq 1
robot ur5 {{ urdf "{URDF}"  rate {RATE:g} Hz  home {{ all [0, -1.2, 1.6, -1.97, -1.57, 0] rad }} }}
signal goal : point {{ timeout 0.1 s  velocity estimated  cutoff 20 Hz }}
task reach = frame_pose(tool0) {{ position goal  gain 10 /s }}
task above = keep(frame(tool0).position.z) {{ min {TABLE} m  gain 10 /s }}
stack follow {{
  level limits hard {{ joint_position_limits  joint_velocity_limits  joint_acceleration_limits  above }}
  level motion {{ reach }}
}}
"""


def goal(t: float, start: np.ndarray) -> np.ndarray:
    """The target at a time [s]: a circle of 10 cm from where the tool starts, whose lowest third is below the table."""
    return start + 0.1 * np.array([0.0, np.sin(0.8 * t), np.cos(0.8 * t) - 1.0])


class Hierarq:
    """The spec above."""

    def __init__(self) -> None:
        self.program = hierarq.load(SPEC)
        self.controller = self.program.controller()
        self.home = self.program.robot.home

    def step(self, measured: np.ndarray, goal: np.ndarray) -> np.ndarray:
        command = self.controller.step(measured, signals={"goal": goal})
        if command.fault:
            raise RuntimeError(command.fault_text)
        return command.position


class Pink:
    """The same task and limit in Pink, with the same gains, and the small cost of a posture that its examples have."""

    def __init__(self, home: np.ndarray) -> None:
        import pink
        import pinocchio
        from pink.barriers import PositionBarrier

        self.solve = pink.solve_ik
        model = pinocchio.buildModelFromUrdf(str(URDF))
        self.configuration = pink.Configuration(model, model.createData(), home.copy())
        # Pink's gain is the part of an error that one step takes away; ours is a rate.
        self.reach = pink.FrameTask("tool0", position_cost=1.0, orientation_cost=1.0, gain=10.0 / RATE)
        self.posture = pink.PostureTask(cost=1e-3, gain=1.0 / RATE)
        for task in (self.reach, self.posture):
            task.set_target_from_configuration(self.configuration)
        self.above = PositionBarrier("tool0", indices=[2], p_min=np.array([TABLE]), gain=np.array([10.0]))

    def step(self, measured: np.ndarray, goal: np.ndarray) -> np.ndarray:
        self.reach.transform_target_to_world.translation[:] = goal
        tasks = [self.reach, self.posture]
        velocity = self.solve(self.configuration, tasks, 1.0 / RATE, solver="daqp", barriers=[self.above])
        self.configuration.integrate_inplace(velocity, 1.0 / RATE)
        return self.configuration.q


def simulated(home: np.ndarray) -> tuple[mujoco.MjModel, mujoco.MjData]:
    """The UR5 in MuJoCo: masses and torque limits of the URDF, and a position servo at each joint."""
    spec = mujoco.MjSpec.from_file(str(URDF))
    spec.option.timestep = 0.001
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    # A body for each link, `tool0` too.
    spec.compiler.fusestatic = False
    # Nothing touches in this motion, and MuJoCo reads no meshes of ROS packages.
    for part in [*spec.geoms, *spec.meshes]:
        spec.delete(part)
    for joint, kp in zip(spec.joints, [20e3, 20e3, 20e3, 2e3, 2e3, 2e3], strict=True):
        servo = spec.add_actuator(name=joint.name, target=joint.name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
        servo.set_to_position(kp=kp, kv=kp / 50.0)
    model = spec.compile()
    data = mujoco.MjData(model)
    data.qpos[:] = data.ctrl[:] = home
    mujoco.mj_forward(model, data)
    return model, data


def follow(step: Callable[[np.ndarray, np.ndarray], np.ndarray], home: np.ndarray, seconds: float) -> dict[str, float]:
    """Lets a controller follow the target in MuJoCo; returns what was measured there [m, rad, rad/s^2, s]."""
    model, data = simulated(home)
    tool = data.body("tool0")
    start = tool.xpos.copy()
    steps = round(1.0 / RATE / model.opt.timestep)
    heights, errors, lags, sent, calls = [], [], [], [home.copy(), home.copy()], []
    for tick in range(round(seconds * RATE)):
        wanted = goal(tick / RATE, start)
        began = time.perf_counter()
        reference = step(data.qpos, wanted)
        calls.append(time.perf_counter() - began)
        sent.append(reference.copy())
        data.ctrl[:] = reference
        mujoco.mj_step(model, data, nstep=steps)
        heights.append(tool.xpos[2])
        lags.append(np.abs(reference - data.qpos).max())
        if wanted[2] > TABLE + 0.02:
            errors.append(np.linalg.norm(tool.xpos - wanted))
    return {
        "height": min(heights),
        "error": max(errors),
        "lag": max(lags),
        "acceleration": np.abs(np.diff(sent, 2, axis=0)).max() * RATE**2,
        "median": float(np.median(calls)),
        "p99": float(np.quantile(calls, 0.99)),
        "worst": max(calls),
    }


if __name__ == "__main__":
    ours = Hierarq()
    found = follow(ours.step, ours.home, 20.0)
    theirs = follow(Pink(ours.home).step, ours.home, 20.0)
    for name, unit, factor in [
        ("height", "mm", 1e3),
        ("error", "mm", 1e3),
        ("lag", "mrad", 1e3),
        ("acceleration", "rad/s^2", 1.0),
        ("median", "us", 1e6),
        ("p99", "us", 1e6),
        ("worst", "us", 1e6),
    ]:
        print(f"{name:14}{factor * found[name]:10.2f}{factor * theirs[name]:10.2f} {unit}")
