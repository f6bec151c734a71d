//! An editor for the tests, and helpers for places in texts.

use std::io::{BufRead, BufReader, Read, Write};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

use serde_json::{Value as Json, json};

use crate::common;

/// An editor: it frames messages by itself, so that client and server do not share a library.
pub struct Editor {
    pub process: Child,
    pub to: Option<ChildStdin>,
    from: Receiver<Json>,
    next: i64,
    /// Standard error of the server; empty unless something is wrong.
    complaints: Receiver<String>,
    /// Received diagnostics, in order.
    published: Vec<Json>,
}

impl Editor {
    pub fn new() -> Editor {
        let mut process = Command::new(env!("CARGO_BIN_EXE_hierarq"))
            .args(["lsp", "--stdio"])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the server starts");
        let to = process.stdin.take();
        let mut out = BufReader::new(process.stdout.take().expect("a pipe"));
        let mut err = process.stderr.take().expect("a pipe");
        let (complain, complaints) = channel();
        std::thread::spawn(move || {
            let mut text = String::new();
            let _ = err.read_to_string(&mut text);
            let _ = complain.send(text);
        });
        let (sender, from) = channel();
        std::thread::spawn(move || {
            loop {
                let mut length = 0usize;
                loop {
                    let mut line = String::new();
                    if out.read_line(&mut line).unwrap_or(0) == 0 {
                        return;
                    }
                    if line == "\r\n" {
                        break;
                    }
                    if let Some(n) = line.strip_prefix("Content-Length: ") {
                        length = n.trim().parse().expect("a length");
                    }
                }
                let mut body = vec![0; length];
                out.read_exact(&mut body).expect("as many bytes as were promised");
                let _ = sender.send(serde_json::from_slice(&body).expect("JSON in UTF-8"));
            }
        });
        Editor { process, to, from, next: 0, complaints, published: Vec::new() }
    }

    /// Creates an editor that is ready to open documents.
    pub fn ready() -> Editor {
        let mut e = Editor::new();
        e.result("initialize", json!({ "processId": null, "rootUri": null, "capabilities": {} }));
        e.notify("initialized", json!({}));
        e
    }

    /// As [`Editor::ready`], with a folder as its workspace.
    pub fn ready_in(folder: &std::path::Path) -> Editor {
        let mut e = Editor::new();
        let folders = json!([{ "uri": format!("file://{}", folder.display()), "name": "here" }]);
        e.result("initialize", json!({ "processId": null, "workspaceFolders": folders, "capabilities": {} }));
        e.notify("initialized", json!({}));
        e
    }

    pub fn send(&mut self, message: &Json) {
        let body = message.to_string();
        let to = self.to.as_mut().expect("the pipe is open");
        write!(to, "Content-Length: {}\r\n\r\n{body}", body.len()).expect("the server reads");
        to.flush().expect("the server reads");
    }

    pub fn notify(&mut self, method: &str, params: Json) {
        self.send(&json!({ "jsonrpc": "2.0", "method": method, "params": params }));
    }

    pub fn receive(&mut self) -> Json {
        self.from.recv_timeout(Duration::from_secs(60)).expect("the server speaks")
    }

    /// Sends a request, and returns the complete response.
    pub fn ask(&mut self, method: &str, params: Json) -> Json {
        self.next += 1;
        let id = self.next;
        self.send(&json!({ "jsonrpc": "2.0", "id": id, "method": method, "params": params }));
        loop {
            let message = self.receive();
            if message["method"] == "textDocument/publishDiagnostics" {
                self.published.push(message["params"].clone());
            } else {
                assert_eq!(message["id"], id, "{message}");
                return message;
            }
        }
    }

    pub fn result(&mut self, method: &str, params: Json) -> Json {
        let answer = self.ask(method, params);
        assert!(answer.get("error").is_none(), "{method}: {answer}");
        answer["result"].clone()
    }

    pub fn error(&mut self, method: &str, params: Json) -> i64 {
        let answer = self.ask(method, params);
        answer["error"]["code"].as_i64().unwrap_or_else(|| panic!("{method} should fail: {answer}"))
    }

    /// Returns the diagnostics of the given version of a document.
    pub fn diagnostics(&mut self, uri: &str, version: Option<i64>) -> Vec<Json> {
        loop {
            let found = self.published.iter().position(|p| p["uri"] == uri && p["version"].as_i64() == version);
            if let Some(i) = found {
                let params = self.published.remove(i);
                return params["diagnostics"].as_array().expect("a list").clone();
            }
            let message = self.receive();
            assert_eq!(message["method"], "textDocument/publishDiagnostics", "{message}");
            self.published.push(message["params"].clone());
        }
    }

    pub fn open(&mut self, uri: &str, language: &str, text: &str) {
        let document = json!({ "uri": uri, "languageId": language, "version": 1, "text": text });
        self.notify("textDocument/didOpen", json!({ "textDocument": document }));
    }

    pub fn change(&mut self, uri: &str, version: i64, changes: Json) {
        let document = json!({ "uri": uri, "version": version });
        self.notify("textDocument/didChange", json!({ "textDocument": document, "contentChanges": changes }));
    }

    /// Sends a request about a place.
    pub fn at(&mut self, method: &str, uri: &str, position: &Json) -> Json {
        self.result(method, json!({ "textDocument": { "uri": uri }, "position": position }))
    }

    /// Shuts the server down; returns the exit code. A panic that the server survived would be in its standard error.
    pub fn goodbye(mut self) -> Option<i32> {
        assert_eq!(self.result("shutdown", Json::Null), Json::Null);
        self.notify("exit", Json::Null);
        let code = self.process.wait().expect("it ends").code();
        assert_eq!(self.complaints.recv_timeout(Duration::from_secs(10)).as_deref(), Ok(""));
        code
    }
}

impl Drop for Editor {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// Returns the URI of a document in the folder of the examples; the file need not exist.
pub fn uri(name: &str) -> String {
    format!("file://{}", common::example(name).display())
}

pub fn text(name: &str) -> String {
    std::fs::read_to_string(common::example(name)).expect("an example")
}

pub fn position(text: &str, byte: usize) -> Json {
    let line = text[..byte].matches('\n').count();
    let start = text[..byte].rfind('\n').map_or(0, |n| n + 1);
    json!({ "line": line, "character": text[start..byte].encode_utf16().count() })
}

/// Returns the position of the character marked by `|` in `pattern`, which must occur once in the text.
pub fn find(text: &str, pattern: &str) -> Json {
    let offset = pattern.find('|').expect("a mark");
    let plain = pattern.replacen('|', "", 1);
    assert_eq!(text.matches(&plain).count(), 1, "`{plain}` does not stand once in the text");
    position(text, text.find(&plain).expect("found") + offset)
}

pub fn byte(text: &str, position: &Json) -> usize {
    let line = position["line"].as_u64().expect("a line") as usize;
    let start: usize = text.split_inclusive('\n').take(line).map(str::len).sum();
    let mut units = position["character"].as_u64().expect("a character") as usize;
    let mut at = start;
    while units > 0 {
        let c = text[at..].chars().next().expect("a position inside the text");
        units -= c.len_utf16();
        at += c.len_utf8();
    }
    at
}

/// Returns the text of a range.
pub fn under<'t>(text: &'t str, range: &Json) -> &'t str {
    &text[byte(text, &range["start"])..byte(text, &range["end"])]
}

/// Returns the text after edits.
pub fn edited(text: &str, edits: &Json) -> String {
    let mut edits = edits.as_array().expect("a list").clone();
    edits.sort_by_key(|e| byte(text, &e["range"]["start"]));
    let mut out = text.to_string();
    for e in edits.iter().rev() {
        let range = byte(text, &e["range"]["start"])..byte(text, &e["range"]["end"]);
        out.replace_range(range, e["newText"].as_str().expect("text"));
    }
    out
}

pub fn labels(items: &Json) -> Vec<String> {
    let items = items.as_array().expect("a list").iter();
    items.map(|i| i["label"].as_str().expect("a label").to_string()).collect()
}

/// A spec with wide characters before the tested places; the URDF is that of the examples.
pub const SPEC: &str = r#"hierarq 1

// How near it may come. 🤖 ü
param reach = 0.4 m

robot arm {
  urdf "robots/arm7.urdf"
  rate 100 Hz
  arms { only { tip link_7  points [elbow] } }
  points { elbow link_4 }
  joints { all_of_it "joint_*" }
  home { joint_2 0.5 rad  joint_4 1.99 rad }
}

task limits = joint_position_limits { gain 5 /s }
task deck = virtual_wall { points elbow  through [[0, 0, 0], [1, 0, 0], [0, 1, 0]] m  d_min reach * 0 }
task go = frame_position(only) { position initial(frame(only).position) + [reach, 0, 0] * sin(t / (1 s)) }

stack work {
  level keep hard { limits deck  joint_velocity_limits }
  level gentle { joint_acceleration_limits }
  level move { go weight 2 }
}

run { stack work  duration 1 s  title "🤖 ä" }
"#;

pub fn spec() -> String {
    SPEC.to_string()
}
