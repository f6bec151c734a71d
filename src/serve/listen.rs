//! Connections: how long a header may take, how long an answer may be refused. [`places`](super::places) bounds their
//! number.

use std::io;
use std::net::SocketAddr;
use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll};
use std::time::Duration;

use axum::Router;
use hyper::rt::{Read, ReadBufCursor, Write};
use hyper::server::conn::http1;
use hyper::service::{Service, service_fn};
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::server::graceful::GracefulShutdown;
use hyper_util::service::TowerToHyperService;
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::watch;
use tokio::task::yield_now;
use tokio::time::{Instant, Sleep, sleep, timeout};

use super::guard::Local;
use super::places::{Held, Places};

/// The header of the first request must be there within this time.
const FIRST: Duration = Duration::from_secs(4);
/// That of each further request of a connection that stays open within this.
const HEADER: Duration = Duration::from_secs(10);
/// A client must take something of an answer within this time.
const TAKEN: Duration = Duration::from_secs(20);
/// What is still being answered when the server ends may take this long.
const FAREWELL: Duration = Duration::from_secs(3);
/// Bytes of a header.
const HEADER_BYTES: usize = 16 * 1024;

/// Answers connections until `end` becomes true.
pub async fn serve(listener: TcpListener, router: Router, mut end: watch::Receiver<bool>) {
    let places = Arc::new(Places::default());
    let graceful = GracefulShutdown::new();
    loop {
        let accepted = tokio::select! {
            accepted = listener.accept() => accepted,
            _ = end.wait_for(|end| *end) => break,
        };
        let Ok((stream, from)) = accepted else {
            // Out of descriptors, most likely: somebody must end first.
            places.make_room();
            sleep(Duration::from_millis(50)).await;
            continue;
        };
        let Ok(local) = stream.local_addr() else { continue };
        let held = places.take(from.ip());
        let connection = graceful.watch(connection(stream, router.clone(), local, held.clone()));
        tokio::spawn(async move {
            let place = held.place();
            let dawdles = async {
                sleep(FIRST).await;
                if place.asked() {
                    std::future::pending::<()>().await;
                }
            };
            tokio::select! {
                // What goes wrong on a connection is the affair of its client.
                _ = connection => {}
                () = place.ended() => {}
                () = dawdles => {}
            }
        });
        // Whoever comes shows who it is before the next one may take its place.
        yield_now().await;
    }
    let _ = timeout(FAREWELL, graceful.shutdown()).await;
}

fn connection(
    stream: TcpStream,
    router: Router,
    local: SocketAddr,
    held: Held,
) -> impl hyper_util::server::graceful::GracefulConnection<Error = hyper::Error> {
    let _ = stream.set_nodelay(true);
    let router = TowerToHyperService::new(router);
    let service = service_fn(move |mut request: hyper::Request<hyper::body::Incoming>| {
        held.place().asks();
        request.extensions_mut().insert(Local(local));
        request.extensions_mut().insert(held.clone());
        router.call(request)
    });
    http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(HEADER)
        .max_buf_size(HEADER_BYTES)
        .serve_connection(Patient { inner: TokioIo::new(stream), waiting: None }, service)
}

/// A stream that fails when its other end takes nothing for [`TAKEN`].
struct Patient {
    inner: TokioIo<TcpStream>,
    waiting: Option<Pin<Box<Sleep>>>,
}

impl Patient {
    /// Passes on what became of a write, or that it takes too long.
    fn judged<T>(&mut self, cx: &mut Context<'_>, written: Poll<io::Result<T>>) -> Poll<io::Result<T>> {
        if written.is_ready() {
            self.waiting = None;
            return written;
        }
        let waiting = self.waiting.get_or_insert_with(|| Box::pin(tokio::time::sleep_until(Instant::now() + TAKEN)));
        match waiting.as_mut().poll(cx) {
            Poll::Ready(()) => Poll::Ready(Err(io::ErrorKind::TimedOut.into())),
            Poll::Pending => Poll::Pending,
        }
    }
}

impl Read for Patient {
    fn poll_read(mut self: Pin<&mut Self>, cx: &mut Context<'_>, buf: ReadBufCursor<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.inner).poll_read(cx, buf)
    }
}

impl Write for Patient {
    fn poll_write(mut self: Pin<&mut Self>, cx: &mut Context<'_>, buf: &[u8]) -> Poll<io::Result<usize>> {
        let written = Pin::new(&mut self.inner).poll_write(cx, buf);
        self.judged(cx, written)
    }

    fn poll_flush(mut self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<io::Result<()>> {
        let flushed = Pin::new(&mut self.inner).poll_flush(cx);
        self.judged(cx, flushed)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<io::Result<()>> {
        let shut = Pin::new(&mut self.inner).poll_shutdown(cx);
        self.judged(cx, shut)
    }

    fn is_write_vectored(&self) -> bool {
        self.inner.is_write_vectored()
    }

    fn poll_write_vectored(
        mut self: Pin<&mut Self>,
        cx: &mut Context<'_>,
        bufs: &[io::IoSlice<'_>],
    ) -> Poll<io::Result<usize>> {
        let written = Pin::new(&mut self.inner).poll_write_vectored(cx, bufs);
        self.judged(cx, written)
    }
}
