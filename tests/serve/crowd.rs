//! More connections than the server's limit, from devices without a link.

use std::io::{ErrorKind, Read, Write};
use std::net::TcpStream;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use hierarq::serve::{OF_AN_ADDRESS, STRANGERS};
use serde_json::json;

use super::Running;
use super::client::Client;

/// Number of simultaneous hostile connections.
const CROWD: usize = 500;

/// Opens a connection with an incomplete header.
fn half_open(of: &Client) -> TcpStream {
    let mut stream = of.connect();
    let _ = stream.write_all(b"GET / HTTP/1.1\r\nHost: ");
    stream.set_nonblocking(true).expect("settable");
    stream
}

fn has_ended(stream: &mut TcpStream) -> bool {
    match stream.read(&mut [0; 64]) {
        Ok(read) => read == 0,
        Err(e) => e.kind() != ErrorKind::WouldBlock,
    }
}

/// Five hundred incomplete headers from the same address as the people, each opened again as soon as it is closed:
/// every report of a session is answered, a page continues to listen, and an invited person still gets in.
#[test]
fn a_crowd_shuts_nobody_out() {
    const { assert!(CROWD > STRANGERS && STRANGERS > OF_AN_ADDRESS) };
    let on = Running::at_speed(1.0);
    let (anna, supervisor, stranger) = (on.anna(), on.supervisor(), on.stranger());
    let mut page = anna.listen();
    let (stop, opened) = (AtomicBool::new(false), AtomicUsize::new(0));
    std::thread::scope(|scope| {
        scope.spawn(|| {
            let mut crowd: Vec<TcpStream> = Vec::new();
            while !stop.load(Ordering::Relaxed) {
                crowd.retain_mut(|stream| !has_ended(stream));
                while crowd.len() < CROWD && !stop.load(Ordering::Relaxed) {
                    crowd.push(half_open(&stranger));
                    opened.fetch_add(1, Ordering::Relaxed);
                }
            }
        });
        while opened.load(Ordering::Relaxed) < CROWD {
            std::thread::yield_now();
        }
        let answers: Vec<u16> = (0..25).map(|_| supervisor.tell(json!({ "what": "replan" })).status).collect();
        assert!(answers.iter().all(|status| *status == 200), "{answers:?}");
        assert_eq!(on.ben().state()["person"]["name"], "<b>ben</b>");
        page.until(|state| state["person"]["messages"].to_string().contains("There is a new plan."));
        stop.store(true, Ordering::Relaxed);
    });
    assert!(opened.load(Ordering::Relaxed) > CROWD, "they kept coming");
}

/// A stranger's connections are replaced by later ones, the oldest first, and their places are released.
#[test]
fn connections_have_a_bound_and_are_given_back() {
    let on = Running::standing();
    let stranger = on.stranger();
    let mut held: Vec<TcpStream> = (0..OF_AN_ADDRESS + 9).map(|_| half_open(&stranger)).collect();
    assert_eq!(stranger.get("/").status, 200);
    for stream in &mut held[..10] {
        stream.set_nonblocking(false).expect("settable");
        let mut rest = Vec::new();
        let _ = stream.read_to_end(&mut rest);
        assert!(rest.is_empty(), "the oldest have ended without an answer");
    }
    drop(held);
    assert_eq!(stranger.get("/").status, 200);
}
