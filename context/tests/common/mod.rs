//! A chat server on loopback that says what it was told to say, and keeps what it was asked.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::sync::{Arc, Mutex};
use std::time::Duration;

/// Response of the server to one request.
#[derive(Clone, Debug)]
pub enum Reply {
    /// A chat completion that says this.
    Says(String),
    /// The same, with another reason to have stopped.
    Stops(&'static str),
    /// A status, headers (each ending its line), and a body.
    Status(u16, &'static str, String),
    /// Says nothing for this long, then closes.
    Silent(Duration),
    /// A body that is no text.
    NoText,
    /// Closes at once.
    Closes,
    /// A completion whose body is shorter than its head promised.
    Truncated,
    /// A body that goes on for this many bytes.
    Endless(usize),
}

/// The server.
pub struct Server {
    /// Its address, for an endpoint.
    pub address: String,
    asked: Arc<Mutex<Vec<(String, serde_json::Value)>>>,
}

impl Server {
    /// Serves these replies in order, then closes every connection at once.
    pub fn new(replies: Vec<Reply>) -> Server {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = format!("http://{}/v1", listener.local_addr().unwrap());
        let asked = Arc::new(Mutex::new(Vec::new()));
        let kept = asked.clone();
        std::thread::spawn(move || {
            let mut replies = replies.into_iter();
            for stream in listener.incoming().flatten() {
                if let Some(request) = request(&stream) {
                    kept.lock().unwrap().push(request);
                }
                let reply = replies.next().unwrap_or(Reply::Closes);
                // A client that has gone is no matter of the server's.
                let _ = answer(stream, reply);
            }
        });
        Server { address, asked }
    }

    /// Heads and bodies of the requests so far.
    pub fn asked(&self) -> Vec<(String, serde_json::Value)> {
        self.asked.lock().unwrap().clone()
    }
}

fn request(stream: &TcpStream) -> Option<(String, serde_json::Value)> {
    let mut reader = BufReader::new(stream);
    let mut head = String::new();
    while !head.ends_with("\r\n\r\n") {
        (reader.read_line(&mut head).ok()? > 0).then_some(())?;
    }
    let lower = head.to_lowercase();
    let mut body = Vec::new();
    if let Some(at) = lower.find("content-length:") {
        let length = lower[at + 15..].lines().next()?.trim().parse().ok()?;
        body.resize(length, 0);
        reader.read_exact(&mut body).ok()?;
    } else if lower.contains("transfer-encoding: chunked") {
        loop {
            let mut size = String::new();
            reader.read_line(&mut size).ok()?;
            let size = usize::from_str_radix(size.trim(), 16).ok()?;
            let mut chunk = vec![0; size + 2];
            reader.read_exact(&mut chunk).ok()?;
            body.extend_from_slice(&chunk[..size]);
            if size == 0 {
                break;
            }
        }
    }
    Some((head, serde_json::from_slice(&body).ok()?))
}

fn completion(text: &str, reason: &str) -> String {
    let message = serde_json::json!({ "role": "assistant", "content": text });
    serde_json::json!({ "choices": [{ "index": 0, "message": message, "finish_reason": reason }] }).to_string()
}

fn answer(mut stream: TcpStream, reply: Reply) -> std::io::Result<()> {
    let mut send = |status: u16, headers: &str, length: usize, body: &str| {
        write!(stream, "HTTP/1.1 {status} X\r\n{headers}Content-Length: {length}\r\nConnection: close\r\n\r\n{body}")?;
        stream.flush()
    };
    match reply {
        Reply::Says(text) => {
            let body = completion(&text, "stop");
            send(200, "", body.len(), &body)
        }
        Reply::Stops(reason) => {
            let body = completion("{\"layers\": [", reason);
            send(200, "", body.len(), &body)
        }
        Reply::Status(status, headers, body) => send(status, headers, body.len(), &body),
        Reply::Truncated => {
            let body = completion("{}", "stop");
            send(200, "", body.len() + 100, &body)
        }
        Reply::Endless(size) => {
            send(200, "", size, "")?;
            let chunk = vec![b' '; 1 << 16];
            for _ in 0..size / chunk.len() {
                stream.write_all(&chunk)?;
            }
            Ok(())
        }
        Reply::Silent(time) => {
            std::thread::sleep(time);
            Ok(())
        }
        Reply::NoText => {
            let body = b"{\"choices\": [{\"message\": {\"content\": \"\xff\xfe\"}}]}";
            write!(stream, "HTTP/1.1 200 X\r\nContent-Length: {}\r\nConnection: close\r\n\r\n", body.len())?;
            stream.write_all(body)
        }
        Reply::Closes => Ok(()),
    }
}
