//! Expectations: formulas over predicates, with windows in ticks. A [`Source`] defines the predicates: a robot that
//! runs its program, or a mission under execution.

use dsl::tree::{Expect, Formula as Written, FormulaKind, Value, Window as Times};
use dsl::{Diagnostic, Span};
use runtime::expect::{Formula, MAX_KEPT, MAX_NODES, Monitor, Node, Unit, Window, WindowError};
use runtime::program::ExpectationProgram;
use stdlib_tasks::dimension::TIME;

use super::{Lowerer, expectation_checks};
use crate::expr::constants::Constants;

/// Maximum number of parts of all expectations in a spec.
const MAX_PARTS: usize = 3000;

/// Ticks at which the expectations of a scenario are judged.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ticks {
    /// Period (s).
    pub period: f64,
    /// Maximum number of ticks.
    pub count: u32,
    /// Span of the period.
    pub at: Span,
}

/// Source of the predicates of a scenario.
pub(super) trait Source {
    /// Returns the index of a predicate among those of the scenario. Returns `None` if it is invalid, with diagnostics.
    fn predicate(&mut self, lowerer: &mut Lowerer, value: &Value) -> Option<usize>;

    /// Units of the predicates so far.
    fn units(&self) -> Vec<Unit>;

    /// Returns true for a robot that runs its program, of which zero satisfies `>`.
    fn is_of_robot(&self) -> bool {
        false
    }

    /// Checks a formula as a whole, after all its predicates are lowered.
    fn whole(&mut self) -> Option<Diagnostic> {
        None
    }
}

impl Lowerer<'_> {
    /// Lowers the expectations of a scenario; `texts` are their source texts.
    pub(super) fn formulas(
        &mut self,
        (expects, texts): (&[Expect], &[String]),
        ticks: Ticks,
        source: &mut dyn Source,
    ) -> Vec<ExpectationProgram> {
        let (mut all, mut kept) = (Vec::new(), 0_usize);
        for (expect, text) in expects.iter().zip(texts) {
            if self.expected > MAX_PARTS {
                let text = format!("the expectations of this spec have more than {MAX_PARTS} parts");
                let d = Diagnostic::error("HQ0803", expect.span, text).here("counted up to here");
                self.push(d.help("write several specs"));
                break;
            }
            let mut formula = Formula::new(ticks.period);
            let found = Builder { lowerer: self, ticks, source, from: 0 }.formula(&expect.formula, &mut formula);
            let wrong = source.whole();
            if found.is_none() {
                continue;
            }
            if let Some(d) = wrong {
                self.push(d);
                continue;
            }
            let monitor = if formula.nodes.len() > MAX_NODES {
                None
            } else {
                Monitor::new(&formula, &source.units(), ticks.count).ok()
            };
            let Some(monitor) = monitor else {
                let d = Diagnostic::error("HQ0803", expect.span, "this expectation is too large to be monitored");
                self.push(d.help("shorten its windows, or write it as several"));
                continue;
            };
            kept = kept.saturating_add(monitor.kept());
            if kept > MAX_KEPT {
                let text = "the expectations of this scenario need too much memory together";
                let d = Diagnostic::error("HQ0803", expect.span, text).here("up to here");
                self.push(d.help("shorten their windows, or spread them over several scenarios"));
                break;
            }
            // A formula that is read as a label was reported.
            let inside = |outer: Span| {
                outer.source == expect.formula.span.source && outer.range().contains(&expect.formula.span.range().start)
            };
            if !self.diagnostics.iter().any(|d| d.code == "HQ0138" && inside(d.primary.span)) {
                self.diagnostics.extend(expectation_checks::first_tick(expect));
            }
            if source.is_of_robot() {
                let mut idle = Vec::new();
                self.idle_conditions(&expect.formula, &mut idle);
                self.diagnostics.append(&mut idle);
            }
            let label = expect.label.as_ref().map(|l| l.value.clone());
            all.push(ExpectationProgram { label, text: text.clone(), formula });
        }
        all
    }
}

/// A formula under construction.
struct Builder<'b, 'l> {
    lowerer: &'b mut Lowerer<'l>,
    ticks: Ticks,
    source: &'b mut dyn Source,
    /// First tick at which the part under construction can be judged.
    from: u32,
}

impl Builder<'_, '_> {
    /// Adds a formula and returns its index.
    fn formula(&mut self, f: &Written, out: &mut Formula) -> Option<usize> {
        use FormulaKind as F;
        self.lowerer.expected += 1;
        if out.nodes.len() > MAX_NODES {
            return Some(0);
        }
        let node = match &f.kind {
            F::Missing => return None,
            F::Value(value) => Node::Predicate(self.source.predicate(self.lowerer, value)?),
            F::Not(a) => Node::Not(self.formula(a, out)?),
            F::And(a, b) => {
                let (a, b) = (self.formula(a, out), self.formula(b, out));
                Node::And(vec![a?, b?])
            }
            F::Or(a, b) => {
                let (a, b) = (self.formula(a, out), self.formula(b, out));
                Node::Or(vec![a?, b?])
            }
            F::Implies(a, b) => {
                let (a, b) = (self.formula(a, out), self.formula(b, out));
                Node::Implies([a?, b?])
            }
            F::After(a, b) => {
                let (a, b) = (self.formula(a, out), self.formula(b, out));
                return Some(out.after(a?, b?));
            }
            F::Always(w, a) => {
                let (window, a) = self.inside(w, a, out);
                let window = window?;
                self.undecided_at_the_end(w, window);
                Node::Always(window, a?)
            }
            F::Never(w, a) => {
                let (window, a) = self.inside(w, a, out);
                let window = window?;
                self.undecided_at_the_end(w, window);
                let not = out.add(Node::Not(a?));
                Node::Always(window, not)
            }
            F::Eventually(w, a) => {
                let (w, a) = self.inside(w, a, out);
                match (w?, a?) {
                    (Window { first: 0, last: Some(last) }, a) => {
                        return Some(out.within(last, a, &self.source.units()));
                    }
                    (w, a) => Node::Eventually(w, a),
                }
            }
            F::Until(a, w, b) => {
                let (a, w, b) = (self.formula(a, out), self.window(w), self.formula(b, out));
                Node::Until(w?, [a?, b?])
            }
        };
        Some(out.add(node))
    }

    /// Adds a formula in a window.
    fn inside(&mut self, w: &Times, a: &Written, out: &mut Formula) -> (Option<Window>, Option<usize>) {
        let before = self.from;
        let window = self.window(w);
        if let Some(window) = &window {
            self.from = before.saturating_add(window.first);
            // Reported once, at the window that leads behind the end.
            if before < self.ticks.count && self.from >= self.ticks.count {
                let text = format!("this window begins after the last tick of the run at {} s", self.last_tick());
                let d = Diagnostic::warning("HQ0809", w.span, text);
                self.lowerer.push(d.help("write an earlier time, or a longer `duration`"));
            }
        }
        let a = self.formula(a, out);
        self.from = before;
        (window, a)
    }

    /// Time of the last tick of the run (s), as text.
    fn last_tick(&self) -> String {
        runtime::text::number(f64::from(self.ticks.count.saturating_sub(1)) * self.ticks.period)
    }

    /// Warns of a window in which something must always hold and that ends after the run of a robot: whatever happens, it is
    /// not known at the end that it holds.
    fn undecided_at_the_end(&mut self, w: &Times, window: Window) {
        let (Some(last), Some(end)) = (window.last, &w.to) else { return };
        let begins = self.from.saturating_add(window.first);
        let ends = self.from.saturating_add(last);
        if !self.source.is_of_robot() || begins >= self.ticks.count || ends < self.ticks.count {
            return;
        }
        let (last, at) = (self.last_tick(), runtime::text::number(f64::from(ends) * self.ticks.period));
        let text = format!("this window ends at {at} s, after the last tick of the run at {last} s");
        let d = Diagnostic::warning("HQ0809", end.span, text)
            .label(self.ticks.at, format!("one tick is {} s", runtime::text::number(self.ticks.period)))
            .note("what must hold in the whole window is undecided at the end of the run, and counts as failed")
            .help("leave the end of the window out, which then is that of the run, or write a longer `duration`");
        self.lowerer.push(d);
    }

    fn window(&mut self, w: &Times) -> Option<Window> {
        let mut time = |value: &Option<Value>| match value {
            Some(value) => {
                let mut constants = Constants { graph: &mut self.lowerer.graph, params: &mut self.lowerer.params };
                constants.scalar(value, TIME, self.lowerer.diagnostics).map(Some)
            }
            None => Some(None),
        };
        let (from, to) = (time(&w.from), time(&w.to));
        let (from, to) = (from?.unwrap_or(0.0), to?);
        let wrong = match Window::seconds(from, to, self.ticks.period) {
            Ok(window) => {
                if let Some(end) = w.to.as_ref().filter(|_| window.last == Some(0) && to.is_some_and(|to| to > 0.0)) {
                    self.shorter_than_a_tick(end);
                }
                return Some(window);
            }
            Err(wrong) => wrong,
        };
        let code = if wrong == WindowError::NotATime { "HQ0308" } else { "HQ0802" };
        let help = match wrong {
            WindowError::NotATime => "count from now: write `from 0 s`",
            WindowError::UpsideDown => "write the earlier time first: `from 2 s to 5 s`",
            WindowError::Empty => "make the window longer than a tick",
            WindowError::TooLong => "leave its end out",
        };
        let d = Diagnostic::error(code, w.span, wrong.to_string());
        let tick = format!("one tick is {} s", self.ticks.period);
        self.lowerer.push(d.label(self.ticks.at, tick).help(help));
        None
    }

    /// Warns of a time that is not zero and ends before the next tick, in an expectation on a robot.
    fn shorter_than_a_tick(&mut self, end: &Value) {
        if !self.source.is_of_robot() {
            return;
        }
        let period = runtime::text::number(self.ticks.period);
        let text = format!("the next tick is {period} s later, after this time");
        let d = Diagnostic::warning("HQ0817", end.span, text)
            .label(self.ticks.at, format!("one tick is {period} s"))
            .note("the window contains the present tick alone; what the controller answers shows at the next one")
            .help(format!("write at least {period} s, or `0 s` if the present tick is meant"));
        self.lowerer.push(d);
    }
}
