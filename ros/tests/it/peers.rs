//! Nodes beside independent participants: processes in Python, on CycloneDDS.
//!
//! The tests run where `HIERARQ_PYTHON` names an interpreter with the package `cyclonedds`. Each has a domain of its own.
//! They need loopback with multicast and nothing else; a network namespace is one, where others use the network:
//!
//! ```text
//! unshare -rn sh -c 'ip link set lo up multicast on; ip route add 224.0.0.0/4 dev lo; cargo test -p hierarq-ros'
//! ```

use std::io::Read;
use std::net::UdpSocket;
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicBool, AtomicU16, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use ros::{Ended, Remark, ServiceMapping, Settings};
use runtime::Program;
use runtime::record::All;
use serde_json::{Value, json};

use crate::specs::{arm, program};

/// Time after which a node ends by itself.
const PATIENCE: Duration = Duration::from_secs(60);

/// An interpreter with CycloneDDS, if there is one.
pub fn interpreter() -> Option<String> {
    let python = std::env::var("HIERARQ_PYTHON").ok()?;
    let found = Command::new(&python).args(["-c", "import cyclonedds"]).stderr(Stdio::null()).status();
    found.is_ok_and(|status| status.success()).then_some(python)
}

/// A domain that nobody uses. Ports of domains above 101 are among those that the system gives to anybody.
pub fn domain() -> u16 {
    static NEXT: AtomicU16 = AtomicU16::new(0);
    let first = (std::process::id() % 90) as u16;
    loop {
        let domain = 10 + (first + NEXT.fetch_add(1, Ordering::Relaxed)) % 90;
        // Participants share the port of their domain with each other only.
        if UdpSocket::bind(("0.0.0.0", 7400 + 250 * domain)).is_ok() {
            return domain;
        }
    }
}

/// A participant in another process.
struct Peer {
    child: Child,
    /// True if it kills or stops itself, so that it reports nothing.
    is_lost: bool,
}

impl Peer {
    fn start(python: &str, to_do: &Value) -> Peer {
        let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/peer.py");
        let mut command = Command::new(python);
        if let Some(lost) = to_do.get("loses") {
            // Out of a thousand messages, CycloneDDS drops so many before they are sent.
            let loss = format!("<Internal><Test><XmitLossiness>{lost}</XmitLossiness></Test></Internal>");
            let often = "<Discovery><SPDPInterval>200 ms</SPDPInterval></Discovery>";
            command.env("CYCLONEDDS_URI", format!("<CycloneDDS><Domain>{loss}{often}</Domain></CycloneDDS>"));
        }
        let child = command.arg(script).arg(to_do.to_string()).stdout(Stdio::piped()).spawn();
        let is_lost = to_do.get("dies").or(to_do.get("freezes")).is_some();
        Peer { child: child.expect("an interpreter that starts"), is_lost }
    }

    /// Everything that it saw.
    fn end(mut self) -> Value {
        let mut text = String::new();
        self.child.stdout.take().expect("a pipe").read_to_string(&mut text).expect("a peer that answers");
        assert!(self.child.wait().expect("a peer that ends").success(), "{text}");
        serde_json::from_str(text.lines().last().expect("a peer that answers")).expect("an object")
    }
}

/// A node that has ended.
pub struct NodeRun {
    pub ended: Ended,
    pub remarks: Vec<Remark>,
}

/// Nodes and peers that have ended.
pub struct Scene {
    pub nodes: Vec<NodeRun>,
    /// Reports of the peers that were not lost.
    pub seen: Vec<Value>,
}

/// Runs nodes beside peers in one domain, until the peers have ended. `before_tick` is called by the nodes before each tick,
/// and while they wait, with what they have told.
pub fn play(python: &str, nodes: &[&Program], peers: Vec<Value>, before_tick: &(dyn Fn(&[Remark]) + Sync)) -> Scene {
    let domain = domain();
    let started: Vec<Peer> = peers
        .into_iter()
        .map(|mut to_do| {
            let of = to_do["node_index"].as_u64().unwrap_or(0) as usize;
            let robot = &nodes[of].robot;
            let names: Vec<&str> = robot.model.dofs.iter().map(|d| d.name.as_str()).collect();
            to_do["domain"] = json!(domain);
            to_do["period"] = json!(robot.period);
            to_do["names"] = json!(names);
            if to_do.get("position").is_none() {
                to_do["position"] = json!(robot.home);
            }
            Peer::start(python, &to_do)
        })
        .collect();
    let end = AtomicBool::new(false);
    let live = |program: &Program| {
        let settings =
            Settings { domain, mapping: ServiceMapping::Cyclone, parameters: Default::default(), duration: None };
        let remarks: Arc<Mutex<Vec<Remark>>> = Arc::default();
        let heard = Arc::clone(&remarks);
        let tell: ros::Tell = Arc::new(move |remark: &Remark| heard.lock().expect("a list").push(remark.clone()));
        let (began, told) = (Instant::now(), Arc::clone(&remarks));
        let mut go_on = || {
            let told = told.lock().expect("a list").clone();
            before_tick(&told);
            !end.load(Ordering::Relaxed) && began.elapsed() < PATIENCE
        };
        let ended = ros::run(program, &settings, &mut All(Vec::new()), &mut go_on, &tell).expect("a node that runs");
        let remarks = remarks.lock().expect("a list").clone();
        NodeRun { ended, remarks }
    };
    std::thread::scope(|scope| {
        let live = &live;
        let running: Vec<_> = nodes.iter().map(|program| scope.spawn(move || live(program))).collect();
        let (lost, others): (Vec<Peer>, Vec<Peer>) = started.into_iter().partition(|peer| peer.is_lost);
        let seen = others.into_iter().map(Peer::end).collect();
        end.store(true, Ordering::Relaxed);
        let nodes = running.into_iter().map(|node| node.join().expect("a node that ends")).collect();
        for mut peer in lost {
            // It may have ended by itself.
            let _ = peer.child.kill();
            let _ = peer.child.wait();
        }
        Scene { nodes, seen }
    })
}

/// A run beside one peer.
pub struct Run {
    pub ended: Ended,
    pub remarks: Vec<Remark>,
    pub seen: Value,
}

/// Runs a node beside a robot.
pub fn run(program: &Program, python: &str, to_do: Value) -> Run {
    run_with(program, python, vec![to_do])
}

/// Runs a node beside a robot, which is the first peer, and others.
pub fn run_with(program: &Program, python: &str, peers: Vec<Value>) -> Run {
    let Scene { mut nodes, mut seen } = play(python, &[program], peers, &|_| ());
    let NodeRun { ended, remarks } = nodes.remove(0);
    Run { ended, remarks, seen: seen.remove(0) }
}

/// Position of a joint at the end.
pub fn at(program: &Program, seen: &Value, joint: &str) -> f64 {
    seen["position"][program.robot.model.dof(joint).expect("a joint")].as_f64().expect("a number")
}

/// Texts that a peer has heard.
pub fn texts(seen: &Value, key: &str) -> Vec<String> {
    let all = seen[key].as_array().expect("a list").iter();
    all.map(|x| x.as_str().expect("a text").to_string()).collect()
}

/// A machine in which the first joint follows a signal, and another one goes to a posture. `faults` are transitions of
/// any state, `ros` is the connection.
pub fn following(faults: &str, ros: &str) -> Program {
    program(&text(faults, ros))
}

/// The text of [`following`], without its version.
pub fn text(faults: &str, ros: &str) -> String {
    arm("} ")
        + &format!(
            "signal goal : angle {{ timeout 0.6 s }}
             task there = joint_position {{ target {{ shoulder_pan_joint goal  elbow_joint 1.2 rad }}  gain 3 /s }}
             stack s {{ level limits hard {{ joint_velocity_limits }}  level move {{ there }} }}
             machine m {{ initial wait  {faults}  state wait {{ when present(goal) -> go }}
                         state go {{ stack s }}  state stop {{ when present(goal) -> go }} }}
             run {{ machine m  duration 1 s  ros {{ {ros} }} }}"
        )
}

/// The same, with an answer to a signal that is stale.
pub fn posture() -> Program {
    following("on fault(stale) -> stop", "stale_after 0.6 s")
}
