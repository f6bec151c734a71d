//! Client of a chat server: sends one question, returns one answer or an error.
//!
//! The interface is that of OpenAI's chat completions, which local servers implement too. Each request has a deadline,
//! each answer a maximum size. Redirects are not followed. A key is never sent in clear text to another machine.

use std::time::Duration;

use serde::{Deserialize, Serialize};

/// Maximum size of an answer (bytes).
pub const MAX_ANSWER: u64 = 4 << 20;

/// Author of a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Speaker {
    /// Instructions for the whole conversation.
    System,
    /// The user, who asks.
    User,
    /// The model.
    Assistant,
}

/// A message of a conversation.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Message {
    /// Author.
    pub role: Speaker,
    /// Text.
    pub content: String,
}

impl Message {
    /// Creates a message with author `role` and text `content`.
    pub fn new(role: Speaker, content: impl Into<String>) -> Message {
        Message { role, content: content.into() }
    }
}

/// A model that can be asked: a server, or a recording of one.
pub trait Chat {
    /// Name of the model.
    fn model(&self) -> &str;

    /// Returns the model's next message in this conversation.
    ///
    /// # Errors
    ///
    /// Any [`AskError`]. The question is sent once, without retries.
    fn ask(&mut self, messages: &[Message]) -> Result<String, AskError>;

    /// Begins a new conversation. A recording skips to its next one.
    fn begin(&mut self) {}

    /// Recorded duration of the last answer (s). None if the answer was not replayed.
    fn recorded_seconds(&self) -> Option<f64> {
        None
    }
}

/// A chat server and the settings of its requests.
#[derive(Clone)]
pub struct Endpoint {
    url: String,
    model: String,
    key: Option<String>,
    temperature: Option<f64>,
    agent: ureq::Agent,
}

/// Reason why a server cannot be used at all.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum EndpointError {
    /// The address is not a valid URL of a server.
    #[error("`{0}` is no address of a server: write `http://HOST:PORT/v1` or `https://HOST/v1`")]
    Address(String),
    /// The key would be readable on the network.
    #[error("the key would be sent in clear text to `{0}`: use `https://`, or leave the key out")]
    KeyInClearText(String),
    /// The key contains characters that are not allowed in a header.
    #[error("the key holds characters that cannot be sent; is there a line break in it?")]
    Key,
}

/// Reason why a question got no answer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(rename_all = "snake_case")]
pub enum AskError {
    /// No server listens, or the connection broke.
    #[error("no connection: {0}")]
    Connection(String),
    /// No answer in time.
    #[error("no answer within {0} s")]
    Timeout(f64),
    /// The server limits the rate of requests (status 429).
    #[error("the server asks to wait (429){}", .wait.map_or(String::new(), |s| format!(", {s} s")))]
    Busy {
        /// Time to wait (s), if the server reports it.
        wait: Option<f64>,
    },
    /// A status other than 200 and 429.
    #[error("the server answered {status}: {text}")]
    Status {
        /// Status code.
        status: u16,
        /// Beginning of the body.
        text: String,
    },
    /// The answer is longer than [`MAX_ANSWER`].
    #[error("the answer is longer than {} MiB", MAX_ANSWER >> 20)]
    TooLong,
    /// The body is not a chat completion.
    #[error("the answer is no chat completion: {0}")]
    Form(String),
    /// The model refuses; the text is in its words.
    #[error("the model refuses: {0}")]
    Refuses(String),
    /// The recording has no more answers.
    #[error("the recording is at its end; ask with `--endpoint`, or fewer times with `--attempts`")]
    RecordingEnds,
    /// The model stopped before its answer was complete, for instance at its length limit.
    #[error("the model did not finish its answer ({0})")]
    Unfinished(String),
}

impl AskError {
    /// Returns true if the same question may get an answer later.
    pub fn passes(&self) -> bool {
        match self {
            AskError::Connection(_) | AskError::Timeout(_) | AskError::Busy { .. } => true,
            AskError::Status { status, .. } => *status >= 500,
            AskError::TooLong
            | AskError::Form(_)
            | AskError::Refuses(_)
            | AskError::RecordingEnds
            | AskError::Unfinished(_) => false,
        }
    }
}

#[derive(Serialize)]
struct Request<'a> {
    model: &'a str,
    messages: &'a [Message],
    #[serde(skip_serializing_if = "Option::is_none")]
    temperature: Option<f64>,
    stream: bool,
}

#[derive(Deserialize)]
struct Response {
    choices: Vec<Choice>,
}

#[derive(Deserialize)]
struct Choice {
    message: Said,
    #[serde(default)]
    finish_reason: Option<String>,
}

#[derive(Deserialize)]
struct Said {
    #[serde(default)]
    content: Option<String>,
    #[serde(default)]
    refusal: Option<String>,
}

impl Endpoint {
    /// Creates a client for the server at `address` (`http://127.0.0.1:8080/v1`) and the model `model`, with an
    /// optional key. `timeout` bounds the duration of one answer.
    ///
    /// # Errors
    ///
    /// If the address is invalid, or if the key would be sent in clear text to another machine or contains characters
    /// that cannot be sent.
    pub fn new(address: &str, model: &str, key: Option<&str>, timeout: Duration) -> Result<Endpoint, EndpointError> {
        let no_address = || EndpointError::Address(address.to_string());
        let base = address.trim().trim_end_matches('/');
        let uri: ureq::http::Uri = base.parse().map_err(|_| no_address())?;
        let (Some(scheme @ ("http" | "https")), Some(host)) = (uri.scheme_str(), uri.host()) else {
            return Err(no_address());
        };
        if key.is_some() && scheme == "http" && !is_loopback(host) {
            return Err(EndpointError::KeyInClearText(host.to_string()));
        }
        if key.is_some_and(|key| ureq::http::HeaderValue::from_str(key).is_err()) {
            return Err(EndpointError::Key);
        }
        let agent = ureq::Agent::config_builder()
            .timeout_global(Some(timeout))
            .http_status_as_error(false)
            .max_redirects(0)
            .proxy(None)
            .user_agent(concat!("hierarq/", env!("CARGO_PKG_VERSION")))
            .build()
            .new_agent();
        let path = "/chat/completions";
        let url = if base.ends_with(path) { base.to_string() } else { format!("{base}{path}") };
        Ok(Endpoint { url, model: model.to_string(), key: key.map(str::to_string), temperature: None, agent })
    }

    /// Returns the endpoint with this sampling temperature.
    pub fn with_temperature(self, temperature: f64) -> Endpoint {
        Endpoint { temperature: Some(temperature), ..self }
    }

    /// URL of the requests.
    pub fn url(&self) -> &str {
        &self.url
    }

    fn trouble(&self, error: ureq::Error) -> AskError {
        let seconds = self.agent.config().timeouts().global.map_or(0.0, |t| t.as_secs_f64());
        match error {
            ureq::Error::Timeout(_) => AskError::Timeout(seconds),
            ureq::Error::BodyExceedsLimit(_) => AskError::TooLong,
            ureq::Error::Io(error) if error.kind() == std::io::ErrorKind::TimedOut => AskError::Timeout(seconds),
            ureq::Error::Io(error) if error.kind() == std::io::ErrorKind::InvalidData => {
                AskError::Form("it is no text in UTF-8".to_string())
            }
            other => AskError::Connection(other.to_string()),
        }
    }
}

impl Chat for Endpoint {
    fn model(&self) -> &str {
        &self.model
    }

    fn ask(&mut self, messages: &[Message]) -> Result<String, AskError> {
        let body = Request { model: &self.model, messages, temperature: self.temperature, stream: false };
        let mut request = self.agent.post(&self.url);
        if let Some(key) = &self.key {
            request = request.header("Authorization", format!("Bearer {key}"));
        }
        let mut response = request.send_json(&body).map_err(|error| self.trouble(error))?;
        let status = response.status().as_u16();
        let wait = response.headers().get("retry-after").and_then(|value| value.to_str().ok());
        let wait = wait.and_then(|text| text.trim().parse::<f64>().ok()).filter(|s| s.is_finite() && *s >= 0.0);
        let text = response.body_mut().with_config().limit(MAX_ANSWER).read_to_string();
        match status {
            200 => read(&text.map_err(|error| self.trouble(error))?),
            429 => Err(AskError::Busy { wait }),
            status => Err(AskError::Status { status, text: beginning(&text.unwrap_or_default()) }),
        }
    }
}

/// Extracts the model's message from the body of a chat completion.
fn read(body: &str) -> Result<String, AskError> {
    let response: Response = serde_json::from_str(body).map_err(|error| AskError::Form(error.to_string()))?;
    let Some(choice) = response.choices.into_iter().next() else {
        return Err(AskError::Form("it has no choices".to_string()));
    };
    match choice.finish_reason.as_deref() {
        None | Some("stop" | "eos" | "end_turn") => {}
        Some(reason) => return Err(AskError::Unfinished(beginning(reason))),
    }
    let Said { content, refusal } = choice.message;
    content.ok_or_else(|| match refusal {
        Some(words) => AskError::Refuses(beginning(&words)),
        None => AskError::Form("its message has no content".to_string()),
    })
}

/// The first line of a text, shortened.
fn beginning(text: &str) -> String {
    let line = text.trim().lines().next().unwrap_or_default();
    line.chars().filter(|c| !c.is_control()).take(200).collect()
}

fn is_loopback(host: &str) -> bool {
    let host = host.trim_start_matches('[').trim_end_matches(']');
    host == "localhost" || host.parse::<std::net::IpAddr>().is_ok_and(|ip| ip.is_loopback())
}
