//! A constraint program over whole numbers and optional intervals, solved by `pumpkin` (lazy clause generation).
//!
//! The solver has neither optional intervals nor numbers beyond 32 bits, and panics on a coefficient of zero. This layer
//! hides that: an interval that is absent is parked beyond the horizon, what does not fit is refused with
//! [`EngineError::Overflow`], zeros are left out.

use std::ops::ControlFlow;
use std::time::Instant;

use pumpkin_conflict_resolvers::resolvers::ResolutionResolver;
use pumpkin_core::optimisation::OptimisationDirection;
use pumpkin_core::optimisation::linear_sat_unsat::LinearSatUnsat;
use pumpkin_core::predicate;
use pumpkin_core::results::{OptimisationResult, ProblemSolution, SolutionReference};
use pumpkin_core::termination::TerminationCondition;
use pumpkin_core::variables::{AffineView, DomainId, Literal, TransformableVariable};
use pumpkin_core::{DefaultBrancher, Solver};
use pumpkin_propagators::disjunctive::ArgDisjunctiveTask;

use crate::plan::Limit;

use super::{Budget, EngineError};

/// The largest magnitude of a number, a coefficient times its range, a sum of such.
pub const MOST: i64 = 1 << 30;

/// A whole number to be found.
#[derive(Clone, Copy, Debug)]
pub struct Number {
    id: DomainId,
    low: i64,
    high: i64,
}

/// Yes or no, to be found.
#[derive(Clone, Copy, Debug)]
pub struct Choice(Literal);

/// Something that counts in a sum.
#[derive(Clone, Copy, Debug)]
pub enum Term {
    /// The number.
    Number(Number),
    /// 1 for yes, 0 for no.
    Choice(Choice),
}

/// An interval that begins at `anchor + offset`, there only if chosen.
#[derive(Clone, Copy, Debug)]
pub struct Optional {
    /// Whether it is there.
    pub present: Choice,
    /// The number by which it moves.
    pub anchor: Number,
    /// How much later than the number it begins; may be negative.
    pub offset: i64,
    /// How long it is. Zero or more.
    pub length: i64,
}

/// Values of a solution.
#[derive(Clone, Debug, PartialEq)]
pub struct Values {
    /// Of the numbers asked for, in their order.
    pub numbers: Vec<i64>,
    /// Of the choices asked for, in their order.
    pub choices: Vec<bool>,
}

/// What came out.
#[derive(Clone, Debug, PartialEq)]
pub enum Outcome {
    /// The best values; with [`Limit`], the best when that ended the search.
    Found(Values, Option<Limit>),
    /// There are none.
    Impossible,
    /// A limit came before any.
    Nothing(Limit),
}

/// A constraint program.
#[derive(Default)]
pub struct Program {
    solver: Solver,
}

fn fit(what: &str, value: i64) -> Result<i32, EngineError> {
    let small = i32::try_from(value).ok().filter(|_| value.abs() <= MOST);
    small.ok_or_else(|| EngineError::Overflow {
        engine: "pumpkin".into(),
        what: format!("{what} would be {value}, beyond {MOST}"),
    })
}

impl Program {
    /// A whole number from `low` to `high`.
    ///
    /// # Errors
    ///
    /// A bound is too large.
    pub fn number(&mut self, low: i64, high: i64) -> Result<Number, EngineError> {
        let (least, most) = (fit("a bound", low)?, fit("a bound", high.max(low))?);
        let id = self.solver.new_bounded_integer(least, most);
        Ok(Number { id, low, high: high.max(low) })
    }

    /// A yes or no.
    pub fn choice(&mut self) -> Choice {
        Choice(self.solver.new_literal())
    }

    /// Terms as the solver takes them, without zeros.
    fn views(terms: &[(Term, i64)]) -> Result<Vec<AffineView<DomainId>>, EngineError> {
        let mut views = Vec::new();
        let mut reach = 0_i64;
        for (term, coefficient) in terms.iter().filter(|(_, coefficient)| *coefficient != 0) {
            let small = fit("a coefficient", *coefficient)?;
            let (view, size) = match term {
                Term::Number(number) => (number.id.scaled(small), number.low.abs().max(number.high.abs())),
                Term::Choice(choice) => (choice.0.get_integer_variable().scaled(small), 1),
            };
            reach = reach.saturating_add(coefficient.saturating_abs().saturating_mul(size));
            views.push(view);
        }
        fit("a sum", reach)?;
        Ok(views)
    }

    /// `sum of terms <= bound`, always or only if chosen.
    ///
    /// # Errors
    ///
    /// A number is too large.
    pub fn at_most(&mut self, terms: &[(Term, i64)], bound: i64, only: Option<Choice>) -> Result<(), EngineError> {
        let views = Program::views(terms)?;
        let bound = fit("a bound", bound)?;
        let tag = self.solver.new_constraint_tag();
        if views.is_empty() {
            if bound < 0 {
                let never: Vec<_> = only.iter().map(|only| only.0.get_false_predicate()).collect();
                self.solver.add_clause(never, tag);
            }
            return Ok(());
        }
        let constraint = self.solver.add_constraint(pumpkin_constraints::less_than_or_equals(views, bound, tag));
        match only {
            Some(only) => constraint.implied_by(only.0),
            None => constraint.post(),
        }
        Ok(())
    }

    /// Exactly one of these.
    ///
    /// # Errors
    ///
    /// There are too many.
    pub fn exactly_one(&mut self, choices: &[Choice]) -> Result<(), EngineError> {
        let ones = |sign: i64| choices.iter().map(move |choice| (Term::Choice(*choice), sign)).collect::<Vec<_>>();
        self.at_most(&ones(1), 1, None)?;
        self.at_most(&ones(-1), -1, None)
    }

    /// No two of these intervals overlap where both are there. All lie between 0 and `horizon`.
    ///
    /// # Errors
    ///
    /// A number is too large.
    pub fn no_overlap(&mut self, intervals: &[Optional], horizon: i64) -> Result<(), EngineError> {
        let mut parked = horizon;
        let mut tasks = Vec::new();
        for interval in intervals {
            let (offset, length) = (interval.offset, interval.length);
            if length == 0 {
                continue;
            }
            let shadow = self.number(0, parked)?;
            let (here, there) = (fit("the horizon", horizon)?, fit("a time", parked)?);
            let id = shadow.id;
            let tag = self.solver.new_constraint_tag();
            let present = interval.present.0;
            self.solver.add_clause([present.get_true_predicate(), predicate![id == there]], tag);
            self.solver.add_clause([present.get_false_predicate(), predicate![id <= here]], tag);
            let (start, anchor) = (Term::Number(shadow), Term::Number(interval.anchor));
            self.at_most(&[(start, 1), (anchor, -1)], offset, Some(interval.present))?;
            self.at_most(&[(start, -1), (anchor, 1)], -offset, Some(interval.present))?;
            let processing_time = fit("a length", length)?;
            tasks.push(ArgDisjunctiveTask { start_time: id.scaled(1), processing_time });
            parked += length;
        }
        fit("the horizon with what is parked", parked)?;
        if tasks.len() > 1 {
            let tag = self.solver.new_constraint_tag();
            self.solver.add_constraint(pumpkin_constraints::disjunctive_strict(tasks, tag)).post();
        }
        Ok(())
    }

    /// The least value of `objective`, with the values of what is asked for. Every run takes the same way; `budget.nodes`
    /// counts the steps of the search.
    pub fn minimise(mut self, objective: Number, ask: (&[Number], &[Choice]), budget: &Budget) -> (Outcome, u64) {
        let mut brancher = self.solver.default_brancher();
        let mut resolver = ResolutionResolver::default();
        let mut limit = Until { begun: Instant::now(), budget: *budget, steps: 0, ended: None };
        let go_on = |_: &Solver, _: SolutionReference<'_>, _: &DefaultBrancher, _: &ResolutionResolver| {
            ControlFlow::<()>::Continue(())
        };
        let procedure = LinearSatUnsat::new(OptimisationDirection::Minimise, objective.id, go_on);
        let result = self.solver.optimise(&mut brancher, &mut limit, &mut resolver, procedure);
        let ended = limit.ended.unwrap_or(Limit::Work);
        let values = |solution: &dyn Fn(DomainId) -> i32, truth: &dyn Fn(Literal) -> bool| Values {
            numbers: ask.0.iter().map(|number| i64::from(solution(number.id))).collect(),
            choices: ask.1.iter().map(|choice| truth(choice.0)).collect(),
        };
        let outcome = match &result {
            OptimisationResult::Optimal(solution) => Outcome::Found(
                values(&|id| solution.get_integer_value(id), &|literal| solution.get_literal_value(literal)),
                None,
            ),
            OptimisationResult::Satisfiable(solution) | OptimisationResult::Stopped(solution, ()) => Outcome::Found(
                values(&|id| solution.get_integer_value(id), &|literal| solution.get_literal_value(literal)),
                Some(ended),
            ),
            OptimisationResult::Unsatisfiable => Outcome::Impossible,
            OptimisationResult::Unknown => Outcome::Nothing(ended),
        };
        (outcome, limit.steps)
    }
}

/// A budget as the solver asks for it.
struct Until {
    begun: Instant,
    budget: Budget,
    steps: u64,
    ended: Option<Limit>,
}

impl TerminationCondition for Until {
    fn should_stop(&mut self) -> bool {
        self.steps += 1;
        if self.steps > self.budget.nodes {
            self.ended = Some(Limit::Work);
        } else if self.steps.is_multiple_of(64) && self.begun.elapsed() >= self.budget.time {
            self.ended = Some(Limit::Time);
        }
        self.ended.is_some()
    }
}
