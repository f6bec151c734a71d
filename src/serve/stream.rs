//! The stream of states that a page listens to. The first is whole, and so is each further one: a page that comes back
//! needs nothing of what it missed.

use std::convert::Infallible;
use std::sync::Arc;
use std::time::Duration;

use axum::response::sse::Event;
use futures_util::stream::{Stream, unfold};
use tokio::sync::watch;
use tokio::time::{Instant, sleep_until};

use super::access::{Role, Session};
use super::routes::App;
use super::view::Published;

/// A stream says something at least this often.
const BEAT: Duration = Duration::from_secs(4);

/// A page that listens. Its session forgets it when it is dropped.
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

/// The states of a page, from now on.
pub fn stream(app: Arc<App>, role: Role, session: Arc<Session>) -> impl Stream<Item = Result<Event, Infallible>> {
    let (number, published) = (session.begin_stream(), app.engine.published.clone());
    let first = Listening { app, role, session, number, published, sent: String::new(), beat: Instant::now() };
    unfold(first, |mut listening| async move {
        let state = listening.next().await?;
        Some((Ok(Event::default().event("state").retry(Duration::from_secs(2)).data(state)), listening))
    })
}

impl Listening {
    /// The next state to send: when something has happened, or the last was sent a while ago. None once it is over.
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
