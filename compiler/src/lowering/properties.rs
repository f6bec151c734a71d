//! Properties of a machine, `check always FORMULA`: formulas without time over states, signals and variables, which hold
//! at every tick.

use std::collections::BTreeSet;

use dsl::Diagnostic;
use dsl::tree::{Expect, Formula, FormulaKind, Machine, StateBody, Value};
use runtime::program::{Measure, Program};

use super::Lowerer;
use super::expectation_scope::Watch;
use super::predicates::measure;
use super::shapes::{Shape, shapes};
use crate::binding::{Known, TaskScope};
use crate::expr::{Kind, Lowering};
use crate::robot_binding::BoundRobot;
use crate::source_map::{MachinePlaces, Property, PropertyPlace};

/// Adds the bodies of the machine and its states, in the order of the states of the program.
fn bodies<'m>(body: &'m StateBody, out: &mut Vec<&'m StateBody>) {
    out.push(body);
    body.states.iter().for_each(|s| bodies(&s.body, out));
}

impl Lowerer<'_> {
    /// Lowers the properties of a machine.
    pub(super) fn properties(
        &mut self,
        machine: &Machine,
        program: &Program,
        robot: &BoundRobot,
        places: &mut MachinePlaces,
    ) {
        let mut all = Vec::new();
        bodies(&machine.body, &mut all);
        if all.iter().all(|b| b.properties.is_empty()) {
            return;
        }
        let shapes = shapes(program);
        for (state, body) in all.into_iter().enumerate() {
            for written in &body.properties {
                let known = (program, robot, shapes.as_slice());
                let Some(formula) = self.always(written, known, &mut places.measures) else { continue };
                let text = || format!("`{}`", dsl::formula_text(&written.formula));
                let name = written.label.as_ref().map_or_else(text, |l| format!("\"{}\"", l.value));
                places.properties.push(PropertyPlace { name, span: written.formula.span, state, formula });
            }
        }
    }

    /// The formula below `always`, or below `never`, negated; one without either holds always. `None` if a part of it is wrong, with diagnostics.
    fn always(
        &mut self,
        written: &Expect,
        known: (&Program, &BoundRobot, &[Option<Shape>]),
        measures: &mut Vec<Measure>,
    ) -> Option<Result<Property, dsl::Span>> {
        let whole = |w: &dsl::tree::Window| w.from.is_none() && w.to.is_none();
        match &written.formula.kind {
            FormulaKind::Missing => None,
            FormulaKind::Always(w, a) if whole(w) => self.property(a, known, measures),
            FormulaKind::Never(w, a) if whole(w) => {
                let found = self.property(a, known, measures)?;
                Some(found.map(|p| Property::Not(Box::new(p))))
            }
            _ => self.property(&written.formula, known, measures),
        }
    }

    fn property(
        &mut self,
        f: &Formula,
        known: (&Program, &BoundRobot, &[Option<Shape>]),
        measures: &mut Vec<Measure>,
    ) -> Option<Result<Property, dsl::Span>> {
        use FormulaKind as F;
        let not = |p: Property| Property::Not(Box::new(p));
        let mut both = |a: &Formula, b: &Formula| {
            let (a, b) = (self.property(a, known, measures), self.property(b, known, measures));
            let (a, b) = (a?, b?);
            Some(a.and_then(|a| Ok(Box::new([a, b?]))))
        };
        match &f.kind {
            F::Missing => None,
            F::Value(value) => self.truth(value, known, measures).map(|node| Ok(Property::Value(node))),
            F::Not(a) => Some(self.property(a, known, measures)?.map(not)),
            F::And(a, b) => Some(both(a, b)?.map(Property::And)),
            F::Or(a, b) => Some(both(a, b)?.map(Property::Or)),
            F::Implies(a, b) => Some(both(a, b)?.map(|pair| {
                let [a, b] = *pair;
                Property::Or(Box::new([not(a), b]))
            })),
            F::Always(..) | F::Eventually(..) | F::Never(..) | F::Until(..) | F::After(..) => Some(Err(f.span)),
        }
    }

    /// Node of a truth value.
    fn truth(
        &mut self,
        value: &Value,
        (program, robot, shapes): (&Program, &BoundRobot, &[Option<Shape>]),
        measures: &mut Vec<Measure>,
    ) -> Option<usize> {
        let Lowerer { graph, table, params, diagnostics, used_tasks, .. } = self;
        let fault = measure(graph, program.interface.width(), measures, Measure::Fault(None));
        let (forms, axes) = (Default::default(), Default::default());
        let (mut named, mut mixed, mut used) = (BTreeSet::new(), BTreeSet::new(), Vec::new());
        let mut scope = Watch {
            inner: TaskScope::free(robot, params, table, Known { forms: &forms, axes: &axes }),
            program,
            shapes,
            measures,
            mixed: &mut mixed,
            fault,
            named: &mut named,
            used: &mut used,
            capturing: false,
        };
        let typed = Lowering { graph, scope: &mut scope, diagnostics }.value(value).ok()?;
        used_tasks.extend(named.iter().map(|&t| program.tasks[t].name.clone()));
        if typed.kind != Kind::Truth {
            let is = typed.kind.describe();
            let d = Diagnostic::error("HQ0304", value.span, format!("a property is true or false, and this is {is}"));
            diagnostics.push(d.here(is).help("compare it with something: `distance > 0.5 m`"));
            return None;
        }
        typed.nodes.first().copied()
    }
}
