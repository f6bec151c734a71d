//! Event stream of a page. Every message is a complete state: a page that reconnects needs none of the missed messages.

use std::convert::Infallible;
use std::sync::Arc;
use std::time::Duration;

use axum::response::sse::Event;
use futures_util::stream::{Stream, unfold};
use tokio::sync::watch;
use tokio::time::{Instant, sleep_until};

use crate::access::{Role, Session};
use crate::published::Published;
use crate::routes::App;

/// Maximum interval between messages of a stream.
const BEAT: Duration = Duration::from_secs(4);

/// A listening page. Dropping it ends the stream of its session.
struct Listening {
    app: Arc<App>,
    role: Role,
    session: Arc<Session>,
    number: u64,
    published: watch::Receiver<Arc<Published>>,
    sent: String,
    beat: Instant,
}

impl Drop for Listening {
    fn drop(&mut self) {
        self.session.end_stream();
    }
}

/// Returns the stream of a page's states, beginning now.
pub fn stream(app: Arc<App>, role: Role, session: Arc<Session>) -> impl Stream<Item = Result<Event, Infallible>> {
    let (number, published) = (session.begin_stream(), app.engine.published.clone());
    let first = Listening { app, role, session, number, published, sent: String::new(), beat: Instant::now() };
    unfold(first, |mut listening| async move {
        let state = listening.next().await?;
        Some((Ok(Event::default().event("state").retry(Duration::from_secs(2)).data(state)), listening))
    })
}

impl Listening {
    /// Returns the next state to send: after an event, or after the heartbeat interval. `None` after the end of the
    /// stream.
    async fn next(&mut self) -> Option<String> {
        while self.session.goes_on(self.number) {
            let published = self.published.borrow_and_update().clone();
            let (still, whole) = self.app.state(self.role, &published);
            if still != self.sent || Instant::now() >= self.beat {
                self.sent = still;
                self.beat = Instant::now() + BEAT;
                return Some(whole);
            }
            tokio::select! {
                changed = self.published.changed() => changed.ok()?,
                () = sleep_until(self.beat) => {}
            }
        }
        None
    }
}
