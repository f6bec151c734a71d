//! Language server: handles `hierarq lsp` over standard input and output.
//!
//! A single thread handles all messages. Requests have priority over diagnostics: a changed document is compiled only
//! when no message is pending, so that fast typing costs one compilation. Requests use the tree as far as the text can
//! be parsed.

mod actions;
mod allowances;
mod completion;
mod diagnostics;
mod document;
mod hover;
mod inlay;
mod library;
mod navigation;
mod rename;
mod server;
mod symbols;
mod text;
mod tokens;
mod transport;
mod uri;
mod workspace;

use std::io;

use lsp_server::{Connection, ErrorCode, Message, Response};
use lsp_types::{InitializeParams, InitializeResult, ServerInfo};

use server::Server;

/// Serves one editor until it exits or closes the pipe. Returns true if the editor shut the server down first, as the
/// protocol requires.
///
/// # Errors
/// The pipe breaks, or its contents violate the protocol.
pub fn serve() -> io::Result<bool> {
    let (connection, threads) = transport::stdio()?;
    let orderly = match talk(&connection) {
        Ok(orderly) => orderly,
        // If the session ended because of an invalid message, that is the error to report.
        Err(e) => return Err(threads.unread().unwrap_or(e)),
    };
    drop(connection);
    threads.join()?;
    Ok(orderly)
}

fn talk(connection: &Connection) -> io::Result<bool> {
    let (id, params) = connection.initialize_start().map_err(io::Error::other)?;
    let params = match serde_json::from_value::<InitializeParams>(params) {
        Ok(params) => params,
        Err(e) => {
            let refusal = Response::new_err(id, ErrorCode::InvalidParams as i32, e.to_string());
            return send(connection, refusal.into()).map(|()| false);
        }
    };
    let result = InitializeResult {
        capabilities: server::capabilities(),
        server_info: Some(ServerInfo {
            name: "hierarq".to_string(),
            version: Some(env!("CARGO_PKG_VERSION").to_string()),
        }),
    };
    connection.initialize_finish(id, serde_json::to_value(result)?).map_err(io::Error::other)?;
    let mut server = Server::of(&params);
    let mut closing = false;
    loop {
        // Pending messages come first; diagnostics are computed when there are none.
        let message = match connection.receiver.try_iter().next() {
            Some(message) => message,
            None => match server.publish() {
                Some(message) => {
                    send(connection, message)?;
                    continue;
                }
                None => match connection.receiver.recv() {
                    Ok(message) => message,
                    Err(_) => return Ok(false),
                },
            },
        };
        match message {
            Message::Request(request) if closing => {
                let text = "the server has been shut down".to_string();
                let refusal = Response::new_err(request.id, ErrorCode::InvalidRequest as i32, text);
                send(connection, refusal.into())?;
            }
            Message::Request(request) if request.method == "shutdown" => {
                closing = true;
                server = Server::default();
                send(connection, Response::new_ok(request.id, ()).into())?;
            }
            Message::Request(request) => send(connection, server.answer(request).into())?,
            Message::Notification(n) if n.method == "exit" => return Ok(closing),
            Message::Notification(n) if !closing => server.note(n),
            Message::Notification(_) | Message::Response(_) => {}
        }
    }
}

fn send(connection: &Connection, message: Message) -> io::Result<()> {
    connection.sender.send(message).map_err(|_| io::Error::from(io::ErrorKind::BrokenPipe))
}
