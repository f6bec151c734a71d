//! Routes of the server and their handlers.

mod stream;

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use axum::Router;
use axum::body::{Body, to_bytes};
use axum::extract::{Path, Request, State};
use axum::http::{HeaderMap, StatusCode, header};
use axum::middleware::{Next, from_fn, from_fn_with_state};
use axum::response::sse::Sse;
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use mission::kind::pages::{Client, PersonPage, Refusal, Request as PageRequest, SupervisorPage};
use serde::Serialize;
use serde_json::{Value, json};
use tokio::time::timeout;

use views::gantt;

use self::stream::stream;
use super::access::keys::NoKeys;
use super::access::{Access, Link, Role, Session};
use super::connections::ConnectionGuard;
use super::engine::{Command, Handle};
use super::guard::{Hosts, guard};
use super::pages;
use super::published::{ClockState, Published};
use super::rate::Bucket;
use super::requests::{ServerRequest, SupervisorRequest};

/// Maximum size of a request's body (bytes).
const BODY: usize = 4096;
/// Lifetime of a session cookie (s): longer than any mission, so that it survives a restart of the browser.
const LASTS: u32 = 1_000_000;
/// Timeout for the body of a request.
const BODY_TIME: Duration = Duration::from_secs(5);

/// Shared state of all requests.
pub struct App {
    /// Links and sessions.
    pub access: Mutex<Access>,
    /// Rate limit of invalid links.
    pub links: Bucket,
    /// The engine.
    pub engine: Handle,
    /// The port, which is part of the names of cookies.
    pub port: u16,
}

type Shared = State<Arc<App>>;

/// Returns the router of all paths, behind the guard.
pub fn router(app: Arc<App>, hosts: Hosts) -> Router {
    Router::new()
        .route("/", get(root))
        .route("/static/{file}", get(file))
        .route("/p/{token}", get(link).post(open))
        .route("/s/{token}", get(link).post(open))
        .route("/person/{member}/", get(person_page))
        .route("/person/{member}/state", get(person_state))
        .route("/person/{member}/events", get(person_events))
        .route("/person/{member}/map.svg", get(person_map_svg))
        .route("/person/{member}/tell", get(wrong_method).post(person_tell))
        .route("/supervisor/", get(supervisor_page))
        .route("/supervisor/state", get(supervisor_state))
        .route("/supervisor/events", get(supervisor_events))
        .route("/supervisor/gantt.svg", get(gantt_svg))
        .route("/supervisor/map.svg", get(map_svg))
        .route("/supervisor/tell", get(wrong_method).post(supervisor_tell))
        .fallback(nothing)
        .layer(from_fn_with_state(app.clone(), recognise))
        .with_state(app)
        .layer(from_fn(move |request, next| guard(hosts.clone(), request, next)))
}

/// Moves a connection that presents a session to the places of that session.
async fn recognise(State(app): Shared, request: Request, next: Next) -> Response {
    if let Some(held) = request.extensions().get::<ConnectionGuard>()
        && let Some(role) = app.shown(request.headers())
    {
        held.shows(role);
    }
    next.run(request).await
}

async fn root() -> Response {
    pages::refusal(
        StatusCode::OK,
        "A mission",
        "This server shows each person of a mission their own page. Open the link that was given to you.",
    )
}

async fn nothing() -> Response {
    pages::refusal(StatusCode::NOT_FOUND, "Nothing here", "There is no such page. Open the link that was given to you.")
}

async fn wrong_method() -> Response {
    (StatusCode::METHOD_NOT_ALLOWED, [(header::ALLOW, "POST")]).into_response()
}

async fn file(Path(name): Path<String>) -> Response {
    match pages::file(&name) {
        Some(response) => response,
        None => nothing().await,
    }
}

impl App {
    fn access(&self) -> MutexGuard<'_, Access> {
        self.access.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Returns a role whose session the request's cookies present.
    fn shown(&self, headers: &HeaderMap) -> Option<Role> {
        let mut roles = cookies(headers).filter_map(|(name, secret)| Some((Role::of_cookie(name, self.port)?, secret)));
        let mut access = self.access();
        roles.find(|(role, secret)| access.session(*role, std::iter::once(*secret)).is_some()).map(|(role, _)| role)
    }

    /// Returns the session of this role that the request's cookies present, within its rate limit.
    fn session(&self, role: Role, headers: &HeaderMap) -> Result<Arc<Session>, Box<Response>> {
        let name = role.cookie(self.port);
        let secrets = cookies(headers).filter(|pair| pair.0 == name).map(|pair| pair.1);
        let session = self.access().session(role, secrets);
        match session {
            None => Err(Box::new(pages::refusal(
                StatusCode::UNAUTHORIZED,
                "Not signed in",
                "This page belongs to somebody. Open the link that was given to you; if it has been used, ask the supervisor for \
                 a new one.",
            ))),
            Some(session) if session.bucket.take() => Ok(session),
            Some(_) => Err(Box::new(too_often())),
        }
    }

    fn name(&self, role: Role) -> String {
        let published = self.engine.published.borrow();
        match role {
            Role::Supervisor => "supervisor".into(),
            Role::Person(member) => published.pages.people.get(&member).map_or_else(String::new, |of| of.name.clone()),
        }
    }

    /// Returns the state of a page twice: only the part that changes with events, and complete.
    pub fn state(&self, role: Role, published: &Published) -> (String, String) {
        let state = match role {
            Role::Person(member) => {
                PageState { person: published.pages.people.get(&member), ..PageState::of(published) }
            }
            Role::Supervisor => {
                let mut page = published.pages.supervisor.clone();
                for row in &mut page.members {
                    row.page = if row.paged { self.presence(row.member) } else { "simulated" };
                }
                PageState { supervisor: Some(page), ..PageState::of(published) }
            }
        };
        let still = PageState { clock: ClockState { time: 0.0, ..state.clock }, ..state.clone() };
        // Non-finite numbers become null; no other error is possible.
        let written = |state: &PageState| serde_json::to_string(state).unwrap_or_default();
        (written(&still), written(&state))
    }

    fn presence(&self, member: usize) -> &'static str {
        match self.access().presence(Role::Person(member)) {
            (false, _) => "link not opened",
            (true, true) => "open",
            (true, false) => "closed",
        }
    }
}

/// Returns the cookies of a request with their names.
fn cookies(headers: &HeaderMap) -> impl Iterator<Item = (&str, &str)> {
    let cookies = headers.get_all(header::COOKIE).into_iter().filter_map(|value| value.to_str().ok());
    cookies.flat_map(|all| all.split(';')).filter_map(|pair| pair.trim().split_once('='))
}

/// Content of a stream's message.
#[derive(Clone, Serialize)]
struct PageState<'p> {
    mission: &'p str,
    #[serde(flatten)]
    clock: ClockState,
    #[serde(skip_serializing_if = "Option::is_none")]
    person: Option<&'p PersonPage>,
    #[serde(flatten)]
    supervisor: Option<SupervisorPage>,
}

impl<'p> PageState<'p> {
    fn of(published: &'p Published) -> PageState<'p> {
        PageState { mission: &published.mission, clock: published.clock, person: None, supervisor: None }
    }
}

fn too_often() -> Response {
    let refused = json!({ "refused": "Too many requests. Wait a few seconds." });
    (StatusCode::TOO_MANY_REQUESTS, [(header::RETRY_AFTER, "2")], as_json(&refused)).into_response()
}

async fn link(State(app): Shared, Path(token): Path<String>, headers: HeaderMap) -> Response {
    let link = app.access().link(&token);
    match link {
        Link::Fresh(role) => {
            let mission = app.engine.published.borrow().mission.clone();
            pages::invitation(&mission, &app.name(role))
        }
        Link::Used(role) if app.session(role, &headers).is_ok() => see(&role.path(), None),
        Link::Used(role) => pages::used(&role.path()),
        Link::Unknown => unknown(&app),
    }
}

async fn open(State(app): Shared, Path(token): Path<String>, headers: HeaderMap) -> Response {
    let (link, exchanged) = {
        let mut access = app.access();
        (access.link(&token), access.exchange(&token))
    };
    match (link, exchanged) {
        (_, Ok(Some((role, secret)))) => {
            let origin = headers.get(header::ORIGIN).and_then(|origin| origin.to_str().ok());
            let secure = if origin.is_some_and(|origin| origin.starts_with("https://")) { "; Secure" } else { "" };
            let name = role.cookie(app.port);
            let kept = format!("Path=/; Max-Age={LASTS}; HttpOnly; SameSite=Strict{secure}");
            see(&role.path(), Some(format!("{name}={secret}; {kept}")))
        }
        (_, Err(e)) => pages::refusal(StatusCode::SERVICE_UNAVAILABLE, "Not now", &unkept(&e)),
        (Link::Used(role), _) if app.session(role, &headers).is_ok() => see(&role.path(), None),
        (Link::Used(role), _) => pages::used(&role.path()),
        _ => unknown(&app),
    }
}

/// Error message for a link that cannot be created or opened. It omits the file name, which is for the operator only.
fn unkept(why: &NoKeys) -> String {
    let why = match why {
        NoKeys::File { why, .. } => why.to_string(),
        other => other.to_string(),
    };
    format!("The owner of the page could not be recorded, so nothing was changed: {why}. Try again later.")
}

fn unknown(app: &App) -> Response {
    if !app.links.take() {
        return too_often();
    }
    pages::refusal(
        StatusCode::NOT_FOUND,
        "No such link",
        "This link is invalid. It may be incomplete, or replaced by a newer one: ask the supervisor.",
    )
}

fn see(path: &str, cookie: Option<String>) -> Response {
    let mut response = (StatusCode::SEE_OTHER, [(header::LOCATION, path.to_string())]).into_response();
    if let Some(value) = cookie.and_then(|cookie| cookie.parse().ok()) {
        response.headers_mut().insert(header::SET_COOKIE, value);
    }
    response
}

/// Returns the role of a person's path.
fn person(path: &str) -> Role {
    // An invalid number is that of no member.
    Role::Person(path.parse().unwrap_or(usize::MAX))
}

async fn person_page(State(app): Shared, Path(path): Path<String>, headers: HeaderMap) -> Response {
    app.session(person(&path), &headers).map_or_else(|refused| *refused, |_| pages::person())
}

async fn supervisor_page(State(app): Shared, headers: HeaderMap) -> Response {
    app.session(Role::Supervisor, &headers).map_or_else(|refused| *refused, |_| pages::supervisor())
}

async fn person_state(State(app): Shared, Path(path): Path<String>, headers: HeaderMap) -> Response {
    state(&app, person(&path), &headers)
}

async fn supervisor_state(State(app): Shared, headers: HeaderMap) -> Response {
    state(&app, Role::Supervisor, &headers)
}

fn state(app: &App, role: Role, headers: &HeaderMap) -> Response {
    if let Err(refused) = app.session(role, headers) {
        return *refused;
    }
    let published = app.engine.published.borrow().clone();
    ([(header::CONTENT_TYPE, "application/json")], app.state(role, &published).1).into_response()
}

async fn person_events(State(app): Shared, Path(path): Path<String>, headers: HeaderMap) -> Response {
    events(app, person(&path), &headers)
}

async fn supervisor_events(State(app): Shared, headers: HeaderMap) -> Response {
    events(app, Role::Supervisor, &headers)
}

fn events(app: Arc<App>, role: Role, headers: &HeaderMap) -> Response {
    match app.session(role, headers) {
        Ok(session) => Sse::new(stream(app, role, session)).into_response(),
        Err(refused) => *refused,
    }
}

async fn gantt_svg(State(app): Shared, headers: HeaderMap) -> Response {
    picture(&app, Role::Supervisor, &headers, |published| {
        let look = gantt::Look { now: Some(published.clock.time), until: None, styled: false };
        gantt::picture(&published.pages.chart, &look)
    })
}

async fn map_svg(State(app): Shared, headers: HeaderMap) -> Response {
    picture(&app, Role::Supervisor, &headers, |published| {
        let robots = published.pages.supervisor.members.iter().filter_map(|row| row.activity.at).collect();
        map_of(published, robots)
    })
}

/// The map, for a person who sees it.
async fn person_map_svg(State(app): Shared, Path(path): Path<String>, headers: HeaderMap) -> Response {
    let role = person(&path);
    let marks = |published: &Published| match role {
        Role::Person(member) => Some(published.pages.people.get(&member)?.content.map.as_ref()?.marks.clone()),
        Role::Supervisor => None,
    };
    // A person without a map gets nothing, even if signed in.
    if app.session(role, &headers).is_ok() && marks(&app.engine.published.borrow()).is_none() {
        return nothing().await;
    }
    picture(&app, role, &headers, |published| map_of(published, marks(published).unwrap_or_default()))
}

fn map_of(published: &Published, moving: Vec<[f64; 2]>) -> String {
    gantt::map(&published.pages.map, &gantt::Standing { moving, styled: false })
}

fn picture(app: &App, role: Role, headers: &HeaderMap, draw: impl FnOnce(&Published) -> String) -> Response {
    if let Err(refused) = app.session(role, headers) {
        return *refused;
    }
    let published = app.engine.published.borrow().clone();
    ([(header::CONTENT_TYPE, "image/svg+xml; charset=utf-8")], draw(&published)).into_response()
}

async fn person_tell(State(app): Shared, Path(path): Path<String>, request: Request) -> Response {
    let role = person(&path);
    match (body(&app, role, request).await, role) {
        (Ok(body), Role::Person(member)) => {
            send(&app, Command::Request(PageRequest { from: Client::Person(member), body })).await
        }
        (Err(refused), _) => *refused,
        (Ok(_), Role::Supervisor) => nothing().await,
    }
}

async fn supervisor_tell(State(app): Shared, request: Request) -> Response {
    let body = match body(&app, Role::Supervisor, request).await {
        Ok(body) => body,
        Err(refused) => return *refused,
    };
    match SupervisorRequest::read(body) {
        Ok(SupervisorRequest::Server(ServerRequest::Invite { member })) => invite(&app, member),
        Ok(SupervisorRequest::Server(ServerRequest::Run {})) => send(&app, Command::Clock(true)).await,
        Ok(SupervisorRequest::Server(ServerRequest::Stop {})) => send(&app, Command::Clock(false)).await,
        Ok(SupervisorRequest::Mission(body)) => {
            send(&app, Command::Request(PageRequest { from: Client::Supervisor, body })).await
        }
        Err(why) => rejected(why),
    }
}

/// Reads the JSON in a request of this role, at most [`BODY`] bytes.
async fn body(app: &App, role: Role, request: Request<Body>) -> Result<Value, Box<Response>> {
    app.session(role, request.headers())?;
    let kind = request.headers().get(header::CONTENT_TYPE).and_then(|kind| kind.to_str().ok());
    let kind = kind.map(|kind| kind.split(';').next().unwrap_or(kind).trim());
    if kind != Some("application/json") {
        return Err(Box::new(refused(
            StatusCode::UNSUPPORTED_MEDIA_TYPE,
            "A request is JSON, with that content type.",
        )));
    }
    let length = request.headers().get(header::CONTENT_LENGTH).and_then(|length| length.to_str().ok()?.parse().ok());
    let large = || Box::new(refused(StatusCode::PAYLOAD_TOO_LARGE, "A request has at most 4096 bytes."));
    if length.is_some_and(|length: u64| length > BODY as u64) {
        return Err(large());
    }
    let body = timeout(BODY_TIME, to_bytes(request.into_body(), BODY)).await;
    let late = |_| Box::new(refused(StatusCode::REQUEST_TIMEOUT, "The request did not arrive in time."));
    let body = body.map_err(late)?;
    let body = body.map_err(|_| large())?;
    serde_json::from_slice(&body).map_err(|e| Box::new(rejected(Refusal::Invalid(e.to_string()))))
}

async fn send(app: &App, command: Command) -> Response {
    match app.engine.send(command).await {
        Some(Ok(said)) => as_json(&json!({ "said": said })).into_response(),
        Some(Err(why)) => rejected(why),
        None => refused(StatusCode::SERVICE_UNAVAILABLE, "The mission is busy: nothing was recorded. Press again."),
    }
}

fn rejected(why: Refusal) -> Response {
    match why {
        Refusal::Invalid(why) => refused(StatusCode::BAD_REQUEST, &format!("The request is invalid: {why}.")),
        Refusal::NotNow(why) => refused(StatusCode::CONFLICT, &why),
    }
}

fn invite(app: &App, member: usize) -> Response {
    if !app.engine.published.borrow().pages.people.contains_key(&member) {
        return rejected(Refusal::Invalid("this member has no page".into()));
    }
    let role = Role::Person(member);
    match app.access().invite(role) {
        Ok(link) => {
            let said = format!("New link for {}. The old link and its page are invalid.", app.name(role));
            as_json(&json!({ "said": said, "link": link })).into_response()
        }
        Err(e) => refused(StatusCode::SERVICE_UNAVAILABLE, &unkept(&e)),
    }
}

fn as_json(value: &serde_json::Value) -> impl IntoResponse {
    ([(header::CONTENT_TYPE, "application/json")], value.to_string())
}

fn refused(status: StatusCode, why: &str) -> Response {
    (status, as_json(&json!({ "refused": why }))).into_response()
}
