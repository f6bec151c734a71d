//! Errors for a schedule that cannot be planned, at the texts that they are about.

use blocks::{Bound, Help, Origin, Snippet};
use quantities::number;

use super::check::{Declaration, Item, Key, MAX_OPERATIONS, MAX_ROBOTS, Mistake, Reason};
use super::problem::Problem;
use crate::declare::{DeclaredMission, Origins, Remark, Remarks};
use crate::numbers::{MAX_NUMBER, MIN_SPEED};

/// Adds the mistakes of a problem, apart from those that follow from reported ones.
pub(super) fn add(m: &DeclaredMission, problem: &Problem, places: &Origins<Item>, remarks: &mut Remarks) {
    for mistake in problem.check() {
        let known = |of: Declaration| places.is_wrong(of.item, of.key.map(Key::name).as_slice());
        // These are about the whole, which is unknown if a part is wrong.
        let of_all =
            matches!(mistake.reason, Reason::NoRobot | Reason::NoOperation | Reason::NoWay | Reason::NoTime { .. });
        if known(mistake.at) || mistake.against.is_some_and(known) || (of_all && places.any_wrong()) {
            continue;
        }
        remarks.push(refusal(m, problem, &mistake, places));
    }
}

/// Place of the speed of a robot's approach to an agent, if it is written.
pub(super) fn approach(places: &Origins<Item>, agent: usize, robot: usize) -> Option<Origin> {
    let approaches = places.block(Item::Agent(agent))?.each(Key::Approaches.name());
    let own = approaches.iter().find(|e| e.member == Some(robot))?;
    match &own.value.value {
        Bound::Block(block) => block.origin(Key::Speed.name()),
        _ => None,
    }
}

/// Place of the approach that a mistake is about.
fn own_approach(mistake: &Mistake, places: &Origins<Item>) -> Option<Origin> {
    match (mistake.at, mistake.against) {
        (
            Declaration { item: Item::Agent(agent), key: Some(Key::Approaches) },
            Some(Declaration { item: Item::Robot(robot), .. }),
        ) => approach(places, agent, robot),
        _ => None,
    }
}

/// Place of a declaration; if its key is not written, of its entry.
fn at_of(places: &Origins<Item>, of: Declaration) -> Origin {
    places.of(of.item, of.key.map(Key::name).as_slice())
}

/// The error for a mistake.
fn refusal(m: &DeclaredMission, problem: &Problem, mistake: &Mistake, places: &Origins<Item>) -> Remark {
    let at = own_approach(mistake, places).unwrap_or_else(|| at_of(places, mistake.at));
    let name = &m.name;
    let key = mistake.at.key.map_or("mission", Key::name);
    let error = |code: &'static str, text: String| Remark::error(code, at, text);
    match &mistake.reason {
        Reason::NoRobot => {
            Remark::lacking("HQ0901", at, format!("mission `{name}` has no service robot")).help(Help::with(
                "declare one: {}",
                [Snippet::declared(
                    "robot",
                    "NAME",
                    [
                        Snippet::entry("depot", "[x, y] m"),
                        Snippet::entry("speed", "[0.05, 0.2] m/s"),
                        Snippet::entry("serve", "20 s"),
                    ],
                )],
            ))
        }
        Reason::NoOperation => {
            Remark::lacking("HQ0901", at, format!("mission `{name}` has nothing to serve: no agent has an operation"))
                .help(Help::with(
                    "declare one: {}",
                    [Snippet::declared(
                        "human",
                        "NAME",
                        [Snippet::entry("place", "[x, y] m"), Snippet::entry("duration", "200 s")],
                    )],
                ))
        }
        Reason::NoWay => error("HQ0902", "no robot has a distance to travel".to_string())
            .note("every agent is at every depot, and waits are relative to the longest path")
            .help("move a depot or an agent away from the others"),
        Reason::TooSmall { value, least } if *least == MIN_SPEED => {
            error("HQ0903", format!("a speed of {} m/s is too slow to plan with", number(*value)))
                .note("a path would take longer than the longest mission")
                .help(format!("write speeds of at least {MIN_SPEED} m/s, the lower one first"))
        }
        Reason::Reversed { low, high } => {
            let (low, high) = (number(*low), number(*high));
            error("HQ0903", format!("this range begins at {low} m/s and ends at {high} m/s, below its beginning"))
                .help(Help::with("write the lower speed first: {}", [Snippet::value(format!("[{high}, {low}] m/s"))]))
        }
        Reason::OutsideCruise { low, high } => {
            let text = match low == high {
                true => format!("{} m/s is outside of the robot's speeds", number(*low)),
                false => {
                    format!(
                        "the range from {} to {} m/s does not overlap the robot's speeds",
                        number(*low),
                        number(*high)
                    )
                }
            };
            let d = error("HQ0903", text);
            let d = d.help("a robot near an agent must also keep to its own speeds: write a range that overlaps them");
            match mistake.against {
                Some(other) => d.label(at_of(places, other), "speeds of the robot"),
                None => d,
            }
        }
        Reason::TooLarge { value } => error("HQ0904", format!("`{key}` is too large: {}", number(*value)))
            .note(format!("lengths in m, times in s, speeds in m/s and weights can be at most {}", number(MAX_NUMBER)))
            .help("check the unit after the number"),
        Reason::TooMany { count, most } => {
            let (what, known) = match *most {
                MAX_ROBOTS => ("robots", MAX_ROBOTS),
                _ => ("operations and agents", MAX_OPERATIONS),
            };
            error("HQ0904", format!("mission `{name}` has {count} {what}, and the maximum is {known}"))
                .help("split it into several missions")
        }
        Reason::NoTime { seconds } => {
            let text = format!("the planned duration of an operation would be {} s", number(*seconds));
            let d = error("HQ0905", text)
                .note("the planned duration is the quantile of the distribution at `confidence`, and the standard deviation is too large for its mean")
                .help("write a smaller standard deviation, or a greater confidence");
            match places.written(Item::Mission, &[Key::Confidence.name()]) {
                Some(confidence) => d.label(confidence, format!("a confidence of {}", number(problem.confidence))),
                None => d,
            }
        }
        Reason::Count { found, expected } => {
            let d = error("HQ0906", format!("`{key}` has {found} numbers, and {expected} are expected"))
                .help("write one for each operation, or a single one for all");
            d.label(places.of(mistake.at.item, &[Key::Operations.name()]), format!("{expected} operations"))
        }
        // The keys' own ranges refuse these, or no spec can say them.
        reason => error("HQ0308", format!("`{key}` {reason}")).help("write a number inside the range of the key"),
    }
}
