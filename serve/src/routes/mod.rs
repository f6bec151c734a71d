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
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::json;
use tokio::time::timeout;

use views::gantt;

use self::stream::stream;
use super::access::keys::NoKeys;
use super::access::{Access, Link, Role, Session};
use super::engine::Handle;
use super::guard::{Hosts, guard};
use super::pages;
use super::places::Held;
use super::rate::Bucket;
use super::told::{PersonTells, SupervisorTells, Tells};
use super::view::{ClockView, PersonView, Published, SupervisorView};

/// Maximum size of a report (bytes).
const BODY: usize = 4096;
/// Lifetime of a session cookie (s): longer than any mission, so that it survives a restart of the browser.
const LASTS: u32 = 1_000_000;
/// Timeout for the body of a report.
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
    /// For each agent, true if it has a page.
    pub paged: Vec<bool>,
}

type Shared = State<Arc<App>>;

/// Returns the router of all paths, behind the guard.
pub fn router(app: Arc<App>, hosts: Hosts) -> Router {
    Router::new()
        .route("/", get(root))
        .route("/static/{file}", get(file))
        .route("/p/{token}", get(link).post(open))
        .route("/s/{token}", get(link).post(open))
        .route("/person/{agent}/", get(person_page))
        .route("/person/{agent}/state", get(person_state))
        .route("/person/{agent}/events", get(person_events))
        .route("/person/{agent}/tell", get(wrong_method).post(person_tell))
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
    if let Some(held) = request.extensions().get::<Held>()
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
            Role::Person(agent) => published.people.get(agent).map_or_else(String::new, |person| person.name.clone()),
        }
    }

    /// Returns the state of a page twice: only the part that changes with events, and complete.
    pub fn state(&self, role: Role, published: &Published) -> (String, String) {
        let state = match role {
            Role::Person(agent) => Shown { person: published.people.get(agent), ..Shown::of(published) },
            Role::Supervisor => {
                let mut view = published.supervisor.clone();
                for (agent, row) in view.agents.iter_mut().enumerate() {
                    row.page = self.presence(agent).into();
                    row.paged = self.paged.get(agent) == Some(&true);
                }
                Shown { supervisor: Some(view), ..Shown::of(published) }
            }
        };
        let still = Shown { clock: ClockView { time: 0.0, ..state.clock }, ..state.clone() };
        // Non-finite numbers become null; no other error is possible.
        let written = |shown: &Shown| serde_json::to_string(shown).unwrap_or_default();
        (written(&still), written(&state))
    }

    fn presence(&self, agent: usize) -> &'static str {
        match (self.paged.get(agent), self.access().presence(Role::Person(agent))) {
            (Some(true), (false, _)) => "link not opened",
            (Some(true), (true, true)) => "open",
            (Some(true), (true, false)) => "closed",
            _ => "simulated",
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
struct Shown<'p> {
    mission: &'p str,
    #[serde(flatten)]
    clock: ClockView,
    #[serde(skip_serializing_if = "Option::is_none")]
    person: Option<&'p PersonView>,
    #[serde(flatten)]
    supervisor: Option<SupervisorView>,
}

impl<'p> Shown<'p> {
    fn of(published: &'p Published) -> Shown<'p> {
        Shown { mission: &published.mission, clock: published.clock, person: None, supervisor: None }
    }
}

fn too_often() -> Response {
    let said = json!({ "refused": "That was too often in a short time. Wait a few seconds." });
    (StatusCode::TOO_MANY_REQUESTS, [(header::RETRY_AFTER, "2")], as_json(&said)).into_response()
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
    format!("It could not be written down who has which page, so nothing was changed: {why}. Try again later.")
}

fn unknown(app: &App) -> Response {
    if !app.links.take() {
        return too_often();
    }
    pages::refusal(
        StatusCode::NOT_FOUND,
        "No such link",
        "This link opens nothing. It may be incomplete, or a newer one has taken its place: ask the supervisor.",
    )
}

fn see(path: &str, cookie: Option<String>) -> Response {
    let mut response = (StatusCode::SEE_OTHER, [(header::LOCATION, path.to_string())]).into_response();
    if let Some(value) = cookie.and_then(|cookie| cookie.parse().ok()) {
        response.headers_mut().insert(header::SET_COOKIE, value);
    }
    response
}

/// Returns the role of an agent's path.
fn agent(path: &str) -> Role {
    // An invalid number is the index of no agent.
    Role::Person(path.parse().unwrap_or(usize::MAX))
}

async fn person_page(State(app): Shared, Path(path): Path<String>, headers: HeaderMap) -> Response {
    app.session(agent(&path), &headers).map_or_else(|refused| *refused, |_| pages::person())
}

async fn supervisor_page(State(app): Shared, headers: HeaderMap) -> Response {
    app.session(Role::Supervisor, &headers).map_or_else(|refused| *refused, |_| pages::supervisor())
}

async fn person_state(State(app): Shared, Path(path): Path<String>, headers: HeaderMap) -> Response {
    state(&app, agent(&path), &headers)
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
    events(app, agent(&path), &headers)
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
    picture(&app, &headers, |published| {
        let look = gantt::Look { now: Some(published.clock.time), until: None, styled: false };
        gantt::picture(&published.plan, &look)
    })
}

async fn map_svg(State(app): Shared, headers: HeaderMap) -> Response {
    picture(&app, &headers, |published| {
        let robots = published.supervisor.robots.iter().filter_map(|robot| robot.at).collect();
        let standing = gantt::Standing { robots, styled: false };
        published.map.as_ref().map_or_else(String::new, |map| gantt::map(map, &standing))
    })
}

fn picture(app: &App, headers: &HeaderMap, draw: impl FnOnce(&Published) -> String) -> Response {
    if let Err(refused) = app.session(Role::Supervisor, headers) {
        return *refused;
    }
    let published = app.engine.published.borrow().clone();
    ([(header::CONTENT_TYPE, "image/svg+xml; charset=utf-8")], draw(&published)).into_response()
}

async fn person_tell(State(app): Shared, Path(path): Path<String>, request: Request) -> Response {
    let role = agent(&path);
    let told = told::<PersonTells>(&app, role, request).await;
    match (told, role) {
        (Ok(told), Role::Person(agent)) => answer(&app, Tells::Person(agent, told)).await,
        (Err(refused), _) => *refused,
        (Ok(_), Role::Supervisor) => nothing().await,
    }
}

async fn supervisor_tell(State(app): Shared, request: Request) -> Response {
    match told::<SupervisorTells>(&app, Role::Supervisor, request).await {
        Ok(SupervisorTells::Invite { agent }) => invite(&app, agent),
        Ok(told) => answer(&app, Tells::Supervisor(told)).await,
        Err(refused) => *refused,
    }
}

/// Parses the report in a request of this role: JSON of at most [`BODY`] bytes.
async fn told<T: DeserializeOwned>(app: &App, role: Role, request: Request<Body>) -> Result<T, Box<Response>> {
    app.session(role, request.headers())?;
    let kind = request.headers().get(header::CONTENT_TYPE).and_then(|kind| kind.to_str().ok());
    let kind = kind.map(|kind| kind.split(';').next().unwrap_or(kind).trim());
    if kind != Some("application/json") {
        return Err(Box::new(refused(
            StatusCode::UNSUPPORTED_MEDIA_TYPE,
            "What is told is JSON, with that content type.",
        )));
    }
    let length = request.headers().get(header::CONTENT_LENGTH).and_then(|length| length.to_str().ok()?.parse().ok());
    let large = || Box::new(refused(StatusCode::PAYLOAD_TOO_LARGE, "What is told has at most 4096 bytes."));
    if length.is_some_and(|length: u64| length > BODY as u64) {
        return Err(large());
    }
    let body = timeout(BODY_TIME, to_bytes(request.into_body(), BODY)).await;
    let late = |_| Box::new(refused(StatusCode::REQUEST_TIMEOUT, "What was told did not arrive in time."));
    let body = body.map_err(late)?;
    let body = body.map_err(|_| large())?;
    let unread = |e| Box::new(refused(StatusCode::BAD_REQUEST, &format!("That is not understood: {e}.")));
    serde_json::from_slice(&body).map_err(unread)
}

async fn answer(app: &App, tells: Tells) -> Response {
    match app.engine.tell(tells).await {
        Some(Ok(said)) => as_json(&json!({ "said": said })).into_response(),
        Some(Err(why)) => refused(StatusCode::CONFLICT, &why),
        None => refused(StatusCode::SERVICE_UNAVAILABLE, "The mission is busy: nothing was noted. Press again."),
    }
}

fn invite(app: &App, agent: usize) -> Response {
    if app.paged.get(agent) != Some(&true) {
        return refused(StatusCode::CONFLICT, "This agent is simulated and has no page.");
    }
    let role = Role::Person(agent);
    match app.access().invite(role) {
        Ok(link) => {
            let said = format!("A new link for {}; the old one, and what it opened, has ended.", app.name(role));
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
