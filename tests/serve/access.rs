//! One-time links, and sessions that open one page.

use std::path::PathBuf;

use hierarq::serve::{Options, new_link};
use serde_json::json;

use super::{ANNA, CARRIER, Running};

#[test]
fn a_link_is_used_by_a_press_and_not_by_a_look() {
    let on = Running::standing();
    let link = on.link(Some("anna"));
    let stranger = on.stranger();
    for _ in 0..3 {
        let shown = stranger.get(&link);
        assert_eq!(shown.status, 200);
        assert!(shown.body.contains("This is the page of anna") && shown.header("set-cookie").is_none());
    }
    let anna = on.anna();
    assert_eq!(anna.home, "/person/2/");
    assert_eq!(anna.state()["person"]["name"], "anna");
}

#[test]
fn a_session_is_kept_from_scripts_and_other_sites() {
    let on = Running::standing();
    let stranger = on.stranger();
    let opened = stranger.ask("POST", &on.link(None), &[("Origin", &stranger.origin())], "");
    let cookie = opened.header("set-cookie").expect("a session");
    for part in ["; HttpOnly", "; SameSite=Strict", "; Path=/"] {
        assert!(cookie.contains(part), "{cookie}");
    }
    assert!(cookie.starts_with(&format!("hierarq_{}_supervisor=", on.server().address().port())), "{cookie}");
    assert!(!cookie.contains("Secure"), "over plain HTTP a browser would drop it: {cookie}");
}

#[test]
fn a_link_that_was_used_says_so() {
    let on = Running::standing();
    let (link, anna, stranger) = (on.link(Some("anna")), on.anna(), on.stranger());
    for answer in [stranger.get(&link), stranger.ask("POST", &link, &[("Origin", &stranger.origin())], "")] {
        assert_eq!(answer.status, 410);
        assert!(answer.body.contains("ask the supervisor for a new link"), "{}", answer.body);
        assert!(answer.header("set-cookie").is_none());
    }
    // The owner of the page is redirected to it by the used link.
    let again = anna.get(&link);
    assert_eq!((again.status, again.header("location")), (303, Some("/person/2/")));
}

#[test]
fn each_page_opens_to_its_own_session_alone() {
    let on = Running::standing();
    let (anna, ben, supervisor, stranger) = (on.anna(), on.ben(), on.supervisor(), on.stranger());
    let pages = [(&anna, "/person/2/"), (&ben, "/person/3/"), (&supervisor, "/supervisor/")];
    for client in [&anna, &ben, &supervisor, &stranger] {
        for (owner, page) in pages {
            for part in ["", "state", "events", "gantt.svg", "map.svg"] {
                if part.ends_with("svg") && page != "/supervisor/" {
                    continue;
                }
                let path = format!("{page}{part}");
                if owner.cookie != client.cookie {
                    assert_eq!(client.get(&path).status, 401, "{path}");
                } else if part != "events" {
                    assert_eq!(client.get(&path).status, 200, "{path}");
                }
            }
            if owner.cookie != client.cookie {
                let told = client.post(&format!("{page}tell"), &json!({ "what": "run" }).to_string());
                assert_eq!(told.status, 401);
            }
        }
    }
    // A worker has no page, and neither has an invalid index.
    for path in ["/person/4/", "/person/99/", "/person/-1/", "/person/x/", "/person/18446744073709551616/"] {
        assert_eq!(anna.get(path).status, 401, "{path}");
    }
}

#[test]
fn guessing_links_is_slow() {
    let on = Running::standing();
    let stranger = on.stranger();
    let answers: Vec<u16> = (0..40).map(|n| stranger.get(&format!("/p/2-{n:x}-{n:032x}")).status).collect();
    assert_eq!(answers[0], 404);
    assert!(answers.iter().filter(|status| **status == 429).count() >= 10, "{answers:?}");
    assert_eq!(stranger.get(&on.link(Some("anna"))).status, 200, "who has a link is not kept waiting by others");
}

#[test]
fn a_new_link_ends_what_the_old_one_opened() {
    let on = Running::standing();
    let (anna, supervisor) = (on.anna(), on.supervisor());
    let mut stream = anna.listen();
    assert!(stream.next().is_some());
    let answer = supervisor.tell(json!({ "what": "invite", "member": ANNA }));
    assert_eq!(answer.status, 200, "{answer:?}");
    let link = answer.json()["link"].as_str().expect("a link").to_string();
    assert_eq!(anna.get("/person/2/state").status, 401);
    while stream.next().is_some() {}
    assert_eq!(on.stranger().get(&on.link(Some("anna"))).status, 404, "the first link is worth nothing");
    let mut other = on.stranger();
    other.open(&link);
    assert_eq!(other.state()["person"]["name"], "anna");
    assert_eq!(supervisor.tell(json!({ "what": "invite", "member": CARRIER })).status, 400, "a worker has no page");
}

fn kept(name: &str) -> Options {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("serve_access");
    std::fs::create_dir_all(&folder).expect("writable");
    let journal = folder.join(name);
    for old in [journal.clone(), folder.join(format!("{name}.key"))] {
        let _ = std::fs::remove_file(old);
    }
    Options { journal: Some(journal), ..Options::default() }
}

/// After a restart of the server every page is still open, at the same address; ended sessions stay invalid, and an
/// unopened link still opens.
#[test]
fn sessions_and_links_outlast_a_server() {
    let options = kept("outlast.journal");
    let on = Running::with(&options);
    let (address, of_ben) = (on.server().address(), on.link(Some("<b>ben</b>")));
    let (stolen, supervisor) = (on.anna(), on.supervisor());
    let answer = supervisor.tell(json!({ "what": "invite", "member": ANNA }));
    let mut anna = on.stranger();
    anna.open(answer.json()["link"].as_str().expect("a link"));
    assert!(on.server().links().iter().all(|link| !link.signed_in));
    on.end();
    let again = Running::with(&options);
    assert_eq!(again.server().address(), address);
    assert_eq!(again.server().links().iter().map(|link| link.signed_in).collect::<Vec<_>>(), [true, true, false]);
    assert_eq!(anna.state()["person"]["name"], "anna");
    assert_eq!(supervisor.tell(json!({ "what": "run" })).status, 200);
    assert_eq!(stolen.get("/person/2/state").status, 401);
    assert_eq!(again.link(Some("<b>ben</b>")), of_ben);
    again.ben();
    again.end();
    // A new key invalidates all sessions of the previous key.
    let key = options.journal.as_ref().expect("a journal").with_extension("journal.key");
    std::fs::remove_file(key).expect("there");
    let other = Running::with(&Options { port: address.port(), ..options });
    assert_eq!(anna.get("/person/2/state").status, 401);
    other.end();
}

/// A supervisor without a session gets a new link while the server runs, which invalidates the old page.
#[test]
fn links_are_made_beside_a_server_that_runs() {
    let options = kept("beside.journal");
    let on = Running::with(&options);
    let journal = options.journal.as_ref().expect("a journal");
    let (lost, address) = (on.supervisor(), format!("http://{}", on.server().address()));
    let made =
        |person| new_link(journal, person).expect("a link").url.strip_prefix(&address).expect("there").to_string();
    let (link, of_anna, unused) = (made(None), made(Some("anna")), on.link(Some("anna")));
    assert_eq!(lost.get("/supervisor/state").status, 200, "until it is opened nothing has ended");
    let (mut supervisor, mut anna) = (on.stranger(), on.stranger());
    supervisor.open(&link);
    anna.open(&of_anna);
    assert_eq!((supervisor.home.as_str(), anna.home.as_str()), ("/supervisor/", "/person/2/"));
    assert_eq!(lost.get("/supervisor/state").status, 401);
    assert_eq!(on.stranger().get(&link).status, 410, "it opens once");
    assert_eq!(on.stranger().get(&unused).status, 404, "a newer one has taken its place");
    on.end();
    // Again while no server is running.
    let link = made(None);
    let again = Running::with(&options);
    assert_eq!(supervisor.state()["running"], false);
    let mut other = again.stranger();
    other.open(&link);
    assert_eq!(supervisor.get("/supervisor/state").status, 401);
}

#[test]
fn the_supervisor_sees_who_has_a_page_open() {
    let on = Running::standing();
    let supervisor = on.supervisor();
    let page = |n: usize| supervisor.state()["members"][n]["page"].as_str().map(str::to_string);
    assert_eq!([page(2), page(3), page(4)].map(Option::unwrap), ["link not opened", "link not opened", "simulated"]);
    let anna = on.anna();
    let mut stream = anna.listen();
    stream.next().expect("a state");
    assert_eq!(page(2).as_deref(), Some("open"));
    drop(stream);
    supervisor.until(|state| state["members"][2]["page"] == "closed");
}
