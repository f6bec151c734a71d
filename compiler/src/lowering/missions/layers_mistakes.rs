//! What a planner of layers says of a problem that it cannot plan, at the text that it is about.

use dsl::tree::Mission;
use dsl::{Diagnostic, Span};
use mission::kinds::layers::check::{Item, Key, Mistake};
use mission::kinds::layers::problem::Problem;
use mission::kinds::layers::reason::Reason;
use names::suggest;

use super::super::Lowerer;
use super::places::OfLayers as Places;
use crate::forms::text_of;

/// So many other tasks of a mistake are underlined.
const MOST_LABELS: usize = 4;

impl Lowerer<'_> {
    /// Reports what is wrong with a problem, but for what follows from mistakes that were reported already; that there is
    /// nothing to do is none where a mission `waits` for its layers.
    pub(super) fn layers_mistakes(&mut self, m: &Mission, problem: &Problem, places: &Places, waits: bool) {
        for mistake in problem.check() {
            if waits && mistake.reason == Reason::NoTask {
                continue;
            }
            let known = |of: mission::kinds::layers::check::Declaration| places.is_wrong(of.item, of.key);
            if known(mistake.at)
                || mistake.against.is_some_and(known)
                || (is_of_all(&mistake.reason) && places.any_wrong())
            {
                continue;
            }
            let d = told(m, problem, &mistake, places);
            self.push(d);
        }
    }
}

/// True for what is about the whole, which is not known where a part is wrong.
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

/// Where a task asks for a feature.
fn feature(m: &Mission, task: Item, word: &str) -> Option<Span> {
    let Item::Task(number) = task else { return None };
    let layers = m.members.iter().filter(|k| k.role.value == "layer");
    let task = layers.flat_map(|layer| &layer.members).filter(|t| t.role.value == "task").nth(number)?;
    let words = task.settings.get("features")?.value.items();
    words.iter().find(|item| text_of(item) == Some(word)).map(|item| item.span)
}

/// A mistake as the reader of the spec is told of it.
fn told(m: &Mission, problem: &Problem, mistake: &Mistake, places: &Places) -> Diagnostic {
    let at = places.of(mistake.at.item, mistake.at.key);
    let (what, fix) = mistake.describe(problem);
    let name = &m.name.value;
    let place_of_task = |task: &usize| places.of(Item::Task(*task), Some(Key::Features));
    let d = match &mistake.reason {
        Reason::NoAgent => Diagnostic::error("HQ0901", at, format!("nobody acts in mission `{name}`: it has no agent"))
            .help("declare one: `robot NAME { place [0, 0, 0] m  speed [0.1, 0.4] m/s  skills { SKILL 2 s } }`"),
        Reason::NoTask => Diagnostic::error("HQ0901", at, format!("there is nothing to do in mission `{name}`")).help(
            "declare tasks: `layer NAME { task NAME = SKILL { .. } }`, or name a file of them with `layers_from`",
        ),
        Reason::EmptyLayer => Diagnostic::error("HQ0901", at, "this layer has no task").help(fix),
        Reason::NoTime => Diagnostic::error("HQ0902", at, "no task takes any time")
            .note("what a plan costs is measured against the time of its tasks")
            .help("give skills their times, or tasks ways to go"),
        Reason::TooSmall { .. } | Reason::Reversed { .. } if mistake.at.key == Some(Key::Speed) => {
            Diagnostic::error("HQ0903", at, format!("this speed {what}"))
                .help("write the least speed first, from 0.001 m/s")
        }
        Reason::TooLarge { .. } => {
            Diagnostic::error("HQ0904", at, format!("this {what}")).help("look at the unit behind the number")
        }
        Reason::TooMany { .. } => Diagnostic::error("HQ0904", at, what).help("split the mission into several"),
        Reason::NobodyHasSkill { action } => {
            let skills = problem.agents.iter().flat_map(|a| &a.skills).map(|s| s.action.as_str());
            let d = Diagnostic::error("HQ0910", at, what);
            match suggest(action, skills) {
                Some(near) => d.help(format!("did you mean `{near}`?")),
                None => d.help(fix),
            }
        }
        Reason::Nobody { .. } => {
            let (what, why) = what.split_once(": ").unwrap_or((&what, ""));
            let d = Diagnostic::error("HQ0910", at, what.replace(" it", " this task"));
            let d = if why.is_empty() { d } else { d.note(why) };
            d.help(fix)
        }
        Reason::NoObject { features, nearest } => {
            let known = || problem.objects.iter().flat_map(|o| &o.features).map(String::as_str);
            let slip = features.iter().find(|f| !known().any(|k| k == f.as_str()));
            let d = match slip.and_then(|f| Some((f, feature(m, mistake.at.item, f)?))) {
                Some((f, at)) => Diagnostic::error("HQ0911", at, format!("no object is `{f}`")),
                None => Diagnostic::error("HQ0911", at, what),
            };
            let d = match nearest {
                Some(object) => d.label(places.of(Item::Object(*object), Some(Key::Features)), "the nearest"),
                None => d,
            };
            match slip.and_then(|f| suggest(f, known())) {
                Some(near) => d.help(format!("did you mean `{near}`?")),
                None => d.help(fix),
            }
        }
        Reason::LacksFeature { object, .. } => Diagnostic::error("HQ0911", at, what)
            .label(places.of(Item::Object(*object), Some(Key::Features)), "what it is")
            .help(fix),
        Reason::TooFewObjects { tasks, .. } => {
            let d = Diagnostic::error("HQ0911", at, what).help(fix);
            let others = tasks.iter().map(place_of_task).filter(|other| *other != at).take(MOST_LABELS);
            others.fold(d, |d, other| d.label(other, "needs one too"))
        }
        // What the keys' own ranges refuse, and what no spec can say.
        _ => Diagnostic::error("HQ0308", at, what).help(fix),
    };
    match mistake.against {
        Some(other) if d.labels.iter().all(|l| l.span != places.of(other.item, other.key)) => {
            d.label(places.of(other.item, other.key), "in the way")
        }
        _ => d,
    }
}
