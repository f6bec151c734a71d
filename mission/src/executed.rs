//! The execution of any kind behind [`kind::Execution`]: measures, log, results, and people who answer after each service.

use serde::Serialize;

use crate::chart::Chart;
use crate::execution::{Replans, Simulation};
use crate::kind::course::{Course, GroundPose};
use crate::kind::{self, Cell, Entry, Event, Measure, Outcome, Rejected, Replies, Table, Work, number};
use crate::labels::Labels;
use crate::map::Map;

/// The measures of a kind, each with its value of the mission, or of the member with the kind's own index.
pub(crate) type MeasureTable<W> = [(Measure, fn(&Simulation<W>, usize) -> Option<[f64; 3]>)];

/// A world of which measures, logs and results are reported: the part of [`kind::Execution`] that only the kind knows.
pub(crate) trait Reports: Replans + 'static {
    /// Results, as they are written into files.
    type Results: Serialize;

    /// Everything that is measured.
    const MEASURES: &'static MeasureTable<Self>;

    /// Text that people read in place of names.
    fn labels(problem: &Self::Problem) -> &Labels;

    /// A role of a member, and the index that its measures take; none: there is no such member.
    fn member(problem: &Self::Problem, member: usize) -> Option<(&'static str, usize)>;

    /// The words for an event.
    fn describe(problem: &Self::Problem, event: &Event) -> String;

    /// An event happens at the present time.
    ///
    /// # Errors
    /// The reason why it cannot happen now, in a sentence. Nothing has changed then.
    fn handle(of: &mut Simulation<Self>, event: &Event) -> Result<(), String>;

    /// The words for an entry of the log.
    fn describe_happening(problem: &Self::Problem, what: &Self::LogEntry) -> String;

    /// True for an entry of the log that came from outside, or changed an assignment.
    fn is_notable(what: &Self::LogEntry) -> bool;

    /// The member that was served, for an entry of the log that says so.
    fn served(_problem: &Self::Problem, _what: &Self::LogEntry) -> Option<usize> {
        None
    }

    /// The Gantt chart of the plan as it is now.
    fn chart(of: &Simulation<Self>) -> Chart;

    /// The map of the plan.
    fn map(of: &Simulation<Self>) -> Map;

    /// Results so far.
    fn results(of: &Simulation<Self>) -> Self::Results;

    /// Results for people.
    fn tables(results: &Self::Results, labels: &Labels) -> Vec<Table>;

    /// Names of the columns of the log of states.
    fn columns(problem: &Self::Problem) -> Vec<String>;

    /// The present state, a cell a column.
    fn row(of: &Simulation<Self>) -> Vec<Cell>;

    /// The work of a member that runs a controller of its own.
    fn work(of: &Simulation<Self>, member: usize) -> Option<Work>;

    /// The true pose of a member at a time (s) between the present and the next step; none: it has none.
    fn pose(_of: &Simulation<Self>, _member: usize, _time: f64) -> Option<GroundPose> {
        None
    }

    /// The way of a member that a controller drives; none for others.
    fn course(_of: &Simulation<Self>, _member: usize) -> Option<Course<'_>> {
        None
    }

    /// The base of a driven member is at this pose, at a time (s) between the present and the next step.
    fn drive(_of: &mut Simulation<Self>, _member: usize, _time: f64, _pose: GroundPose) {}
}

/// A mission under way, with people who answer after each service.
pub(crate) struct Executed<W: Reports> {
    pub(crate) execution: Simulation<W>,
    replies: Vec<Replies>,
    /// Number of answers of each entry of `replies`.
    answers: Vec<usize>,
    /// Records that were looked at for services.
    seen: usize,
    rejected: Vec<Rejected>,
}

impl<W: Reports> Executed<W> {
    pub fn new(execution: Simulation<W>, replies: Vec<Replies>) -> Executed<W> {
        Executed { execution, answers: vec![0; replies.len()], replies, seen: 0, rejected: Vec::new() }
    }

    /// Lets people who were served say what it was like.
    fn listen(&mut self) {
        while let Some(record) = self.execution.records().get(self.seen) {
            self.seen += 1;
            let Some(member) = W::served(&self.execution.problem, &record.what) else { continue };
            let Some(index) = self.replies.iter().position(|replies| replies.member == member) else { continue };
            let (services, count) = (&self.replies[index].services, &mut self.answers[index]);
            let reply = services.get(*count).or(services.last()).cloned().flatten();
            *count += 1;
            if let Some(reply) = reply
                && let Err(why) = W::handle(&mut self.execution, &reply)
            {
                let event = W::describe(&self.execution.problem, &reply);
                self.rejected.push(Rejected { time: self.execution.time, event, why });
            }
        }
    }
}

impl<W: Reports> kind::Execution for Executed<W> {
    fn time(&self) -> f64 {
        self.execution.time
    }

    fn advance(&mut self, to: f64) {
        self.execution.advance(to);
        self.listen();
    }

    fn next(&self) -> Option<f64> {
        self.execution.next()
    }

    fn done(&self) -> Option<f64> {
        self.execution.log.done
    }

    fn stranded(&self) -> Option<String> {
        self.execution.stranded().map(ToString::to_string)
    }

    fn chart(&self) -> Chart {
        W::chart(&self.execution)
    }

    fn labels(&self) -> &Labels {
        W::labels(&self.execution.problem)
    }

    fn map(&self) -> Map {
        W::map(&self.execution)
    }

    fn describe(&self, event: &Event) -> String {
        W::describe(&self.execution.problem, event)
    }

    fn handle(&mut self, event: &Event) -> Result<(), String> {
        W::handle(&mut self.execution, event)?;
        self.listen();
        Ok(())
    }

    fn take_rejected(&mut self) -> Vec<Rejected> {
        std::mem::take(&mut self.rejected)
    }

    fn log_len(&self) -> usize {
        self.execution.log.records.len()
    }

    fn log_from(&self, first: usize) -> Vec<Entry> {
        let records = self.execution.records().iter().skip(first);
        let entries = records.map(|record| Entry {
            time: record.time,
            text: W::describe_happening(&self.execution.problem, &record.what),
            notable: W::is_notable(&record.what),
        });
        entries.collect()
    }

    fn measure(&self, name: &str, member: Option<usize>) -> [f64; 3] {
        let of = &self.execution;
        let (role, index) = match member.map(|member| W::member(&of.problem, member)) {
            None => (None, 0),
            Some(Some((role, index))) => (Some(role), index),
            Some(None) => return number(f64::NAN),
        };
        let found = W::MEASURES.iter().find(|(measure, _)| measure.name == name && measure.is_of(role));
        found.and_then(|(_, value)| value(of, index)).unwrap_or(number(f64::NAN))
    }

    fn outcome(&self) -> Outcome {
        let results = W::results(&self.execution);
        let log = &self.execution.log;
        Outcome {
            reschedules: log.reschedules,
            reallocations: log.reallocations,
            tables: W::tables(&results, self.labels()),
            data: serde_json::to_value(&results).unwrap_or_default(),
        }
    }

    fn columns(&self) -> Vec<String> {
        W::columns(&self.execution.problem)
    }

    fn row(&self) -> Vec<Cell> {
        W::row(&self.execution)
    }

    fn work(&self, member: usize) -> Option<Work> {
        W::work(&self.execution, member)
    }

    fn pose(&self, member: usize, time: f64) -> Option<GroundPose> {
        W::pose(&self.execution, member, time)
    }

    fn course(&self, member: usize) -> Option<Course<'_>> {
        W::course(&self.execution, member)
    }

    fn drive(&mut self, member: usize, time: f64, pose: GroundPose) {
        W::drive(&mut self.execution, member, time, pose);
    }
}
