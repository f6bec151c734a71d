//! `hierarq serve`: a small web server for the people of a mission.
//!
//! One thread owns the mission and lets time pass ([`engine`]); another answers requests. Each person has a page with the
//! plan in words, what comes next, and buttons; whoever supervises has one with the chart, the map and everything that
//! happens. Pages listen to a stream of states and show the latest whole one, so that a reload or a lost connection costs
//! nothing. What is told is written into a journal before it has an effect ([`journal`]).
//!
//! | keeps out | where |
//! |---|---|
//! | whoever has no link | [`access`]: links open once and become sessions; [`keys`]: both are signed |
//! | pages of other sites, foreign host names | [`guard`] |
//! | too much: connections, headers, bodies, requests, patience | [`places`], [`listen`], [`routes`], [`rate`] |
//! | text that is read as markup | pages are constant; names are text nodes, or escaped |

mod access;
mod clock;
mod diary;
mod engine;
mod guard;
mod journal;
mod keys;
mod layered;
mod layered_view;
mod lines;
mod listen;
mod messages;
mod overview;
mod pages;
mod places;
mod rate;
mod routes;
mod schedule;
mod stream;
mod told;
mod view;
mod words;
mod world;

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

use self::access::{Access, Role};
use self::engine::Engine;
use self::guard::Hosts;
use self::journal::Journal;
use self::keys::{Keys, Page};
use self::layered::Layered;
use self::rate::Bucket;
use self::routes::App;
use self::schedule::Schedule;
use self::view::Published;
use self::world::World;

pub use self::engine::Resuming;
pub use self::journal::NoJournal;
pub use self::keys::{NoKeys, new_link};
pub use self::places::{OF_AN_ADDRESS, STRANGERS};

/// A schedule to be served.
#[derive(Clone, Debug)]
pub struct Mission {
    /// Its name.
    pub name: String,
    /// What is planned.
    pub problem: Problem,
    /// How it is executed; who ends operations by telling is decided here, by who has a page.
    pub settings: Settings,
}

/// A mission of layers to be served.
#[derive(Clone, Debug)]
pub struct LayersMission {
    /// Its name.
    pub name: String,
    /// What is planned.
    pub problem: layers::problem::Problem,
    /// How it is executed; who begins and ends tasks by telling is decided here, by who has a page.
    pub settings: layers::execution::Settings,
}

/// A mission of either kind to be served.
#[derive(Clone, Debug)]
pub enum Served {
    /// Robots that serve agents.
    Schedule(Mission),
    /// A team that does layers of tasks.
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

/// How a mission is served.
#[derive(Clone, Debug)]
pub struct Options {
    /// The address to listen at.
    pub bind: IpAddr,
    /// The port; 0: that of the server before where a journal is gone on with, or a free one.
    pub port: u16,
    /// Further host names under which people reach the server, with their port where it is another one.
    pub hosts: Vec<String>,
    /// Seconds of the mission in a second. More than 0.
    pub speed: f64,
    /// People without a page, by name: how long they work is drawn at random.
    pub simulate: Vec<String>,
    /// Where to write what is told; an existing file is gone on with. Beside it, with `.key` behind its name, is the file of
    /// links and sessions.
    pub journal: Option<PathBuf>,
    /// The clock runs from the start; otherwise from when the supervisor lets it.
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

/// Why a mission cannot be served.
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

/// A link of somebody.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LinkOf {
    /// The name of the person; none: the supervisor.
    pub person: Option<String>,
    /// The link, as a whole address.
    pub url: String,
    /// Somebody has opened an earlier one, whose page this link takes over.
    pub signed_in: bool,
}

/// What whoever runs a server should know while it does.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Trouble {
    /// The mission is behind its clock by so much.
    Behind(Duration),
    /// What is told cannot be written into the journal, and is refused; why.
    Unwritten(String),
}

/// A server that runs.
pub struct Server {
    address: SocketAddr,
    links: Vec<LinkOf>,
    /// Time that a journal led to (s), and whether it led to what had been.
    resumed: Option<(f64, bool)>,
    published: watch::Receiver<Arc<Published>>,
    end: watch::Sender<bool>,
    threads: Vec<JoinHandle<()>>,
}

impl Server {
    /// Plans the mission, goes through the journal if there is one, and begins to answer.
    ///
    /// # Errors
    ///
    /// The mission has no plan, an option is wrong, or the system does not let us.
    pub fn start(mission: impl Into<Served>, options: &Options) -> Result<Server, NoServer> {
        Server::start_and_tell(mission, options, &mut |_| {})
    }

    /// The same; `tell` hears, at once and again and again, how far a journal has been gone through.
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
        // Pages that are open look for the server where it was.
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

    /// Where it listens.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// A link for the supervisor and one for each person with a page. Each opens once.
    pub fn links(&self) -> &[LinkOf] {
        &self.links
    }

    /// The time of the mission that a journal led to (s), and whether what it led to is what had been; none: it is a new
    /// mission.
    pub fn resumed(&self) -> Option<(f64, bool)> {
        self.resumed
    }

    /// What ends the server: send `true`.
    pub fn end(&self) -> watch::Sender<bool> {
        self.end.clone()
    }

    /// Waits until it has ended.
    ///
    /// # Errors
    ///
    /// It ended although nobody ended it.
    pub fn wait(self) -> Result<(), NoServer> {
        self.wait_and_tell(&mut |_| {})
    }

    /// The same; `tell` hears of trouble again and again while it lasts.
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
        // Somebody may plan just now; what was told is on the disk already.
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
    /// By agent of the pages: what people read for it.
    names: Vec<String>,
    /// Whether it has a page.
    paged: Vec<bool>,
    /// Plans it, which may take a while.
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
    /// The pages, that of the supervisor first.
    fn pages(&self) -> Vec<Page> {
        let people = self.names.iter().enumerate().filter(|(agent, _)| self.paged.get(*agent) == Some(&true));
        let pages = people.map(|(agent, name)| Page::new(Role::Person(agent), Some(name.clone())));
        std::iter::once(Page::new(Role::Supervisor, None)).chain(pages).collect()
    }
}

/// For each agent, of which is known whether it is a person, whether it has a page: people that are not simulated.
fn paged(agents: &[(&str, bool)], simulate: &[String]) -> Result<Vec<bool>, NoServer> {
    let people: Vec<&str> = agents.iter().filter(|agent| agent.1).map(|agent| agent.0).collect();
    if let Some(name) = simulate.iter().find(|name| !people.contains(&name.as_str())) {
        let people = if people.is_empty() { "none".into() } else { people.join(", ") };
        return Err(NoServer::Nobody { name: name.clone(), people });
    }
    let has = |(name, human): &(&str, bool)| *human && !simulate.iter().any(|other| other == name);
    Ok(agents.iter().map(has).collect())
}

/// A number that differs as soon as the mission does, or is of another kind.
fn digest(mission: &impl serde::Serialize) -> String {
    // All of it are numbers, texts and lists of them, which JSON has.
    let text = serde_json::to_string(mission).unwrap_or_default();
    format!("{:032x}", XxHash3_128::oneshot(text.as_bytes()))
}

/// Where pages are, as links name it.
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
