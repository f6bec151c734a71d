//! Messages over standard input and output, of bounded size. Memory grows with received bytes, not announced ones.

use std::io::{self, BufRead, Read};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};

use crossbeam_channel::{Sender, bounded};
use lsp_server::{Connection, Message};

/// Maximum size of a message (bytes): a document of the maximum size, escaped, with a reserve.
const LARGEST: u64 = 64 << 20;
/// Maximum length of a header line (bytes).
const LONGEST: u64 = 4096;
/// Maximum number of header lines.
const MOST: usize = 100;

/// Reader and writer threads.
pub struct Threads {
    reader: JoinHandle<()>,
    writer: JoinHandle<io::Result<()>>,
    unread: Arc<Mutex<Option<io::Error>>>,
}

impl Threads {
    /// Waits for the threads to end.
    ///
    /// # Errors
    /// The input was not a valid message, or the output could not be written.
    pub fn join(self) -> io::Result<()> {
        let panicked = || io::Error::other("a thread of the language server panicked");
        self.reader.join().map_err(|_| panicked())?;
        if let Some(e) = taken(&self.unread) {
            return Err(e);
        }
        self.writer.join().unwrap_or_else(|_| Err(panicked()))
    }

    /// Returns the error that ended the input, if it was invalid.
    pub fn unread(&self) -> Option<io::Error> {
        taken(&self.unread)
    }
}

/// Opens the connection to the editor that started this program.
///
/// # Errors
/// The threads cannot be started.
pub fn stdio() -> io::Result<(Connection, Threads)> {
    // No buffer: an editor that writes faster than the server reads has to wait.
    let (said, receiver) = bounded(0);
    let (sender, to_say) = bounded::<Message>(0);
    let unread = Arc::new(Mutex::new(None));
    let noted = Arc::clone(&unread);
    let reader = thread::Builder::new().name("LSP reader".to_string()).spawn(move || {
        // Stored before the channel is closed, so that a closed channel always has its reason.
        if let Err(e) = read_all(&mut io::stdin().lock(), &said) {
            *noted.lock().unwrap_or_else(PoisonError::into_inner) = Some(e);
        }
        drop(said);
    })?;
    let writer = thread::Builder::new().name("LSP writer".to_string()).spawn(move || {
        let mut output = io::stdout().lock();
        to_say.into_iter().try_for_each(|message| message.write(&mut output))
    })?;
    Ok((Connection { sender, receiver }, Threads { reader, writer, unread }))
}

fn taken(unread: &Mutex<Option<io::Error>>) -> Option<io::Error> {
    unread.lock().unwrap_or_else(PoisonError::into_inner).take()
}

/// Forwards messages until the end of the input or the session.
fn read_all(input: &mut impl BufRead, to: &Sender<Message>) -> io::Result<()> {
    while let Some(message) = read(input)? {
        let ends = matches!(&message, Message::Notification(n) if n.method == "exit");
        if to.send(message).is_err() || ends {
            break;
        }
    }
    Ok(())
}

fn invalid(text: String) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, text)
}

/// Reads the next message; `None` at the end of the input.
fn read(input: &mut impl BufRead) -> io::Result<Option<Message>> {
    let Some(length) = head(input)? else { return Ok(None) };
    if length > LARGEST {
        return Err(invalid(format!("a message of {length} bytes; at most {} MiB are read", LARGEST >> 20)));
    }
    // The buffer grows with the received bytes, whatever length was announced.
    let mut bytes = Vec::new();
    input.take(length).read_to_end(&mut bytes)?;
    if bytes.len() as u64 != length {
        return Err(io::ErrorKind::UnexpectedEof.into());
    }
    serde_json::from_slice(&bytes)
        .map(Some)
        .map_err(|e| invalid(format!("a message that is none of the protocol: {e}")))
}

/// Reads the header of the next message and returns the announced length.
fn head(input: &mut impl BufRead) -> io::Result<Option<u64>> {
    let mut length = None;
    for _ in 0..MOST {
        let mut line = Vec::new();
        input.take(LONGEST).read_until(b'\n', &mut line)?;
        if line.is_empty() {
            return Ok(None);
        }
        let line = String::from_utf8_lossy(&line);
        let malformed = || invalid(format!("a head with the line {line:?}"));
        let line = line.strip_suffix("\r\n").ok_or_else(malformed)?;
        if line.is_empty() {
            return length.map(Some).ok_or_else(|| invalid("a head without Content-Length".to_string()));
        }
        let (name, value) = line.split_once(':').ok_or_else(malformed)?;
        if name.eq_ignore_ascii_case("Content-Length") {
            length = Some(value.trim().parse().map_err(|_| malformed())?);
        }
    }
    Err(invalid(format!("a head of more than {MOST} lines")))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn framed(body: &str) -> Vec<u8> {
        format!("Content-Length: {}\r\n\r\n{body}", body.len()).into_bytes()
    }

    #[test]
    fn messages_come_one_after_the_other() {
        let bytes = [
            framed(r#"{"jsonrpc":"2.0","method":"a"}"#),
            b"content-type: x\r\n".to_vec(),
            framed(r#"{"jsonrpc":"2.0","id":1,"method":"b"}"#),
        ]
        .concat();
        let mut input = bytes.as_slice();
        assert!(matches!(read(&mut input), Ok(Some(Message::Notification(n))) if n.method == "a"));
        assert!(matches!(read(&mut input), Ok(Some(Message::Request(r))) if r.method == "b"));
        assert!(matches!(read(&mut input), Ok(None)));
    }

    #[test]
    fn a_length_is_believed_only_as_far_as_bytes_come() {
        for length in ["18446744073709551615", "100000000000", "67108865"] {
            let text = format!("Content-Length: {length}\r\n\r\n{{}}");
            let e = read(&mut text.as_bytes()).expect_err("too long");
            assert_eq!(e.kind(), io::ErrorKind::InvalidData, "{length}");
        }
        let e = read(&mut b"Content-Length: 60000000\r\n\r\n{}".as_slice()).expect_err("cut off");
        assert_eq!(e.kind(), io::ErrorKind::UnexpectedEof);
        let endless = io::repeat(b'x');
        assert!(read(&mut io::BufReader::new(endless)).is_err());
        assert!(read(&mut io::Cursor::new(b"A: b\r\n".repeat(1000))).is_err());
    }

    proptest! {
        #[test]
        fn no_bytes_make_it_panic(text in "(Content-Length: ?|[0-9]{1,20}|\r\n|\\{|\\}|\"|[a-z:]){0,40}") {
            let _ = read(&mut text.as_bytes());
        }
    }
}
