//! `hierarq serve`: a small web server for the people of a mission.
//!
//! One thread owns the mission and advances its time ([`engine`]); another one serves requests. Each person has a page
//! with the plan in words, the next step, and buttons; the supervisor has one with the chart, the map and all events.
//! Pages listen to a stream of complete states and show the latest one, so that a reload or a lost connection loses
//! nothing. A report is written into a journal before it has an effect ([`journal`]).
//!
//! | protection against | module |
//! |---|---|
//! | visitors without a link | [`access`]: one-time links create sessions; [`keys`](access::keys): both are signed |
//! | pages of other sites, foreign host names | [`guard`] |
//! | excessive connections, headers, bodies, requests, delays | [`places`], [`listen`], [`routes`], [`rate`] |
//! | texts that are parsed as markup | pages are constant; names are text nodes, or escaped |

mod access;
mod clock;
mod engine;
mod guard;
mod journal;
mod layered;
mod lines;
mod listen;
mod overview;
mod pages;
mod places;
mod rate;
mod routes;
mod schedule;
mod told;
mod view;
mod words;

use std::net::{IpAddr, SocketAddr};
use std::path::PathBuf;
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use mission::kinds::layers;
use mission::kinds::layers::execution::LayeredExecution;
use mission::kinds::schedule::execution::{Execution, Refusal, Settings};
use mission::kinds::schedule::problem::{AgentKind, Problem};
use tokio::sync::watch;
use twox_hash::XxHash3_128;

use self::access::keys::{Keys, Page};
use self::access::{Access, Role};
use self::engine::Engine;
use self::engine::world::World;
use self::guard::Hosts;
use self::journal::Journal;
use self::layered::Layered;
use self::rate::Bucket;
use self::routes::App;
use self::schedule::Schedule;
use self::view::Published;

pub use self::access::keys::{NoKeys, new_link};
pub use self::engine::Resuming;
pub use self::journal::NoJournal;
pub use self::places::{OF_AN_ADDRESS, STRANGERS};

/// A schedule to be served.
#[derive(Clone, Debug)]
pub struct Mission {
    /// Name of the mission.
    pub name: String,
    /// The planning problem.
    pub problem: Problem,
    /// Settings of the execution; the server sets the agents that report their operations: those with a page.
    pub settings: Settings,
}

/// A mission of layers to be served.
#[derive(Clone, Debug)]
pub struct LayersMission {
    /// Name of the mission.
    pub name: String,
    /// The planning problem.
    pub problem: layers::problem::Problem,
    /// Settings of the execution; the server sets the agents that report their tasks: those with a page.
    pub settings: layers::execution::Settings,
}

/// A mission of either kind to be served.
#[derive(Clone, Debug)]
pub enum Served {
    /// A schedule, in which robots serve agents.
    Schedule(Mission),
    /// A team that performs layers of tasks.
    Layers(LayersMission),
}

impl From<Mission> for Served {
    fn from(mission: Mission) -> Served {
        Served::Schedule(mission)
    }
}

impl From<LayersMission> for Served {
    fn from(mission: LayersMission) -> Served {
        Served::Layers(mission)
    }
}

/// Options of the server.
#[derive(Clone, Debug)]
pub struct Options {
    /// Address to listen on.
    pub bind: IpAddr,
    /// Port; 0: that of the previous server if a journal is continued, else a free one.
    pub port: u16,
    /// Further host names of the server, with their port if it differs.
    pub hosts: Vec<String>,
    /// Mission seconds per real second. More than 0.
    pub speed: f64,
    /// Names of people without a page, whose durations are random.
    pub simulate: Vec<String>,
    /// Path of the journal; an existing file is continued. The file of links and sessions is beside it, with `.key`
    /// appended to the name.
    pub journal: Option<PathBuf>,
    /// True if the clock runs from the start; otherwise the supervisor starts it.
    pub begin: bool,
}

impl Default for Options {
    fn default() -> Options {
        Options {
            bind: IpAddr::from([127, 0, 0, 1]),
            port: 0,
            hosts: Vec::new(),
            speed: 1.0,
            simulate: Vec::new(),
            journal: None,
            begin: false,
        }
    }
}

/// Reason why a mission cannot be served.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "the message says what each field is")]
pub enum NoServer {
    #[error("the mission cannot be executed: {0}")]
    Mission(#[from] Refusal),
    #[error("the mission cannot be executed: {0}")]
    Layers(#[from] layers::execution::Refusal),
    #[error("`--simulate {name}`: the mission has no person of that name; it has {people}")]
    Nobody { name: String, people: String },
    #[error("a speed must be more than 0 and at most 1000, and is {0}")]
    Speed(f64),
    #[error("`--host {0}`: write a name such as `field.example` or `field.example:8080`")]
    Host(String),
    #[error(transparent)]
    Journal(#[from] NoJournal),
    #[error(transparent)]
    Keys(#[from] NoKeys),
    #[error("cannot listen at {address}: {why}")]
    Bind { address: SocketAddr, why: std::io::Error },
    #[error("the mission ended unexpectedly; what was told is in the journal if there is one")]
    Ended,
}

/// A link for a person or the supervisor.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LinkOf {
    /// Name of the person; `None`: the supervisor.
    pub person: Option<String>,
    /// URL of the link.
    pub url: String,
    /// True if an earlier link was opened, whose session this link replaces.
    pub signed_in: bool,
}

/// Problem of a running server, for its operator.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Trouble {
    /// The mission lags behind its clock by this time.
    Behind(Duration),
    /// The journal cannot be written, and reports are rejected; with the reason.
    Unwritten(String),
}

/// A running server.
pub struct Server {
    address: SocketAddr,
    links: Vec<LinkOf>,
    /// Mission time that a journal led to (s), and true if the restored state is the recorded one.
    resumed: Option<(f64, bool)>,
    published: watch::Receiver<Arc<Published>>,
    end: watch::Sender<bool>,
    threads: Vec<JoinHandle<()>>,
}

impl Server {
    /// Plans the mission, replays the journal if there is one, and starts serving.
    ///
    /// # Errors
    ///
    /// The mission has no plan, an option is invalid, or the system refuses an operation.
    pub fn start(mission: impl Into<Served>, options: &Options) -> Result<Server, NoServer> {
        Server::start_and_tell(mission, options, &mut |_| {})
    }

    /// As [`Server::start`]; `tell` is called repeatedly with the progress of replaying a journal, first at its begin.
    ///
    /// # Errors
    ///
    /// As [`Server::start`].
    pub fn start_and_tell(
        mission: impl Into<Served>,
        options: &Options,
        tell: &mut dyn FnMut(Resuming),
    ) -> Result<Server, NoServer> {
        check(options)?;
        let ready = ready(mission.into(), &options.simulate)?;
        let journal = match &options.journal {
            Some(path) => Some(Journal::open(path, &ready.name, &ready.digest)?),
            None => None,
        };
        let pages = ready.pages();
        let mut keys = match &options.journal {
            Some(path) => Keys::beside(path, &ready.name, &ready.digest, pages)?,
            None => Keys::passing(&ready.name, pages)?,
        };
        let wanted = SocketAddr::new(options.bind, options.port);
        let bound = |why| NoServer::Bind { address: wanted, why };
        // Open pages reconnect to the previous address.
        let before = keys.address().filter(|before| options.port == 0 && before.ip() == options.bind);
        let again = before.and_then(|before| std::net::TcpListener::bind(before).ok());
        let listener = again.map_or_else(|| std::net::TcpListener::bind(wanted).map_err(bound), Ok)?;
        listener.set_nonblocking(true).map_err(bound)?;
        let address = listener.local_addr().map_err(bound)?;
        let Ready { name, paged, plans, .. } = ready;
        if let Some(last) = journal.as_ref().and_then(|(_, said)| said.last()) {
            tell(Resuming { time: 0.0, until: last.time });
        }
        let mut engine = Engine::new(&name, plans()?, options.speed);
        let resumed = match journal {
            Some((journal, said)) => Some(engine.resume(journal, &said, tell)?).filter(|_| !said.is_empty()),
            None => None,
        };
        let site = site(address, options);
        keys.begin(&site, address)?;
        let links = links(&keys, &site);
        let access = Access::new(keys);
        let (handle, carries) = engine.start(options.begin);
        let published = handle.published.clone();
        let (end, ended) = watch::channel(false);
        let app =
            App { access: Mutex::new(access), links: Bucket::of_links(), engine: handle, port: address.port(), paged };
        let hosts = Hosts(options.hosts.iter().map(|host| host.to_ascii_lowercase()).collect());
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().map_err(bound)?;
        let answers = std::thread::spawn(move || {
            runtime.block_on(async move {
                let router = routes::router(Arc::new(app), hosts);
                if let Ok(listener) = tokio::net::TcpListener::from_std(listener) {
                    listen::serve(listener, router, ended).await;
                }
            });
            runtime.shutdown_background();
        });
        Ok(Server { address, links, resumed, published, end, threads: vec![answers, carries] })
    }

    /// Returns the listening address.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// Returns a one-time link for the supervisor and one for each person with a page.
    pub fn links(&self) -> &[LinkOf] {
        &self.links
    }

    /// Returns the mission time that a journal led to (s), and true if the restored state is the recorded one; `None`
    /// for a new mission.
    pub fn resumed(&self) -> Option<(f64, bool)> {
        self.resumed
    }

    /// Returns a sender that ends the server: send `true`.
    pub fn end(&self) -> watch::Sender<bool> {
        self.end.clone()
    }

    /// Waits until the server has ended.
    ///
    /// # Errors
    ///
    /// It ended unexpectedly.
    pub fn wait(self) -> Result<(), NoServer> {
        self.wait_and_tell(&mut |_| {})
    }

    /// As [`Server::wait`]; `tell` is called repeatedly with each trouble while it lasts.
    ///
    /// # Errors
    ///
    /// As [`Server::wait`].
    pub fn wait_and_tell(self, tell: &mut dyn FnMut(Trouble)) -> Result<(), NoServer> {
        let pause = Duration::from_millis(50);
        let unwritten = || self.published.borrow().unwritten.clone().map(Trouble::Unwritten);
        while !*self.end.borrow() {
            if self.threads.iter().any(JoinHandle::is_finished) {
                return Err(NoServer::Ended);
            }
            let behind = self.published.borrow().behind.map(Trouble::Behind);
            behind.into_iter().chain(unwritten()).for_each(&mut *tell);
            std::thread::sleep(pause);
        }
        // A plan may be in progress; all reports are on the disk already.
        let patience = Instant::now() + Duration::from_secs(10);
        while Instant::now() < patience && !self.threads.iter().all(JoinHandle::is_finished) {
            std::thread::sleep(pause);
        }
        unwritten().into_iter().for_each(tell);
        Ok(())
    }
}

fn check(options: &Options) -> Result<(), NoServer> {
    if !(options.speed > 0.0 && options.speed <= 1000.0) {
        return Err(NoServer::Speed(options.speed));
    }
    let plain = |host: &&String| {
        let known = |c: char| c.is_ascii_alphanumeric() || matches!(c, '.' | '-' | ':' | '[' | ']');
        !host.is_empty() && host.chars().all(known)
    };
    match options.hosts.iter().find(|host| !plain(host)) {
        Some(host) => Err(NoServer::Host(host.clone())),
        None => Ok(()),
    }
}

/// A mission that can be served and has not been planned.
struct Ready {
    name: String,
    digest: String,
    /// Labels of the agents, by their number on pages.
    names: Vec<String>,
    /// True for each agent with a page.
    paged: Vec<bool>,
    /// Plans the mission, which may take a while.
    plans: Box<dyn FnOnce() -> Result<Box<dyn World>, NoServer>>,
}

fn ready(mission: Served, simulate: &[String]) -> Result<Ready, NoServer> {
    match mission {
        Served::Schedule(Mission { name, problem, settings }) => {
            let human = |agent: &mission::kinds::schedule::problem::Agent| agent.kind == AgentKind::Human;
            let agents = problem.agents.iter().map(|agent| (agent.name.as_str(), human(agent))).collect::<Vec<_>>();
            let paged = paged(&agents, simulate)?;
            let told = (0..paged.len()).filter(|agent| paged[*agent]).collect();
            let settings = Settings { told, ..settings };
            Ok(Ready {
                name,
                digest: digest(&(&problem, &settings)),
                names: problem.agents.iter().map(|agent| problem.labels.member(&agent.name).to_string()).collect(),
                paged,
                plans: Box::new(move || Ok(Box::new(Schedule::new(Execution::new(problem, settings)?)))),
            })
        }
        Served::Layers(LayersMission { name, problem, settings }) => {
            let people = layered::people(&problem);
            let names: Vec<String> = people.iter().map(|agent| problem.agents[*agent].name.clone()).collect();
            let labels = names.iter().map(|name| problem.labels.member(name).to_string()).collect();
            let paged = paged(&names.iter().map(|name| (name.as_str(), true)).collect::<Vec<_>>(), simulate)?;
            let told = people.iter().zip(&paged).filter(|(_, has)| **has).map(|(agent, _)| *agent).collect();
            let settings = layers::execution::Settings { told, ..settings };
            Ok(Ready {
                name,
                digest: digest(&("layers", &problem, &settings)),
                names: labels,
                paged,
                plans: Box::new(move || Ok(Box::new(Layered::new(LayeredExecution::new(problem, settings)?)))),
            })
        }
    }
}

impl Ready {
    /// Returns the pages, that of the supervisor first.
    fn pages(&self) -> Vec<Page> {
        let people = self.names.iter().enumerate().filter(|(agent, _)| self.paged.get(*agent) == Some(&true));
        let pages = people.map(|(agent, name)| Page::new(Role::Person(agent), Some(name.clone())));
        std::iter::once(Page::new(Role::Supervisor, None)).chain(pages).collect()
    }
}

/// Returns for each agent (name, and true for a person) whether it has a page: people who are not simulated have one.
fn paged(agents: &[(&str, bool)], simulate: &[String]) -> Result<Vec<bool>, NoServer> {
    let people: Vec<&str> = agents.iter().filter(|agent| agent.1).map(|agent| agent.0).collect();
    if let Some(name) = simulate.iter().find(|name| !people.contains(&name.as_str())) {
        let people = if people.is_empty() { "none".into() } else { people.join(", ") };
        return Err(NoServer::Nobody { name: name.clone(), people });
    }
    let has = |(name, human): &(&str, bool)| *human && !simulate.iter().any(|other| other == name);
    Ok(agents.iter().map(has).collect())
}

/// Returns a digest of the mission.
fn digest(mission: &impl serde::Serialize) -> String {
    // Serialization cannot fail: the mission consists of numbers, texts and lists.
    let text = serde_json::to_string(mission).unwrap_or_default();
    format!("{:032x}", XxHash3_128::oneshot(text.as_bytes()))
}

/// Returns the base URL of the pages for links.
fn site(address: SocketAddr, options: &Options) -> String {
    let host = match options.hosts.first() {
        Some(named) if named.contains(':') => named.clone(),
        Some(named) => format!("{named}:{}", address.port()),
        None if address.ip().is_unspecified() => format!("localhost:{}", address.port()),
        None => address.to_string(),
    };
    format!("http://{host}")
}

fn links(keys: &Keys, site: &str) -> Vec<LinkOf> {
    let link = |page: &Page| {
        let url = format!("{site}{}", keys.path(page.role).unwrap_or_default());
        LinkOf { person: page.person.clone(), url, signed_in: page.opened.is_some() }
    };
    keys.pages().iter().map(link).collect()
}
