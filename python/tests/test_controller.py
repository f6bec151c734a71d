"""Controllers stepped from Python: the same numbers as a run of the command line, and mistakes of a host."""

import threading

import numpy as np
import pytest

import hierarq


def goal(program):
    return program.robot.pose(program.robot.home, "tool")[:3, 3] + [0.05, 0.02, -0.03]


HAND = {"worker": {"hand": [1.0, 0.0, 1.0]}}


def test_a_loop_in_python_is_the_run_of_the_command_line(examples):
    program = hierarq.load(examples / "completion.hq")
    run = hierarq.simulate(program)
    controller, q = program.controller(), program.robot.home
    for i in range(len(run)):
        command = controller.step(q)
        assert command.state == run.states[i]
        assert np.array_equal(command.velocity, run.table[i, [run.names.index(f"cmd.{n}") for n in program.robot.v_names]])
        for task, margins in command.margins.items():
            assert margins.min() == run[f"margin.{task}"][i]
        for task, errors in command.errors.items():
            assert np.linalg.norm(errors) == pytest.approx(run[f"error.{task}"][i], rel=1e-12)
        q = command.position
    assert controller.is_final and run.ok


def test_the_tool_arrives_at_the_goal(program):
    controller, q, to = program.controller(), program.robot.home, goal(program)
    for i in range(400):
        command = controller.step(q, signals={"goal": to}, humans=HAND, events=["go"] if i == 3 else None)
        assert command.fault is None and np.isfinite(command.velocity).all()
        q = command.position
    assert command.state == "work"
    assert np.linalg.norm(program.robot.pose(q, "tool")[:3, 3] - to) < 1e-4
    assert np.linalg.norm(command.errors["reach"]) < 1e-4
    assert [name for name, *_ in command.levels] == ["limits", "motion"]
    command = controller.step(q, signals={"goal": to, "push": True})
    assert command.state == "done" and command.is_final


def test_rows_at_a_bound_are_named(program):
    controller = program.controller(stack="reaching")
    # To the side of the arm: the first joint turns as fast as it may.
    far = goal(program) + [0.0, 3.0, 0.0]
    q = program.robot.home
    for _ in range(20):
        command = controller.step(q, signals={"goal": far})
        q = command.position
    at = {row for task, row, _ in command.active if task == "limits.joint_velocity_limits"}
    speeds = np.abs(command.velocity) / program.robot.max_velocity
    assert at == {name for name, speed in zip(program.robot.v_names, speeds) if speed > 1 - 1e-9}
    assert "joint_1" in at
    motion = dict((name, rest) for name, *rest in command.levels)["motion"]
    assert motion[1] == "relaxed" and motion[2] > 0.1


@pytest.mark.parametrize(
    ("given", "fault"),
    [({"q": np.nan}, "not_finite"), ({"t": -1.0}, "deadline"), ({"t": 9.0}, "deadline"), ({"t": np.nan}, "not_finite")],
)
def test_a_bad_observation_is_a_fault_and_the_robot_stands(program, given, fault):
    controller, q = program.controller(), program.robot.home
    controller.step(q, signals={"goal": goal(program)}, humans=HAND)
    bad = q * given.get("q", 1.0)
    command = controller.step(bad, t=given.get("t"), signals={"goal": goal(program)})
    assert command.fault == fault and command.fault_text
    assert not command.velocity.any()
    assert command.state == "stopped"


def test_a_signal_that_stops_is_stale(program):
    controller, q = program.controller(stack="reaching"), program.robot.home
    command = controller.step(q, signals={"goal": goal(program)})
    while command.fault is None:
        q = command.position
        command = controller.step(q)
    assert command.fault == "stale" and "goal" in command.fault_text
    assert command.time == pytest.approx(0.5, abs=0.02)
    assert not command.velocity.any()
    controller.step(q)
    assert controller.is_halted
    controller.restart()
    assert controller.step(q, signals={"goal": goal(program)}).fault is None
    assert controller.step(q, signals={"goal": None}).fault == "stale"


def test_a_signal_of_the_spec_enables_the_robot(examples):
    program = hierarq.load(examples / "enabled.hq")
    controller, q = program.controller(), program.robot.home

    def speed(count, signals, **others):
        nonlocal q
        for _ in range(count):
            command = controller.step(q, signals=signals, **others)
            assert command.fault is None
            q = command.position
        return np.abs(command.velocity).max()

    assert speed(20, None) == 0.0
    assert speed(50, {"drives_on": True}) > 0.01
    assert speed(5, {"drives_on": False}) == 0.0
    assert speed(50, {"drives_on": True}) == 0.0
    controller.resume()
    assert speed(50, {"drives_on": True}) > 0.01
    assert speed(12, None) == 0.0, "too old"
    controller.resume()
    assert speed(5, {"drives_on": True}, enabled=False) == 0.0, "both must say yes"


def test_the_rate_of_the_calls_is_measured(program):
    controller, q = program.controller(interval=0.0125), program.robot.home
    assert controller.measured_rate is None
    for i in range(50):
        controller.step(q, t=0.0125 * i)
    assert controller.measured_rate == pytest.approx(80.0)
    with pytest.raises(ValueError, match="later than the robot's `deadline`"):
        program.controller(interval=0.5)


ROVER = """hierarq 1
robot arm { urdf "robots/arm7.urdf"  rate 100 Hz  base planar  home { joint_4 1.6 rad }
  limits { base_x { velocity 1 m/s }  base_y { velocity 1 m/s }  base_yaw { velocity 1 rad/s } } }
task turn = joint_velocity { velocity { joint_1 0.2 rad/s } }
stack work { level limits hard { joint_velocity_limits }  level motion { turn } }
run { stack work  duration 1 s }
"""


@pytest.mark.parametrize("told", [True, False])
def test_a_base_that_is_localised_anew_takes_its_reference_along(examples, told):
    program = hierarq.load(ROVER, folder=examples)
    controller, q = program.controller(), program.robot.home
    for _ in range(50):
        q = controller.step(q).position
    q = q.copy()
    q[0] += 0.5
    if told:
        controller.relocated()
    for _ in range(50):
        command = controller.step(q)
        assert command.fault == (None if told else "jump")
        if not told:
            return
        q = command.position
        assert abs(command.velocity[0]) < 1e-9
    assert q[0] == pytest.approx(0.5) and command.velocity[3] == pytest.approx(0.2)


@pytest.mark.parametrize(
    ("keywords", "message"),
    [
        ({"q": np.zeros(6)}, "q has 6 numbers, and the robot has 7: `joint_1`"),
        ({"q": np.zeros((7, 1))}, "one dimension"),
        ({"signals": {"gaol": [0, 0, 0]}}, "did you mean `goal`"),
        ({"signals": {"goal": [0, 0]}}, "given 2 numbers.*x, y, z in m"),
        ({"signals": {"go": True}}, "`go` is an event"),
        ({"events": ["went"]}, "no event `went`"),
        ({"humans": {"worker": {"hnad": [0, 0, 0]}}}, "worker.hand"),
    ],
)
def test_a_mistake_of_the_host_is_one_clear_error(program, keywords, message):
    controller = program.controller()
    arguments = {"q": program.robot.home, **keywords}
    with pytest.raises(ValueError, match=message):
        controller.step(arguments.pop("q"), **arguments)


def test_what_is_no_number_is_a_type_error(program):
    with pytest.raises(TypeError, match="not `str`"):
        program.controller().step("home")
    with pytest.raises(TypeError, match="points of `worker`"):
        program.controller().step(program.robot.home, humans={"worker": [0, 0, 0]})
    with pytest.raises(ValueError, match="did you mean `reaching`"):
        program.controller(stack="reachng")


def test_arrays_of_any_form_are_read(program):
    home = program.robot.home
    forms = [home, list(home), tuple(home), np.repeat(home, 2)[::2], home.astype(">f8"), home.astype(np.float32)]
    found = [program.controller(stack="limits").step(q).position for q in forms]
    assert all(np.allclose(x, found[0], atol=1e-6) for x in found)


def test_a_driver_with_another_order_of_joints(program):
    robot = program.robot
    names = ["gripper", *reversed(robot.q_names)]
    order = robot.order(names)
    assert [names[i] for i in order] == robot.q_names
    with pytest.raises(ValueError, match="lacks a joint of the robot.*joint_1"):
        robot.order(["j1", "j2"])


def test_a_controller_belongs_to_one_thread_at_a_time(program):
    batch = program.batch(64)
    q = np.tile(program.robot.home, (64, 1))
    errors = []

    def work():
        for _ in range(50):
            try:
                batch.step(q)
            except RuntimeError as e:
                errors.append(str(e))

    threads = [threading.Thread(target=work) for _ in range(4)]
    [t.start() for t in threads]
    [t.join() for t in threads]
    assert all("another thread" in e for e in errors)


def test_a_batch_does_what_its_controllers_do(program):
    rng = np.random.default_rng(7)
    n = 9
    batch, single = program.batch(n, threads=4), [program.controller() for _ in range(n)]
    q = program.robot.home + rng.uniform(-0.2, 0.2, (n, 7))
    goals = rng.uniform(-0.1, 0.1, (n, 3)) + goal(program)
    hands = np.tile(HAND["worker"]["hand"], (n, 1))
    hands[4, 0] = -1.0
    for _ in range(30):
        v = batch.step(q, signals={"goal": goals, "worker.hand": hands})
        for i, c in enumerate(single):
            command = c.step(q[i], signals={"goal": goals[i]}, humans={"worker": {"hand": hands[i]}})
            assert np.array_equal(v[i], command.velocity)
            assert np.array_equal(batch.position[i], command.position)
            assert batch.state(i) == command.state and batch.faulted[i] == (command.fault is not None)
        q = batch.position
    assert batch.state(4) == "stopped" and batch.state(0) == "wait" and len(batch) == n
    batch.restart([4])
    batch.step(q, signals={"goal": goals, "worker.hand": np.abs(hands)})
    assert batch.state(4) == "wait"
    with pytest.raises(ValueError, match=r"shape \[9, 6\], and \[9, 7\]"):
        batch.step(q[:, :6])
    with pytest.raises(ValueError, match="no robot 9"):
        batch.state(9)


def test_kinematics_agree_with_differences(program):
    robot, rng = program.robot, np.random.default_rng(1)
    for _ in range(5):
        q = rng.uniform(robot.lower, robot.upper)
        jacobian, h = robot.jacobian(q, "tool"), 1e-6
        for i in range(robot.nv):
            step = np.zeros(robot.nv)
            step[i] = h
            ahead, behind = robot.pose(q + step, "tool"), robot.pose(q - step, "tool")
            assert jacobian[:3, i] == pytest.approx((ahead - behind)[:3, 3] / (2 * h), abs=1e-6)
            # R' R^T is the matrix of the cross product with the angular velocity.
            spin = (ahead - behind)[:3, :3] / (2 * h) @ robot.pose(q, "tool")[:3, :3].T
            assert jacobian[3:, i] == pytest.approx([spin[2, 1], spin[0, 2], spin[1, 0]], abs=1e-6)
    with pytest.raises(ValueError, match="no link `tol`.*`tool`"):
        robot.pose(robot.home, "tol")
