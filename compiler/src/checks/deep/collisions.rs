//! Links that touch at sampled postures, and that no limit of a stack that runs keeps apart.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet};

use dsl::{Diagnostic, Help, Snippet};
use robot::contacts::{self, LinkPair};
use robot::{Data, LinkId};
use runtime::text::number;
use stdlib_tasks::protection::{Hazard, Protection};

use super::{Checked, Work, share};
use crate::robot_binding::RobotSrdf;
use crate::sampled::Contacts;

/// Share of the postures from which on two links count as touching always: by how their shapes are drawn.
const ALWAYS: f64 = 0.9;

/// Reason in an SRDF for pairs that were not seen to touch.
const NEVER: &str = "Never";

/// Most pairs that are named.
const NAMED: usize = 6;

/// A pair of links, and the number of sampled postures at which they touch.
struct Touching {
    count: usize,
    pair: LinkPair,
}

/// Warns of links that can touch each other and are guarded nowhere, and of those whose SRDF says that they never do. The
/// figures are `None` without shapes.
pub(super) fn check(c: &Checked, work: &Work, out: &mut Vec<Diagnostic>) -> Option<Contacts> {
    let model = &c.program.robot.model;
    if model.links.iter().filter(|l| !l.collision.is_empty()).count() < 2 {
        return None;
    }
    let guarded = guarded(c);
    // Neighbours overlap at their joint by how they are built.
    let pairs: Vec<LinkPair> = contacts::pairs(model).into_iter().filter(|pair| !guarded.contains(pair)).collect();
    let counts = work.share(
        c.program,
        || (vec![0_usize; pairs.len()], Data::new(model)),
        |(counts, data), _, q| {
            model.forward(q, data);
            for (count, pair) in counts.iter_mut().zip(&pairs) {
                *count += usize::from(contacts::touch(model, data, *pair));
            }
        },
    );
    let mut home = Data::new(model);
    model.forward(&c.program.robot.home, &mut home);
    let postures = work.deep.postures;
    let sum = |i: usize| counts.iter().map(|(counts, _)| counts[i]).sum::<usize>();
    let all = (0..pairs.len()).map(|i| Touching { count: sum(i), pair: pairs[i] });
    let mut found: Vec<Touching> = all.filter(|t| t.count > 0).collect();
    found.sort_by_key(|t| Reverse(t.count));
    let by_design = |t: &Touching| t.count as f64 >= ALWAYS * postures as f64 || contacts::touch(model, &home, t.pair);
    let disabled = c.places.srdf.iter().flat_map(|of| of.srdf.disabled_pairs()).collect::<BTreeMap<_, _>>();
    let (without, open): (Vec<Touching>, Vec<Touching>) =
        found.into_iter().partition(|t| disabled.contains_key(&t.pair));
    let sometimes = |t: &&Touching| (t.count as f64) < ALWAYS * postures as f64;
    let is_never = |t: &&Touching| disabled.get(&t.pair).is_some_and(|why| why.eq_ignore_ascii_case(NEVER));
    let never: Vec<&Touching> = without.iter().filter(is_never).filter(sometimes).collect();
    out.extend(never_yet_touching(c, &never, postures));
    let (always, open): (Vec<Touching>, Vec<Touching>) = open.into_iter().partition(by_design);
    out.extend(warning(c, &open, &home, postures));
    let name = |link: LinkId| model.link_ref(link).name.clone();
    let always = always.iter().map(|t| t.pair.map(name)).collect();
    Some(Contacts { unguarded: open.len(), disabled: without.len(), always })
}

/// Pairs that limits of the stacks that run keep apart.
fn guarded(c: &Checked) -> BTreeSet<LinkPair> {
    let mut guarded = BTreeSet::new();
    for stack in c.program.run_stacks() {
        let built = c.stacks.tasks(stack).iter().filter_map(|b| b.task.as_ref().ok());
        for Protection { links, hazard } in built.flat_map(|task| task.protections()) {
            if let Hazard::Link(other) = hazard {
                guarded.extend(links.iter().map(|&l| contacts::pair(l, other)));
            }
        }
    }
    guarded
}

/// The first of some pairs, each with its share of the postures.
fn listed<'t>(c: &Checked, found: impl Iterator<Item = &'t Touching>, postures: usize) -> String {
    let name = |l: LinkId| &c.program.robot.model.link_ref(l).name;
    let one = |Touching { count, pair: [a, b] }: &Touching| {
        format!("`{}` and `{}` ({})", name(*a), name(*b), share(*count, postures))
    };
    found.take(NAMED).map(one).collect::<Vec<_>>().join(", ")
}

/// Warning of pairs that the SRDF disables since they never touch, and that do.
fn never_yet_touching(c: &Checked, found: &[&Touching], postures: usize) -> Option<Diagnostic> {
    let first = found.first()?;
    let disables = |of: &&RobotSrdf| of.srdf.disabled.iter().any(|pair| pair.links == first.pair);
    let of = c.places.srdf.iter().find(disables).or(c.places.srdf.first())?;
    let name = |l: LinkId| &c.program.robot.model.link_ref(l).name;
    let [a, b] = first.pair;
    let text = match found.len() {
        1 => format!("`{}` and `{}` touch, and the SRDF says that they never do", name(a), name(b)),
        n => format!("{n} pairs of links touch, and the SRDF says that they never do"),
    };
    let mut d = Diagnostic::warning("HQ0592", of.span, text);
    if let Some(pair) = of.srdf.disabled.iter().find(|pair| pair.links == first.pair) {
        d = d.label(of.place(&pair.span), format!("the pair of `{}` and `{}`", name(a), name(b)));
    }
    let listed = listed(c, found.iter().copied(), postures);
    let more = found.len().saturating_sub(NAMED);
    let rest = if more > 0 { format!(", and {more} more") } else { String::new() };
    Some(
        d.note(format!("with their share of the sampled postures: {listed}{rest}"))
            .note("nothing keeps a disabled pair apart; a mesh counts as the capsule around it, which is larger")
            .help("take the pairs out of the SRDF, or write another reason if only the capsules touch"),
    )
}

fn warning(c: &Checked, found: &[Touching], home: &Data, postures: usize) -> Option<Diagnostic> {
    let model = &c.program.robot.model;
    let name = |l: LinkId| &model.link_ref(l).name;
    let stack = *c.program.run_stacks().first()?;
    let &Touching { count, pair: [a, b] } = found.first()?;
    let text = match found.len() {
        1 => format!("`{}` and `{}` can touch, and no limit keeps them apart", name(a), name(b)),
        n => format!("{n} pairs of links can touch, and no limit keeps them apart"),
    };
    let mut d = Diagnostic::warning("HQ0591", c.places.stacks[stack].0, text);
    let listed = listed(c, found.iter(), postures);
    d = match found.len() {
        1 => d.note(format!("they touch at {} of the sampled postures", share(count, postures))),
        n if n > NAMED => d.note(format!("most often, of the sampled postures: {listed}, and {} more", n - NAMED)),
        _ => d.note(format!("with their share of the sampled postures: {listed}")),
    };
    // One task for the link that is in most of the pairs.
    let mut of: BTreeMap<LinkId, BTreeSet<LinkId>> = BTreeMap::new();
    for Touching { pair: [a, b], .. } in found {
        of.entry(*a).or_default().insert(*b);
        of.entry(*b).or_default().insert(*a);
    }
    let (one, others) = of.into_iter().max_by_key(|(l, others)| (others.len(), std::cmp::Reverse(*l)))?;
    // A distance that holds at home, or the proposal would be an error.
    let nearest = others.iter().map(|&l| contacts::distance(model, home, [one, l])).fold(f64::INFINITY, f64::min);
    let d_min = number((500.0 * nearest).floor().clamp(1.0, 20.0));
    let others: Vec<&str> = others.into_iter().map(|l| name(l).as_str()).collect();
    Some(d.help(Help::with(
        "keep them apart on a hard level, beginning with {}",
        [Snippet::each(
            format!("self_collision {{ between {}  and [{}]  d_min {d_min} mm }}", name(one), others.join(", ")),
            format!("self_collision: {{ between: {}, and: [{}], d_min: {d_min} mm }}", name(one), others.join(", ")),
        )],
    )))
}
