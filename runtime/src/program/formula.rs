//! Formulas as plain data: a list of nodes, operands before users; the last node is the formula.

use serde::{Deserialize, Serialize};
use stdlib_tasks::dimension::{Dimension, TIME};

use super::window::Window;
use super::{ProgramError, error};

/// Largest number of nodes of a formula.
pub const MAX_NODES: usize = 1000;

/// Unit of the number of a signal, or of the robustness of a formula.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Unit {
    /// A truth value: plus or minus infinity.
    Truth,
    /// A quantity in the SI unit of this dimension.
    Quantity(Dimension),
    /// Quantities of several dimensions were compared: only the sign is meaningful.
    Mixed,
}

impl Unit {
    /// Unit of a value that is chosen from both. Truth values are infinite and do not affect it.
    pub fn join(self, other: Unit) -> Unit {
        match (self, other) {
            (Unit::Truth, u) | (u, Unit::Truth) => u,
            (a, b) if a == b => a,
            _ => Unit::Mixed,
        }
    }
}

/// One operation; operands are indices of earlier nodes.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Node {
    /// A signal, by its index in a tick's numbers: true if it is zero or more, with the number as its robustness.
    Predicate(usize),
    /// The negation.
    Not(usize),
    /// All of them.
    And(Vec<usize>),
    /// At least one of them.
    Or(Vec<usize>),
    /// The second holds if the first does.
    Implies([usize; 2]),
    /// It holds now and did not at the previous tick; at the first tick, it holds. Only its truth value counts, so that
    /// a trigger contributes no number to a formula.
    Rise(usize),
    /// At every tick of the window.
    Always(Window, usize),
    /// At some tick of the window.
    Eventually(Window, usize),
    /// The second holds at some tick of the window, and the first at all ticks from now to before that one.
    Until(Window, [usize; 2]),
    /// At some tick from now to this many later, as `Eventually`, but with a robustness in s: the deadline minus the
    /// instant at which the operand first holds, negative if that is late. Only the truth value of the operand counts.
    Within(u32, usize),
}

impl Node {
    /// Its operands.
    pub fn operands(&self) -> &[usize] {
        match self {
            Node::Predicate(_) => &[],
            Node::And(list) | Node::Or(list) => list,
            Node::Not(a) | Node::Rise(a) | Node::Always(_, a) | Node::Eventually(_, a) | Node::Within(_, a) => {
                std::slice::from_ref(a)
            }
            Node::Implies(pair) | Node::Until(_, pair) => pair,
        }
    }
}

/// A formula over the signals of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Formula {
    /// Operations, operands before users; the last one is the formula, each other one is used once.
    pub nodes: Vec<Node>,
    /// Time from a tick to the next, in s.
    pub period: f64,
}

impl Formula {
    /// Creates an empty list of operations, to which a formula is added.
    pub fn new(period: f64) -> Formula {
        Formula { nodes: Vec::new(), period }
    }

    /// Adds an operation and returns its index.
    pub fn add(&mut self, node: Node) -> usize {
        self.nodes.push(node);
        self.nodes.len() - 1
    }

    /// Adds `after trigger : then`: at every tick at which the trigger becomes true, or is true at the start, `then`
    /// holds from there. It is `always (rise trigger implies then)`.
    pub fn after(&mut self, trigger: usize, then: usize) -> usize {
        let rise = self.add(Node::Rise(trigger));
        let implied = self.add(Node::Implies([rise, then]));
        self.add(Node::Always(Window::ALWAYS, implied))
    }

    /// Adds `within ticks : of`. The robustness is in s if the operand has only truth values, otherwise in the unit of
    /// the operand. `signals` are the units of a tick's numbers.
    pub fn within(&mut self, ticks: u32, of: usize, signals: &[Unit]) -> usize {
        match self.units(signals).get(of) {
            Some(Unit::Truth) => self.add(Node::Within(ticks, of)),
            _ => self.add(Node::Eventually(Window { first: 0, last: Some(ticks) }, of)),
        }
    }

    /// For a requirement on certain ticks only, `always (a implies b)` or `a implies b`: the formula that `a` holds at one of
    /// the ticks at which it is evaluated. If that fails, the requirement holds although nothing was ever required.
    pub fn antecedent(&self) -> Option<Formula> {
        let (window, inner) = match self.nodes.last()? {
            Node::Always(window, inner) => (*window, *inner),
            _ => (Window { first: 0, last: Some(0) }, self.nodes.len() - 1),
        };
        let Node::Implies([condition, _]) = self.nodes.get(inner)? else { return None };
        let mut out = Formula::new(self.period);
        let top = self.copy_into(*condition, &mut out)?;
        out.add(Node::Eventually(window, top));
        Some(out)
    }

    /// Copies an operation with its operands; returns its index in `out`.
    fn copy_into(&self, node: usize, out: &mut Formula) -> Option<usize> {
        let mut copy = |a: usize| self.copy_into(a, out);
        let node = match self.nodes.get(node)? {
            Node::Predicate(k) => Node::Predicate(*k),
            Node::Not(a) => Node::Not(copy(*a)?),
            Node::Rise(a) => Node::Rise(copy(*a)?),
            Node::And(list) => Node::And(list.iter().map(|a| copy(*a)).collect::<Option<_>>()?),
            Node::Or(list) => Node::Or(list.iter().map(|a| copy(*a)).collect::<Option<_>>()?),
            Node::Implies([a, b]) => Node::Implies([copy(*a)?, copy(*b)?]),
            Node::Until(w, [a, b]) => Node::Until(*w, [copy(*a)?, copy(*b)?]),
            Node::Always(w, a) => Node::Always(*w, copy(*a)?),
            Node::Eventually(w, a) => Node::Eventually(*w, copy(*a)?),
            Node::Within(n, a) => Node::Within(*n, copy(*a)?),
        };
        Some(out.add(node))
    }

    /// Unit of its robustness. `signals` are the units of a tick's numbers.
    pub fn unit(&self, signals: &[Unit]) -> Unit {
        self.units(signals).last().copied().unwrap_or(Unit::Truth)
    }

    fn units(&self, signals: &[Unit]) -> Vec<Unit> {
        let mut units: Vec<Unit> = Vec::with_capacity(self.nodes.len());
        for node in &self.nodes {
            let unit = match node {
                Node::Predicate(k) => signals.get(*k).copied().unwrap_or(Unit::Truth),
                Node::Rise(_) => Unit::Truth,
                Node::Within(..) => Unit::Quantity(TIME),
                _ => node.operands().iter().filter_map(|&a| units.get(a)).fold(Unit::Truth, |u, v| u.join(*v)),
            };
            units.push(unit);
        }
        units
    }

    /// Signals that it reads, sorted and without duplicates.
    pub fn signals(&self) -> Vec<usize> {
        let read = self.nodes.iter().filter_map(|n| if let Node::Predicate(k) = n { Some(*k) } else { None });
        let mut list: Vec<usize> = read.collect();
        list.sort_unstable();
        list.dedup();
        list
    }

    /// Checks all indices and windows, so that an evaluation never reads outside the formula. `signals` is the number
    /// of numbers in a tick.
    ///
    /// # Errors
    /// The first operation that cannot be evaluated.
    pub fn check(&self, signals: usize) -> Result<(), ProgramError> {
        if !(self.period.is_finite() && self.period > 0.0) {
            return Err(error("period", "not a positive time"));
        }
        if self.nodes.is_empty() || self.nodes.len() > MAX_NODES {
            return Err(error("nodes", format!("a formula has between 1 and {MAX_NODES} operations")));
        }
        let mut used = vec![false; self.nodes.len()];
        for (i, node) in self.nodes.iter().enumerate() {
            let wrong = |message: &str| Err(error(format!("nodes[{i}]"), message));
            for &a in node.operands() {
                match used.get_mut(a) {
                    Some(used) if a < i && !*used => *used = true,
                    Some(_) if a < i => return wrong("reads an operation that another one reads too"),
                    _ => return wrong("reads an operation that comes later"),
                }
            }
            match node {
                Node::Predicate(k) if *k >= signals => return wrong("reads a signal that does not exist"),
                Node::And(list) | Node::Or(list) if list.is_empty() => return wrong("joins nothing"),
                Node::Always(w, _) | Node::Eventually(w, _) | Node::Until(w, _)
                    if w.last.is_some_and(|l| l < w.first) =>
                {
                    return wrong("a window ends before it begins");
                }
                _ => {}
            }
        }
        match used.iter().position(|u| !u) {
            Some(i) if i + 1 < self.nodes.len() => Err(error(format!("nodes[{i}]"), "nothing reads this operation")),
            _ => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use stdlib_tasks::dimension::{ANGLE, LENGTH, TIME};

    use super::super::Window;
    use super::{Formula, Node, Unit};

    fn formula(nodes: Vec<Node>) -> Formula {
        Formula { nodes, period: 0.01 }
    }

    #[test]
    fn units_follow_the_numbers() {
        let signals = [Unit::Truth, Unit::Quantity(LENGTH), Unit::Quantity(ANGLE)];
        let p = Node::Predicate;
        let unit = |nodes| formula(nodes).unit(&signals);
        assert_eq!(unit(vec![p(0)]), Unit::Truth);
        assert_eq!(unit(vec![p(0), p(1), Node::Implies([0, 1])]), Unit::Quantity(LENGTH));
        assert_eq!(unit(vec![p(2), p(1), Node::And(vec![0, 1])]), Unit::Mixed);
        assert_eq!(unit(vec![p(2), Node::Rise(0), p(1), Node::Implies([1, 2])]), Unit::Quantity(LENGTH));
        let mut f = Formula::new(0.01);
        let ask = f.add(p(0));
        let grasp = f.add(p(0));
        let soon = f.within(2500, grasp, &signals);
        f.after(ask, soon);
        assert_eq!(f.check(3), Ok(()));
        assert_eq!(f.unit(&signals), Unit::Quantity(TIME));
        assert_eq!(f.signals(), [0]);
        let near = f.add(p(1));
        f.within(2500, near, &signals);
        assert_eq!(f.nodes.last(), Some(&Node::Eventually(Window { first: 0, last: Some(2500) }, near)));
    }

    #[test]
    fn broken_formulas_are_refused() {
        let p = Node::Predicate;
        let upside_down = Window { first: 3, last: Some(2) };
        for (nodes, reason) in [
            (vec![], "nodes: a formula has between 1 and 1000 operations"),
            (vec![p(1)], "nodes[0]: reads a signal that does not exist"),
            (vec![Node::Not(0)], "nodes[0]: reads an operation that comes later"),
            (vec![p(0), Node::Not(7)], "nodes[1]: reads an operation that comes later"),
            (vec![p(0), Node::Implies([0, 0])], "nodes[1]: reads an operation that another one reads too"),
            (vec![p(0), Node::And(vec![])], "nodes[1]: joins nothing"),
            (vec![p(0), p(0), Node::Not(1)], "nodes[0]: nothing reads this operation"),
            (vec![p(0), Node::Always(upside_down, 0)], "nodes[1]: a window ends before it begins"),
        ] {
            assert_eq!(formula(nodes).check(1).map_err(|e| e.to_string()), Err(reason.to_string()));
        }
        let mut f = formula(vec![p(0)]);
        f.period = f64::NAN;
        assert!(f.check(1).is_err());
    }

    #[test]
    fn the_antecedent_is_that_of_the_outermost_implication() {
        let p = Node::Predicate;
        let once = |window, nodes: Vec<Node>| {
            let mut f = formula(nodes);
            f.add(Node::Eventually(window, f.nodes.len() - 1));
            Some(f)
        };
        let now = Window { first: 0, last: Some(0) };
        let late = Window { first: 5, last: None };
        for (nodes, antecedent) in [
            (vec![p(0), Node::Always(Window::ALWAYS, 0)], None),
            (vec![p(0), p(1), Node::Implies([0, 1])], once(now, vec![p(0)])),
            (
                vec![p(2), p(1), p(0), Node::And(vec![1, 2]), Node::Implies([3, 0]), Node::Always(late, 4)],
                once(late, vec![p(1), p(0), Node::And(vec![0, 1])]),
            ),
        ] {
            let found = formula(nodes).antecedent();
            assert_eq!(found, antecedent);
            assert!(found.is_none_or(|f| f.check(3).is_ok()));
        }
        let mut f = Formula::new(0.01);
        let (a, b) = (f.add(p(0)), f.add(p(1)));
        f.after(a, b);
        assert_eq!(f.antecedent(), once(Window::ALWAYS, vec![p(0), Node::Rise(0)]));
    }

    #[test]
    fn a_formula_reads_well_in_a_file() {
        let f = formula(vec![
            Node::Predicate(0),
            Node::Predicate(1),
            Node::Until(Window { first: 0, last: Some(20) }, [0, 1]),
            Node::Always(Window::ALWAYS, 2),
        ]);
        let text = serde_json::to_string(&f).unwrap();
        assert_eq!(
            text,
            "{\"nodes\":[{\"predicate\":0},{\"predicate\":1},{\"until\":[{\"first\":0,\"last\":20},[0,1]]},\
             {\"always\":[{\"first\":0,\"last\":null},2]}],\"period\":0.01}"
        );
        assert_eq!(serde_json::from_str::<Formula>(&text).unwrap(), f);
    }
}
