"""The controllers beside each other: each gives the times and the joint velocities that it commands, and where they lead.

All have the same robot, period, gain, limits of position, velocity and acceleration, and a posture to hold: the start.
"""

import csv
import os
import subprocess

import numpy as np
import pink
import pinocchio as pin
from pink.limits import AccelerationLimit, ConfigurationLimit, VelocityLimit
import tsid
from tsid import tsid_pywrap

from motions import DATA, GAIN


class Trace:
    """Positions and velocities of the joints, one row a tick; `v[k]` leads from `q[k]` to `q[k + 1]`."""

    def __init__(self, t, q, v):
        self.t, self.q, self.v = np.asarray(t), np.asarray(q), np.asarray(v)


def joints(robot, values):
    return " ".join(
        f'"{name}" {value:.6f} {"m" if sliding else "rad"}'
        for name, sliding, value in zip(robot.names, robot.sliding, values)
    )


def vector(x):
    return "[" + ", ".join(f"{value:.6f}" for value in x) + "] m"


def spec(motion, damping, disturbed):
    """The motion in the language of Hierarq."""
    robot = motion.robot
    limits = " ".join(
        f'"{name}" {value:.6f} {"m" if sliding else "rad"}/s^2'
        for name, sliding, value in zip(robot.names, robot.sliding, robot.acceleration)
    )
    shape = f"sin(2*pi*t/({motion.period} s))"
    if motion.kind == "jumping":
        shape = f"smoothstep(1e9*({shape} - 1e-6))"
    way = vector(motion.way) if motion.shape(0.1)[1:] == (0.0, 0.0) and motion.kind != "jumping" else f"{vector(motion.way)} * {shape}"
    task, kept = ("frame_pose", "orientation initial(orientation)") if motion.pose else ("frame_position", "")
    second = ""
    if motion.second is not None:
        second = f"level second {damping} {{ frame_position({robot.middle}) {{ position {vector(motion.second)} }} }}"
    return f"""hierarq 1
robot it {{ urdf "{robot.urdf}"  rate {motion.rate} Hz  home {{ {joints(robot, motion.home)} }} }}
stack reach {{
  level limits hard {{ joint_position_limits  joint_velocity_limits  joint_acceleration_limits {{ max {{ {limits} }} }} }}
  level first {damping} {{ {task}({robot.tip}) {{ position initial(position) + {way} {kept} }} }}
  {second}
  level posture {damping} {{ joint_position {{ target {{ {joints(robot, motion.home)} }} }} }}
}}
run {{ duration {motion.duration} s }}
scenario "it" {{ duration {motion.duration} s  seed 1 {"simulator { lag 5 ms  noise 0.1 mrad }" if disturbed else ""}  expect never fault }}
"""


def hierarq(motion, folder, damping="", disturbed=False):
    """The release build of this repository, on its simulated robot."""
    folder.mkdir(parents=True, exist_ok=True)
    file = folder / "spec.hq"
    file.write_text(spec(motion, damping, disturbed))
    binary = os.environ.get("HIERARQ", "target/release/hierarq")
    done = subprocess.run(
        [binary, "run", file, "--scenario", "it", "--out", folder],
        capture_output=True,
        text=True,
        env=dict(os.environ, ROS_PACKAGE_PATH=str(DATA.parents[1])),
    )
    if done.returncode:
        raise RuntimeError(f"{file}: {done.stdout[-400:]}{done.stderr[-800:]}")
    with open(folder / "log.csv") as log:
        rows = list(csv.DictReader(log))
    def column(kind):
        return [[float(row[f"{kind}.{name}"]) for name in motion.robot.names] for row in rows]
    return Trace([float(row["time"]) for row in rows], column("q"), column("v"))


def pink_(motion, _folder):
    """Pink as its examples for arms use it: `lm_damping` 1, a posture of cost 1e-3, DAQP, and limits of acceleration."""
    robot, model, period = motion.robot, motion.robot.model.copy(), 1.0 / motion.rate
    model.velocityLimit = robot.speed
    model.lowerPositionLimit, model.upperPositionLimit = robot.lower, robot.upper
    here = pink.Configuration(model, model.createData(), motion.home)
    gain = GAIN * period
    tip = pink.tasks.FrameTask(robot.tip, 1.0, 1.0 if motion.pose else 0.0, lm_damping=1.0, gain=gain)
    posture = pink.tasks.PostureTask(cost=1e-3, gain=gain)
    posture.set_target(motion.home)
    tasks = [tip, posture]
    if motion.second is not None:
        # No strict priority: the lower wish weighs a tenth.
        middle = pink.tasks.FrameTask(robot.middle, 0.1, 0.0, lm_damping=1.0, gain=gain)
        middle.set_target(pin.SE3(np.eye(3), motion.second))
        tasks.append(middle)
    accelerations = AccelerationLimit(model, robot.acceleration)
    limits = [ConfigurationLimit(model), VelocityLimit(model), accelerations]
    t, q, v = [], [], []
    for k in range(int(round(motion.duration * motion.rate))):
        tip.set_target(pin.SE3(motion.start.rotation, motion.target(k * period)[0]))
        velocity = pink.solve_ik(here, tasks, period, solver="daqp", limits=limits, safety_break=False)
        accelerations.set_last_integration(velocity, period)
        t.append(k * period), q.append(here.q.copy()), v.append(velocity.copy())
        here.integrate_inplace(velocity, period)
    return Trace(t, q, v)


def tsid_(motion, _folder):
    """TSID as its exercises for arms use it: kp 100, kd 20, posture kp 1 with weight 1e-3; bounds by viability."""
    robot, period = motion.robot, 1.0 / motion.rate
    model = robot.model.copy()
    for i in range(1, model.njoints):
        # The dynamics need a mass where the URDF has none; the motion does not depend on it.
        if model.inertias[i].mass < 1e-3:
            model.inertias[i] = pin.Inertia.FromSphere(1.0, 0.1)
    wrapper = tsid_pywrap.RobotWrapper(model, tsid_pywrap.RootJointType.FIXED_BASE_SYSTEM, False)
    form = tsid_pywrap.InverseDynamicsFormulationAccForce("tsid", wrapper, False)
    q, v = motion.home.copy(), np.zeros(model.nv)
    form.computeProblemData(0.0, q, v)
    def frame(name, frame, mask, weight):
        task = tsid_pywrap.TaskSE3Equality(name, wrapper, frame)
        task.setKp(100.0 * np.ones(6)), task.setKd(20.0 * np.ones(6))
        task.setMask(np.array(mask)), task.useLocalFrame(False)
        form.addMotionTask(task, weight, 1, 0.0)
        return task
    def sample(rotation, p, dp, ddp):
        it = tsid_pywrap.TrajectorySample(12, 6)
        it.value(np.concatenate([p, rotation.flatten("F")]))
        it.derivative(np.concatenate([dp, np.zeros(3)])), it.second_derivative(np.concatenate([ddp, np.zeros(3)]))
        return it
    tip = frame("tip", robot.tip, [1.0, 1, 1] + [1.0 if motion.pose else 0.0] * 3, 1.0)
    if motion.second is not None:
        middle = frame("middle", robot.middle, [1.0, 1, 1, 0, 0, 0], 0.1)
        middle.setReference(sample(np.eye(3), motion.second, np.zeros(3), np.zeros(3)))
    posture = tsid_pywrap.TaskJointPosture("posture", wrapper)
    posture.setKp(np.ones(model.nv)), posture.setKd(2.0 * np.ones(model.nv))
    form.addMotionTask(posture, 1e-3, 1, 0.0)
    posture.setReference(tsid_pywrap.TrajectoryEuclidianConstant("home", motion.home).computeNext())
    bounds = tsid_pywrap.TaskJointPosVelAccBounds("bounds", wrapper, period, False)
    bounds.setPositionBounds(robot.lower, robot.upper)
    bounds.setVelocityBounds(robot.speed), bounds.setAccelerationBounds(robot.acceleration)
    form.addMotionTask(bounds, 1.0, 0, 0.0)
    solver = tsid_pywrap.SolverHQuadProgFast("solver")
    solver.resize(form.nVar, form.nEq, form.nIn)
    ts, qs, vs = [], [], []
    for k in range(int(round(motion.duration * motion.rate))):
        tip.setReference(sample(motion.start.rotation, *motion.target(k * period)))
        solution = solver.solve(form.computeProblemData(k * period, q, v))
        if solution.status != 0:
            raise RuntimeError(f"status {solution.status} at {k * period} s")
        dv = form.getAccelerations(solution)
        ts.append(k * period), qs.append(q.copy()), vs.append(v + period * dv)
        q = pin.integrate(model, q, period * (v + 0.5 * period * dv))
        v = v + period * dv
    return Trace(ts, qs, vs)


CONTROLLERS = {
    "Hierarq": hierarq,
    "Hierarq, lag 5 ms, noise 0.1 mrad": lambda motion, folder: hierarq(motion, folder, disturbed=True),
    "Hierarq, `damping none`": lambda motion, folder: hierarq(motion, folder, "damping none"),
    "Pink": pink_,
    "TSID": tsid_,
}
