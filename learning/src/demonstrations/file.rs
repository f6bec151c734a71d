//! Files of demonstrations: JSON Lines, one trajectory in each line.
//!
//! ```json
//! {"targets":[{"cell":12,"kind":1}],"cells":[3,4,5],"actions":["east","east"]}
//! ```
//!
//! `targets` are those at the start; `cells` are the cells of the person, one more than `actions`. Cells and actions say the
//! same twice, so that a recording of another world, or one with a gap, is noticed.

use super::Trajectory;
use crate::grid::{Action, Cell, StateError, Target, World};
use serde::{Deserialize, Serialize};

/// The most steps of a trajectory in a file.
pub const MAX_STEPS: usize = 100_000;

/// A line.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Line {
    targets: Vec<Target>,
    cells: Vec<Cell>,
    actions: Vec<String>,
}

/// Reason why a file holds no demonstrations.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
pub enum DemonstrationError {
    /// No line.
    #[error("the file holds no trajectory")]
    Empty,
    /// A wrong line.
    #[error("line {line}: {fault}")]
    Line {
        /// Number of the line, from 1.
        line: usize,
        /// Its fault.
        fault: FaultOfLine,
    },
}

/// Fault of a line.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
pub enum FaultOfLine {
    /// Not the JSON of a trajectory.
    #[error("not a trajectory: {0}")]
    Json(String),
    /// The numbers of cells and actions do not fit.
    #[error("there are {cells} cells and {actions} actions; one cell more than actions is expected")]
    Lengths {
        /// Cells.
        cells: usize,
        /// Actions.
        actions: usize,
    },
    /// No action.
    #[error("the trajectory has no actions")]
    NoActions,
    /// Too many actions.
    #[error("the trajectory has {0} actions; at most {MAX_STEPS} are read")]
    TooLong(usize),
    /// The first state is not one of the world.
    #[error("the start: {0}")]
    Start(StateError),
    /// An unknown action.
    #[error("action {step} is `{name}`; `north`, `south`, `west`, `east` and `collect` are known")]
    Action {
        /// Index of the action, from 0.
        step: usize,
        /// Its name in the file.
        name: String,
    },
    /// A cell outside of the grid.
    #[error("cell {step} is {cell}, and the grid has {cells} cells")]
    Outside {
        /// Index of the cell in the line, from 0.
        step: usize,
        /// The cell.
        cell: Cell,
        /// Cells of the grid.
        cells: usize,
    },
    /// A step that the action does not make.
    #[error("action {step}, `{}`, leads from cell {from} to cell {expected}, and the line says {found}", action.name())]
    Step {
        /// Index of the action, from 0.
        step: usize,
        /// The action.
        action: Action,
        /// Cell before.
        from: Cell,
        /// Cell that the action leads to.
        expected: Cell,
        /// Cell in the line.
        found: Cell,
    },
    /// Actions after an exit.
    #[error("the person is on an exit before action {0}, and the way ends there")]
    AfterExit(usize),
}

/// Writes trajectories of a world.
pub fn write(world: &World, trajectories: &[Trajectory]) -> String {
    let mut text = String::new();
    for trajectory in trajectories {
        let cells = trajectory.steps(world).map(|step| step.step.state.cell());
        let line = Line {
            targets: trajectory.start.targets().to_vec(),
            cells: [trajectory.start.cell()].into_iter().chain(cells).collect(),
            actions: trajectory.actions.iter().map(|action| action.name().to_string()).collect(),
        };
        text += &serde_json::to_string(&line).expect("numbers and texts are JSON");
        text.push('\n');
    }
    text
}

/// Reads trajectories of a world. Empty lines are skipped.
pub fn read(world: &World, text: &str) -> Result<Vec<Trajectory>, DemonstrationError> {
    let lines = text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty());
    let trajectory =
        |(at, line)| of_line(world, line).map_err(|fault| DemonstrationError::Line { line: at + 1, fault });
    let trajectories = lines.map(trajectory).collect::<Result<Vec<_>, _>>()?;
    if trajectories.is_empty() { Err(DemonstrationError::Empty) } else { Ok(trajectories) }
}

fn of_line(world: &World, line: &str) -> Result<Trajectory, FaultOfLine> {
    let line: Line = serde_json::from_str(line).map_err(|e| FaultOfLine::Json(e.to_string()))?;
    let count = line.actions.len();
    if line.cells.len() != count + 1 {
        return Err(FaultOfLine::Lengths { cells: line.cells.len(), actions: count });
    }
    if count == 0 {
        return Err(FaultOfLine::NoActions);
    }
    if count > MAX_STEPS {
        return Err(FaultOfLine::TooLong(count));
    }
    let start = world.state(line.cells[0], &line.targets).map_err(FaultOfLine::Start)?;
    let mut state = start;
    let mut actions = Vec::with_capacity(count);
    for (step, name) in line.actions.into_iter().enumerate() {
        let action = Action::from_name(&name).ok_or(FaultOfLine::Action { step, name })?;
        let found = line.cells[step + 1];
        if usize::from(found) >= world.cells() {
            return Err(FaultOfLine::Outside { step: step + 1, cell: found, cells: world.cells() });
        }
        if world.is_exit(state.cell()) {
            return Err(FaultOfLine::AfterExit(step));
        }
        let from = state.cell();
        state = world.step(&state, action).state;
        let expected = state.cell();
        if expected != found {
            return Err(FaultOfLine::Step { step, action, from, expected, found });
        }
        actions.push(action);
    }
    Ok(Trajectory { start, actions })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn world() -> World {
        World::new(4, 2, &[2], &[3], 2).unwrap()
    }

    #[test]
    fn trajectories_are_read_as_they_were_written() {
        let world = world();
        let start = world.state(0, &[Target { cell: 1, kind: 1 }, Target { cell: 4, kind: 0 }]).unwrap();
        use Action::{Collect, East, North, South};
        let actions = vec![East, Collect, East, North, East, East, South];
        let trajectory = Trajectory { start, actions };
        assert_eq!(trajectory.steps(&world).filter(|step| step.step.collision).count(), 1);
        let short = Trajectory { start, actions: vec![South] };
        let text = write(&world, &[trajectory.clone(), short.clone()]);
        assert!(text.starts_with(
            r#"{"targets":[{"cell":1,"kind":1},{"cell":4,"kind":0}],"cells":[0,1,1,1,5,6,7,3],"actions":["east","#
        ));
        assert_eq!(read(&world, &text).unwrap(), [trajectory, short]);
    }

    #[test]
    fn wrong_files_are_refused_with_their_line() {
        let good = r#"{"targets":[],"cells":[0,1],"actions":["east"]}"#;
        let error = |line: &str| read(&world(), &format!("{good}\n\n{line}\n")).unwrap_err().to_string();
        assert_eq!(read(&world(), "\n \n").unwrap_err(), DemonstrationError::Empty);
        assert!(error("{").starts_with("line 3: not a trajectory: EOF"), "{}", error("{"));
        assert!(error(r#"{"cells":[0]}"#).contains("missing field `targets`"));
        let negative = error(r#"{"targets":[],"cells":[-1,1],"actions":["east"]}"#);
        assert!(negative.contains("not a trajectory: invalid value"), "{negative}");
        let cases = [
            (
                r#"{"targets":[],"cells":[0],"actions":["east"]}"#,
                "there are 1 cells and 1 actions; one cell more than actions is expected",
            ),
            (r#"{"targets":[],"cells":[0],"actions":[]}"#, "the trajectory has no actions"),
            (
                r#"{"targets":[],"cells":[9,1],"actions":["east"]}"#,
                "the start: the person is in cell 9, and the grid has 8 cells",
            ),
            (
                r#"{"targets":[{"cell":8,"kind":0}],"cells":[0,1],"actions":["east"]}"#,
                "the start: a target is in cell 8, and the grid has 8 cells",
            ),
            (
                r#"{"targets":[{"cell":1,"kind":2}],"cells":[0,1],"actions":["east"]}"#,
                "the start: a target has type 2, and the world has 2 types, numbered from 0",
            ),
            (
                r#"{"targets":[],"cells":[0,1],"actions":["up"]}"#,
                "action 0 is `up`; `north`, `south`, `west`, `east` and `collect` are known",
            ),
            (r#"{"targets":[],"cells":[0,8],"actions":["east"]}"#, "cell 1 is 8, and the grid has 8 cells"),
            (
                r#"{"targets":[],"cells":[0,5],"actions":["east"]}"#,
                "action 0, `east`, leads from cell 0 to cell 1, and the line says 5",
            ),
            (
                r#"{"targets":[],"cells":[7,3,7],"actions":["south","north"]}"#,
                "the person is on an exit before action 1, and the way ends there",
            ),
        ];
        for (line, expected) in cases {
            assert_eq!(error(line), format!("line 3: {expected}"));
        }
    }
}
