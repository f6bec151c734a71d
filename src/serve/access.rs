//! Who may see which page: links that open once, and the sessions that they become.
//!
//! A link holds 128 random bits. The first use turns it into a session, whose own 128 bits a cookie holds; a second use is
//! refused. Nothing of it is written to a disk.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use super::rate::Bucket;

/// Whose page it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Role {
    /// Who watches over the mission.
    Supervisor,
    /// The agent of this index.
    Person(usize),
}

impl Role {
    /// The path of its page, and of all below it.
    pub fn path(self) -> String {
        match self {
            Role::Supervisor => "/supervisor/".to_string(),
            Role::Person(agent) => format!("/person/{agent}/"),
        }
    }

    /// The path of a link with this token.
    pub fn link(self, token: &str) -> String {
        match self {
            Role::Supervisor => format!("/s/{token}"),
            Role::Person(_) => format!("/p/{token}"),
        }
    }

    /// The name of its cookie: a browser sends the cookies of one host to all of its ports, and one browser may show the
    /// pages of several people.
    pub fn cookie(self, port: u16) -> String {
        match self {
            Role::Supervisor => format!("hierarq_{port}_supervisor"),
            Role::Person(agent) => format!("hierarq_{port}_person_{agent}"),
        }
    }
}

/// What a link is worth.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Link {
    /// Nobody has used it.
    Fresh(Role),
    /// It has become a session.
    Used(Role),
    /// There is no such link, or a newer one has taken its place.
    Unknown,
}

/// Most streams of events of one session; a further one ends the oldest.
const STREAMS: u64 = 3;

/// What the requests of one session share.
#[derive(Debug)]
pub struct Session {
    id: String,
    /// Whose page it opens.
    pub role: Role,
    /// What it may still ask for.
    pub bucket: Bucket,
    begun: AtomicU64,
    open: AtomicU64,
    ended: AtomicU64,
}

impl Session {
    /// Notes that a stream begins; its number.
    pub fn begin_stream(&self) -> u64 {
        self.open.fetch_add(1, Ordering::Relaxed);
        self.begun.fetch_add(1, Ordering::Relaxed) + 1
    }

    /// Notes that a stream has ended.
    pub fn end_stream(&self) {
        self.open.fetch_sub(1, Ordering::Relaxed);
    }

    /// False once newer streams have taken the place of this one, or the session has ended.
    pub fn goes_on(&self, stream: u64) -> bool {
        self.begun.load(Ordering::Relaxed) < stream + STREAMS && self.ended.load(Ordering::Relaxed) == 0
    }

    /// True while a page listens.
    pub fn listens(&self) -> bool {
        self.open.load(Ordering::Relaxed) > 0
    }
}

struct Invitation {
    token: String,
    role: Role,
    used: bool,
}

/// All links and sessions of a server.
pub struct Access {
    invitations: Vec<Invitation>,
    sessions: Vec<Arc<Session>>,
}

impl Access {
    /// No link and no session.
    pub fn new() -> Access {
        Access { invitations: Vec::new(), sessions: Vec::new() }
    }

    /// A new link for this role; its token. Older links and sessions of the role end.
    ///
    /// # Errors
    ///
    /// The system gives no random numbers.
    pub fn invite(&mut self, role: Role) -> Result<String, getrandom::Error> {
        let token = secret()?;
        self.invitations.retain(|invitation| invitation.role != role);
        self.sessions.iter().filter(|session| session.role == role).for_each(|session| {
            session.ended.store(1, Ordering::Relaxed);
        });
        self.sessions.retain(|session| session.role != role);
        self.invitations.push(Invitation { token: token.clone(), role, used: false });
        Ok(token)
    }

    /// What this token is worth.
    pub fn link(&self, token: &str) -> Link {
        match self.invitations.iter().find(|invitation| same(&invitation.token, token)) {
            Some(Invitation { role, used: false, .. }) => Link::Fresh(*role),
            Some(Invitation { role, .. }) => Link::Used(*role),
            None => Link::Unknown,
        }
    }

    /// Uses a link: its role and the secret of the session that it becomes; none unless it is fresh.
    ///
    /// # Errors
    ///
    /// The system gives no random numbers.
    pub fn exchange(&mut self, token: &str) -> Result<Option<(Role, String)>, getrandom::Error> {
        let fresh = |invitation: &&mut Invitation| !invitation.used && same(&invitation.token, token);
        let Some(invitation) = self.invitations.iter_mut().find(fresh) else { return Ok(None) };
        let id = secret()?;
        invitation.used = true;
        let role = invitation.role;
        let counts = || AtomicU64::new(0);
        let bucket = Bucket::of_a_session();
        let session = Session { id: id.clone(), role, bucket, begun: counts(), open: counts(), ended: counts() };
        self.sessions.push(Arc::new(session));
        Ok(Some((role, id)))
    }

    /// The session of this role whose secret is among these.
    pub fn session<'a>(&self, role: Role, secrets: impl Iterator<Item = &'a str>) -> Option<Arc<Session>> {
        let session = self.sessions.iter().find(|session| session.role == role)?;
        let mut secrets = secrets;
        secrets.any(|secret| same(&session.id, secret)).then(|| session.clone())
    }

    /// Whether this role has opened its link, and whether a page of it listens now.
    pub fn presence(&self, role: Role) -> (bool, bool) {
        let session = self.sessions.iter().find(|session| session.role == role);
        (session.is_some(), session.is_some_and(|session| session.listens()))
    }
}

/// 128 random bits as 32 digits.
fn secret() -> Result<String, getrandom::Error> {
    let mut bytes = [0u8; 16];
    getrandom::fill(&mut bytes)?;
    Ok(bytes.iter().map(|byte| format!("{byte:02x}")).collect())
}

/// Equality that takes as long for a first wrong digit as for a last.
fn same(known: &str, told: &str) -> bool {
    known.len() == told.len() && known.bytes().zip(told.bytes()).fold(0, |all, (a, b)| all | (a ^ b)) == 0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_link_opens_once() {
        let mut access = Access::new();
        let token = access.invite(Role::Person(1)).expect("random");
        let other = access.invite(Role::Supervisor).expect("random");
        assert_ne!(token, other);
        assert_eq!(access.link(&token), Link::Fresh(Role::Person(1)));
        let (role, id) = access.exchange(&token).expect("random").expect("fresh");
        assert_eq!(role, Role::Person(1));
        assert_eq!(access.link(&token), Link::Used(Role::Person(1)));
        assert!(access.exchange(&token).expect("random").is_none());
        assert!(access.session(Role::Person(1), [id.as_str()].into_iter()).is_some());
        assert!(access.session(Role::Supervisor, [id.as_str()].into_iter()).is_none(), "of another role");
        assert!(access.session(Role::Person(1), [token.as_str(), ""].into_iter()).is_none(), "the link is no session");
        assert_eq!(access.link(""), Link::Unknown);
        assert_eq!(access.link(&token[1..]), Link::Unknown);
    }

    #[test]
    fn a_newer_link_ends_what_the_older_opened() {
        let mut access = Access::new();
        let token = access.invite(Role::Person(0)).expect("random");
        let (role, id) = access.exchange(&token).expect("random").expect("fresh");
        let session = access.session(role, [id.as_str()].into_iter()).expect("open");
        let stream = session.begin_stream();
        assert!(session.goes_on(stream) && session.listens());
        let newer = access.invite(Role::Person(0)).expect("random");
        assert_eq!((access.link(&token), access.link(&newer)), (Link::Unknown, Link::Fresh(role)));
        assert!(access.session(role, [id.as_str()].into_iter()).is_none());
        assert!(!session.goes_on(stream));
    }

    #[test]
    fn a_further_stream_ends_the_oldest() {
        let mut access = Access::new();
        let token = access.invite(Role::Supervisor).expect("random");
        let (role, id) = access.exchange(&token).expect("random").expect("fresh");
        let session = access.session(role, [id.as_str()].into_iter()).expect("open");
        let streams: Vec<u64> = (0..STREAMS).map(|_| session.begin_stream()).collect();
        assert!(streams.iter().all(|stream| session.goes_on(*stream)));
        session.begin_stream();
        assert!(!session.goes_on(streams[0]) && session.goes_on(streams[1]));
    }
}
