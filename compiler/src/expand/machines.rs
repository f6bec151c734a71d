//! Copies signals, named blocks and machines, and adds the stacks that states name.

use dsl::Spanned;
use dsl::tree::{
    Action, Call, ItemKind, Machine, NamedBlock, Signal, Stack, State, StateBody, Transition, Trigger, Variable,
};

use super::substitute::Frame;
use super::{Class, Expander};

impl Expander<'_> {
    /// Copies a signal and fills its holes.
    pub(super) fn copied_signal(&mut self, s: &Signal, frame: &mut Frame) -> Signal {
        Signal {
            name: self.name(&s.name, frame),
            ty: self.name(&s.ty, frame),
            optional: s.optional.map(|at| self.at(at, frame)),
            settings: self.block(&s.settings, frame),
        }
    }

    /// Copies a human, a safety field or an obstacle and fills its holes.
    pub(super) fn copied_block(&mut self, b: &NamedBlock, frame: &mut Frame) -> NamedBlock {
        NamedBlock { kind: b.kind, name: self.name(&b.name, frame), body: self.block(&b.body, frame) }
    }

    /// Copies a variable and fills its holes.
    pub(super) fn copied_variable(&mut self, v: &Variable, frame: &mut Frame) -> Variable {
        Variable {
            name: self.name(&v.name, frame),
            ty: self.name(&v.ty, frame),
            optional: v.optional.map(|at| self.at(at, frame)),
            value: v.value.as_ref().map(|value| self.value(value, frame)),
        }
    }

    /// Copies a machine and fills its holes.
    pub(super) fn copied_machine(&mut self, m: &Machine, frame: &mut Frame) -> Machine {
        Machine { name: self.name(&m.name, frame), body: self.states_body(&m.body, frame) }
    }

    fn states_body(&mut self, b: &StateBody, frame: &mut Frame) -> StateBody {
        StateBody {
            stack: b.stack.as_ref().map(|c| self.call(c, frame)),
            stack_comments: Default::default(),
            settings: self.block(&b.settings, frame),
            actions: b.actions.iter().map(|a| self.action(a, frame)).collect(),
            transitions: b.transitions.iter().map(|t| self.transition(t, frame)).collect(),
            properties: b.properties.iter().map(|p| self.expect(p, frame)).collect(),
            states: b.states.iter().map(|s| self.state(s, frame)).collect(),
            closing_comments: Default::default(),
        }
    }

    fn state(&mut self, s: &State, frame: &mut Frame) -> State {
        State {
            name: self.name(&s.name, frame),
            region: s.region,
            final_: s.final_.map(|at| self.at(at, frame)),
            body: self.states_body(&s.body, frame),
            span: self.at(s.span, frame),
            comments: Default::default(),
        }
    }

    /// Copies a call and its arguments.
    pub(super) fn call(&mut self, c: &Call, frame: &mut Frame) -> Call {
        Call {
            name: self.name(&c.name, frame),
            args: c.args.iter().map(|a| self.value(a, frame)).collect(),
            named: self.entries(&c.named, frame),
            span: self.at(c.span, frame),
        }
    }

    fn action(&mut self, a: &Action, frame: &mut Frame) -> Action {
        Action {
            moment: Spanned::new(a.moment.value, self.at(a.moment.span, frame)),
            verb: self.name(&a.verb, frame),
            args: a.args.iter().map(|v| self.value(v, frame)).collect(),
            named: self.entries(&a.named, frame),
            bare: a.bare,
            span: self.at(a.span, frame),
            comments: Default::default(),
        }
    }

    fn transition(&mut self, t: &Transition, frame: &mut Frame) -> Transition {
        let trigger = match &t.trigger {
            Trigger::On(value) => Trigger::On(self.value(value, frame)),
            Trigger::When { condition, hold } => Trigger::When {
                condition: self.value(condition, frame),
                hold: hold.as_ref().map(|h| self.value(h, frame)),
            },
            Trigger::After(value) => Trigger::After(self.value(value, frame)),
            Trigger::Missing => Trigger::Missing,
        };
        Transition {
            trigger,
            target: self.name(&t.target, frame),
            settings: self.block(&t.settings, frame),
            span: self.at(t.span, frame),
            comments: Default::default(),
        }
    }

    /// Adds a machine to the program, with the stacks and tasks that it names.
    pub(super) fn emit_machine(&mut self, (m, i): (usize, usize)) {
        let ItemKind::Machine(machine) = self.modules[m].items[i].kind.clone() else { return };
        let frame = &mut Frame::of(m);
        let mut copy = self.copied_machine(&machine, frame);
        copy.name.value = self.program_name(m, Class::Machine, &copy.name.value);
        self.stacks_of(&mut copy.body, "", m);
        self.triggers_of(&mut copy.body, None, &[], m);
        self.out.machines.push(copy);
    }

    /// Replaces the stack that each state names by the stack of the program.
    fn stacks_of(&mut self, body: &mut StateBody, path: &str, m: usize) {
        if let Some(call) = body.stack.take() {
            body.stack = self.stack_of(&call, path, m);
        }
        for state in &mut body.states {
            let name = &state.name.value;
            let inner = if path.is_empty() { name.clone() } else { format!("{path}.{name}") };
            self.stacks_of(&mut state.body, &inner, m);
        }
    }

    /// Stack of the program that a state names; a stack with parameters is instantiated for the state.
    fn stack_of(&mut self, call: &Call, path: &str, m: usize) -> Option<Call> {
        let (bm, bi) = match self.find(m, Class::Stack, &call.name.value) {
            Ok(found) => found,
            Err(failed) => {
                self.unknown(m, Class::Stack, &call.name, failed);
                return None;
            }
        };
        let ItemKind::Stack(stack) = self.modules[bm].items[bi].kind.clone() else { return None };
        let plain = |name: String| Call {
            name: Spanned::new(name, call.name.span),
            args: Vec::new(),
            named: Vec::new(),
            span: call.span,
        };
        if stack.parameters.is_empty() && call.args.is_empty() && call.named.is_empty() {
            self.emit_stack((bm, bi), &stack);
            return Some(plain(self.program_name(bm, Class::Stack, &stack.name.value)));
        }
        let name = Spanned::new(format!("{path}.{}", call.name.value), call.name.span);
        let made = Stack {
            name: name.clone(),
            parameters: Vec::new(),
            base: Some(call.clone()),
            settings: Default::default(),
            levels: Vec::new(),
            changes: Vec::new(),
        };
        let expanded = self.expanded_stack(m, &made, &mut Frame::of(m))?;
        self.out.stacks.push(Stack { name: name.clone(), ..expanded });
        Some(plain(name.value))
    }
}
