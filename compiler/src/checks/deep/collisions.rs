//! Links that touch at sampled postures, and that no limit of a stack that runs keeps apart.

use std::collections::{BTreeMap, BTreeSet};

use dsl::{Diagnostic, Help, Snippet};
use robot::geometry::{Degenerate, closest};
use robot::{Data, LinkId, Model, PlacedShape};
use runtime::text::number;
use stdlib_tasks::protection::{Hazard, Protection};

use super::{Checked, Work, share};

/// Share of the postures from which on two links count as touching always: by how their shapes are drawn.
const ALWAYS: f64 = 0.9;

/// Most pairs that are named.
const NAMED: usize = 6;

/// Two links.
type Pair = [LinkId; 2];

/// Warns of links that can touch each other and are guarded nowhere. Returns the number of such pairs; `None` without shapes.
pub(super) fn check(c: &Checked, work: &Work, out: &mut Vec<Diagnostic>) -> Option<usize> {
    let model = &c.program.robot.model;
    let pairs = open_pairs(c);
    if !pairs.is_empty() || model.links.iter().filter(|l| !l.collision.is_empty()).count() > 1 {
        let counts = work.share(
            c.program,
            || (vec![0_usize; pairs.len()], Data::new(model)),
            |(counts, data), _, q| {
                model.forward(q, data);
                for (count, pair) in counts.iter_mut().zip(&pairs) {
                    *count += usize::from(touch(model, data, *pair));
                }
            },
        );
        let mut data = Data::new(model);
        model.forward(&c.program.robot.home, &mut data);
        let postures = work.deep.postures;
        let sum = |i: usize| counts.iter().map(|(counts, _)| counts[i]).sum::<usize>();
        let mut found: Vec<(usize, Pair)> = (0..pairs.len())
            .map(|i| (sum(i), pairs[i]))
            .filter(|(count, pair)| {
                *count > 0 && (*count as f64) < ALWAYS * postures as f64 && !touch(model, &data, *pair)
            })
            .collect();
        found.sort_by_key(|(count, _)| std::cmp::Reverse(*count));
        out.extend(warning(c, &found, &data, postures));
        return Some(found.len());
    }
    None
}

/// Pairs of links with shapes that move against each other, are no neighbours, and that no limit names.
fn open_pairs(c: &Checked) -> Vec<Pair> {
    let model = &c.program.robot.model;
    let guarded = guarded(c);
    let with_shapes: Vec<LinkId> =
        (0..model.links.len() as u32).map(LinkId).filter(|l| !model.link_ref(*l).collision.is_empty()).collect();
    let mut pairs = Vec::new();
    for (k, &a) in with_shapes.iter().enumerate() {
        for &b in &with_shapes[k + 1..] {
            let joints_between = {
                let (of_a, of_b) = (model.support(a), model.support(b));
                of_a.iter().filter(|j| !of_b.contains(j)).count() + of_b.iter().filter(|j| !of_a.contains(j)).count()
            };
            // Neighbours overlap at their joint by how they are built.
            if joints_between > 1 && !guarded.contains(&[a.min(b), a.max(b)]) {
                pairs.push([a, b]);
            }
        }
    }
    pairs
}

/// Pairs that limits of the stacks that run keep apart.
fn guarded(c: &Checked) -> BTreeSet<Pair> {
    let mut guarded = BTreeSet::new();
    for stack in c.program.run_stacks() {
        let built = c.stacks.tasks(stack).iter().filter_map(|b| b.task.as_ref().ok());
        for Protection { links, hazard } in built.flat_map(|task| task.protections()) {
            if let Hazard::Link(other) = hazard {
                guarded.extend(links.iter().map(|&l| [l.min(other), l.max(other)]));
            }
        }
    }
    guarded
}

/// Distance of two links (m), not above zero if they overlap.
fn distance(model: &Model, data: &Data, [a, b]: Pair) -> f64 {
    let (on_a, on_b) = (&model.link_ref(a).collision, &model.link_ref(b).collision);
    let (at_a, at_b) = (data.pose(a), data.pose(b));
    let apart =
        |s: &PlacedShape, t: &PlacedShape| match closest(&s.shape, &(at_a * s.origin), &t.shape, &(at_b * t.origin)) {
            Ok(found) => found.distance,
            Err(Degenerate::Touching) => 0.0,
        };
    on_a.iter().flat_map(|s| on_b.iter().map(move |t| apart(s, t))).fold(f64::INFINITY, f64::min)
}

/// True if two links overlap.
fn touch(model: &Model, data: &Data, pair: Pair) -> bool {
    distance(model, data, pair) <= 0.0
}

fn warning(c: &Checked, found: &[(usize, Pair)], home: &Data, postures: usize) -> Option<Diagnostic> {
    let model = &c.program.robot.model;
    let name = |l: LinkId| &model.link_ref(l).name;
    let stack = *c.program.run_stacks().first()?;
    let (count, [a, b]) = *found.first()?;
    let text = match found.len() {
        1 => format!("`{}` and `{}` can touch, and no limit keeps them apart", name(a), name(b)),
        n => format!("{n} pairs of links can touch, and no limit keeps them apart"),
    };
    let mut d = Diagnostic::warning("HQ0591", c.places.stacks[stack].0, text);
    let listed: Vec<String> = found
        .iter()
        .take(NAMED)
        .map(|(count, [a, b])| format!("`{}` and `{}` ({})", name(*a), name(*b), share(*count, postures)))
        .collect();
    d = match found.len() {
        1 => d.note(format!("they touch at {} of the sampled postures", share(count, postures))),
        n if n > NAMED => {
            d.note(format!("most often, of the sampled postures: {}, and {} more", listed.join(", "), n - NAMED))
        }
        _ => d.note(format!("with their share of the sampled postures: {}", listed.join(", "))),
    };
    // One task for the link that is in most of the pairs.
    let mut of: BTreeMap<LinkId, BTreeSet<LinkId>> = BTreeMap::new();
    for (_, [a, b]) in found {
        of.entry(*a).or_default().insert(*b);
        of.entry(*b).or_default().insert(*a);
    }
    let (one, others) = of.into_iter().max_by_key(|(l, others)| (others.len(), std::cmp::Reverse(*l)))?;
    // A distance that holds at home, or the proposal would be an error.
    let nearest = others.iter().map(|&l| distance(model, home, [one, l])).fold(f64::INFINITY, f64::min);
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
