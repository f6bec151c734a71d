//! Expressions of the robot's state in specs, and their rows at any configuration and time.

use dsl::Syntax;
use nalgebra::{DMatrix, Quaternion, UnitQuaternion, Vector3};
use robot::{Data, Model};
use runtime::program::{Program, Times};
use stdlib_tasks::task::{Context, Rows, State, Task, TaskFault};

use super::{compile_text, examples};

pub use robot::random::units as rng;

/// The single arm.
pub const ARM7: &str = r#"
robot arm {
  urdf "robots/arm7.urdf"
  rate 100 Hz
  arms { one { shoulder link_2  elbow link_4  wrist link_6  tip tool  points [elbow, wrist] } }
  points { elbow link_4  wrist link_6  base_point link_1  finger { link tool  offset [0.02, 0, 0.05] m } }
  segments { lower { link link_1  from [0, 0, 0] m  to [0, 0, 0.3] m }  upper { link link_5  from [0, 0, 0] m  to [0, 0.1, 0.2] m } }
  home { all [0.1, 0.4, 0.2, 1.6, 0.1, 1.14, 0.3] rad }
}
"#;

/// The dual-arm robot on a planar base.
pub const CANOPIES: &str = r#"
robot canopies {
  urdf "robots/canopies.urdf"
  base planar
  rate 100 Hz
  arms { one { tip left_tool } }
  points { elbow arm_left_4_link  wrist arm_right_6_link  base_point torso_link  finger { link left_tool  offset [0.02, 0, 0.05] m } }
  segments { lower { link torso_link  from [0, 0, 0] m  to [0, 0, 0.5] m }  upper { link arm_right_5_link  from [0, 0, 0] m  to [0, 0.1, 0.2] m } }
  home { torso_lift 0.15 m  "arm_left_?" [1.11, 0.91, 0.67, -1.86, -0.77, 0.76, -0.89] rad  "arm_right_?" [1.11, 0.91, 0.67, -1.86, -0.77, 0.76, -0.89] rad }
}
"#;

/// Substitutes names of one of the robots: `@A`, `@B` for frames, `@J`, `@K` for joints.
pub fn words(text: &str, robot: &str) -> String {
    let single = robot == ARM7;
    let names = [
        ("@A", if single { "one" } else { "left_tool" }),
        ("@B", if single { "link_4" } else { "right_tool" }),
        ("@J", if single { "joint_2" } else { "arm_left_2" }),
        ("@K", if single { "joint_4" } else { "arm_right_4" }),
    ];
    names.iter().fold(text.to_string(), |t, (word, name)| t.replace(word, name))
}

/// Program of some tasks, without hard levels.
pub fn program(robot: &str, tasks: &[String]) -> Program {
    let lines: Vec<String> =
        tasks.iter().enumerate().map(|(i, t)| format!("task t{i} = {}\n", words(t, robot))).collect();
    let names: Vec<String> = (0..tasks.len()).map(|i| format!("t{i}")).collect();
    let stack = format!("stack s {{ level all {{ {} }} }}\n", names.join("  "));
    let text = format!("hierarq 1\n{robot}{}{stack}run {{ duration 1 s }}\n", lines.concat());
    let compiled = compile_text(&text, Syntax::Native, &examples(), &[]);
    compiled.program.unwrap_or_else(|| panic!("{}", super::annotated(&super::Compiled::refused(compiled.report))))
}

/// Evaluates the tasks of a program.
pub struct Bench<'p> {
    pub program: &'p Program,
    pub inputs: Vec<f64>,
}

/// Rows written by a task.
pub struct Written {
    pub j: DMatrix<f64>,
    pub lower: Vec<f64>,
    pub upper: Vec<f64>,
    pub margins: Vec<f64>,
}

impl Bench<'_> {
    pub fn model(&self) -> &Model {
        &self.program.robot.model
    }

    pub fn task(&self, index: usize) -> Box<dyn Task> {
        let p = self.program;
        let speed: Vec<f64> = p.robot.model.dofs.iter().map(|d| d.velocity).collect();
        let ctx = Context {
            model: &p.robot.model,
            values: &p.values.initial,
            period: p.robot.period,
            speed: &speed,
            entry_speed: &speed,
        };
        let kind = stdlib_tasks::find(&p.tasks[index].kind).expect("a task type");
        (kind.build)(&p.tasks[index].params, &ctx).expect("good parameters")
    }

    fn tables(&self, t: f64) -> (Vec<f64>, Vec<f64>) {
        let v = &self.program.values;
        let (mut values, mut rates) = (v.initial.clone(), vec![0.0; v.initial.len()]);
        let mut registers = vec![0.0; v.tape.ops.len()];
        v.tape.evaluate(Times { t, time: t }, &self.inputs, &[], &mut registers, &mut values, &mut rates);
        (values, rates)
    }

    pub fn rows(&self, task: &mut dyn Task, q: &[f64], t: f64) -> Result<Written, TaskFault> {
        let model = self.model();
        let mut data = Data::new(model);
        model.forward(q, &mut data);
        let (values, rates) = self.tables(t);
        let velocity = vec![0.0; model.nv()];
        let state = State {
            model,
            data: &data,
            q,
            values: &values,
            rates: &rates,
            velocity: &velocity,
            stack_velocity: &velocity,
        };
        let (n, nv) = (task.rows().len(), model.nv());
        let stride = nv + 3;
        let mut jacobian = vec![0.0; n * stride];
        let (mut lower, mut upper) = (vec![f64::NEG_INFINITY; n], vec![f64::INFINITY; n]);
        let (mut margins, mut measures) = (vec![f64::INFINITY; n], vec![0.0; task.measures().len()]);
        let mut undefined = false;
        for (i, dof) in task.degrees_of_freedom().into_iter().flatten().enumerate() {
            jacobian[i * stride + dof] = 1.0;
        }
        let mut rows = Rows {
            idle: &[],
            jacobian: &mut jacobian,
            stride,
            lower: &mut lower,
            upper: &mut upper,
            margins: &mut margins,
            measures: &mut measures,
            undefined: &mut undefined,
            trial: false,
        };
        task.update(&state, &mut rows)?;
        assert!(jacobian.chunks(stride).all(|row| row[nv..].iter().all(|&x| x == 0.0)), "padding was written");
        Ok(Written { j: DMatrix::from_fn(n, nv, |i, k| jacobian[i * stride + k]), lower, upper, margins })
    }

    /// Value that `initial(value)` would capture.
    pub fn value(&self, task: &dyn Task, q: &[f64], t: f64, len: usize) -> Vec<f64> {
        let model = self.model();
        let mut data = Data::new(model);
        model.forward(q, &mut data);
        let (values, rates) = self.tables(t);
        let mut out = vec![0.0; len];
        let velocity = vec![0.0; model.nv()];
        let state = State {
            model,
            data: &data,
            q,
            values: &values,
            rates: &rates,
            velocity: &velocity,
            stack_velocity: &velocity,
        };
        assert!(task.current_value("value", &state, &mut out));
        out
    }
}

/// Rate between two values `2 h` apart: for four numbers, the angular velocity; for a pose, both.
pub fn difference(plus: &[f64], minus: &[f64], h: f64) -> Vec<f64> {
    if plus.len() == 7 {
        return [difference(&plus[..3], &minus[..3], h), difference(&plus[3..], &minus[3..], h)].concat();
    }
    if plus.len() == 4 {
        let q = |a: &[f64]| UnitQuaternion::new_normalize(Quaternion::new(a[0], a[1], a[2], a[3]));
        let turn: Vector3<f64> = stdlib_tasks::so3::log(&(q(plus) * q(minus).inverse())) / (2.0 * h);
        return turn.iter().copied().collect();
    }
    plus.iter().zip(minus).map(|(a, b)| (a - b) / (2.0 * h)).collect()
}
