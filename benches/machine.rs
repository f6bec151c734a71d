//! Time per tick that a machine of 30 states with 10 conditions in the current one adds: the same stack with and
//! without it. `cargo bench --bench machine`.

use std::fmt::Write;
use std::path::Path;

use divan::Bencher;
use runtime::{Controller, Observation, Program};

fn main() {
    divan::main();
}

const STACK: &str = "hierarq 1
robot arm { urdf \"robots/arm7.urdf\"  rate 100 Hz  home { all [0, 0.40, 0, 1.60, 0, 1.14, 0] rad } }
signal push : wrench
signal goal : point?  timeout 1 s
signal go : event
task here = hold(tool)
stack still { level limits hard { joint_position_limits  joint_velocity_limits }  level motion { here } }
";

/// Conditions of signals, of the time, and of what the robot does; none of them holds.
const CONDITIONS: [&str; 10] = [
    "norm(push.force) > 3 N",
    "norm(push.moment) > 1 N m for 0.2 s",
    "push.force.x > 5 N and push.force.z < -1 N",
    "t > 1000 s",
    "joint(joint_1) > 1 rad",
    "norm(frame(tool).position - [1, 1, 1] m) < 0.1 m",
    "frame(tool).position.z < 0 m for 1 s",
    "present(goal) and norm(frame(tool).position - goal) < 0.1 m",
    "joint(joint_2) + joint(joint_4) > 3 rad",
    "abs(push.force.y) > 2 N or norm(push.force) > 8 N",
];

fn program(machine: bool) -> Program {
    let mut text = STACK.to_string();
    if machine {
        let _ = writeln!(text, "machine m {{ initial s0  blend 0.1 s  on fault(any) -> end  on go -> s1\n");
        for i in 0..30 {
            let _ = writeln!(text, "state s{i} {{ stack still  after 900 s -> s{}", (i + 1) % 30);
            for condition in CONDITIONS {
                let _ = writeln!(text, "when {condition} -> end");
            }
            let _ = writeln!(text, "}}");
        }
        let _ = writeln!(text, "final state end }}");
    }
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples");
    let input = compiler::Input {
        name: "bench.hq",
        text: &text,
        syntax: dsl::Syntax::Native,
        folder: &folder,
        set: &[],
        package_paths: &[],
    };
    compiler::compile(&input).program.expect("a good spec")
}

/// A whole tick.
#[divan::bench(args = [false, true])]
fn tick(bencher: Bencher, machine: bool) {
    let program = program(machine);
    let mut controller = Controller::new(&program).expect("it can be executed");
    let q = program.robot.home.clone();
    let mut time = 0.0;
    bencher.bench_local(|| {
        controller.signals().set(0, &[1.0, 0.0, 0.0, 0.0, 0.0, 0.1], time);
        let fault = controller.step(&Observation { time, q: &q }).fault;
        assert!(fault.is_none());
        time += program.robot.period;
        if time > 800.0 {
            controller.restart();
            time = 0.0;
        }
    });
}
