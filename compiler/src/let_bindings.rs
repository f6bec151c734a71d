//! Named values: params with their ranges, and lets.

use dsl::tree::{Let, Param, Value, ValueKind};
use dsl::{Diagnostic, Span, Spanned};

use crate::expr::constants::{Constants, Params, is_word};
use crate::expr::dimension_check::replaces;
use crate::expr::{Kind, PRESENT, Symbol, Typed};
use crate::forms::target;
use crate::units;

impl Params {
    /// Stores the value of a name, or marks the name as failed.
    pub fn put(&mut self, name: &Spanned<String>, value: Option<Typed>) {
        self.later.remove(&name.value);
        match value {
            Some(value) => {
                self.symbols.insert(name.value.clone(), Symbol { value, declared: name.span });
            }
            None => {
                self.failed.insert(name.value.clone());
            }
        }
    }
}

/// True if a value depends on the robot: on its current or captured state, on axes, or on a name with such a value.
fn of_the_robot(value: &Value, params: &Params) -> bool {
    let here = match &value.kind {
        ValueKind::In(..) => true,
        ValueKind::Call(function, _) => function.value == "initial" || PRESENT.contains(&function.value.as_str()),
        ValueKind::Name(name) => params.later.contains(target(name)),
        _ => false,
    };
    here || value.parts().into_iter().any(|v| of_the_robot(v, params))
}

impl Constants<'_> {
    /// Types a declared parameter; `changed` is a value from the command line that replaces its own. Reports a
    /// parameter without a value, or outside its range.
    pub fn declare(&mut self, param: &Param, changed: Option<&Value>, diagnostics: &mut Vec<Diagnostic>) {
        if self.taken(&param.name, diagnostics) {
            return;
        }
        let value = self.constant(&param.value, diagnostics).and_then(|own| {
            let range = self.range(param, &own, diagnostics)?;
            let good = self.inside(&own, &param.name, &range, diagnostics);
            let Some(changed) = changed else { return good.then_some(own) };
            let new = self.constant(changed, diagnostics)?;
            let wrong = replaces(self.graph, &new, &own, &param.name);
            let fits = wrong.is_none();
            diagnostics.extend(wrong);
            (good && fits && self.inside(&new, &param.name, &range, diagnostics)).then_some(new)
        });
        self.params.put(&param.name, value);
    }

    /// Types a named expression, which may move with time. Returns true, without typing it, if it depends on the robot.
    pub fn declare_let(&mut self, it: &Let, diagnostics: &mut Vec<Diagnostic>) -> bool {
        if self.taken(&it.name, diagnostics) {
            return false;
        }
        if of_the_robot(&it.value, self.params) {
            self.params.later.insert(it.name.value.clone());
            return true;
        }
        let value = self.typed(&it.value, diagnostics);
        self.params.put(&it.name, value);
        false
    }

    /// Reports a reserved name and returns true for it.
    fn taken(&mut self, name: &Spanned<String>, diagnostics: &mut Vec<Diagnostic>) -> bool {
        // A name from another file has the prefix of that file.
        let own = name.value.rsplit('.').next().unwrap_or(&name.value);
        let taken = is_word(own);
        if taken {
            let d = Diagnostic::error("HQ0202", name.span, format!("`{own}` is a word of the language"));
            diagnostics.push(d.help("choose another name"));
            self.params.failed.insert(name.value.clone());
        }
        taken
    }

    /// Bounds of a parameter in SI: for each, true for the lower one, the number and the span. Returns `None` if a
    /// bound is wrong, with diagnostics.
    fn range(
        &mut self,
        param: &Param,
        own: &Typed,
        diagnostics: &mut Vec<Diagnostic>,
    ) -> Option<Vec<(bool, f64, Span)>> {
        let mut bounds = Vec::new();
        for e in &param.range.entries {
            if own.kind != Kind::Scalar {
                let text = format!("`{}` is {}, and only a number has a range", param.name.value, own.kind.describe());
                let d = Diagnostic::error("HQ0304", e.key.span, text).label(param.name.span, "declared here");
                diagnostics.push(d.help("leave the range out"));
                return None;
            }
            let bound = self.constant(&e.value, diagnostics)?;
            if let Some(d) = replaces(self.graph, &bound, own, &param.name) {
                diagnostics.push(d);
                return None;
            }
            bounds.push((e.key.value == "min", self.graph.constant(bound.nodes[0])?, e.value.span));
        }
        if let (Some((_, min, at)), Some((_, max, other))) = (bounds.iter().find(|b| b.0), bounds.iter().find(|b| !b.0))
            && min > max
        {
            let d = Diagnostic::error("HQ0315", *at, format!("nothing lies between {min} and {max}"));
            diagnostics.push(d.here("min").label(*other, "max").help("write the smaller bound after `min`"));
            return None;
        }
        Some(bounds)
    }

    /// Returns true if a value is within the range of its parameter; reports it otherwise, with both spans.
    fn inside(
        &self,
        value: &Typed,
        name: &Spanned<String>,
        range: &[(bool, f64, Span)],
        diagnostics: &mut Vec<Diagnostic>,
    ) -> bool {
        let Some(x) = value.nodes.first().and_then(|&n| self.graph.constant(n)) else { return true };
        let unit = units::written(value.dimension);
        let unit = if unit.is_empty() { unit } else { format!(" {unit}") };
        let outside = range.iter().find(|(min, bound, _)| if *min { x < *bound } else { x > *bound });
        if let Some((min, bound, at)) = outside {
            let (word, side) = if *min { ("below", "least") } else { ("above", "most") };
            let text = format!("`{}` is {x}{unit}, {word} its range", name.value);
            let d = Diagnostic::error("HQ0315", value.span, text).here(format!("at {side} {bound}{unit} is allowed"));
            diagnostics.push(d.label(*at, "the range").help("give a value inside the range, or change the range"));
        }
        outside.is_none()
    }
}
