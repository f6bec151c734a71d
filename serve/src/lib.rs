//! `hierarq serve`: a small web server for the people of a mission.
//!
//! One thread owns the mission and advances its time ([`engine`]); another one serves requests. Each person has a page
//! with the plan in words, the next step, and buttons; the supervisor has one with the chart, the map and all events.
//! Pages listen to a stream of complete states and show the latest one, so that a reload or a lost connection loses
//! nothing. A request is written into a journal before it has an effect ([`journal`]).
//!
//! Contents of pages and effects of requests come from the mission ([`mission::kind::pages`]); nothing here knows a kind of mission.
//!
//! | protection against | module |
//! |---|---|
//! | visitors without a link | [`access`]: one-time links create sessions; [`keys`](access::keys): both are signed |
//! | pages of other sites, foreign host names | [`guard`] |
//! | excessive connections, headers, bodies, requests, delays | [`connections`], [`listen`], [`routes`], [`rate`] |
//! | texts that are parsed as markup | pages are constant; names are text nodes, or escaped |

mod access;
mod clock;
mod connections;
mod engine;
mod guard;
mod journal;
mod lines;
mod listen;
mod pages;
mod published;
mod rate;
mod requests;
mod routes;

use std::net::{IpAddr, SocketAddr};
use std::path::PathBuf;
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use mission::kind::Mission;
use mission::kind::pages::{MissionSession, ServeSettings};
use tokio::sync::watch;
use twox_hash::XxHash3_128;

use self::access::keys::{Keys, Page};
use self::access::{Access, Role};
use self::engine::Engine;
use self::guard::Hosts;
use self::journal::Journal;
use self::published::Published;
use self::rate::Bucket;
use self::routes::App;

pub use self::access::keys::{NoKeys, new_link};
pub use self::connections::{OF_AN_ADDRESS, STRANGERS};
pub use self::engine::Resuming;
pub use self::journal::NoJournal;

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
    /// Names of people without a page, who are simulated.
    pub simulate: Vec<String>,
    /// Seed of random durations; none: everybody without a page takes as long as planned.
    pub seed: Option<u64>,
    /// Maximum number of nodes of a search; none: the default of the kind of mission.
    pub nodes: Option<u64>,
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
            seed: None,
            nodes: None,
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
    Mission(String),
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
    #[error("the mission ended unexpectedly; all requests are in the journal if there is one")]
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
    /// The journal cannot be written, and requests are rejected; with the reason.
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
    pub fn start(name: &str, mission: &dyn Mission, options: &Options) -> Result<Server, NoServer> {
        Server::start_with_progress(name, mission, options, &mut |_| {})
    }

    /// As [`Server::start`]; `progress` is called repeatedly with the progress of replaying a journal, first at its begin.
    ///
    /// # Errors
    ///
    /// As [`Server::start`].
    pub fn start_with_progress(
        name: &str,
        mission: &dyn Mission,
        options: &Options,
        progress: &mut dyn FnMut(Resuming),
    ) -> Result<Server, NoServer> {
        check(options)?;
        let people = people(mission, &options.simulate)?;
        let reporting = people.iter().map(|person| person.member).collect();
        let settings = ServeSettings { sampled: options.seed, reporting, nodes: options.nodes };
        let digest = digest(mission, &settings);
        let journal = match &options.journal {
            Some(path) => Some(Journal::open(path, name, &digest)?),
            None => None,
        };
        let pages = pages(&people);
        let mut keys = match &options.journal {
            Some(path) => Keys::beside(path, name, &digest, pages)?,
            None => Keys::passing(name, pages)?,
        };
        let wanted = SocketAddr::new(options.bind, options.port);
        let bound = |why| NoServer::Bind { address: wanted, why };
        // Open pages reconnect to the previous address.
        let before = keys.address().filter(|before| options.port == 0 && before.ip() == options.bind);
        let again = before.and_then(|before| std::net::TcpListener::bind(before).ok());
        let listener = again.map_or_else(|| std::net::TcpListener::bind(wanted).map_err(bound), Ok)?;
        listener.set_nonblocking(true).map_err(bound)?;
        let address = listener.local_addr().map_err(bound)?;
        if let Some(last) = journal.as_ref().and_then(|(_, lines)| lines.last()) {
            progress(Resuming { time: 0.0, until: last.time });
        }
        let session = MissionSession::new(mission, &settings).map_err(NoServer::Mission)?;
        let mut engine = Engine::new(name, Box::new(session), options.speed);
        let resumed = match journal {
            Some((journal, lines)) => Some(engine.resume(journal, &lines, progress)?).filter(|_| !lines.is_empty()),
            None => None,
        };
        let site = site(address, options);
        keys.begin(&site, address)?;
        let links = links(&keys, &site);
        let access = Access::new(keys);
        let (handle, carries) = engine.start(options.begin);
        let published = handle.published.clone();
        let (end, ended) = watch::channel(false);
        let app = App { access: Mutex::new(access), links: Bucket::of_links(), engine: handle, port: address.port() };
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
        self.wait_with_report(&mut |_| {})
    }

    /// As [`Server::wait`]; `report` is called repeatedly with each trouble while it lasts.
    ///
    /// # Errors
    ///
    /// As [`Server::wait`].
    pub fn wait_with_report(self, report: &mut dyn FnMut(Trouble)) -> Result<(), NoServer> {
        let pause = Duration::from_millis(50);
        let unwritten = || self.published.borrow().unwritten.clone().map(Trouble::Unwritten);
        while !*self.end.borrow() {
            if self.threads.iter().any(JoinHandle::is_finished) {
                return Err(NoServer::Ended);
            }
            let behind = self.published.borrow().behind.map(Trouble::Behind);
            behind.into_iter().chain(unwritten()).for_each(&mut *report);
            std::thread::sleep(pause);
        }
        // A plan may be in progress; all requests are on the disk already.
        let patience = Instant::now() + Duration::from_secs(10);
        while Instant::now() < patience && !self.threads.iter().all(JoinHandle::is_finished) {
            std::thread::sleep(pause);
        }
        unwritten().into_iter().for_each(report);
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

/// A person with a page.
struct Person {
    /// Number of the member.
    member: usize,
    /// Label.
    name: String,
}

/// Role of members who are people, the word of the language.
const HUMAN: &str = "human";

/// Returns the people with a page: those who are not simulated.
fn people(mission: &dyn Mission, simulate: &[String]) -> Result<Vec<Person>, NoServer> {
    let members = mission.members();
    let people: Vec<(usize, &str)> =
        (0..).zip(&members).filter(|of| of.1.role == HUMAN).map(|of| (of.0, of.1.name)).collect();
    if let Some(name) = simulate.iter().find(|name| people.iter().all(|of| of.1 != name.as_str())) {
        let names: Vec<&str> = people.iter().map(|of| of.1).collect();
        let people = if names.is_empty() { "none".into() } else { names.join(", ") };
        return Err(NoServer::Nobody { name: name.clone(), people });
    }
    let paged = people.into_iter().filter(|(_, name)| simulate.iter().all(|other| other != name));
    Ok(paged.map(|(member, name)| Person { member, name: mission.labels().member(name).to_string() }).collect())
}

/// Returns the pages, that of the supervisor first.
fn pages(people: &[Person]) -> Vec<Page> {
    let pages = people.iter().map(|person| Page::new(Role::Person(person.member), Some(person.name.clone())));
    std::iter::once(Page::new(Role::Supervisor, None)).chain(pages).collect()
}

/// Returns a digest of everything that determines a mission, except the requests.
fn digest(mission: &dyn Mission, settings: &ServeSettings) -> String {
    let ServeSettings { sampled, reporting, nodes } = settings;
    let all = serde_json::json!([mission.kind().name, mission.to_value(), sampled, reporting, nodes]);
    format!("{:032x}", XxHash3_128::oneshot(all.to_string().as_bytes()))
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
