//! Measures that tasks of a program provide.

use runtime::program::Program;
use stdlib_tasks::dimension::Dimension;
use stdlib_tasks::task::{Context, RowKind, Task};

/// Measures that a task provides.
pub(super) struct Shape {
    /// Target or limit.
    pub row_kind: RowKind,
    /// Common dimension of all rows, if they have one.
    pub margin: Option<Dimension>,
    /// True if the task depends on a value captured when its stack was entered.
    pub remembers_entry: bool,
    /// Parts of the error, with their dimensions.
    pub parts: Vec<(String, Dimension)>,
}

/// Measures of all tasks of a program; `None` for a task that cannot be built, which was reported.
pub(super) fn shapes(program: &Program) -> Vec<Option<Shape>> {
    let (model, values, period) = (&program.robot.model, &program.values.initial, program.robot.period);
    let shape = |kind: &str, task: &dyn Task| {
        let rows = task.rows();
        let first = rows.first().map(|r| r.dimension);
        Some(Shape {
            row_kind: stdlib_tasks::find(kind)?.row_kind,
            remembers_entry: task.remembers_entry(),
            margin: first.filter(|d| rows.iter().all(|r| r.dimension == *d)),
            parts: task.measures().into_iter().map(|m| (m.name, m.dimension)).collect(),
        })
    };
    let mut all: Vec<Option<Shape>> = program.tasks.iter().map(|_| None).collect();
    // Tasks of stacks are built in the context of their first stack.
    let mut stands = vec![false; all.len()];
    for stack in &program.stacks {
        let built = runtime::build_tasks(program, stack);
        for (m, built) in stack.levels.iter().flat_map(|l| &l.members).zip(built) {
            if let (Ok(task), false) = (built.task, std::mem::replace(&mut stands[m.task], true)) {
                all[m.task] = shape(&program.tasks[m.task].kind, task.as_ref());
            }
        }
    }
    let speed = vec![f64::INFINITY; model.nv()];
    let context = Context { model, values, period, speed: &speed, entry_speed: &speed };
    for ((shape_of, t), _) in all.iter_mut().zip(&program.tasks).zip(&stands).filter(|(_, stands)| !**stands) {
        let built = stdlib_tasks::find(&t.kind).and_then(|kind| (kind.build)(&t.params, &context).ok());
        *shape_of = built.and_then(|task| shape(&t.kind, task.as_ref()));
    }
    all
}
