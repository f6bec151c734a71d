//! `hierarq serve SPEC [MISSION]`

use std::fmt::Write;
use std::net::IpAddr;
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};

use clap::Args;
use hierarq::project;
use hierarq::serve::{LinkOf, Options, Resuming, Server, Trouble};
use tokio::sync::watch;

use super::{Outcome, SpecOptions, interruption, output};

/// Interval of progress reports while a journal is replayed; lags are reported five times less often.
const PATIENCE: Duration = Duration::from_secs(2);

#[derive(Args)]
pub struct Arguments {
    /// A spec (`*.hq`, `*.yaml`), or a compiled program (`*.json`).
    #[arg(required_unless_present = "link")]
    spec: Option<PathBuf>,
    /// The mission; may be omitted if the spec declares only one.
    mission: Option<String>,
    #[command(flatten)]
    options: SpecOptions,
    /// Address to listen on [default: only this machine].
    #[arg(long, value_name = "ADDRESS", default_value = "127.0.0.1")]
    bind: IpAddr,
    /// The port; 0: that of the previous server if a journal is continued, otherwise a free one.
    #[arg(long, value_name = "PORT", default_value_t = 0)]
    port: u16,
    /// A further host name of the server, such as `field.example`. May be repeated; the links contain the first.
    #[arg(long, value_name = "NAME")]
    host: Vec<String>,
    /// Speed of the mission's clock: seconds of the mission per second.
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0)]
    speed: f64,
    /// A person without a page, whose work is simulated. May be repeated.
    #[arg(long, value_name = "PERSON")]
    simulate: Vec<String>,
    /// Seed of simulated durations.
    #[arg(long, value_name = "SEED", default_value_t = 0)]
    seed: u64,
    /// Record all requests in this file, and continue from an existing record. Links and sessions are stored in `FILE.key`.
    #[arg(long, value_name = "FILE")]
    journal: Option<PathBuf>,
    /// Print a new link to a person's page, or without a name to the supervisor's, and exit. The server with the same journal
    /// continues; opening the link ends the previous page.
    #[arg(long, value_name = "PERSON", num_args = 0..=1, requires = "journal", conflicts_with = "spec")]
    link: Option<Option<String>>,
    /// Maximum number of nodes of a search that improves a constructed plan: more nodes give better plans and longer replies.
    /// A number of nodes ends the search at the same place in every run, so that a journal leads to the same plans. The
    /// default depends on the kind of mission: 0, or as many as take about a second.
    #[arg(long, value_name = "N")]
    nodes: Option<u64>,
    /// Start the clock immediately, not on the supervisor's request.
    #[arg(long)]
    begin: bool,
}

pub fn run(a: &Arguments) -> Result<Outcome, String> {
    match (&a.link, &a.journal, &a.spec) {
        (Some(person), Some(journal), _) => link(journal, person.as_deref()),
        (_, _, Some(spec)) => serve(a, spec),
        _ => Err("name a spec".into()),
    }
}

fn link(journal: &Path, person: Option<&str>) -> Result<Outcome, String> {
    let link = hierarq::serve::new_link(journal, person).map_err(|e| e.to_string())?;
    output::print(&format!("{}\n", link.url));
    Ok(Outcome::Good)
}

fn serve(a: &Arguments, spec: &Path) -> Result<Outcome, String> {
    let compiled = project::load(spec, &a.options.settings());
    if !compiled.is_good() {
        return output::refuse(&compiled.report, spec, false);
    }
    output::show(&compiled.report);
    let mission = project::mission(&compiled.missions, a.mission.as_deref())
        .map_err(|message| format!("{}: {message}", spec.display()))?;
    let options = Options {
        bind: a.bind,
        port: a.port,
        hosts: a.host.clone(),
        speed: a.speed,
        simulate: a.simulate.clone(),
        seed: Some(a.seed),
        nodes: a.nodes,
        journal: a.journal.clone(),
        begin: a.begin,
    };
    let mut last: Option<Instant> = None;
    let mut progress = |at: Resuming| {
        if last.is_none_or(|last| last.elapsed() >= PATIENCE) {
            last = Some(Instant::now());
            output::eprint(&format!("replaying the journal: at {:.0} of {:.0} s\n", at.time, at.until));
        }
    };
    // Installed before the server starts its threads, which would receive the signals otherwise.
    let end: Arc<OnceLock<watch::Sender<bool>>> = Arc::default();
    let ending = Arc::clone(&end);
    let interrupted = move || match ending.get() {
        // Without a receiver, the server has ended already.
        Some(end) => drop(end.send(true)),
        None => std::process::exit(130),
    };
    interruption::answer(interrupted)?;
    let server = Server::start_with_progress(&mission.name, &*mission.kind, &options, &mut progress)
        .map_err(|e| e.to_string())?;
    end.get_or_init(|| server.end());
    output::print(&greeting(a, &mission.name, &server));
    let mut reported: [Option<Instant>; 2] = [None, None];
    let mut report = |trouble: Trouble| {
        let (last, text) = match trouble {
            Trouble::Behind(behind) => {
                let (seconds, speed) = (behind.as_secs_f64(), a.speed);
                let why = format!("planning takes longer than `--speed {speed}` allows");
                (&mut reported[0], format!("the mission is {seconds:.0} s behind its clock: {why}\n"))
            }
            Trouble::Unwritten(why) => {
                (&mut reported[1], format!("requests are rejected, because the journal cannot be written: {why}\n"))
            }
        };
        if last.is_none_or(|last| last.elapsed() >= 5 * PATIENCE) {
            *last = Some(Instant::now());
            output::eprint(&text);
        }
    };
    server.wait_with_report(&mut report).map_err(|e| e.to_string())?;
    Ok(Outcome::Good)
}

/// Returns the links, with hints on how to continue.
fn greeting(a: &Arguments, mission: &str, server: &Server) -> String {
    let mut out = format!("mission {mission} at http://{}\n", server.address());
    if let Some((time, same)) = server.resumed() {
        let _ = writeln!(out, "continues at {time:.1} s, where its journal ends");
        if !same {
            out.push_str(
                "the restored state differs from the recorded one: a search was ended by its time limit, or the file was changed\n",
            );
        }
    }
    let longest =
        server.links().iter().filter_map(|link| link.person.as_ref()).map(|name| hierarq::gantt::columns(name)).max();
    let width = longest.unwrap_or(0).max("supervisor".len());
    out.push_str("each link opens once:\n");
    let name = |link: &LinkOf| link.person.clone().unwrap_or_else(|| "supervisor".into());
    for link in server.links() {
        let person = name(link);
        let space = width.saturating_sub(hierarq::gantt::columns(&person));
        let _ = writeln!(out, "  {person}{:space$}  {}", "", link.url);
    }
    let signed_in: Vec<String> = server.links().iter().filter(|link| link.signed_in).map(name).collect();
    if !signed_in.is_empty() {
        let _ = writeln!(out, "still signed in, until their new link is opened: {}", signed_in.join(", "));
    }
    if !a.bind.is_loopback() {
        out.push_str("pages and links are sent unencrypted: use a network that you trust, or a proxy with HTTPS\n");
    }
    out.push_str(if a.begin { "the clock runs; " } else { "the supervisor starts the clock; " });
    out.push_str("Ctrl-C ends the server\n");
    out
}
