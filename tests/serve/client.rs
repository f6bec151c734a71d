//! A client with full control over its requests.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::time::{Duration, Instant};

use serde_json::{Value as Json, json};

/// A client of a server.
#[derive(Clone, Debug)]
pub struct Client {
    pub address: SocketAddr,
    pub cookie: Option<String>,
    /// Path of its page, with a trailing slash.
    pub home: String,
}

/// A response.
#[derive(Clone, Debug)]
pub struct Answer {
    pub status: u16,
    pub headers: Vec<(String, String)>,
    pub body: String,
}

impl Answer {
    pub fn header(&self, name: &str) -> Option<&str> {
        self.headers.iter().find(|(is, _)| is == name).map(|(_, value)| value.as_str())
    }

    pub fn json(&self) -> Json {
        serde_json::from_str(&self.body).unwrap_or_else(|e| panic!("{e}: {}", self.body))
    }

    /// Returns the message of the response: a confirmation, or the reason for the rejection.
    pub fn said(&self) -> String {
        let json = self.json();
        let text = json["said"].as_str().or(json["refused"].as_str());
        text.expect("it says something").to_string()
    }
}

impl Client {
    pub fn new(address: SocketAddr) -> Client {
        Client { address, cookie: None, home: String::new() }
    }

    /// Sends raw bytes, and reads until the server closes the connection.
    pub fn raw(&self, bytes: &[u8]) -> Answer {
        let mut stream = self.connect();
        // A server that rejects a request early closes the connection before everything is sent.
        let _ = stream.write_all(bytes);
        read(&mut stream)
    }

    pub fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect(self.address).expect("it listens");
        stream.set_read_timeout(Some(Duration::from_secs(30))).expect("settable");
        stream
    }

    /// Sends a request with these headers, in addition to `Host` and the cookie, unless they replace them.
    pub fn ask(&self, method: &str, path: &str, headers: &[(&str, &str)], body: &str) -> Answer {
        self.raw(self.request(method, path, headers, body).as_bytes())
    }

    pub fn request(&self, method: &str, path: &str, headers: &[(&str, &str)], body: &str) -> String {
        let mut text = format!("{method} {path} HTTP/1.1\r\nConnection: close\r\n");
        let given = |name: &str| headers.iter().any(|(is, _)| is.eq_ignore_ascii_case(name));
        if !given("host") {
            text += &format!("Host: {}\r\n", self.address);
        }
        if let Some(cookie) = self.cookie.as_ref().filter(|_| !given("cookie")) {
            text += &format!("Cookie: {cookie}\r\n");
        }
        if !body.is_empty() && !given("content-length") && !given("transfer-encoding") {
            text += &format!("Content-Length: {}\r\n", body.len());
        }
        for (name, value) in headers {
            text += &format!("{name}: {value}\r\n");
        }
        text + "\r\n" + body
    }

    pub fn get(&self, path: &str) -> Answer {
        self.ask("GET", path, &[], "")
    }

    pub fn origin(&self) -> String {
        format!("http://{}", self.address)
    }

    /// Sends a request in the same form as the page's script.
    pub fn post(&self, path: &str, body: &str) -> Answer {
        let headers = [("Origin", self.origin()), ("Content-Type", "application/json".into())];
        let headers: Vec<(&str, &str)> = headers.iter().map(|(name, value)| (*name, value.as_str())).collect();
        self.ask("POST", path, &headers, body)
    }

    /// Opens a link like a person: loads it, and presses the button.
    pub fn open(&mut self, link: &str) {
        assert_eq!(self.get(link).status, 200);
        let answer = self.ask("POST", link, &[("Origin", &self.origin())], "");
        assert_eq!(answer.status, 303, "{answer:?}");
        let cookie = answer.header("set-cookie").expect("a session");
        self.cookie = cookie.split(';').next().map(str::to_string);
        self.home = answer.header("location").expect("a page").to_string();
    }

    /// Sends a request to the server.
    pub fn tell(&self, what: Json) -> Answer {
        self.post(&format!("{}tell", self.home), &what.to_string())
    }

    /// Sends a report to a server that may die meanwhile; returns status 0 without a response.
    pub fn attempt(&self, what: Json) -> u16 {
        let headers = [("Origin", self.origin()), ("Content-Type", "application/json".into())];
        let headers: Vec<(&str, &str)> = headers.iter().map(|(name, value)| (*name, value.as_str())).collect();
        let request = self.request("POST", &format!("{}tell", self.home), &headers, &what.to_string());
        let Ok(mut stream) = TcpStream::connect(self.address) else { return 0 };
        let _ = stream.set_read_timeout(Some(Duration::from_secs(30)));
        let _ = stream.write_all(request.as_bytes());
        read(&mut stream).status
    }

    /// Sends a request about this operation.
    pub fn press(&self, what: &str, operation: u64) -> Answer {
        self.tell(json!({ "what": what, "operation": operation }))
    }

    /// Sends a request about this task of a mission of layers.
    pub fn press_task(&self, what: &str, task: u64) -> Answer {
        self.tell(json!({ "what": what, "task": task }))
    }

    /// Returns the state of the page.
    pub fn state(&self) -> Json {
        let answer = self.get(&format!("{}state", self.home));
        assert_eq!(answer.status, 200, "{answer:?}");
        answer.json()
    }

    /// Waits until the state satisfies a condition, and returns it.
    pub fn until(&self, wanted: impl Fn(&Json) -> bool) -> Json {
        let end = Instant::now() + Duration::from_secs(30);
        loop {
            let state = self.state();
            if wanted(&state) {
                return state;
            }
            assert!(Instant::now() < end, "never: {state:#}");
            std::thread::sleep(Duration::from_millis(250));
        }
    }

    /// Opens the stream of states.
    pub fn listen(&self) -> Stream {
        let mut stream = self.connect();
        let request = self.request("GET", &format!("{}events", self.home), &[("Accept", "text/event-stream")], "");
        stream.write_all(request.as_bytes()).expect("sent");
        let mut lines = BufReader::new(stream);
        let mut first = String::new();
        lines.read_line(&mut first).expect("an answer");
        Stream { status: first.split(' ').nth(1).and_then(|s| s.parse().ok()).expect("a status"), lines }
    }
}

/// Returns the button with this identifier on a person's page.
pub fn button(state: &Json, id: &str) -> Json {
    let groups = state["person"]["groups"].as_array().expect("groups").iter();
    let mut buttons = groups.flat_map(|group| group["buttons"].as_array().expect("buttons"));
    buttons.find(|button| button["id"] == id).cloned().unwrap_or_default()
}

/// Returns a condition: the button with this identifier is enabled.
pub fn may(id: &'static str) -> impl Fn(&Json) -> bool {
    move |state| button(state, id)["enabled"] == true
}

/// Returns the row of a member of the supervisor's page.
pub fn row(state: &Json, member: usize) -> &Json {
    &state["members"][member]
}

/// A listening page.
pub struct Stream {
    pub status: u16,
    lines: BufReader<TcpStream>,
}

impl Stream {
    /// Returns the next state; `None` after the end of the stream.
    pub fn next(&mut self) -> Option<Json> {
        loop {
            let mut line = String::new();
            if self.lines.read_line(&mut line).expect("in time") == 0 {
                return None;
            }
            if let Some(data) = line.strip_prefix("data:") {
                return Some(serde_json::from_str(data.trim()).expect("JSON"));
            }
        }
    }

    /// Reads until a state satisfies a condition.
    pub fn until(&mut self, wanted: impl Fn(&Json) -> bool) -> Json {
        loop {
            let state = self.next().expect("it goes on");
            if wanted(&state) {
                return state;
            }
        }
    }
}

/// Reads a response to its end. A missing response has status 0.
pub fn read(stream: &mut TcpStream) -> Answer {
    let mut bytes = Vec::new();
    // A connection reset may follow a complete response.
    let _ = stream.read_to_end(&mut bytes);
    let text = String::from_utf8_lossy(&bytes).into_owned();
    let (head, body) = text.split_once("\r\n\r\n").unwrap_or((&text, ""));
    let mut lines = head.lines();
    let status = lines.next().and_then(|line| line.split(' ').nth(1)?.parse().ok()).unwrap_or(0);
    let header = |line: &str| line.split_once(':').map(|(name, value)| (name.to_lowercase(), value.trim().to_string()));
    Answer { status, headers: lines.filter_map(header).collect(), body: body.to_string() }
}
