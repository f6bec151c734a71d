//! Rewards of a team over an interval of time: production, pools, precedence and codependence, srs (1) to (6) and (15) to
//! (19).
//!
//! An interval ends whenever an action of somebody ends, as the states of the search tree do. Sources that are closed at its
//! begin stay closed until its end. The worth of hidden objects is counted as it is expected: by the probability that they are
//! detected, srs (28), agent by agent within an interval. Within it sources are settled in their order, so that a pool is never consumed beyond its
//! content. Who has no activity any more consumes nothing, and is still exposed to what repels; the paper leaves it open.

use super::belief::Undetected;
use super::geometry::{Point, Pose, along};
use super::plan::{Activity, Phase};
use super::problem::{EMPTY, Problem, SourceKind, Travel};
use super::sight::Sight;
use super::ways::{Way, rate, steps};

/// The motion of an agent in an interval.
#[derive(Clone, Copy, Debug)]
pub enum Motion<'w> {
    /// It takes no part.
    Absent,
    /// It stands still.
    Still {
        /// Reward rate of each source (1/s).
        rates: &'w [f64],
        /// Its pose.
        pose: Pose,
        /// Cell from which it sees, if it looks for hidden objects.
        seat: Option<u32>,
        /// It has no activity any more: it consumes nothing, and is still exposed to what repels.
        idle: bool,
    },
    /// It moves along a way.
    Along {
        /// The way.
        way: &'w Way,
        /// Shares of the way at the begin and at the end of the interval.
        shares: [f64; 2],
        /// Time that the whole way really takes, relative to its planned one.
        pace: f64,
    },
}

impl Motion<'_> {
    /// Calls `look` with each cell from which it sees in an interval, and with the times (s) between which it does.
    pub fn each_seat(&self, from: f64, to: f64, mut look: impl FnMut(u32, f64, f64)) {
        match self {
            Motion::Absent | Motion::Still { seat: None, .. } => {}
            Motion::Still { seat: Some(seat), .. } => look(*seat, from, to),
            Motion::Along { way, shares: [first, last], .. } => {
                let time = |share: f64| from + (share - first) / (last - first) * (to - from);
                for dwell in &way.dwells {
                    let (begin, end) = (dwell.shares[0].max(*first), dwell.shares[1].min(*last));
                    if begin < end {
                        look(dwell.seat, time(begin), time(end));
                    }
                }
            }
        }
    }

    /// It has no activity any more.
    fn is_idle(&self) -> bool {
        matches!(self, Motion::Still { idle: true, .. })
    }

    /// Pose at a share of the interval.
    fn pose(&self, share: f64) -> Pose {
        match self {
            Motion::Absent => Pose { at: [f64::NAN; 2], heading: 0.0 },
            Motion::Still { pose, .. } => *pose,
            Motion::Along { way, shares: [from, to], .. } => along(&way.points, from + share * (to - from), 0.0),
        }
    }
}

/// Computes the reward that each source produces for each agent in an interval, before pools limit it: srs (2). `gained` has
/// a row of sources for each agent.
pub fn produced(problem: &Problem, motions: &[Motion<'_>], duration: f64, gained: &mut Vec<f64>) {
    let sources = problem.sources.len();
    gained.clear();
    gained.resize(motions.len() * sources, 0.0);
    if sources == 0 {
        return;
    }
    for (motion, sums) in motions.iter().zip(gained.chunks_mut(sources)) {
        match motion {
            Motion::Absent => {}
            Motion::Still { rates, idle, .. } => {
                let limit = if *idle { 0.0 } else { f64::INFINITY };
                sums.iter_mut().zip(*rates).for_each(|(sum, rate)| *sum += rate.min(limit) * duration);
            }
            Motion::Along { way, shares: [from, to], pace } => {
                way.add(*from, *to, sums);
                if *pace != 1.0 {
                    sums.iter_mut().for_each(|sum| *sum *= pace);
                }
            }
        }
    }
    for (index, source) in problem.sources.iter().enumerate() {
        let Some(of) = source.of.filter(|_| source.kind == SourceKind::Interaction) else { continue };
        if matches!(motions.get(of), None | Some(Motion::Absent)) {
            continue;
        }
        let count = steps(duration);
        for agent in (0..motions.len()).filter(|agent| *agent != of && problem.consumes(*agent, index)) {
            if matches!(motions[agent], Motion::Absent) {
                continue;
            }
            let limit = if matches!(motions[agent], Motion::Still { idle: true, .. }) { 0.0 } else { f64::INFINITY };
            let shares = (0..count).map(|i| (i as f64 + 0.5) / count as f64);
            let at = |share| relative(motions[agent].pose(share).at, motions[of].pose(share));
            let rates = shares.map(|share| source.rate(at(share)).min(limit));
            gained[agent * sources + index] += rates.sum::<f64>() * duration / count as f64;
        }
    }
}

/// Looks for hidden objects in an interval: takes away what is detected, and returns its expected worth. `note` gets each agent
/// with its part.
pub fn look(
    problem: &Problem,
    sight: &Sight,
    motions: &[Motion<'_>],
    [from, to]: [f64; 2],
    left: &mut Undetected,
    mut note: impl FnMut(usize, f64),
) -> f64 {
    let mut total = 0.0;
    for (agent, motion) in motions.iter().enumerate().filter(|(_, motion)| !motion.is_idle()) {
        let Some(sees) = problem.looks(agent) else { continue };
        let mut own = 0.0;
        motion.each_seat(from, to, |seat, begin, end| {
            let detected = left.look(sight, seat, sees.within, sees.rate * (end - begin));
            own += detected * problem.urgency(0.5 * (begin + end));
        });
        total += own;
        note(agent, own);
    }
    total
}

/// Returns a point in the frame of a pose.
pub fn relative(p: Point, frame: Pose) -> Point {
    let (sin, cos) = frame.heading.sin_cos();
    let [x, y] = [p[0] - frame.at[0], p[1] - frame.at[1]];
    [cos * x + sin * y, cos * y - sin * x]
}

/// Settles an interval: pools give what they hold, srs (4), and are consumed, srs (5), also those of codependent sources.
/// Returns the reward. `note` gets the source, its reward, and the share of the produced reward that the pool gave.
pub fn settle(problem: &Problem, pools: &mut [f64], gained: &[f64], mut note: impl FnMut(usize, f64, f64)) -> f64 {
    let sources = problem.sources.len();
    let mut open = 0_u64;
    for source in 0..sources {
        open |= u64::from(problem.is_open(source, pools)) << source;
    }
    let mut total = 0.0;
    for source in (0..sources).filter(|source| open >> source & 1 == 1) {
        let sum: f64 = gained.iter().skip(source).step_by(sources).sum();
        if sum == 0.0 {
            continue;
        }
        let taken = if sum > 0.0 { sum.min(pools[source]) } else { sum };
        if pools[source].is_finite() {
            take(&mut pools[source], taken);
            for pair in problem.codependent.iter().filter(|pair| pair.of.contains(&source)) {
                let other = if pair.of[0] == source { pair.of[1] } else { pair.of[0] };
                take(&mut pools[other], pair.share * taken);
            }
        }
        total += taken;
        note(source, taken, taken / sum);
    }
    total
}

fn take(pool: &mut f64, amount: f64) {
    *pool -= amount;
    if *pool <= EMPTY {
        *pool = 0.0;
    }
}

/// Rewards of a plan.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Rewards {
    /// `g` of srs (15).
    pub total: f64,
    /// By source.
    pub sources: Vec<f64>,
    /// By agent.
    pub agents: Vec<f64>,
    /// Pools at the horizon.
    pub pools: Vec<f64>,
    /// Reward of hidden objects: expected of a plan, collected in an execution.
    pub objects: f64,
}

impl Rewards {
    /// Adds an interval.
    pub fn add(&mut self, problem: &Problem, motions: &[Motion<'_>], duration: f64, gained: &mut Vec<f64>) {
        produced(problem, motions, duration, gained);
        let count = problem.sources.len();
        let (sources, agents) = (&mut self.sources, &mut self.agents);
        self.total += settle(problem, &mut self.pools, gained, |source, taken, share| {
            sources[source] += taken;
            for (agent, sum) in agents.iter_mut().enumerate() {
                *sum += share * gained[agent * count + source];
            }
        });
    }

    /// Nothing yet.
    pub fn none(problem: &Problem) -> Rewards {
        Rewards {
            total: 0.0,
            sources: vec![0.0; problem.sources.len()],
            agents: vec![0.0; problem.agents.len()],
            pools: problem.pools(),
            objects: 0.0,
        }
    }
}

/// Returns the instants of a plan at which an interval ends: the end of each activity, and that of the time it accounts for.
pub fn instants(problem: &Problem, activities: &[Activity]) -> Vec<f64> {
    let ends = activities.iter().map(|activity| activity.end).chain([problem.end()]);
    let mut all: Vec<f64> = ends.filter(|t| *t > problem.start && *t <= problem.end()).collect();
    all.sort_by(f64::total_cmp);
    all.dedup_by(|next, kept| *next - *kept <= 1e-9);
    all
}

/// Computes the rewards of the activities of a team from the present to the end of the time that a plan accounts for.
pub fn evaluate(problem: &Problem, activities: &[Activity]) -> Rewards {
    struct Own {
        leg: Option<(Way, [f64; 2])>,
        pose: Pose,
        rates: Vec<f64>,
        seat: Option<u32>,
        next: usize,
        order: Vec<usize>,
    }
    let sight = problem.is_searching().then(|| problem.sight());
    let mut undetected = Undetected::of(problem);
    let seat = |agent: usize, at: Point| sight.as_ref().filter(|_| problem.looks(agent).is_some())?.seat(at);
    let rates = |agent: usize, at: Point| -> Vec<f64> {
        (0..problem.sources.len()).map(|source| rate(problem, agent, source, at, Travel::REST)).collect()
    };
    let mut own: Vec<Own> = Vec::new();
    for (agent, who) in problem.agents.iter().enumerate() {
        let mut order: Vec<usize> = (0..activities.len()).filter(|i| activities[*i].agent == agent).collect();
        order.sort_by(|a, b| activities[*a].start.total_cmp(&activities[*b].start));
        let pose = Pose { at: who.start, heading: who.heading };
        let seat = seat(agent, who.start);
        own.push(Own { leg: None, pose, rates: rates(agent, who.start), seat, next: 0, order });
    }
    let mut rewards = Rewards::none(problem);
    let (mut now, mut gained) = (problem.start, Vec::new());
    for then in instants(problem, activities) {
        for (agent, of) in own.iter_mut().enumerate() {
            // The activity that goes on in this interval.
            while let Some(activity) = of.order.get(of.next).map(|i| &activities[*i]) {
                if activity.start > now + 1e-9 {
                    break;
                }
                if let Some((way, _)) = of.leg.take() {
                    of.pose = along(&way.points, 1.0, of.pose.heading);
                    (of.rates, of.seat) = (rates(agent, of.pose.at), seat(agent, of.pose.at));
                }
                if activity.end > now + 1e-9 {
                    if activity.phase == Phase::Going {
                        let way = Way::new(problem, agent, activity.way.clone());
                        of.leg = Some((way, [activity.start, activity.end]));
                    }
                    of.next += 1;
                    break;
                }
                of.next += 1;
            }
            if of.leg.as_ref().is_some_and(|(_, [_, end])| *end <= now + 1e-9)
                && let Some((way, _)) = of.leg.take()
            {
                of.pose = along(&way.points, 1.0, of.pose.heading);
                (of.rates, of.seat) = (rates(agent, of.pose.at), seat(agent, of.pose.at));
            }
        }
        let motions = own.iter().enumerate().map(|(agent, of)| match &of.leg {
            _ if problem.agents[agent].lost => Motion::Absent,
            Some((way, [start, end])) => {
                let share = |t: f64| (t - start) / (end - start);
                let pace = if way.duration > 0.0 { (end - start) / way.duration } else { 1.0 };
                Motion::Along { way, shares: [share(now), share(then)], pace }
            }
            None => {
                let last = of.order.last().map_or(problem.start, |i| activities[*i].end);
                Motion::Still { rates: &of.rates, pose: of.pose, seat: of.seat, idle: last <= now + 1e-9 }
            }
        });
        let motions: Vec<Motion<'_>> = motions.collect();
        rewards.add(problem, &motions, then - now, &mut gained);
        if let Some(sight) = &sight {
            let agents = &mut rewards.agents;
            let worth = look(problem, sight, &motions, [now, then], &mut undetected, |agent, own| agents[agent] += own);
            rewards.objects += worth;
            rewards.total += worth;
        }
        now = then;
    }
    rewards
}
