//! Access to pages: one-time links, and the sessions that they create.
//!
//! A link and the cookie of a session are signed numbers ([`keys`]). The first use of a link creates a
//! session; a second use is rejected. The opened link of each page, which identifies the valid session, is stored with
//! the key.

pub mod keys;

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use serde::{Deserialize, Serialize};

use self::keys::{Keys, Kind, NoKeys};
use super::rate::Bucket;

/// Owner of a page.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Role {
    /// The supervisor of the mission.
    Supervisor,
    /// The person that is this member.
    Person(usize),
}

impl Role {
    /// Returns the path of the role's page, which is a prefix of all its paths.
    pub fn path(self) -> String {
        match self {
            Role::Supervisor => "/supervisor/".to_string(),
            Role::Person(member) => format!("/person/{member}/"),
        }
    }

    /// Returns the path of a link with this signed number.
    pub fn link(self, signed: &str) -> String {
        match self {
            Role::Supervisor => format!("/s/{signed}"),
            Role::Person(member) => format!("/p/{member}-{signed}"),
        }
    }

    /// Returns the name of the role's cookie. It contains port and role, since a browser sends the cookies of a host to
    /// all of its ports, and one browser may show the pages of several people.
    pub fn cookie(self, port: u16) -> String {
        match self {
            Role::Supervisor => format!("hierarq_{port}_supervisor"),
            Role::Person(member) => format!("hierarq_{port}_person_{member}"),
        }
    }

    /// Returns the role whose cookie has this name.
    pub fn of_cookie(name: &str, port: u16) -> Option<Role> {
        let rest = name.strip_prefix("hierarq_")?.strip_prefix(&port.to_string())?.strip_prefix('_')?;
        let person = || Some(Role::Person(rest.strip_prefix("person_")?.parse().ok()?));
        let role = if rest == "supervisor" { Role::Supervisor } else { person()? };
        (role.cookie(port) == name).then_some(role)
    }
}

/// State of a link.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Link {
    /// It has not been used.
    Fresh(Role),
    /// It has created a session.
    Used(Role),
    /// It does not exist, or a newer one replaces it.
    Unknown,
}

/// Maximum number of event streams of one session; a further one ends the oldest.
const STREAMS: u64 = 3;

/// Shared state of the requests of one session.
#[derive(Debug)]
pub struct Session {
    /// Role whose page it opens.
    pub role: Role,
    /// Number of the link that created it.
    number: u64,
    /// Rate limit of its requests.
    pub bucket: Bucket,
    begun: AtomicU64,
    open: AtomicU64,
    ended: AtomicU64,
}

impl Session {
    fn new(role: Role, number: u64) -> Session {
        let counts = || AtomicU64::new(0);
        Session { role, number, bucket: Bucket::of_a_session(), begun: counts(), open: counts(), ended: counts() }
    }

    /// Registers a new stream; returns its number.
    pub fn begin_stream(&self) -> u64 {
        self.open.fetch_add(1, Ordering::Relaxed);
        self.begun.fetch_add(1, Ordering::Relaxed) + 1
    }

    /// Registers the end of a stream.
    pub fn end_stream(&self) {
        self.open.fetch_sub(1, Ordering::Relaxed);
    }

    /// Returns false once newer streams have replaced this one, or the session has ended.
    pub fn goes_on(&self, stream: u64) -> bool {
        self.begun.load(Ordering::Relaxed) < stream + STREAMS && self.ended.load(Ordering::Relaxed) == 0
    }

    /// Returns true while a page is listening.
    pub fn listens(&self) -> bool {
        self.open.load(Ordering::Relaxed) > 0
    }
}

/// All links and sessions of a server.
pub struct Access {
    keys: Keys,
    /// Sessions that have been presented to this server.
    sessions: Vec<Arc<Session>>,
}

impl Access {
    /// Creates the access control with these keys.
    pub fn new(keys: Keys) -> Access {
        Access { keys, sessions: Vec::new() }
    }

    /// Creates a new link for this role, and ends its older links and sessions; returns the path of the link.
    ///
    /// # Errors
    ///
    /// It cannot be stored. Nothing has changed then.
    pub fn invite(&mut self, role: Role) -> Result<String, NoKeys> {
        self.keys.renew(role)?;
        self.end(role);
        Ok(self.keys.path(role).unwrap_or_default())
    }

    fn end(&mut self, role: Role) {
        for session in self.sessions.iter().filter(|session| session.role == role) {
            session.ended.store(1, Ordering::Relaxed);
        }
        self.sessions.retain(|session| session.role != role);
    }

    /// Returns the state of a link, from the last part of its path.
    pub fn link(&self, token: &str) -> Link {
        self.read(token).map_or(Link::Unknown, |(link, _)| link)
    }

    fn read(&self, token: &str) -> Option<(Link, u64)> {
        let (role, signed) = match token.split_once('-')? {
            (agent, signed) if signed.contains('-') => (Role::Person(agent.parse().ok()?), signed),
            _ => (Role::Supervisor, token),
        };
        let page = self.keys.page(role)?;
        let number = self.keys.number(Kind::Link, role, signed)?;
        match page.opened {
            Some(opened) if opened == number => Some((Link::Used(role), number)),
            _ => page.opens(number).then_some((Link::Fresh(role), number)),
        }
    }

    /// Uses a link: returns its role and the secret of the new session, or `None` if the link is not fresh. The role's
    /// previous session ends.
    ///
    /// # Errors
    ///
    /// It cannot be stored. Nothing has changed then.
    pub fn exchange(&mut self, token: &str) -> Result<Option<(Role, String)>, NoKeys> {
        let Some((Link::Fresh(role), number)) = self.read(token) else { return Ok(None) };
        self.keys.open(role, number)?;
        self.end(role);
        Ok(Some((role, self.keys.signed(Kind::Session, role, number))))
    }

    /// Returns the session of this role whose secret is among these.
    pub fn session<'a>(&mut self, role: Role, mut secrets: impl Iterator<Item = &'a str>) -> Option<Arc<Session>> {
        let opened = self.keys.page(role)?.opened?;
        if !secrets.any(|secret| self.keys.number(Kind::Session, role, secret) == Some(opened)) {
            return None;
        }
        let known = self.sessions.iter().find(|session| (session.role, session.number) == (role, opened));
        if let Some(known) = known {
            return Some(known.clone());
        }
        let session = Arc::new(Session::new(role, opened));
        self.sessions.push(session.clone());
        Some(session)
    }

    /// Returns whether this role has opened its link, and whether one of its pages is listening now.
    pub fn presence(&self, role: Role) -> (bool, bool) {
        let opened = self.keys.page(role).is_some_and(|page| page.opened.is_some());
        (opened, self.sessions.iter().any(|session| session.role == role && session.listens()))
    }
}

#[cfg(test)]
mod tests {
    use crate::access::keys::Page;

    use super::*;

    fn access() -> Access {
        let pages = [Role::Supervisor, Role::Person(0), Role::Person(1)].map(|role| Page::new(role, None));
        Access::new(Keys::passing("field", pages.to_vec()).expect("random"))
    }

    /// Returns the last part of a new link's path.
    fn invite(access: &mut Access, role: Role) -> String {
        let path = access.invite(role).expect("random");
        path.rsplit('/').next().expect("a part").to_string()
    }

    #[test]
    fn a_link_opens_once() {
        let mut access = access();
        let token = invite(&mut access, Role::Person(1));
        let other = invite(&mut access, Role::Supervisor);
        assert_ne!(token, other);
        assert_eq!(access.link(&token), Link::Fresh(Role::Person(1)));
        assert_eq!(access.link(&other), Link::Fresh(Role::Supervisor));
        let (role, id) = access.exchange(&token).expect("kept").expect("fresh");
        assert_eq!(role, Role::Person(1));
        assert_eq!(access.link(&token), Link::Used(Role::Person(1)));
        assert!(access.exchange(&token).expect("kept").is_none());
        assert!(access.session(Role::Person(1), [id.as_str()].into_iter()).is_some());
        assert!(access.session(Role::Supervisor, [id.as_str()].into_iter()).is_none(), "of another role");
        assert!(access.session(Role::Person(1), [token.as_str(), ""].into_iter()).is_none(), "the link is no session");
        assert_eq!(access.link(&token.replacen("1-", "0-", 1)), Link::Unknown, "of another person");
        assert_eq!(access.link(""), Link::Unknown);
        assert_eq!(access.link(&token[1..]), Link::Unknown);
    }

    #[test]
    fn a_newer_link_ends_what_the_older_opened() {
        let mut access = access();
        let token = invite(&mut access, Role::Person(0));
        let (role, id) = access.exchange(&token).expect("kept").expect("fresh");
        let session = access.session(role, [id.as_str()].into_iter()).expect("open");
        let stream = session.begin_stream();
        assert!(session.goes_on(stream) && session.listens());
        let newer = invite(&mut access, Role::Person(0));
        assert_eq!((access.link(&token), access.link(&newer)), (Link::Unknown, Link::Fresh(role)));
        assert!(access.session(role, [id.as_str()].into_iter()).is_none());
        assert!(!session.goes_on(stream));
    }

    #[test]
    fn of_several_links_the_newest_that_is_opened_counts() {
        let mut access = access();
        let (role, first) = (Role::Person(0), invite(&mut access, Role::Person(0)));
        // Links that another process made with the same key.
        let made = |access: &Access, more: u64| {
            let number = access.keys.page(role).expect("a page").link + more;
            format!("0-{}", access.keys.signed(Kind::Link, role, number))
        };
        let (second, third) = (made(&access, 1), made(&access, 2));
        let (_, of_second) = access.exchange(&second).expect("kept").expect("fresh");
        assert_eq!(access.link(&first), Link::Unknown);
        let (_, of_third) = access.exchange(&third).expect("kept").expect("fresh");
        assert!(access.session(role, [of_second.as_str()].into_iter()).is_none());
        assert!(access.session(role, [of_third.as_str()].into_iter()).is_some());
        assert_eq!((access.link(&second), access.link(&third)), (Link::Unknown, Link::Used(role)));
    }

    #[test]
    fn a_further_stream_ends_the_oldest() {
        let mut access = access();
        let token = invite(&mut access, Role::Supervisor);
        let (role, id) = access.exchange(&token).expect("kept").expect("fresh");
        let session = access.session(role, [id.as_str()].into_iter()).expect("open");
        let streams: Vec<u64> = (0..STREAMS).map(|_| session.begin_stream()).collect();
        assert!(streams.iter().all(|stream| session.goes_on(*stream)));
        session.begin_stream();
        assert!(!session.goes_on(streams[0]) && session.goes_on(streams[1]));
    }

    #[test]
    fn a_cookie_says_whose_it_is() {
        for role in [Role::Supervisor, Role::Person(0), Role::Person(17)] {
            assert_eq!(Role::of_cookie(&role.cookie(8080), 8080), Some(role));
        }
        for name in ["hierarq_80_supervisor", "hierarq_8080_person_01", "hierarq_8080_person_", "supervisor", ""] {
            assert_eq!(Role::of_cookie(name, 8080), None, "{name}");
        }
    }
}
