"""Whole ticks of controllers on `tick.hq`: kinematics, tasks, limits and the solver, from the configuration to the velocity."""

import json
import pathlib
import time

import mink
import mujoco
import numpy as np
import pink
import pinocchio as pin
from tsid import tsid_pywrap

HERE = pathlib.Path(__file__).resolve().parent
URDF = HERE.parents[1] / "examples/robots/arm7.urdf"
PERIOD, GAIN = 0.002, 5.0
HOME = np.array([0, 0.40, 0, 1.60, 0, 1.14, 0])
WAY = np.array([0, 0.2, 0.1])


def way(t):
    return WAY * np.sin(np.pi * t / 4), WAY * np.pi / 4 * np.cos(np.pi * t / 4), -WAY * (np.pi / 4) ** 2 * np.sin(np.pi * t / 4)


def timed(most, tick):
    """CPU times in microseconds of `tick(t)` at the instants of the run."""
    us = []
    for k in range(most):
        begin = time.thread_time_ns()
        tick(k * PERIOD)
        us.append(1e-3 * (time.thread_time_ns() - begin))
    return us


def with_pink(most):
    model = pin.buildModelFromUrdf(str(URDF))
    here = pink.Configuration(model, model.createData(), HOME.copy())
    tool = pink.tasks.FrameTask("tool", 1.0, 0.0, gain=GAIN * PERIOD)
    posture = pink.tasks.PostureTask(cost=1e-3, gain=GAIN * PERIOD)
    posture.set_target(HOME)
    start = here.get_transform_frame_to_world("tool").copy()
    limits = [pink.limits.ConfigurationLimit(model), pink.limits.VelocityLimit(model)]
    def tick(t):
        tool.set_target(pin.SE3(start.rotation, start.translation + way(t)[0]))
        velocity = pink.solve_ik(here, [tool, posture], PERIOD, solver="daqp", limits=limits)
        here.integrate_inplace(velocity, PERIOD)
    return timed(most, tick)


def with_mink(most):
    model = mujoco.MjModel.from_xml_path(str(URDF))
    here = mink.Configuration(model, HOME.copy())
    last = mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_BODY, model.nbody - 1)
    tool = mink.FrameTask(last, "body", position_cost=1.0, orientation_cost=0.0, gain=GAIN * PERIOD)
    posture = mink.PostureTask(model, cost=1e-3, gain=GAIN * PERIOD)
    posture.set_target(HOME)
    start = here.get_transform_frame_to_world(last, "body")
    names = [mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_JOINT, j) for j in range(model.njnt)]
    speeds = dict(zip(names, pin.buildModelFromUrdf(str(URDF)).velocityLimit))
    limits = [mink.ConfigurationLimit(model), mink.VelocityLimit(model, speeds)]
    def tick(t):
        target = mink.SE3.from_rotation_and_translation(start.rotation(), start.translation() + way(t)[0])
        tool.set_target(target)
        velocity = mink.solve_ik(here, [tool, posture], PERIOD, solver="daqp", limits=limits)
        here.integrate_inplace(velocity, PERIOD)
    return timed(most, tick)


def with_tsid(most):
    """Pinocchio and eiquadprog by way of TSID: accelerations, in C++ but for the calls."""
    model = pin.buildModelFromUrdf(str(URDF))
    for i in range(1, model.njoints):
        # The dynamics need a mass where the URDF has none.
        if model.inertias[i].mass < 1e-3:
            model.inertias[i] = pin.Inertia.FromSphere(1.0, 0.1)
    robot = tsid_pywrap.RobotWrapper(model, tsid_pywrap.RootJointType.FIXED_BASE_SYSTEM, False)
    program = tsid_pywrap.InverseDynamicsFormulationAccForce("tsid", robot, False)
    q, v = HOME.copy(), np.zeros(model.nv)
    program.computeProblemData(0.0, q, v)
    tool = tsid_pywrap.TaskSE3Equality("tool", robot, "tool")
    tool.setKp(GAIN**2 * np.ones(6)), tool.setKd(2 * GAIN * np.ones(6))
    tool.setMask(np.array([1.0, 1, 1, 0, 0, 0])), tool.useLocalFrame(False)
    program.addMotionTask(tool, 1.0, 1, 0.0)
    posture = tsid_pywrap.TaskJointPosture("posture", robot)
    posture.setKp(GAIN**2 * np.ones(model.nv)), posture.setKd(2 * GAIN * np.ones(model.nv))
    posture.setReference(tsid_pywrap.TrajectoryEuclidianConstant("home", HOME).computeNext())
    program.addMotionTask(posture, 1e-3, 1, 0.0)
    bounds = tsid_pywrap.TaskJointPosVelAccBounds("bounds", robot, PERIOD, False)
    bounds.setPositionBounds(model.lowerPositionLimit, model.upperPositionLimit)
    bounds.setVelocityBounds(model.velocityLimit), bounds.setAccelerationBounds(np.full(model.nv, 100.0))
    program.addMotionTask(bounds, 1.0, 0, 0.0)
    solver = tsid_pywrap.SolverHQuadProgFast("solver")
    solver.resize(program.nVar, program.nEq, program.nIn)
    start = robot.framePosition(program.data(), model.getFrameId("tool"))
    state = [q, v]
    def tick(t):
        p, dp, ddp = way(t)
        sample = tsid_pywrap.TrajectorySample(12, 6)
        sample.value(np.concatenate([start.translation + p, start.rotation.flatten("F")]))
        sample.derivative(np.concatenate([dp, np.zeros(3)]))
        sample.second_derivative(np.concatenate([ddp, np.zeros(3)]))
        tool.setReference(sample)
        q, v = state
        acceleration = program.getAccelerations(solver.solve(program.computeProblemData(t, q, v)))
        state[1] = v + PERIOD * acceleration
        state[0] = pin.integrate(model, q, PERIOD * state[1])
    return timed(most, tick)


def measure(hierarq, most):
    """What each is, and median, 99th percentile and worst of its ticks in microseconds."""
    told = json.loads(hierarq("bench", HERE / "tick.hq", "--ticks", str(most), "--json"))["tick"]["us"]
    yield "Hierarq", [told["median"], told["p99"], told["max"]]
    others = {"TSID (Pinocchio, eiquadprog)": with_tsid, "Pink (Pinocchio, DAQP)": with_pink, "mink (MuJoCo, DAQP)": with_mink}
    for label, run in others.items():
        us = np.sort(run(most))
        yield label, [us[len(us) // 2], us[int(0.99 * (len(us) - 1))], us[-1]]
