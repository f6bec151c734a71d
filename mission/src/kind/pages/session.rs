//! A mission with its pages, for every kind: the supervisor's page and requests, messages, notices.

use std::collections::BTreeMap;
use std::sync::Arc;

use serde_json::{Value, json};

use crate::kind::{Event, EventInfo, Execution, Mission};

use super::message_log::MessageLog;
use super::request::EventRequest;
use super::words::{clock_time, counted};
use super::{
    ALREADY_NOTED, Button, Client, JournalSink, MemberRow, PageData, Pages, PersonMessage, PersonPage, PlanUpdate,
    PointInput, Progress, Refusal, Request, ServeSettings, SupervisorPage, is_current, parse,
};

/// Maximum number of messages of one person's page.
const MESSAGES: usize = 12;
/// Maximum number of events of the supervisor's page.
const EVENTS: usize = 80;
/// Delay of the supervisor's button for a longer activity (s).
const DELAY: f64 = 30.0;

/// A mission under way, as the server sees it.
pub trait Session: Send {
    /// Returns the mission time (s).
    fn time(&self) -> f64;

    /// Returns the number of log entries.
    fn log_len(&self) -> usize;

    /// Advances to this time (s), which is later than now.
    fn advance(&mut self, to: f64);

    /// Returns the contents of all pages; `running` is the state of the clock.
    fn data(&self, running: bool) -> PageData;

    /// Applies a request, and returns the reply. The result depends on the state of the mission and the request alone, so
    /// that the requests of a journal restore the state.
    ///
    /// # Errors
    /// The reason for rejecting it.
    fn handle(&mut self, request: &Request, running: bool, journal: &mut JournalSink<'_>) -> Result<String, Refusal>;
}

/// A mission of any kind with its pages.
pub struct MissionSession {
    mission: Box<dyn Mission>,
    pages: Box<dyn Pages>,
    /// Messages of people with a page, by member.
    people: BTreeMap<usize, MessageLog>,
    events: MessageLog,
    /// Number of log entries that the messages contain.
    seen: usize,
}

impl MissionSession {
    /// Plans a mission, and stands at its start.
    ///
    /// # Errors
    /// The reason why there is no plan, in a sentence.
    pub fn new(mission: &dyn Mission, settings: &ServeSettings) -> Result<MissionSession, String> {
        let people = settings.reporting.iter().map(|member| (*member, MessageLog::new(MESSAGES)));
        Ok(MissionSession {
            mission: mission.boxed(),
            pages: mission.pages(settings)?,
            people: people.collect(),
            events: MessageLog::new(EVENTS),
            seen: 0,
        })
    }

    /// The mission.
    pub fn mission(&self) -> &dyn Mission {
        &*self.mission
    }

    /// The mission as it is executed.
    pub fn execution(&self) -> &dyn Execution {
        self.pages.execution()
    }

    /// Makes messages of new log entries.
    fn observe(&mut self) {
        let end = self.pages.execution().log_len();
        if self.seen == end {
            return;
        }
        for (index, entry) in (self.seen..).zip(self.pages.execution().log_from(self.seen)) {
            self.pages.observe(index);
            self.events.add(entry.time, PersonMessage::new(entry.text));
            for (member, messages) in &mut self.people {
                if let Some(message) = self.pages.message(index, *member) {
                    messages.add(entry.time, message);
                }
            }
        }
        self.seen = end;
    }

    /// Applies a request of the supervisor: an event of the kind.
    fn supervise(&mut self, body: &Value, journal: &mut JournalSink<'_>) -> Result<String, Refusal> {
        let request: EventRequest = parse(body)?;
        let kind = self.mission.kind();
        if let Some((_, why)) = kind.absent.iter().find(|(key, _)| *key == request.what) {
            return Err(Refusal::Invalid((*why).into()));
        }
        if request.what == REPLAN {
            let known = request.member.is_none() && request.with.is_empty();
            known.then_some(()).ok_or_else(|| Refusal::Invalid("`replan` is of the whole mission".into()))?;
        } else {
            let info = kind.event(&request.what);
            let info =
                info.ok_or_else(|| Refusal::Invalid(format!("{} has no event `{}`", kind.title, request.what)))?;
            self.check(info, &request)?;
            let until = request.member.and_then(|member| self.pages.activity(member).until);
            if !is_current(until, request.until) {
                return Ok(ALREADY_NOTED.into());
            }
        }
        let event = request.event();
        self.mission.check_event(&event).map_err(|why| Refusal::Invalid(why.text))?;
        Ok(match self.pages.happen(&event, journal)? {
            PlanUpdate::Replanned => "Noted; there is a new plan.".into(),
            PlanUpdate::Rescheduled => "Noted; the plan was rescheduled.".into(),
            PlanUpdate::Unchanged => "Noted; the plan is unchanged.".into(),
        })
    }

    /// Checks the keys and the member of an event.
    fn check(&self, info: &EventInfo, request: &EventRequest) -> Result<(), Refusal> {
        let unknown = |key: &&String| info.with.iter().all(|further| further.key != key.as_str());
        if let Some(key) = request.with.keys().find(unknown) {
            return Err(Refusal::Invalid(format!("the event `{}` has no key `{key}`", info.name)));
        }
        let members = self.mission.members();
        let member = request.member.and_then(|member| members.get(member));
        let member = member.ok_or_else(|| Refusal::Invalid("there is no member with this number".into()))?;
        match info.not_of.iter().find(|not| not.role == member.role) {
            Some(not) => Err(Refusal::Invalid(not.why.into())),
            None => Ok(()),
        }
    }

    /// The row of a member.
    fn row(&self, member: usize, role: &'static str, name: String) -> MemberRow {
        let activity = self.pages.activity(member);
        let request = |what: &str, more: Value| {
            let mut request = json!({ "what": what, "member": member });
            if let (Some(all), Value::Object(more)) = (request.as_object_mut(), more) {
                all.extend(more);
            }
            request
        };
        let event = |name: &str| {
            let of = |info: &&EventInfo| info.not_of.iter().all(|not| not.role != role);
            self.mission.kind().event(name).filter(of).is_some()
        };
        let mut buttons = Vec::new();
        if event("moved") {
            let prompt = format!("{name} is now at");
            let moved = Button::new("moved", "Moved", true, request("moved", json!({})));
            buttons.push(Button { point: Some(PointInput { key: "to", prompt }), ..moved });
        }
        if activity.lost {
            buttons.push(Button::new("back", "Is back", event("back"), request("back", json!({}))));
        } else {
            if let Some(until) = activity.until.filter(|_| event("late")) {
                let late = request("late", json!({ "by": DELAY, "until": until }));
                let title = Some("takes 30 s longer");
                buttons.push(Button { title, ..Button::new("late", "+30 s", true, late) });
            }
            if activity.fails && event("failed") {
                let failed = request("failed", json!({ "until": activity.until }));
                buttons.push(Button { confirm: true, ..Button::new("failed", "Failed", true, failed) });
            }
            if event("lost") {
                let lost = request("lost", json!({}));
                buttons.push(Button { confirm: true, ..Button::new("lost", "Lost", true, lost) });
            }
        }
        let paged = self.people.contains_key(&member);
        MemberRow { member, name, role, paged, page: "", activity, buttons }
    }

    fn supervisor(&self, progress: &Progress) -> SupervisorPage {
        let execution = self.pages.execution();
        let (outcome, feasible) = (execution.outcome(), progress.stranded.is_none());
        let ends = execution.chart().end().filter(|_| feasible).map(|end| format!("ends at {}", clock_time(end)));
        let counts =
            [counted("rescheduled", outcome.reschedules), counted("replanned", outcome.reallocations)].map(Some);
        let numbers: Vec<String> = [progress.done.clone(), ends].into_iter().chain(counts).flatten().collect();
        let rows = self.mission.members().into_iter().enumerate().map(|(member, who)| {
            let label = self.mission.labels().member(who.name).to_string();
            self.row(member, who.role, label)
        });
        let replans = self.mission.check_event(&Event::of_all(REPLAN)).is_ok();
        let replan = Button::new("replan", "Replan", progress.over.is_none(), json!({ "what": REPLAN }));
        SupervisorPage {
            status: if feasible { self.pages.plan_status() } else { "no plan".into() },
            numbers: numbers.join(", "),
            over: progress.over.clone(),
            note: progress.stranded.clone().filter(|_| progress.over.is_none()),
            buttons: if replans { vec![replan] } else { Vec::new() },
            members: rows.collect(),
            events: self.events.messages(),
            drawing: execution.log_len(),
        }
    }

    fn person(&self, member: usize, messages: &MessageLog, progress: &Progress, running: bool) -> PersonPage {
        let members = self.mission.members();
        let name = members.get(member).map_or_else(String::new, |who| self.mission.labels().member(who.name).into());
        let mut content = self.pages.person(member);
        for button in content.groups.iter_mut().flat_map(|group| &mut group.buttons) {
            button.enabled &= running;
        }
        let stranded = progress.stranded.as_ref().map(|why| format!("{why} Ask the supervisor."));
        let note = match () {
            () if self.pages.execution().done().is_some() => Some("The mission is done. Thank you.".into()),
            () if self.pages.activity(member).lost => {
                Some("The supervisor has noted that you left. If you are back, tell the supervisor.".into())
            }
            () if stranded.is_some() => stranded,
            () if !running => Some("The mission clock is stopped. The supervisor starts it.".into()),
            () => None,
        };
        PersonPage { name, note, content, messages: messages.messages() }
    }
}

/// The event of the whole mission that asks for a new plan.
const REPLAN: &str = "replan";

impl Session for MissionSession {
    fn time(&self) -> f64 {
        self.pages.execution().time()
    }

    fn log_len(&self) -> usize {
        self.pages.execution().log_len()
    }

    fn advance(&mut self, to: f64) {
        self.pages.execution_mut().advance(to);
        self.observe();
    }

    fn data(&self, running: bool) -> PageData {
        let progress = self.pages.progress();
        let person =
            |(member, messages): (&usize, &MessageLog)| (*member, self.person(*member, messages, &progress, running));
        PageData {
            people: self.people.iter().map(person).collect(),
            supervisor: self.supervisor(&progress),
            chart: Arc::new(self.pages.execution().chart()),
            map: Arc::new(self.pages.execution().map()),
        }
    }

    fn handle(&mut self, request: &Request, running: bool, journal: &mut JournalSink<'_>) -> Result<String, Refusal> {
        let reply = match request.from {
            Client::Supervisor => self.supervise(&request.body, journal),
            Client::Person(member) if !self.people.contains_key(&member) => {
                Err(Refusal::Invalid(format!("member {member} has no page")))
            }
            Client::Person(_) if !running && !self.pages.accepts_stopped(&request.body) => {
                Err(Refusal::NotNow("The mission clock is stopped: nothing was recorded.".into()))
            }
            Client::Person(member) => self.pages.request(member, &request.body, journal),
        };
        self.observe();
        reply
    }
}
