//! Conversations with a real server on loopback: good ones, and every way in which one goes wrong.
use crate::common;

use std::time::{Duration, Instant};

use common::{Reply, Server};
use hierarq_context::endpoint::{AskError, Chat, Endpoint, EndpointError, MAX_ANSWER, Message, Speaker};
use hierarq_context::generate::{Bounds, GenerateError, Question, generate};
use hierarq_context::transcript::{self, Exchange, Replay};

const QUICK: Bounds =
    Bounds { attempts: 3, trials: 3, pause: Duration::from_millis(5), longest_pause: Duration::from_millis(400) };

fn endpoint(server: &Server, timeout: Duration) -> Endpoint {
    Endpoint::new(&server.address, "tiny", Some("secret"), timeout).unwrap()
}

fn question() -> Vec<Message> {
    vec![Message::new(Speaker::System, "You plan."), Message::new(Speaker::User, "Plan.")]
}

fn asked(prompt: &[Message]) -> Question<'_> {
    Question { prompt, keys: &[] }
}

/// Takes `{"good": n}` alone.
fn judge(text: &str) -> Result<i64, Vec<String>> {
    let value: serde_json::Value = serde_json::from_str(text).map_err(|error| vec![error.to_string()])?;
    value["good"].as_i64().ok_or_else(|| vec!["`good` is missing".to_string(), "try `good`".to_string()])
}

/// Asks a server with these replies; what came of it, what was kept, and what the server saw.
fn talk(replies: Vec<Reply>) -> (Result<i64, GenerateError>, Vec<Exchange>, Server) {
    let server = Server::new(replies);
    let mut kept = Vec::new();
    let mut endpoint = endpoint(&server, Duration::from_millis(300));
    let outcome = generate(&mut endpoint, &asked(&question()), &QUICK, judge, |exchange| {
        kept.push(exchange.clone());
        Ok(())
    });
    (outcome, kept, server)
}

fn says(text: &str) -> Reply {
    Reply::Says(text.to_string())
}

#[test]
fn a_good_answer_is_taken_at_once() {
    let (outcome, kept, server) = talk(vec![says("Sure:\n```json\n{\"good\": 7}\n```")]);
    assert_eq!(outcome, Ok(7));
    assert_eq!(kept.len(), 1);
    assert!(kept[0].refused.is_empty());
    let asked = server.asked();
    assert!(asked[0].0.starts_with("POST /v1/chat/completions HTTP/1.1"), "{}", asked[0].0);
    assert!(asked[0].0.to_lowercase().contains("authorization: bearer secret"));
    assert_eq!(asked[0].1["model"], "tiny");
    assert_eq!(asked[0].1["stream"], false);
    assert_eq!(asked[0].1["messages"][0]["role"], "system");
    assert_eq!(asked[0].1["messages"][1]["content"], "Plan.");
}

#[test]
fn refusals_go_back_to_the_model() {
    let broken = says("{\"good\": ");
    let (outcome, kept, server) = talk(vec![broken, says("{\"bad\": 1}"), says("{\"good\": 3}")]);
    assert_eq!(outcome, Ok(3));
    let asked = server.asked();
    assert_eq!(asked.len(), 3);
    let last = asked[2].1["messages"].as_array().unwrap();
    let speakers: Vec<&str> = last.iter().map(|m| m["role"].as_str().unwrap()).collect();
    assert_eq!(speakers, ["system", "user", "assistant", "user", "assistant", "user"]);
    assert!(last[3]["content"].as_str().unwrap().contains("EOF while parsing"));
    assert!(last[5]["content"].as_str().unwrap().contains("- `good` is missing\n- try `good`\n"));
    // The transcript holds each message once, and what was said of each answer.
    let messages: Vec<usize> = kept.iter().map(|exchange| exchange.asked.len()).collect();
    assert_eq!(messages, [2, 2, 2]);
    assert_eq!(kept[1].refused.len(), 2);
}

#[test]
fn attempts_are_bounded() {
    let (outcome, kept, server) = talk(vec![says("no"), says("no"), says("never"), says("{\"good\": 1}")]);
    let reasons = vec!["the answer holds no JSON object; answer with one object and nothing else".to_string()];
    assert_eq!(outcome, Err(GenerateError::Refused { attempts: 3, reasons }));
    assert_eq!((kept.len(), server.asked().len()), (3, 3));
}

#[test]
fn an_answer_that_stopped_too_early_is_an_attempt() {
    let (outcome, kept, _) = talk(vec![Reply::Stops("length"), says("{\"good\": 2}")]);
    assert_eq!(outcome, Ok(2));
    assert_eq!(kept[0].answered, Err(AskError::Unfinished("length".to_string())));
    assert_eq!(kept[1].attempt, 2);
}

#[test]
fn a_server_in_trouble_is_asked_again() {
    let busy = Reply::Status(429, "Retry-After: 0.1\r\n", "{}".to_string());
    let down = Reply::Status(503, "", "overloaded\nat once".to_string());
    let begun = Instant::now();
    let (outcome, kept, _) = talk(vec![busy, down, says("{\"good\": 4}")]);
    assert_eq!(outcome, Ok(4));
    assert!(begun.elapsed() >= Duration::from_millis(100));
    assert_eq!(kept[0].answered, Err(AskError::Busy { wait: Some(0.1) }));
    assert_eq!(kept[1].answered, Err(AskError::Status { status: 503, text: "overloaded".to_string() }));
    assert_eq!(kept.iter().map(|e| (e.attempt, e.trial)).collect::<Vec<_>>(), [(1, 1), (1, 2), (1, 3)]);
    // A question is stored once for each time that it is asked.
    assert_eq!(kept[2].asked, question());
}

#[test]
fn one_that_stays_in_trouble_is_given_up() {
    for (reply, error) in [
        (Reply::Closes, None),
        (Reply::Truncated, None),
        (Reply::Silent(Duration::from_millis(600)), Some(AskError::Timeout(0.3))),
        (Reply::Status(429, "Retry-After: 1e300\r\n", String::new()), Some(AskError::Busy { wait: Some(1e300) })),
        (Reply::Status(429, "Retry-After: NaN\r\n", String::new()), Some(AskError::Busy { wait: None })),
    ] {
        let (outcome, kept, _) = talk(vec![reply.clone(); 3]);
        assert_eq!(kept.len(), 3, "{reply:?}");
        match (outcome, error) {
            (Err(GenerateError::Server(is)), Some(error)) => assert_eq!(is, error),
            (Err(GenerateError::Server(AskError::Connection(_))), None) => {}
            (outcome, _) => panic!("{reply:?}: {outcome:?}"),
        }
    }
}

#[test]
fn what_will_not_change_is_not_asked_again() {
    let form = Reply::Status(200, "", "<html>".to_string());
    let no_choice = Reply::Status(200, "", "{\"choices\": []}".to_string());
    let redirect = Reply::Status(307, "Location: http://127.0.0.1:1/\r\n", String::new());
    let refused = Reply::Status(401, "", "{\"error\": \"no such key\"}".to_string());
    for reply in [form, no_choice, redirect, refused, Reply::Endless(MAX_ANSWER as usize + (1 << 20)), Reply::NoText] {
        let (outcome, kept, _) = talk(vec![reply.clone(), says("{\"good\": 1}")]);
        assert_eq!(kept.len(), 1, "{reply:?}");
        assert!(matches!(outcome, Err(GenerateError::Server(_))), "{reply:?}: {outcome:?}");
        if matches!(reply, Reply::NoText) {
            assert_eq!(kept[0].answered, Err(AskError::Form("it is no text in UTF-8".to_string())));
        }
    }
    let words = "{\"choices\": [{\"message\": {\"content\": null, \"refusal\": \"I cannot\"}}]}";
    let (outcome, ..) = talk(vec![Reply::Status(200, "", words.to_string())]);
    assert_eq!(outcome, Err(GenerateError::Server(AskError::Refuses("I cannot".to_string()))));
}

#[test]
fn a_recording_ends_once() {
    let mut kept = 0;
    let ended = generate(&mut Replay::new(Vec::new()), &asked(&question()), &QUICK, judge, |_| {
        kept += 1;
        Ok(())
    });
    assert_eq!((ended, kept), (Err(GenerateError::Server(AskError::RecordingEnds)), 1));
}

#[test]
fn a_transcript_replays() {
    let (outcome, kept, _) = talk(vec![Reply::Closes, says("hm"), says("{\"good\": 5}")]);
    let mut file = Vec::new();
    for exchange in &kept {
        transcript::write(&mut file, exchange).unwrap();
    }
    assert!(!String::from_utf8_lossy(&file).contains("secret"));
    let read = transcript::read(file.as_slice()).unwrap();
    assert_eq!(read, kept);
    let mut again = Vec::new();
    let replayed = generate(&mut Replay::new(read), &asked(&question()), &QUICK, judge, |exchange| {
        again.push(exchange.clone());
        Ok(())
    });
    assert_eq!(replayed, outcome);
    let without_time = |of: &[Exchange]| of.iter().map(|e| Exchange { seconds: 0.0, ..e.clone() }).collect::<Vec<_>>();
    assert_eq!(without_time(&again), without_time(&kept));
    assert!(transcript::read("{}".as_bytes()).unwrap_err().to_string().starts_with("line 1 is no exchange"));
}

#[test]
fn a_transcript_that_cannot_be_kept_ends_the_conversation() {
    let server = Server::new(vec![says("{\"good\": 5}")]);
    let mut endpoint = endpoint(&server, Duration::from_secs(1));
    let outcome =
        generate(&mut endpoint, &asked(&question()), &QUICK, judge, |_| Err(std::io::Error::other("disk full")));
    assert_eq!(outcome, Err(GenerateError::Transcript("disk full".to_string())));
}

#[test]
fn keys_do_not_travel_in_clear_text() {
    let time = Duration::from_secs(1);
    let new = |address: &str, key: Option<&str>| Endpoint::new(address, "m", key, time).map(|e| e.url().to_string());
    let clear = Err(EndpointError::KeyInClearText("models.example".to_string()));
    assert_eq!(new("http://models.example/v1", Some("k")), clear);
    assert_eq!(new("https://models.example/v1/", Some("k")), Ok("https://models.example/v1/chat/completions".into()));
    for address in ["http://localhost:80/v1", "http://127.0.0.1/v1", "http://[::1]:8080/v1"] {
        assert!(new(address, Some("k")).is_ok(), "{address}");
    }
    assert!(new("http://models.example/v1", None).is_ok());
    assert_eq!(new("https://a/v1", Some("a\nb")), Err(EndpointError::Key));
    for address in ["", "models", "ftp://a/b", "http://", "file:///etc/passwd"] {
        assert_eq!(new(address, None), Err(EndpointError::Address(address.to_string())), "{address}");
    }
}

#[test]
fn nobody_listens() {
    let free = std::net::TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
    let mut endpoint = Endpoint::new(&format!("http://{free}"), "m", None, Duration::from_secs(1)).unwrap();
    assert!(matches!(endpoint.ask(&question()), Err(AskError::Connection(_))));
}
