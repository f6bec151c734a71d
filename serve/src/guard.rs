//! Checks of every request before it is processed, and headers of every response.
//!
//! - `Host` must be the address of this connection, or a configured name: a foreign name that resolves to this address
//!   (DNS rebinding) is rejected.
//! - A request that changes state must come from a page of this server: `Origin` must be that same host.
//!   `Sec-Fetch-Site`, if the browser sends it, must agree.
//! - A response allows no scripts but ours, and no frames; it is not cached.

use std::net::SocketAddr;

use axum::extract::Request;
use axum::http::{HeaderMap, HeaderName, HeaderValue, Method, StatusCode, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};

use super::pages;

/// Local address of a connection.
#[derive(Clone, Copy, Debug)]
pub struct Local(pub SocketAddr);

/// Host names of the server, in addition to its address.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Hosts(pub Vec<String>);

impl Hosts {
    /// Returns true if a request with this `Host` on this local address is meant for this server.
    pub fn allow(&self, host: &str, local: SocketAddr) -> bool {
        let host = host.to_ascii_lowercase();
        let own = host == local.to_string() || (local.port() == 80 && host == bare(local));
        let loopback = local.ip().is_loopback() && host == format!("localhost:{}", local.port());
        let named = |name: &String| host == *name || host == format!("{name}:{}", local.port());
        own || loopback || self.0.iter().any(named)
    }
}

fn bare(local: SocketAddr) -> String {
    match local {
        SocketAddr::V4(v4) => v4.ip().to_string(),
        SocketAddr::V6(v6) => format!("[{}]", v6.ip()),
    }
}

/// Reason for rejecting a request before it is processed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refused {
    /// The method is not GET, HEAD or POST.
    Method,
    /// The request is for another host.
    Host,
    /// The request comes from a page of another origin.
    Origin,
}

/// Checks the method, host and origin of a request.
///
/// # Errors
///
/// The reason for rejecting it.
pub fn check(method: &Method, headers: &HeaderMap, local: SocketAddr, hosts: &Hosts) -> Result<(), Refused> {
    if !matches!(*method, Method::GET | Method::HEAD | Method::POST) {
        return Err(Refused::Method);
    }
    let host = only(headers, header::HOST).ok_or(Refused::Host)?;
    if !hosts.allow(host, local) {
        return Err(Refused::Host);
    }
    let site = headers.get("sec-fetch-site").map(HeaderValue::as_bytes);
    let elsewhere = !matches!(site, None | Some(b"same-origin" | b"none"));
    if *method == Method::POST {
        let origin = only(headers, header::ORIGIN).ok_or(Refused::Origin)?;
        let of = origin.strip_prefix("http://").or_else(|| origin.strip_prefix("https://"));
        let ours = of.is_some_and(|of| of.eq_ignore_ascii_case(host));
        return if ours && !elsewhere { Ok(()) } else { Err(Refused::Origin) };
    }
    // Links may be followed from anywhere; subresources are only for our own pages.
    let followed = headers.get("sec-fetch-mode").is_some_and(|mode| mode == "navigate")
        && headers.get("sec-fetch-dest").is_some_and(|dest| dest == "document");
    if elsewhere && !followed { Err(Refused::Origin) } else { Ok(()) }
}

/// Returns the value of a header that occurs exactly once.
fn only(headers: &HeaderMap, name: HeaderName) -> Option<&str> {
    let mut values = headers.get_all(name).iter();
    let value = values.next()?.to_str().ok()?;
    values.next().is_none().then_some(value)
}

/// Rejects requests by [`check`], and adds the headers of every response.
pub async fn guard(hosts: Hosts, request: Request, next: Next) -> Response {
    let local = request.extensions().get::<Local>().copied();
    let checked =
        local.map_or(Err(Refused::Host), |Local(local)| check(request.method(), request.headers(), local, &hosts));
    let mut response = match checked {
        Ok(()) => next.run(request).await,
        Err(Refused::Method) => {
            let allow = [(header::ALLOW, "GET, HEAD, POST")];
            (StatusCode::METHOD_NOT_ALLOWED, allow, "this server accepts GET and POST only\n").into_response()
        }
        Err(Refused::Host) => pages::refusal(
            StatusCode::MISDIRECTED_REQUEST,
            "Not this address",
            "The address in your browser is not one of this server's. Use the link exactly as it was printed; if people \
             reach the server under another name, whoever runs it must give that name with --host.",
        ),
        Err(Refused::Origin) => pages::refusal(
            StatusCode::FORBIDDEN,
            "From another page",
            "This request was made by a page of another site, or does not say which page made it. Nothing was changed.",
        ),
    };
    let headers = response.headers_mut();
    for (name, value) in HEADERS {
        headers.insert(HeaderName::from_static(name), HeaderValue::from_static(value));
    }
    response
}

const HEADERS: [(&str, &str); 8] = [
    (
        "content-security-policy",
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; connect-src 'self'; form-action 'self'; \
         base-uri 'none'; frame-ancestors 'none'",
    ),
    ("x-content-type-options", "nosniff"),
    ("x-frame-options", "DENY"),
    // With `no-referrer` a browser would send `Origin: null` for the form that opens a link.
    ("referrer-policy", "same-origin"),
    ("cross-origin-opener-policy", "same-origin"),
    ("cross-origin-resource-policy", "same-origin"),
    ("permissions-policy", "camera=(), microphone=(), geolocation=()"),
    ("cache-control", "no-store"),
];

#[cfg(test)]
mod tests {
    use super::*;

    fn asked(method: Method, headers: &[(&'static str, &str)]) -> Result<(), Refused> {
        let mut map = HeaderMap::new();
        for (name, value) in headers {
            map.append(*name, HeaderValue::from_str(value).expect("a value"));
        }
        let local = "192.168.1.7:8080".parse().expect("an address");
        check(&method, &map, local, &Hosts(vec!["field.example".into()]))
    }

    #[test]
    fn only_our_own_names_are_answered() {
        for host in ["192.168.1.7:8080", "field.example", "field.example:8080", "Field.Example"] {
            assert_eq!(asked(Method::GET, &[("host", host)]), Ok(()), "{host}");
        }
        for host in
            ["192.168.1.7", "192.168.1.7:80", "evil.example:8080", "localhost:8080", "field.example.evil.example", ""]
        {
            assert_eq!(asked(Method::GET, &[("host", host)]), Err(Refused::Host), "{host}");
        }
        assert_eq!(asked(Method::GET, &[]), Err(Refused::Host));
        let twice = [("host", "field.example"), ("host", "evil.example")];
        assert_eq!(asked(Method::GET, &twice), Err(Refused::Host));
        let hosts = Hosts::default();
        let local: SocketAddr = "[::1]:4000".parse().expect("an address");
        assert!(hosts.allow("[::1]:4000", local) && hosts.allow("localhost:4000", local));
        assert!(!hosts.allow("127.0.0.1:4000", local));
        assert!(hosts.allow("10.0.0.1", "10.0.0.1:80".parse().expect("an address")));
    }

    #[test]
    fn what_changes_something_comes_from_our_own_page() {
        let host = ("host", "192.168.1.7:8080");
        let told = |more: &[(&'static str, &str)]| asked(Method::POST, &[&[host], more].concat());
        assert_eq!(told(&[("origin", "http://192.168.1.7:8080")]), Ok(()));
        assert_eq!(told(&[("origin", "https://192.168.1.7:8080"), ("sec-fetch-site", "same-origin")]), Ok(()));
        for bad in
            ["null", "http://192.168.1.7", "http://evil.example", "192.168.1.7:8080", "ftp://192.168.1.7:8080", ""]
        {
            assert_eq!(told(&[("origin", bad)]), Err(Refused::Origin), "{bad}");
        }
        assert_eq!(told(&[]), Err(Refused::Origin));
        assert_eq!(told(&[("origin", "http://field.example")]), Err(Refused::Origin), "the other name of ours");
        let mixed = [("origin", "http://192.168.1.7:8080"), ("sec-fetch-site", "cross-site")];
        assert_eq!(told(&mixed), Err(Refused::Origin));
    }

    #[test]
    fn a_link_may_be_followed_from_anywhere_and_nothing_be_embedded() {
        let host = ("host", "192.168.1.7:8080");
        let read = |more: &[(&'static str, &str)]| asked(Method::GET, &[&[host], more].concat());
        let followed =
            [("sec-fetch-site", "cross-site"), ("sec-fetch-mode", "navigate"), ("sec-fetch-dest", "document")];
        assert_eq!(read(&followed), Ok(()));
        let framed = [("sec-fetch-site", "cross-site"), ("sec-fetch-mode", "navigate"), ("sec-fetch-dest", "iframe")];
        assert_eq!(read(&framed), Err(Refused::Origin));
        assert_eq!(read(&[("sec-fetch-site", "cross-site"), ("sec-fetch-mode", "no-cors")]), Err(Refused::Origin));
        assert_eq!(read(&[("sec-fetch-site", "same-site")]), Err(Refused::Origin));
        assert_eq!(read(&[("sec-fetch-site", "none")]), Ok(()));
        assert_eq!(asked(Method::DELETE, &[host]), Err(Refused::Method));
        assert_eq!(asked(Method::OPTIONS, &[host]), Err(Refused::Method));
    }
}
