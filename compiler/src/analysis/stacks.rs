//! The stacks of a program, each built once for all rules that look at it.
//!
//! To build a stack takes far longer than to evaluate it: the reserve of a distance alone needs bounds of its curvature
//! over the whole range of the joints. Rules therefore share the tasks, the evaluator, and the rows at a few postures.

use std::cell::{OnceCell, RefCell};

use runtime::program::{Program, StackProgram, Times};
use runtime::{Built, Evaluator, Member, RestInputs, build_tasks};
use solver::Problem;

/// Number of random postures, beside home, at which rows are sampled.
pub(crate) const RANDOM: usize = 4;

/// All stacks of a program.
pub(crate) struct Stacks<'p> {
    all: Vec<Stack<'p>>,
    /// Home, and random postures.
    postures: Vec<Vec<f64>>,
}

/// One stack.
pub(crate) struct Stack<'p> {
    program: &'p Program,
    index: usize,
    tasks: OnceCell<Vec<Built>>,
    members: OnceCell<Vec<Member>>,
    /// An evaluator that nobody uses at the moment.
    spare: RefCell<Option<Prepared>>,
    /// False if the stack cannot be built.
    builds: OnceCell<bool>,
    /// Rows at postures, without signals and with all of them.
    samples: [Vec<OnceCell<Option<Sample>>>; 2],
}

/// A stack that can be evaluated, and the problem that it fills.
pub(crate) struct Prepared {
    pub evaluator: Evaluator,
    pub problem: Problem,
}

/// Signals at which rows are sampled.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Signals {
    /// Absent.
    Absent,
    /// Present, with zeros: see [`RestInputs::present`].
    Present,
}

/// Rows of a stack at a posture where it is entered, at time zero.
pub(crate) struct Sample {
    problem: Problem,
    /// True for each task with an undefined row.
    pub undefined: Vec<bool>,
    /// Margins of the rows of all limits, as in [`Evaluator::margins`].
    pub margins: Vec<f64>,
}

impl Sample {
    /// The problem.
    pub fn problem(&self) -> &Problem {
        &self.problem
    }

    /// Coefficients of the rows of a task, `nv` each.
    pub fn rows(&self, member: &Member) -> impl Iterator<Item = &[f64]> {
        let level = &self.problem.levels[member.level];
        member.rows.clone().map(|r| level.row(r))
    }
}

impl<'p> Stacks<'p> {
    /// Nothing is built until a rule asks for it.
    pub fn new(program: &'p Program) -> Stacks<'p> {
        let cells = || (0..=RANDOM).map(|_| OnceCell::new()).collect();
        let one = |index| Stack {
            program,
            index,
            tasks: OnceCell::new(),
            members: OnceCell::new(),
            spare: RefCell::new(None),
            builds: OnceCell::new(),
            samples: [cells(), cells()],
        };
        Stacks { all: (0..program.stacks.len()).map(one).collect(), postures: postures(program, RANDOM) }
    }

    /// Number of stacks.
    pub fn len(&self) -> usize {
        self.all.len()
    }

    /// The tasks of a stack, one for each member in the order of levels, or the reasons why they cannot be built.
    pub fn tasks(&self, stack: usize) -> &[Built] {
        let stack = &self.all[stack];
        stack.tasks.get_or_init(|| build_tasks(stack.program, stack.stack()))
    }

    /// The members of a stack; none if it cannot be built.
    pub fn members(&self, stack: usize) -> &[Member] {
        let members = || self.with(stack, |evaluator, _| evaluator.members().to_vec()).unwrap_or_default();
        self.all[stack].members.get_or_init(members)
    }

    /// Signals that must be present for a stack to run; none if it cannot be built.
    pub fn needs(&self, stack: usize) -> Vec<usize> {
        self.with(stack, |evaluator, _| evaluator.needs().to_vec()).unwrap_or_default()
    }

    /// Takes an evaluator of a stack, which has to be entered before it is used; `None` if the stack cannot be built.
    /// [`Stacks::give`] keeps it for the next one who needs it.
    pub fn take(&self, stack: usize) -> Option<Prepared> {
        let stack = &self.all[stack];
        if stack.builds.get() == Some(&false) {
            return None;
        }
        let spare = stack.spare.borrow_mut().take();
        let prepared = spare.or_else(|| {
            let made = Evaluator::new(stack.program, stack.index).ok();
            made.map(|(evaluator, problem)| Prepared { evaluator, problem })
        });
        stack.builds.get_or_init(|| prepared.is_some());
        prepared
    }

    /// Takes back an evaluator of a stack.
    pub fn give(&self, stack: usize, prepared: Prepared) {
        *self.all[stack].spare.borrow_mut() = Some(prepared);
    }

    /// Uses an evaluator of a stack; `None` if the stack cannot be built.
    pub fn with<T>(&self, stack: usize, run: impl FnOnce(&mut Evaluator, &mut Problem) -> T) -> Option<T> {
        let mut prepared = self.take(stack)?;
        let result = run(&mut prepared.evaluator, &mut prepared.problem);
        self.give(stack, prepared);
        Some(result)
    }

    /// The rows of a stack at home (`posture` 0), or at a random posture, up to [`RANDOM`]. `None` if they cannot be
    /// computed there, for example where parts overlap.
    pub fn sample(&self, stack: usize, signals: Signals, posture: usize) -> Option<&Sample> {
        let (q, of) = (self.postures.get(posture)?, &self.all[stack]);
        let take = || {
            let rest = signals.inputs(of.program);
            self.with(stack, |evaluator, problem| {
                evaluator.enter(q, rest.at(Times::default()));
                evaluator.update(q, rest.at(Times::default()), problem).ok()?;
                Some(Sample {
                    problem: problem.clone(),
                    undefined: evaluator.undefined().to_vec(),
                    margins: evaluator.margins().to_vec(),
                })
            })?
        };
        of.samples[signals as usize].get(posture)?.get_or_init(take).as_ref()
    }

    /// All samples of a stack that exist, home first.
    pub fn samples(&self, stack: usize, signals: Signals) -> impl Iterator<Item = &Sample> {
        (0..=RANDOM).filter_map(move |k| self.sample(stack, signals, k))
    }
}

impl Stack<'_> {
    fn stack(&self) -> &StackProgram {
        &self.program.stacks[self.index]
    }
}

impl Signals {
    /// The inputs with these signals, for a robot at rest.
    pub fn inputs(self, program: &Program) -> RestInputs {
        match self {
            Signals::Absent => RestInputs::new(program),
            Signals::Present => RestInputs::present(program),
        }
    }
}

/// The posture at home, and random ones, always the same.
pub(crate) fn postures(program: &Program, random: usize) -> Vec<Vec<f64>> {
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    let mut unit = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    let mut postures = vec![program.robot.home.clone()];
    postures.extend((0..random).map(|_| program.robot.model.random_configuration(&mut unit)));
    postures
}
