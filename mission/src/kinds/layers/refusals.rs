//! Errors for a mission of layers that cannot be planned, at the texts that they are about.

use blocks::{Bound, Help, Origin, Snippet};
use names::suggest;

use super::check::{Declaration, Item, Key, Mistake};
use super::problem::Problem;
use super::reason::Reason;
use crate::declare::{DeclaredMission, Origins, Remark, Remarks};

/// Number of other tasks of a mistake that are shown.
const MOST_LABELS: usize = 4;

/// Adds the mistakes of a problem, apart from those that follow from reported ones. If the mission `waits` for its layers,
/// it may have no task.
pub(super) fn add(m: &DeclaredMission, problem: &Problem, places: &Origins<Item>, waits: bool, remarks: &mut Remarks) {
    for mistake in problem.check() {
        if waits && mistake.reason == Reason::NoTask {
            continue;
        }
        let known = |of: Declaration| places.is_wrong(of.item, of.key.map_or(&[], Key::names));
        if known(mistake.at) || mistake.against.is_some_and(known) || (is_of_all(&mistake.reason) && places.any_wrong())
        {
            continue;
        }
        remarks.push(refusal(m, problem, &mistake, places));
    }
}

/// Place of a declaration; if its key is not written, of its entry.
fn at_of(places: &Origins<Item>, of: Declaration) -> Origin {
    places.of(of.item, of.key.map_or(&[], Key::names))
}

/// Place at which a task asks for a feature.
fn feature(places: &Origins<Item>, task: Item, word: &str) -> Option<Origin> {
    let words = places.block(task)?.items("features");
    words.iter().find(|item| matches!(&item.value, Bound::Text(text) if text == word)).map(|item| item.at)
}

/// True for a reason about the whole, which is unknown if a part is wrong.
fn is_of_all(reason: &Reason) -> bool {
    use Reason::{EmptyLayer, LacksFeature, NoAgent, NoObject, NoTask, NoTime, Nobody, NobodyHasSkill, TooFewObjects};
    matches!(
        reason,
        NoAgent
            | NoTask
            | EmptyLayer
            | NoTime
            | NobodyHasSkill { .. }
            | Nobody { .. }
            | NoObject { .. }
            | LacksFeature { .. }
            | TooFewObjects { .. }
    )
}

/// The error for a mistake.
fn refusal(m: &DeclaredMission, problem: &Problem, mistake: &Mistake, places: &Origins<Item>) -> Remark {
    let at = at_of(places, mistake.at);
    let (what, fix) = mistake.describe(problem);
    let name = &m.name;
    let place_of_task = |task: &usize| places.of(Item::Task(*task), Key::Features.names());
    let d = match &mistake.reason {
        Reason::NoAgent => Remark::lacking("HQ0901", at, format!("mission `{name}` has no agent")).help(Help::with(
            "declare one: {}",
            [Snippet::declared(
                "robot",
                "NAME",
                [
                    Snippet::entry("place", "[0, 0, 0] m"),
                    Snippet::entry("speed", "[0.1, 0.4] m/s"),
                    Snippet::block("skills", [Snippet::entry("SKILL", "2 s")]),
                ],
            )],
        )),
        Reason::NoTask => Remark::lacking("HQ0901", at, format!("mission `{name}` has no task")).help(Help::with(
            "declare tasks: {}, or name a file of them with `layers_from`",
            [Snippet::declared("layer", "NAME", [Snippet::typed("task", "NAME", "SKILL", [Snippet::dots()])])],
        )),
        Reason::EmptyLayer => Remark::lacking("HQ0901", at, "this layer has no task").help(fix),
        Reason::NoTime => Remark::error("HQ0902", at, "no task takes any time")
            .note("the cost of a plan is relative to the time of its tasks")
            .help("give skills a time, or tasks a path"),
        Reason::TooSmall { .. } | Reason::Reversed { .. } if mistake.at.key == Some(Key::Speed) => {
            Remark::error("HQ0903", at, format!("this speed {what}"))
                .help("write the lower speed first, at least 0.001 m/s")
        }
        Reason::TooLarge { .. } => {
            Remark::error("HQ0904", at, format!("this {what}")).help("check the unit after the number")
        }
        Reason::TooMany { .. } => Remark::error("HQ0904", at, what).help("split the mission into several"),
        Reason::NobodyHasSkill { action } => {
            let skills = problem.agents.iter().flat_map(|a| &a.skills).map(|s| s.action.as_str());
            let d = Remark::error("HQ0910", at, what);
            d.meant_or(suggest(action, skills), fix)
        }
        Reason::Nobody { .. } => {
            let (what, why) = what.split_once(": ").unwrap_or((&what, ""));
            let d = Remark::error("HQ0910", at, what.replace(" it", " this task"));
            let d = if why.is_empty() { d } else { d.note(why) };
            d.help(fix)
        }
        Reason::NoObject { features, nearest } => {
            let known = || problem.objects.iter().flat_map(|o| &o.features).map(String::as_str);
            let slip = features.iter().find(|f| !known().any(|k| k == f.as_str()));
            let d = match slip.and_then(|f| Some((f, feature(places, mistake.at.item, f)?))) {
                Some((f, at)) => Remark::error("HQ0911", at, format!("no object is `{f}`")),
                None => Remark::error("HQ0911", at, what),
            };
            let d = match nearest {
                Some(object) => d.label(places.of(Item::Object(*object), Key::Features.names()), "the nearest"),
                None => d,
            };
            d.meant_or(slip.and_then(|f| suggest(f, known())), fix)
        }
        Reason::LacksFeature { object, .. } => Remark::error("HQ0911", at, what)
            .label(places.of(Item::Object(*object), Key::Features.names()), "what it is")
            .help(fix),
        Reason::TooFewObjects { tasks, .. } => {
            let d = Remark::error("HQ0911", at, what).help(fix);
            let others = tasks.iter().map(place_of_task).filter(|other| *other != at).take(MOST_LABELS);
            others.fold(d, |d, other| d.label(other, "needs one too"))
        }
        // The keys' own ranges refuse these, or no spec can say them.
        _ => Remark::error("HQ0308", at, what).help(fix),
    };
    match mistake.against {
        Some(other) if d.labels.iter().all(|l| l.at != at_of(places, other)) => {
            d.label(at_of(places, other), "in the way")
        }
        _ => d,
    }
}
