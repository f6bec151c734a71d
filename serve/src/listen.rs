//! Connections: timeouts for headers and for unread responses. [`connections`](super::connections) limits their number.

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

use super::connections::{ConnectionGuard, Connections};
use super::guard::Local;

/// Timeout for the header of the first request.
const FIRST: Duration = Duration::from_secs(4);
/// Timeout for the header of each further request on an open connection.
const HEADER: Duration = Duration::from_secs(10);
/// Timeout for a client that reads nothing of a response.
const TAKEN: Duration = Duration::from_secs(20);
/// Timeout for pending responses when the server ends.
const FAREWELL: Duration = Duration::from_secs(3);
/// Maximum size of a header (bytes).
const HEADER_BYTES: usize = 16 * 1024;

/// Serves connections until `end` becomes true.
pub async fn serve(listener: TcpListener, router: Router, mut end: watch::Receiver<bool>) {
    let connections = Arc::new(Connections::default());
    let graceful = GracefulShutdown::new();
    loop {
        let accepted = tokio::select! {
            accepted = listener.accept() => accepted,
            _ = end.wait_for(|end| *end) => break,
        };
        let Ok((stream, from)) = accepted else {
            // Probably out of file descriptors: end one connection.
            connections.make_room();
            sleep(Duration::from_millis(50)).await;
            continue;
        };
        let Ok(local) = stream.local_addr() else { continue };
        let guard = connections.take(from.ip());
        let connection = graceful.watch(connection(stream, router.clone(), local, guard.clone()));
        tokio::spawn(async move {
            let registered = guard.connection();
            let dawdles = async {
                sleep(FIRST).await;
                if registered.asked() {
                    std::future::pending::<()>().await;
                }
            };
            tokio::select! {
                // Errors of a connection concern only its client.
                _ = connection => {}
                () = registered.ended() => {}
                () = dawdles => {}
            }
        });
        // Lets the new connection present its session before the next one may replace it.
        yield_now().await;
    }
    let _ = timeout(FAREWELL, graceful.shutdown()).await;
}

fn connection(
    stream: TcpStream,
    router: Router,
    local: SocketAddr,
    guard: ConnectionGuard,
) -> impl hyper_util::server::graceful::GracefulConnection<Error = hyper::Error> {
    let _ = stream.set_nodelay(true);
    let router = TowerToHyperService::new(router);
    let service = service_fn(move |mut request: hyper::Request<hyper::body::Incoming>| {
        guard.connection().asks();
        request.extensions_mut().insert(Local(local));
        request.extensions_mut().insert(guard.clone());
        router.call(request)
    });
    http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(HEADER)
        .max_buf_size(HEADER_BYTES)
        .serve_connection(Patient { inner: TokioIo::new(stream), waiting: None }, service)
}

/// A stream that fails if its other end reads nothing for [`TAKEN`].
struct Patient {
    inner: TokioIo<TcpStream>,
    waiting: Option<Pin<Box<Sleep>>>,
}

impl Patient {
    /// Returns the result of a write, or a timeout.
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
