//! Hostile and faulty clients.

use std::io::Write;
use std::time::{Duration, Instant};

use hierarq::serve::Options;
use proptest::prelude::*;
use serde_json::json;

use super::client::{Client, may, read};
use super::{ANNA, M1, Running};

#[test]
fn every_answer_forbids_what_no_page_needs() {
    let on = Running::standing();
    let (anna, stranger) = (on.anna(), on.stranger());
    let answers = [
        anna.get("/person/2/"),
        anna.get("/static/person.js"),
        stranger.get("/"),
        stranger.get("/no"),
        stranger.get("/person/2/"),
        stranger.ask("PUT", "/", &[], ""),
        stranger.ask("GET", "/", &[("Host", "evil.example")], ""),
        stranger.ask("POST", "/", &[], "x"),
    ];
    for answer in answers {
        let policy = answer.header("content-security-policy").expect("a policy");
        assert!(policy.contains("default-src 'none'") && policy.contains("frame-ancestors 'none'"), "{policy}");
        assert!(!policy.contains("unsafe") && !policy.contains('*'), "{policy}");
        assert_eq!(answer.header("x-content-type-options"), Some("nosniff"));
        assert_eq!(answer.header("cache-control"), Some("no-store"));
        assert_eq!(answer.header("referrer-policy"), Some("same-origin"));
        assert!(answer.headers.iter().all(|(name, _)| !name.starts_with("access-control")));
    }
}

#[test]
fn pages_hold_no_script_no_style_and_nothing_from_elsewhere() {
    let on = Running::standing();
    let (anna, supervisor) = (on.anna(), on.supervisor());
    let files =
        ["/static/person.js", "/static/supervisor.js", "/static/common.js", "/static/page.css", "/static/plan.css"];
    let texts = [anna.get("/person/2/"), supervisor.get("/supervisor/"), anna.get(&on.link(Some("<b>ben</b>")))];
    for page in &texts {
        assert_eq!(page.status, 200);
        for bad in ["<style", " style=", "onclick", "javascript:", "http:", "https:", "<b>ben"] {
            assert!(!page.body.contains(bad), "{bad} in {}", page.body);
        }
        let scripts = page.body.matches("<script").count();
        assert_eq!(scripts, page.body.matches("<script type=\"module\" src=\"/static/").count());
    }
    for file in files {
        let answer = anna.get(file);
        assert_eq!(answer.status, 200, "{file}");
        for bad in ["innerHTML", "outerHTML", "insertAdjacentHTML", "document.write", "eval(", "@import", "url("] {
            assert!(!answer.body.contains(bad), "{bad} in {file}");
        }
    }
    for picture in ["/supervisor/gantt.svg", "/supervisor/map.svg"] {
        let answer = supervisor.get(picture);
        assert_eq!(answer.header("content-type"), Some("image/svg+xml; charset=utf-8"));
        assert!(answer.body.contains("&lt;b&gt;ben") && !answer.body.contains("<b>"), "{}", answer.body);
    }
}

#[test]
fn a_foreign_host_name_is_refused() {
    let on = Running::with(&Options { hosts: vec!["Field.example".into()], ..Options::default() });
    let link = on.link_at("Field.example");
    let stranger = on.stranger();
    let port = on.server().address().port();
    for host in ["evil.example", &format!("evil.example:{port}"), "127.0.0.1", "127.0.0.1:1", "[::1]", "", "localhost"]
    {
        let answer = stranger.ask("GET", &link, &[("Host", host)], "");
        // An invalid host is rejected before any processing.
        assert!(matches!(answer.status, 400 | 421), "{host}: {answer:?}");
        assert!(!answer.body.contains("anna"));
    }
    for host in [
        format!("127.0.0.1:{port}"),
        format!("localhost:{port}"),
        "field.example".into(),
        format!("field.example:{port}"),
    ] {
        assert_eq!(stranger.ask("GET", &link, &[("Host", &host)], "").status, 200, "{host}");
    }
    let none = stranger.raw(b"GET / HTTP/1.1\r\nConnection: close\r\n\r\n");
    assert!(matches!(none.status, 400 | 421), "{none:?}");
}

#[test]
fn another_site_changes_nothing() {
    let on = Running::at_speed(1.0);
    let (anna, supervisor) = (on.anna(), on.supervisor());
    anna.until(may("done"));
    let ours = anna.origin();
    let kind = ("Content-Type", "application/json");
    let body = json!({ "what": "done", "operation": 0 }).to_string();
    let attempts: [&[(&str, &str)]; 7] = [
        &[kind],
        &[kind, ("Origin", "null")],
        &[kind, ("Origin", "http://evil.example")],
        &[kind, ("Origin", "http://127.0.0.1")],
        &[kind, ("Origin", &ours), ("Sec-Fetch-Site", "cross-site")],
        &[kind, ("Origin", &ours), ("Sec-Fetch-Site", "same-site")],
        &[kind, ("Origin", &ours), ("Origin", "http://evil.example")],
    ];
    for headers in attempts {
        assert_eq!(anna.ask("POST", "/person/2/tell", headers, &body).status, 403, "{headers:?}");
    }
    // A form of another site cannot send JSON; our pages only send JSON.
    let form = [("Origin", ours.as_str()), ("Content-Type", "text/plain")];
    assert_eq!(anna.ask("POST", "/person/2/tell", &form, &body).status, 415);
    // No session is created by a foreign page.
    let link = on.link(Some("<b>ben</b>"));
    assert_eq!(on.stranger().ask("POST", &link, &[("Origin", "http://evil.example")], "").status, 403);
    assert_eq!(on.stranger().get(&link).status, 200, "and the link is not used up");
    // Pictures are only for our own page.
    let embedded = [("Sec-Fetch-Site", "cross-site"), ("Sec-Fetch-Mode", "no-cors"), ("Sec-Fetch-Dest", "image")];
    assert_eq!(supervisor.ask("GET", "/supervisor/map.svg", &embedded, "").status, 403);
    assert!(may("done")(&anna.state()), "she still works");
    assert_eq!(anna.ask("OPTIONS", "/person/2/tell", &[("Origin", "http://evil.example")], "").status, 405);
}

#[test]
fn what_is_too_large_is_not_read() {
    let on = Running::standing();
    let anna = on.anna();
    let large = format!("{{\"what\":\"done\",\"operation\":0,\"x\":\"{}\"}}", "x".repeat(5000));
    assert_eq!(anna.post("/person/2/tell", &large).status, 413);
    let (origin, json) = (anna.origin(), "application/json");
    let announced = [("Origin", origin.as_str()), ("Content-Type", json), ("Content-Length", "9999999999")];
    assert_eq!(anna.ask("POST", "/person/2/tell", &announced, "{}").status, 413);
    let chunked = [("Origin", origin.as_str()), ("Content-Type", json), ("Transfer-Encoding", "chunked")];
    let chunks = format!("1388\r\n{}\r\n0\r\n\r\n", "x".repeat(5000));
    assert_eq!(anna.ask("POST", "/person/2/tell", &chunked, &chunks).status, 413);
    let long = "x".repeat(100_000);
    assert!(matches!(on.stranger().get(&format!("/{long}")).status, 0 | 414 | 431));
    assert!(matches!(on.stranger().ask("GET", "/", &[("X", &long)], "").status, 0 | 431));
    let many: Vec<(&str, &str)> = (0..1000).map(|_| ("X", "y")).collect();
    assert!(matches!(on.stranger().ask("GET", "/", &many, "").status, 0 | 431));
    assert_eq!(on.stranger().get("/").status, 200, "others are served as before");
}

#[test]
fn what_is_not_understood_is_refused_with_a_reason() {
    let on = Running::at_speed(1.0);
    let (anna, supervisor) = (on.anna(), on.supervisor());
    for body in [
        "",
        "{",
        "[]",
        "null",
        "{\"what\":\"explode\"}",
        "{\"what\":\"done\",\"operation\":-1}",
        "\u{0}",
        "{\"what\":\"run\"}",
    ] {
        let answer = anna.post("/person/2/tell", body);
        assert_eq!(answer.status, 400, "{body}");
        assert!(answer.said().starts_with("The request is invalid"), "{answer:?}");
    }
    std::thread::sleep(Duration::from_secs(1));
    let odd = [
        (400, json!({ "what": "done", "operation": 99 })),
        (400, json!({ "what": "done", "operation": u64::MAX })),
        (400, json!({ "what": "served", "operation": 1_000_000 })),
        (409, json!({ "what": "served", "operation": 1 })),
        (409, json!({ "what": "feedback", "operation": 0, "wait": 0, "approach": 0, "distance": 0 })),
    ];
    for (status, what) in odd {
        assert_eq!(anna.tell(what.clone()).status, status, "{what}");
    }
    let odd = [
        (400, json!({ "what": "moved", "member": ANNA, "to": [1e300, 0.0] })),
        (400, json!({ "what": "moved", "member": ANNA })),
        (400, json!({ "what": "moved", "member": ANNA, "to": [1, null] })),
        (400, json!({ "what": "moved", "member": ANNA, "to": [1, 2, 3] })),
        (400, json!({ "what": "moved", "member": 77, "to": [0.0, 0.0] })),
        (400, json!({ "what": "moved", "member": M1, "to": [0.0, 0.0] })),
        (400, json!({ "what": "lost", "member": M1, "agent": 0 })),
        (400, json!({ "what": "lost" })),
        (409, json!({ "what": "back", "member": M1 })),
        (400, json!({ "what": "back", "member": 12 })),
        (400, json!({ "what": "invite", "member": 12 })),
        (400, json!({ "what": "late", "member": ANNA, "by": 1e300 })),
    ];
    for (status, what) in odd {
        let answer = supervisor.tell(what.clone());
        assert_eq!(answer.status, status, "{what} {answer:?}");
    }
    assert!(may("done")(&anna.state()), "nothing has changed");
}

#[test]
fn who_asks_too_often_waits() {
    let on = Running::standing();
    let (anna, ben) = (on.anna(), on.ben());
    let answers: Vec<u16> = (0..60).map(|_| anna.get("/person/2/state").status).collect();
    assert!(answers.iter().take(20).all(|status| *status == 200), "{answers:?}");
    assert!(answers.contains(&429), "{answers:?}");
    assert_eq!(ben.get("/person/3/state").status, 200, "others do not wait");
    std::thread::sleep(Duration::from_millis(1500));
    assert_eq!(anna.get("/person/2/state").status, 200);
}

#[test]
fn a_client_that_dawdles_is_left() {
    let on = Running::standing();
    let (anna, stranger) = (on.anna(), on.stranger());
    let begun = Instant::now();
    let mut header = stranger.connect();
    header.write_all(b"GET / HTTP/1.1\r\nHost: ").expect("sent");
    let mut idle = stranger.connect();
    let mut body = anna.connect();
    let headers =
        [("Origin", anna.origin()), ("Content-Type", "application/json".into()), ("Content-Length", "20".into())];
    let headers: Vec<(&str, &str)> = headers.iter().map(|(name, value)| (*name, value.as_str())).collect();
    body.write_all(anna.request("POST", "/person/2/tell", &headers, "{\"what\"").as_bytes()).expect("sent");
    assert_eq!(read(&mut body).status, 408);
    assert!(begun.elapsed() < Duration::from_secs(9));
    assert!(matches!(read(&mut header).status, 0 | 408));
    assert!(matches!(read(&mut idle).status, 0 | 408));
    assert!(begun.elapsed() < Duration::from_secs(20), "both were left long before");
}

#[test]
fn paths_lead_nowhere_else() {
    let on = Running::standing();
    let stranger = on.stranger();
    for path in [
        "/static/../Cargo.toml",
        "/static/..%2fCargo.toml",
        "/static/%2e%2e/x",
        "/../../etc/passwd",
        "//",
        "/static/",
        "/person//",
        "/person/2/%00",
        "/p/",
        "/s/%ff%fe",
    ] {
        let status = stranger.get(path).status;
        assert!(matches!(status, 400 | 401 | 404), "{path}: {status}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn no_bytes_bring_it_down(requests in prop::collection::vec(prop::collection::vec(any::<u8>(), 0..300), 1..4), json in "\\PC{0,80}") {
        let on = shared();
        let stranger = Client::new(on);
        for bytes in &requests {
            let mut stream = stranger.connect();
            let _ = stream.write_all(bytes);
            drop(stream);
        }
        let _ = stranger.post("/supervisor/tell", &json);
        prop_assert_eq!(stranger.get("/").status, 200);
    }
}

/// Returns the address of one server for all cases, which runs until the tests end.
fn shared() -> std::net::SocketAddr {
    static ON: std::sync::OnceLock<std::net::SocketAddr> = std::sync::OnceLock::new();
    *ON.get_or_init(|| {
        let on = Running::standing();
        let address = on.server().address();
        std::mem::forget(on);
        address
    })
}

impl Running {
    /// Returns the path of anna's link if links contain this host.
    fn link_at(&self, host: &str) -> String {
        let links = self.server().links();
        let link = links.iter().find(|link| link.person.as_deref() == Some("anna")).expect("a link");
        let start = format!("http://{host}:{}", self.server().address().port());
        link.url.strip_prefix(&start).expect("at that host").to_string()
    }
}
