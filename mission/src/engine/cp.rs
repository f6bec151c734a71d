//! A constraint program over integers and optional intervals, solved by `pumpkin` (lazy clause generation).
//!
//! The solver has neither optional intervals nor numbers beyond 32 bits, and panics on a coefficient of zero. This
//! layer hides that: an absent interval is moved beyond the horizon, values out of range are rejected with
//! [`EngineError::Overflow`], and zeros are omitted.

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

/// Maximum magnitude of a number, of a coefficient times its range, and of a sum of these.
pub const MOST: i64 = 1 << 30;

/// An integer variable.
#[derive(Clone, Copy, Debug)]
pub struct Number {
    id: DomainId,
    low: i64,
    high: i64,
}

/// A Boolean variable.
#[derive(Clone, Copy, Debug)]
pub struct Choice(Literal);

/// A term of a sum.
#[derive(Clone, Copy, Debug)]
pub enum Term {
    /// The number.
    Number(Number),
    /// The choice, as 1 for true and 0 for false.
    Choice(Choice),
}

/// An interval that begins at `anchor + offset` and is present only if chosen.
#[derive(Clone, Copy, Debug)]
pub struct Optional {
    /// True if the interval is present.
    pub present: Choice,
    /// Variable part of the begin.
    pub anchor: Number,
    /// Constant part of the begin; may be negative.
    pub offset: i64,
    /// Length of the interval. Zero or more.
    pub length: i64,
}

/// Values of a solution.
#[derive(Clone, Debug, PartialEq)]
pub struct Values {
    /// Values of the requested numbers, in their order.
    pub numbers: Vec<i64>,
    /// Values of the requested choices, in their order.
    pub choices: Vec<bool>,
}

/// Result of a search.
#[derive(Clone, Debug, PartialEq)]
pub enum Outcome {
    /// The optimal values; with [`Limit`], the best values when that limit ended the search.
    Found(Values, Option<Limit>),
    /// The program is infeasible.
    Impossible,
    /// A limit was reached before the first solution.
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
    /// Adds an integer variable from `low` to `high`.
    ///
    /// # Errors
    ///
    /// A bound is too large.
    pub fn number(&mut self, low: i64, high: i64) -> Result<Number, EngineError> {
        let (least, most) = (fit("a bound", low)?, fit("a bound", high.max(low))?);
        let id = self.solver.new_bounded_integer(least, most);
        Ok(Number { id, low, high: high.max(low) })
    }

    /// Adds a Boolean variable.
    pub fn choice(&mut self) -> Choice {
        Choice(self.solver.new_literal())
    }

    /// Converts terms for the solver, without zeros.
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

    /// Adds `sum of terms <= bound`, unconditionally or only if `only` is true.
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

    /// Adds the constraint that exactly one of these choices is true.
    ///
    /// # Errors
    ///
    /// There are too many.
    pub fn exactly_one(&mut self, choices: &[Choice]) -> Result<(), EngineError> {
        let ones = |sign: i64| choices.iter().map(move |choice| (Term::Choice(*choice), sign)).collect::<Vec<_>>();
        self.at_most(&ones(1), 1, None)?;
        self.at_most(&ones(-1), -1, None)
    }

    /// Adds the constraint that no two present intervals overlap. All lie between 0 and `horizon`.
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

    /// Minimises `objective`; returns the values of the requested variables and the number of search steps. The search
    /// is deterministic; `budget.nodes` limits its steps.
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

/// A budget as the solver's termination condition.
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
