//! A tick of the controller performs no allocation, from the observation to the command, in any example: a counting
//! allocator checks it for every tick of the run. (The reference cascade allocates, as documented; it is not the
//! default.)

#[path = "common/allocations.rs"]
mod allocations;
mod common;

use runtime::record::joint_motion::JointMotionRecorder;
use runtime::{Controller, Observation, Recorder, SimulatedRobot, Simulation, Tick};

// A single test: the allocations of a second one in this process would be counted too.
#[test]
fn a_tick_allocates_nothing() {
    allocations::are_counted();

    machines();
    regions();
    people();
    fields();
    planners();
    recorders();
    late();
    for name in common::EXAMPLES {
        let program = common::program(&format!("{name}.hq"));
        let mut controller = Controller::new(&program).expect("it can be executed");
        let mut robot = SimulatedRobot::new(&program);
        let ticks = (program.run.duration / program.robot.period).round() as usize;
        let of_people = |s: &usize| program.interface.signals[*s].motion.is_some();
        let needs: Vec<usize> = controller.evaluator().needs().iter().copied().filter(of_people).collect();
        for k in 0..ticks {
            let observation = Observation { time: k as f64 * program.robot.period, q: robot.measure() };
            let before = allocations::so_far();
            // People without whom the first stack cannot run stand aside.
            for &point in &needs {
                assert!(controller.signals().set(point, &[2.0, 2.0, 1.0], observation.time));
            }
            let command = controller.step(&observation);
            assert_eq!(allocations::so_far(), before, "{name} allocates at tick {k}");
            assert!(command.fault.is_none(), "{name}, tick {k}");
            let velocity = command.velocity.to_vec();
            robot.apply(&velocity);
        }
    }
}

/// Ticks that exceed the time budget of the hierarchy.
fn late() {
    let mut program = common::program("hard/short_of_time.hq");
    program.run.tick_budget = Some(1e-9);
    let mut controller = Controller::new(&program).expect("it can be executed");
    let mut robot = SimulatedRobot::new(&program);
    let mut late = 0;
    for k in 0..500 {
        let observation = Observation { time: k as f64 * program.robot.period, q: robot.measure() };
        let before = allocations::so_far();
        let command = controller.step(&observation);
        assert_eq!(allocations::so_far(), before, "a tick without time allocates, tick {k}");
        late += u32::from(command.late);
        let velocity = command.velocity.to_vec();
        robot.apply(&velocity);
    }
    assert!(late > 100, "{late} late ticks");
}

/// Measurements of each joint during a run.
fn recorders() {
    struct Counted(JointMotionRecorder);
    impl Recorder for Counted {
        fn tick(&mut self, tick: &Tick) -> std::io::Result<()> {
            let before = allocations::so_far();
            let done = self.0.tick(tick);
            assert_eq!(allocations::so_far(), before, "joints at tick {}", tick.index);
            done
        }
    }
    let program = common::program("trajectories.hq");
    let mut simulation = Simulation::new(&program).expect("it can be executed");
    let mut counted = Counted(JointMotionRecorder::new(simulation.controller()));
    simulation.run(&mut counted, &mut || 0.0, &mut |tick| tick < 3000).expect("no recorder fails");
    assert!(counted.0.result().values().any(|j| j.max_acceleration > 0.0));
}

/// Points of a person that appear, move, are lost and held, and reappear.
fn people() {
    let mut program = common::program("bystander.hq");
    program.run = program.scenarios[0].run.clone();
    let mut controller = Controller::new(&program).expect("it can be executed");
    let mut robot = SimulatedRobot::new(&program);
    let mut uncertain = 0;
    for k in 0..800 {
        let time = k as f64 * 0.01;
        let q = robot.measure();
        let before = allocations::so_far();
        if k % 200 < 150 {
            for (point, height) in [1.0, 0.7, 0.7].into_iter().enumerate() {
                let x = if k % 100 == 50 { f64::NAN } else { 1.0 - 0.1 * time.sin() };
                assert!(controller.signals().set(point, &[x, 0.3, height], time));
            }
        }
        let command = controller.step(&Observation { time, q });
        assert_eq!(allocations::so_far(), before, "a person allocates at tick {k}");
        assert!(command.fault.is_none(), "tick {k}: {:?}", command.fault);
        let velocity = command.velocity.to_vec();
        uncertain += usize::from(controller.signals().uncertainty(0).is_some_and(|u| u > 0.0));
        robot.apply(&velocity);
    }
    assert!(uncertain > 100, "{uncertain}");
}

/// A safety field in a limit, in conditions of a machine, and a separation that slows the tool.
fn fields() {
    let program = common::program_of(
        "hierarq 1
robot arm { urdf \"robots/arm7.urdf\"  rate 100 Hz  home { all [0, 0.40, 0, 1.60, 0, 1.14, 0] rad }  points { tip tool } }
human walker { points [chest, hand]  links [[chest, hand]]  lost hold }
safety_field nearness { of walker  distance 1 m * (1 - exp(-d/(1 m)))  points soft_minimum(8 /m) }
task apart = keep(field(nearness)) { min 0.4 m }
task slow = speed_separation(tip) { from walker.hand  human measured  reaction 0.1 s  stopping 0.3 s  intrusion 0.1 m }
task clear = keep(distance(tip, walker)) { min 0.2 m }
task stay = hold(tool)
task limits = joint_velocity_limits
stack near { level limits hard { limits }  level people { apart  slow  clear }  level motion { stay } }
machine m { initial a  on fault(any) -> c  state a { stack near  when field(nearness) < 0.45 m -> b }
  state b { stack near  when field(nearness) > 0.5 m -> a }  final state c }",
    );
    let mut controller = Controller::new(&program).expect("it can be executed");
    let mut robot = SimulatedRobot::new(&program);
    for k in 0..400 {
        let time = k as f64 * 0.01;
        let q = robot.measure();
        let before = allocations::so_far();
        for (point, height) in [1.0, 0.7].into_iter().enumerate() {
            let at = if k == 200 { f64::NAN } else { 1.1 - 0.5 * time.sin() };
            assert!(controller.signals().set(point, &[at, 0.3, height], time));
        }
        let command = controller.step(&Observation { time, q });
        assert_eq!(allocations::so_far(), before, "a field allocates at tick {k}");
        assert!(command.fault.is_none(), "tick {k}: {:?}", command.fault);
        let velocity = command.velocity.to_vec();
        robot.apply(&velocity);
    }
}

/// Safety planners of all methods, with a person who comes as close as the arm can reach.
fn planners() {
    for stack in ["a1", "a2", "a3"] {
        let mut program = common::program("give_way.hq");
        let found = program
            .scenarios
            .iter()
            .find(|s| matches!(s.run.subject, runtime::program::Subject::Stack(k) if program.stacks[k].name == stack));
        program.run = found.map(|s| s.run.clone()).expect("a scenario for each stack");
        let person = program.interface.signal("operator.chest").expect("it is tracked");
        let mut controller = Controller::new(&program).expect("it can be executed");
        let mut robot = SimulatedRobot::new(&program);
        let (mut near, mut unmet) = (0, 0);
        for k in 0..800 {
            let time = k as f64 * 0.01;
            let q = robot.measure();
            let before = allocations::so_far();
            let x = 1.2 - 0.1 * time;
            controller.signals().set(person, &[x, 0.0, 1.2, -0.1, 0.0, 0.0], time);
            let command = controller.step(&Observation { time, q });
            assert_eq!(allocations::so_far(), before, "a planner allocates at tick {k}");
            assert!(command.fault.is_none(), "{stack}, tick {k}: {:?}", command.fault);
            let velocity = command.velocity.to_vec();
            near += usize::from(controller.evaluator().safety().any(|(p, _)| p.plan().margin < 0.01));
            unmet += usize::from(controller.evaluator().safety().any(|(p, _)| p.plan().outcome.slack > 1e-3));
            robot.apply(&velocity);
        }
        assert!(near > 100, "{stack}: {near}");
        // The planner's demand is also infeasible, so that its damped plan below limits is counted too.
        assert!(stack != "a1" || unmet > 20, "{unmet}");
    }
}

/// A machine that changes between stacks all the time, blends, starts and cancels actions, and handles faults.
fn machines() {
    let program = common::program_of(
        "hierarq 1
robot arm { urdf \"robots/arm7.urdf\"  rate 100 Hz  home { all [0, 0.40, 0, 1.60, 0, 1.14, 0] rad } }
signal goal : point?  timeout 0.2 s
signal ft : wrench? { timeout 1 s  frame link_6  low_pass 20 Hz }
signal go : event
variable turns : number = 0
variable seen : point?
stack still { level limits hard { joint_position_limits  joint_velocity_limits } }
task reach = frame_position(tool) { position goal  gain 2 /s }
task wave = joint_position { target { joint_1 initial(joint(joint_1)) + 0.2 rad * sin(t/(1 s)) }  gain 5 /s }
stack follow from still { lock joint_1  add motion { reach } }
stack waving from still { add motion { wave } }
machine m {
  initial a
  blend 50 ms
  on fault(any) -> a
  state a { stack waving  initial b  when present(goal) for 30 ms -> c
    state b { do capture(camera)  enter say \"hello\"  exit log \"gone\"  on go -> d  after 70 ms -> d }
    state d { enter emit go  on go -> b  when reversals(all) > 1e6 or acceleration(tool) > 1e6 m/s^2 -> b } }
  state c { stack follow
    enter set(turns, turns + norm(ft.force)/(1 N))  enter set(seen, frame(tool).position)  exit tare(ft)  exit clear(seen)
    on reached(reach, 1 mm) -> a  after 90 ms -> a
    when norm(frame(tool).position - [1, 1, 1] m) < 0.1 m -> a }
}",
    );
    let mut controller = Controller::new(&program).expect("it can be executed");
    let mut robot = SimulatedRobot::new(&program);
    let (mut states, mut faults) = (std::collections::BTreeSet::new(), 0);
    for k in 0..2000 {
        let time = k as f64 * 0.01;
        let q = robot.measure();
        let observation = Observation { time, q };
        let before = allocations::so_far();
        if k % 400 < 200 {
            controller.signals().set(0, &[0.4, 0.1, 0.5], time);
            controller.signals().set(1, &[1.0, 2.0, 3.0, 0.1, 0.2, 0.3], time);
        }
        if k % 7 == 0 {
            controller.signals().raise(0);
        }
        let command = controller.step(&observation);
        assert_eq!(allocations::so_far(), before, "the machine allocates at tick {k}");
        faults += usize::from(command.fault.is_some());
        let velocity = command.velocity.to_vec();
        states.insert(controller.state_index());
        robot.apply(&velocity);
    }
    assert_eq!((states.len(), faults > 0), (3, true), "{states:?}, {faults} faults");
}

/// Regions that change stacks, with tasks that go on in the next one: trajectories, captured values, memories.
fn regions() {
    let program = common::program_of(
        "hierarq 1
robot l { urdf \"robots/arm7.urdf\"  base unicycle  at [0, 0.5, 0] m  rate 100 Hz  home { all [0, 0.40, 0, 1.60, 0, 1.14, 0] rad } }
robot r { urdf \"robots/arm7.urdf\"  base floating  at [0, -0.5, 0] m  rate 100 Hz  home { all [0, 0.40, 0, 1.60, 0, 1.14, 0] rad } }
signal go : event
variable turns : number = 0
stack limits { level limits hard { joint_position_limits  joint_velocity_limits  joint_acceleration_limits } }
task up = frame_position(l_tool) { position trapezoid(initial(position) + [0, 0, 0.1] m, speed: 0.3 m/s, acceleration: 1 m/s^2)  gain 5 /s }
task keep = hold(l_tool)
task wave = joint_position { target { r_joint_1 initial(joint(r_joint_1)) + 0.2 rad * sin(t/(1 s)) }  gain 5 /s }
task soft = admittance(r_tool) {
  target { position initial(position)  orientation initial(orientation) }
  mass { linear 5 kg  angular 0.5 kg m^2 }  damping { linear 60 N s/m  angular 6 N m s/rad }
  stiffness { linear 100 N/m  angular 10 N m/rad }  wrench { force [1, 0, 0] N } }
stack rising from limits { add motion { up } }
stack keeping from limits { add motion { keep } }
stack waving from limits { add motion { wave } }
stack yielding from limits { add motion { soft } }
machine m {
  initial w
  blend 50 ms
  on fault(any) -> w
  state w {
    after 3 s -> w
    region a { initial b  state b { stack rising  after 110 ms -> c }  state c { stack keeping  exit set(turns, turns + 1)  after 70 ms -> d }  state d { after 30 ms -> b } }
    region e { initial f  state f { stack waving  on go -> g  after 0.4 s -> g }  state g { stack yielding  do capture(camera)  after 90 ms -> f  on reached(up, 1 mm) -> f } }
    region h { state i { after 10 ms -> j }  initial i  state j { after 10 ms -> i } } } }",
    );
    let mut controller = Controller::new(&program).expect("it can be executed");
    let mut robot = SimulatedRobot::new(&program);
    let mut states = std::collections::BTreeSet::new();
    for k in 0..2000 {
        let observation = Observation { time: k as f64 * 0.01, q: robot.measure() };
        let before = allocations::so_far();
        if k % 37 == 0 {
            controller.signals().raise(0);
        }
        let command = controller.step(&observation);
        assert_eq!(allocations::so_far(), before, "regions allocate at tick {k}");
        assert!(command.fault.is_none(), "tick {k}: {:?}", command.fault);
        let velocity = command.velocity.to_vec();
        states.insert(controller.state().to_string());
        robot.apply(&velocity);
    }
    assert_eq!(states.len(), 12, "{states:?}");
}
