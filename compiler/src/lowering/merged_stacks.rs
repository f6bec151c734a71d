//! Stacks of regions that run together, for each combination that can occur: their levels merged by name.
//!
//! A level that several stacks have is one level with the tasks of all. The order of the levels is that of each stack; where
//! none decides, hard levels come first, and then those of the region that was written first.

use std::collections::BTreeSet;

use dsl::{Diagnostic, Span};
use runtime::build_tasks;
use runtime::program::{
    BESIDE, EqualTask, LevelProgram, MAX_MERGED, MachineProgram, MemberProgram, MergedStack, PartProgram, Program,
    StackProgram,
};

use super::Lowerer;
use crate::source_map::{MachinePlaces, SourceMap};

/// States of regions whose stacks run together, and the spans of the names of these stacks.
struct Together<'p> {
    program: &'p Program,
    machine: &'p MachineProgram,
    places: &'p MachinePlaces,
    /// Spans of the names of each stack's levels.
    levels: &'p [(Span, Vec<Span>)],
    /// Tasks that remember the configuration at their entry.
    remembering: &'p BTreeSet<usize>,
    /// Number of tasks that have a name of their own; those behind them are written in levels.
    declared: usize,
    owners: Vec<usize>,
}

impl Lowerer<'_> {
    /// Adds the merged stacks of regions to a program.
    pub(super) fn merge_stacks(&mut self, declared: usize, program: &mut Program, source_map: &mut SourceMap) {
        let (Some(machine), Some(places)) = (program.machine.clone(), source_map.machine.clone()) else { return };
        let mut merged: Vec<MergedStack> = Vec::new();
        let remembering = remembering(program, &machine);
        for p in (0..machine.states.len()).filter(|&p| !machine.states[p].regions.is_empty()) {
            let count = machine.count_merged(p);
            if count > MAX_MERGED {
                self.push(too_many(&machine, &places, p, count));
                continue;
            }
            for owners in machine.combinations(p).into_iter().filter(|owners| owners.len() > 1) {
                let parts: Vec<usize> = owners.iter().filter_map(|&s| machine.states[s].stack).collect();
                if merged.iter().any(|m| m.parts == parts) {
                    continue;
                }
                let levels = &source_map.stacks;
                let remembering = &remembering;
                let together = Together {
                    program: &*program,
                    machine: &machine,
                    places: &places,
                    levels,
                    remembering,
                    declared,
                    owners,
                };
                match together.merge() {
                    Ok((stack, spans)) => {
                        merged.push(MergedStack { parts, stack: program.stacks.len() });
                        let at = places.stacks[together.owners[0]].unwrap_or(places.states[together.owners[0]]);
                        program.stacks.push(stack);
                        source_map.stacks.push((at, spans));
                    }
                    Err(d) => {
                        // The other combinations of these states would report the same.
                        self.push(*d);
                        return;
                    }
                }
            }
        }
        let Some(machine) = &mut program.machine else { return };
        machine.merged = merged;
        // A demand on the stack of a region is one on all that it runs in.
        let alone = machine.stacks();
        let with = |stack: usize| {
            let merged: Vec<usize> =
                machine.merged.iter().filter(|m| m.parts.contains(&stack)).map(|m| m.stack).collect();
            let own = Some(stack).filter(|s| merged.is_empty() || alone.contains(s));
            own.into_iter().chain(merged).collect::<Vec<usize>>()
        };
        for of in source_map.coverage.iter_mut().flat_map(|demands| demands.stacks.iter_mut().flatten()) {
            of.stacks = of.stacks.iter().flat_map(|s| with(*s)).collect();
        }
    }
}

/// Tasks in the stacks of regions that remember the configuration at their entry.
fn remembering(program: &Program, machine: &MachineProgram) -> BTreeSet<usize> {
    let in_regions = (0..machine.states.len()).filter(|&s| machine.region(s).is_some());
    let stacks: BTreeSet<usize> = in_regions.filter_map(|s| machine.states[s].stack).collect();
    let of = |stack: &StackProgram| {
        let members = stack.levels.iter().flat_map(|l| &l.members).map(|m| m.task);
        let built = build_tasks(program, stack).into_iter().map(|b| b.task.is_ok_and(|task| task.remembers_entry()));
        members.zip(built).filter(|(_, remembers)| *remembers).map(|(task, _)| task).collect::<Vec<usize>>()
    };
    stacks.into_iter().flat_map(|s| of(&program.stacks[s])).collect()
}

fn too_many(machine: &MachineProgram, places: &MachinePlaces, state: usize, count: usize) -> Diagnostic {
    let name = &machine.states[state].name;
    let text = format!("the stacks of the regions of `{name}` have {count} combinations");
    Diagnostic::error("HQ0731", places.states[state], text)
        .note(format!("a stack is merged for each of them, and at most {MAX_MERGED} are possible"))
        .help("let fewer states name stacks, or let states of a region that move alike share one")
}

/// Orders names such that each list keeps its order; of those that may come next, the first with the least rank comes.
///
/// # Errors
/// Two names that two lists order differently, directly or by others.
pub(super) fn ordered(lists: &[Vec<&str>], rank: impl Fn(&str) -> usize) -> Result<Vec<String>, [String; 2]> {
    let mut out: Vec<String> = Vec::new();
    let mut names: Vec<&str> = Vec::new();
    lists.iter().flatten().for_each(|name| {
        if !names.contains(name) {
            names.push(name);
        }
    });
    while !names.is_empty() {
        let before = |name: &str| {
            let of = lists.iter().filter_map(|list| Some(&list[..list.iter().position(|n| *n == name)?]));
            of.flatten().copied().find(|other| names.contains(other))
        };
        let next = names.iter().copied().filter(|name| before(name).is_none()).min_by_key(|name| rank(name));
        let Some(next) = next else {
            let pair = |a: &&str, b: &&str| {
                let orders = |x: &str, y: &str| {
                    let at = |list: &Vec<&str>, n: &str| list.iter().position(|o| *o == n);
                    lists.iter().any(|list| at(list, x).zip(at(list, y)).is_some_and(|(x, y)| x < y))
                };
                orders(a, b) && orders(b, a)
            };
            let all = names.iter().flat_map(|a| names.iter().map(move |b| (a, b)));
            let found = all.into_iter().find(|(a, b)| a != b && pair(a, b));
            let (a, b) = found.map_or((names[0], names[names.len() - 1]), |(a, b)| (*a, *b));
            return Err([a.to_string(), b.to_string()]);
        };
        out.push(next.to_string());
        names.retain(|name| *name != next);
    }
    Ok(out)
}

impl Together<'_> {
    fn stack(&self, part: usize) -> &StackProgram {
        let index = self.machine.states[self.owners[part]].stack.unwrap_or(0);
        &self.program.stacks[index]
    }

    /// Span of the name of a level of a part.
    fn level_span(&self, part: usize, name: &str) -> Span {
        let index = self.machine.states[self.owners[part]].stack.unwrap_or(0);
        let level = self.program.stacks[index].levels.iter().position(|l| l.name == name);
        level.and_then(|l| self.levels.get(index)?.1.get(l).copied()).unwrap_or(self.span(part))
    }

    /// Span at which the state of a part names its stack.
    fn span(&self, part: usize) -> Span {
        let owner = self.owners[part];
        self.places.stacks[owner].unwrap_or(self.places.states[owner])
    }

    fn state(&self, part: usize) -> &str {
        &self.machine.states[self.owners[part]].name
    }

    /// Diagnostic about the stacks of two parts.
    fn error(&self, [a, b]: [usize; 2], text: String) -> Diagnostic {
        let d =
            Diagnostic::error("HQ0731", self.span(b), text).label(self.span(a), "runs at the same time as this one");
        d.note(format!(
            "while `{}` and `{}` are active, their stacks are one, in which levels of the same name are one level",
            self.state(a),
            self.state(b)
        ))
    }

    /// Merges the stacks; returns the stack with the spans of its levels.
    fn merge(&self) -> Result<(StackProgram, Vec<Span>), Box<Diagnostic>> {
        let parts = 0..self.owners.len();
        let lists: Vec<Vec<&str>> =
            parts.clone().map(|p| self.stack(p).levels.iter().map(|l| l.name.as_str()).collect()).collect();
        let hard = |name: &str| parts.clone().any(|p| self.stack(p).levels.iter().any(|l| l.name == name && l.hard));
        let order = ordered(&lists, |name| usize::from(!hard(name))).map_err(|names| self.contradiction(&names))?;
        let mut equal: Vec<Vec<EqualTask>> = vec![Vec::new(); parts.len()];
        let (mut levels, mut spans): (Vec<LevelProgram>, Vec<Span>) = (Vec::new(), Vec::new());
        for name in &order {
            let mut merged: Option<(usize, LevelProgram)> = None;
            for part in parts.clone() {
                let Some(level) = self.stack(part).levels.iter().find(|l| l.name == *name) else { continue };
                let (first, merged) =
                    merged.get_or_insert_with(|| (part, LevelProgram { members: Vec::new(), ..level.clone() }));
                if (merged.hard, merged.damping, merged.exact) != (level.hard, level.damping, level.exact) {
                    return Err(Box::new(self.other_settings([*first, part], name)));
                }
                for m in &level.members {
                    self.add(merged, m, part, &levels, &mut equal)?;
                }
            }
            let Some((first, level)) = merged else { continue };
            spans.push(self.level_span(first, name));
            levels.push(level);
        }
        let all_lock = |dof: &usize| parts.clone().all(|p| self.stack(p).locked.contains(dof));
        let stack = StackProgram {
            name: parts.clone().map(|p| self.state(p)).collect::<Vec<_>>().join(BESIDE),
            locked: self.stack(0).locked.iter().copied().filter(all_lock).collect(),
            levels,
            parts: equal.into_iter().map(|equal| PartProgram { equal }).collect(),
        };
        Ok((stack, spans))
    }

    /// Adds a member of a part to a merged level.
    fn add(
        &self,
        level: &mut LevelProgram,
        m: &MemberProgram,
        part: usize,
        above: &[LevelProgram],
        equal: &mut [Vec<EqualTask>],
    ) -> Result<(), Box<Diagnostic>> {
        let name = &self.program.tasks[m.task].name;
        let other = |l: &&LevelProgram| l.members.iter().any(|o| o.task == m.task);
        if let Some(other) = above.iter().find(other) {
            let first = other.members.iter().find(|o| o.task == m.task).map_or(0, |o| o.parts[0]);
            let text =
                format!("task `{name}` is on level `{}` in one region and on `{}` in another", other.name, level.name);
            return Err(Box::new(
                self.error([first, part], text)
                    .help("put it on the same level in both stacks, or declare a second task"),
            ));
        }
        let shared = level.members.iter_mut().find(|o| {
            let same = || self.program.same_task(o.task, m.task) && o.weight == m.weight;
            o.task == m.task || (m.task >= self.declared && same() && !self.depends_on_entry(m.task))
        });
        let Some(shared) = shared else {
            level.members.push(MemberProgram { parts: vec![part], idle: Vec::new(), ..m.clone() });
            return Ok(());
        };
        let parts = [shared.parts[0], part];
        if shared.weight != m.weight {
            let text =
                format!("task `{name}` has the weight {} in one region and {} in another", shared.weight, m.weight);
            return Err(Box::new(self.error(parts, text).help("give it one weight, or declare a second task")));
        }
        if shared.task == m.task && self.depends_on_entry(m.task) {
            let text = format!("task `{name}` runs in two regions, and depends on the time or the place of its entry");
            return Err(Box::new(
                self.error(parts, text).help("declare a second task for one of them, with a clock of its own"),
            ));
        }
        if shared.task != m.task {
            equal[part].push(EqualTask { task: m.task, member: shared.task });
        }
        shared.parts.push(part);
        Ok(())
    }

    /// True if a task reads a clock, captured values, or remembers its entry.
    fn depends_on_entry(&self, task: usize) -> bool {
        self.program.depends_on_entry(task) || self.remembering.contains(&task)
    }

    fn contradiction(&self, [a, b]: &[String; 2]) -> Box<Diagnostic> {
        let at = |part: usize, name: &str| self.stack(part).levels.iter().position(|l| l.name == *name);
        let has = |part: &usize, x: &str, y: &str| at(*part, x).zip(at(*part, y)).is_some_and(|(x, y)| x < y);
        let mut parts = 0..self.owners.len();
        let (first, second) = (parts.clone().find(|p| has(p, a, b)), parts.find(|p| has(p, b, a)));
        let (first, second) = (first.unwrap_or(0), second.unwrap_or(self.owners.len() - 1));
        let pair = [first.min(second), first.max(second)];
        let d = self.error(pair, format!("the stacks of two regions order the levels `{a}` and `{b}` differently"));
        Box::new(
            d.label(self.level_span(first, a), format!("`{a}` is above `{b}` here"))
                .label(self.level_span(second, b), format!("`{b}` is above `{a}` here"))
                .help("give the levels one order in both stacks, or other names"),
        )
    }

    fn other_settings(&self, parts: [usize; 2], name: &str) -> Diagnostic {
        let [a, b] = parts.map(|p| self.stack(p).levels.iter().find(|l| l.name == name).is_some_and(|l| l.hard));
        let words = |hard: bool| if hard { "hard" } else { "soft" };
        let text = match a == b {
            true => format!("level `{name}` has another damping in the stack of another region"),
            false => format!("level `{name}` is {} here, and {} in the stack of another region", words(b), words(a)),
        };
        let d = self.error(parts, text).label(self.level_span(parts[0], name), "this level");
        d.label(self.level_span(parts[1], name), "and this one").help("give both the same settings, or other names")
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::ordered;

    const NAMES: [&str; 5] = ["a", "b", "c", "d", "e"];

    /// All orders of some names.
    fn permutations(names: &[&'static str]) -> Vec<Vec<&'static str>> {
        let [] = names else {
            let one = |i: usize| {
                let rest: Vec<&str> = names.iter().enumerate().filter(|(k, _)| *k != i).map(|(_, n)| *n).collect();
                permutations(&rest).into_iter().map(move |p| [vec![names[i]], p].concat())
            };
            return (0..names.len()).flat_map(one).collect();
        };
        vec![Vec::new()]
    }

    fn keeps(order: &[&str], list: &[&str]) -> bool {
        let at: Vec<Option<usize>> = list.iter().map(|n| order.iter().position(|o| o == n)).collect();
        at.iter().all(Option::is_some) && at.windows(2).all(|w| w[0] < w[1])
    }

    proptest! {
        #[test]
        fn orders_are_those_of_all_lists(lists in prop::collection::vec(
            Just(NAMES.to_vec()).prop_shuffle().prop_flat_map(|all| (0..=4_usize).prop_map(move |n| all[..n].to_vec())),
            1..4,
        ), ranks in prop::array::uniform5(0..2_usize)) {
            let mut names: Vec<&'static str> = Vec::new();
            lists.iter().flatten().for_each(|n| if !names.contains(n) { names.push(n) });
            let rank = |name: &str| ranks[NAMES.iter().position(|n| *n == name).expect("one of them")];
            let possible: Vec<Vec<&str>> =
                permutations(&names).into_iter().filter(|p| lists.iter().all(|l| keeps(p, l))).collect();
            match ordered(&lists, rank) {
                Ok(found) => {
                    let key = |p: &[&str]| -> Vec<(usize, usize)> {
                        p.iter().map(|n| (rank(n), names.iter().position(|o| o == n).expect("one"))).collect()
                    };
                    let best = possible.iter().min_by_key(|p| key(p)).expect("there is one");
                    prop_assert_eq!(&found, best);
                }
                Err(_) => prop_assert!(possible.is_empty()),
            }
        }
    }
}
