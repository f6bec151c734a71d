//! One question to a chat server, one answer or a reason.
//!
//! The interface is that of OpenAI's chat completions, which local servers speak too. A request has a deadline, an answer
//! a greatest size. Redirects are not followed, and a key is not sent in clear text to another machine.

use std::time::Duration;

use serde::{Deserialize, Serialize};

/// The greatest answer that is read (bytes).
pub const MAX_ANSWER: u64 = 4 << 20;

/// Who says a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Speaker {
    /// What holds for the whole conversation.
    System,
    /// The one who asks.
    User,
    /// The model.
    Assistant,
}

/// A message of a conversation.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Message {
    /// Who says it.
    pub role: Speaker,
    /// What is said.
    pub content: String,
}

impl Message {
    /// `content`, said by `role`.
    pub fn new(role: Speaker, content: impl Into<String>) -> Message {
        Message { role, content: content.into() }
    }
}

/// Who can be asked: a server, or a recording of one.
pub trait Chat {
    /// The name of the model.
    fn model(&self) -> &str;

    /// What the model says next in this conversation.
    ///
    /// # Errors
    ///
    /// As [`AskError`] lists them. Nothing is asked twice.
    fn ask(&mut self, messages: &[Message]) -> Result<String, AskError>;

    /// A new conversation begins. A recording goes on to the next one that it has.
    fn begin(&mut self) {}

    /// Duration of the last answer when it was recorded (s); none for an answer that was waited for.
    fn recorded_seconds(&self) -> Option<f64> {
        None
    }
}

/// A chat server, and how it is asked.
#[derive(Clone)]
pub struct Endpoint {
    url: String,
    model: String,
    key: Option<String>,
    temperature: Option<f64>,
    agent: ureq::Agent,
}

/// Why a server cannot be asked at all.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum EndpointError {
    /// The address is none.
    #[error("`{0}` is no address of a server: write `http://HOST:PORT/v1` or `https://HOST/v1`")]
    Address(String),
    /// Everybody on the way could read the key.
    #[error("the key would be sent in clear text to `{0}`: use `https://`, or leave the key out")]
    KeyInClearText(String),
    /// The key cannot stand in a header.
    #[error("the key holds characters that cannot be sent; is there a line break in it?")]
    Key,
}

/// Why a question got no answer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(rename_all = "snake_case")]
pub enum AskError {
    /// Nobody listens, or the connection broke.
    #[error("no connection: {0}")]
    Connection(String),
    /// No answer in time.
    #[error("no answer within {0} s")]
    Timeout(f64),
    /// The server wants to be asked less often.
    #[error("the server asks to wait (429){}", .wait.map_or(String::new(), |s| format!(", {s} s")))]
    Busy {
        /// For how long (s), if it says so.
        wait: Option<f64>,
    },
    /// Another status than 200.
    #[error("the server answered {status}: {text}")]
    Status {
        /// The status.
        status: u16,
        /// The beginning of what it said.
        text: String,
    },
    /// More than [`MAX_ANSWER`].
    #[error("the answer is longer than {} MiB", MAX_ANSWER >> 20)]
    TooLong,
    /// Not the form of a chat completion.
    #[error("the answer is no chat completion: {0}")]
    Form(String),
    /// The model does not want to, in its words.
    #[error("the model refuses: {0}")]
    Refuses(String),
    /// There are no more answers in a recording.
    #[error("the recording is at its end; ask with `--endpoint`, or fewer times with `--attempts`")]
    RecordingEnds,
    /// The model stopped because its answer became too long for it, or for other reasons than being done.
    #[error("the model did not finish its answer ({0})")]
    Unfinished(String),
}

impl AskError {
    /// Whether the same question may get an answer later.
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
    /// A server at `address` (`http://127.0.0.1:8080/v1`), the name of a model there, a key if it wants one, and how long
    /// one answer may take.
    ///
    /// # Errors
    ///
    /// An address that is none; a key that would be sent in clear text to another machine, or that cannot be sent.
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

    /// The same with this temperature of sampling.
    pub fn with_temperature(self, temperature: f64) -> Endpoint {
        Endpoint { temperature: Some(temperature), ..self }
    }

    /// Where questions go.
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

/// What the model said, from the body of a chat completion.
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
