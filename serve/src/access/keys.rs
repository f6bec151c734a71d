//! The key of links and sessions, and their persistent state, in a file beside the journal.
//!
//! A link and a session are each a number with its signature (HMAC-SHA256, by `ring`, a dependency of the TLS of
//! `hierarq context`). Numbers increase: for each page the file holds the number of its newest link and that of the
//! opened one, which determine the links that still open and the valid session. The file is readable by its owner only
//! (mode 0600), is replaced atomically, and is written by the server that holds the journal; other processes read it to
//! create links ([`new_link`]).

use std::io::Write;
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

use ring::hmac;
use serde::{Deserialize, Serialize};

use super::Role;
use crate::LinkOf;

/// Maximum size of the file (bytes).
const LARGEST: u64 = 1 << 20;
/// Number of hexadecimal digits of a signature: its first 128 bits.
const DIGITS: usize = 32;

/// Purpose of a signed number.
#[derive(Clone, Copy, Debug)]
pub enum Kind {
    /// Opens a page once.
    Link,
    /// Identifies a session.
    Session,
}

/// A page, with its links.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Page {
    /// Role of its owner.
    pub role: Role,
    /// Name of the person; `None`: the supervisor.
    pub person: Option<String>,
    /// Links with smaller numbers are invalid.
    pub oldest: u64,
    /// Number of the newest link that a server created.
    pub link: u64,
    /// Number of the link that was opened last, which identifies the valid session.
    pub opened: Option<u64>,
}

impl Page {
    /// Creates a page without a link.
    pub fn new(role: Role, person: Option<String>) -> Page {
        Page { role, person, oldest: 0, link: 0, opened: None }
    }

    /// Returns true while this link opens the page.
    pub fn opens(&self, link: u64) -> bool {
        link >= self.oldest && self.opened.is_none_or(|opened| opened < link)
    }

    /// Returns a number greater than those of all links: the time (µs), unless the system clock was set back.
    pub fn next(&self) -> u64 {
        let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        let now = u64::try_from(since.as_micros()).unwrap_or(0);
        now.max(self.link + 1).max(self.opened.unwrap_or(0) + 1)
    }
}

/// Content of the file.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
struct Kept {
    keys: u32,
    mission: String,
    digest: String,
    /// The key, in hexadecimal digits.
    key: String,
    /// Base URL of the pages, without a trailing slash.
    site: String,
    /// Last address of the server.
    address: Option<SocketAddr>,
    pages: Vec<Page>,
}

/// A key with the pages that it protects.
pub struct Keys {
    kept: Kept,
    key: hmac::Key,
    /// Path of the file; `None`: nothing is persistent.
    path: Option<PathBuf>,
    /// True if the file contains `kept`.
    written: bool,
}

/// Reason why links and sessions cannot be stored.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "the message says what each field is")]
pub enum NoKeys {
    #[error("cannot use the file of links and sessions `{}`: {why}", .path.display())]
    File { path: PathBuf, why: std::io::Error },
    #[error(
        "`{}` holds no links and sessions; remove it, or name another journal: if it is missing, a new one is created, and \
         everybody needs a new link",
        .path.display()
    )]
    Foreign { path: PathBuf },
    #[error(
        "others may read the links and sessions in `{}`, mode {mode:04o}: its key opens every page; remove it, and \
         everybody needs a new link, or run `chmod 600` on it if nobody has read it",
        .path.display()
    )]
    Open { path: PathBuf, mode: u32 },
    #[error(
        "there is no `{}`: `--journal` names the journal of a server, and links are created from the file beside it",
        .path.display()
    )]
    Missing { path: PathBuf },
    #[error("`{name}` has no page in the mission `{mission}`; {have}")]
    Nobody { name: String, mission: String, have: String },
    #[error("the system provides no random numbers: {0}")]
    Random(#[from] getrandom::Error),
}

impl Keys {
    /// Creates a key that ends with the server.
    ///
    /// # Errors
    ///
    /// The system provides no random numbers.
    pub fn passing(mission: &str, pages: Vec<Page>) -> Result<Keys, NoKeys> {
        Ok(Keys::of(Kept::new(mission, "", pages)?, None))
    }

    /// Loads the key beside a journal of this mission, or creates a new one. The caller must hold the open journal,
    /// which excludes other servers.
    ///
    /// # Errors
    ///
    /// The file cannot be used, or is not a file of keys.
    pub fn beside(journal: &Path, mission: &str, digest: &str, pages: Vec<Page>) -> Result<Keys, NoKeys> {
        let path = path_of(journal);
        let kept = read(&path)?.filter(|kept| (kept.mission.as_str(), kept.digest.as_str()) == (mission, digest));
        let same = |kept: &Kept| kept.pages.iter().map(|page| page.role).eq(pages.iter().map(|page| page.role));
        // The key of another mission would admit its people.
        let (kept, written) = match kept.filter(same) {
            Some(kept) => (kept, true),
            None => (Kept::new(mission, digest, pages)?, false),
        };
        Ok(Keys { written, ..Keys::of(kept, Some(path)) })
    }

    fn of(kept: Kept, path: Option<PathBuf>) -> Keys {
        let key = hmac::Key::new(hmac::HMAC_SHA256, kept.key.as_bytes());
        Keys { kept, key, path, written: false }
    }

    /// Returns the pages with their links.
    pub fn pages(&self) -> &[Page] {
        &self.kept.pages
    }

    /// Returns the page of a role.
    pub fn page(&self, role: Role) -> Option<&Page> {
        self.kept.pages.iter().find(|page| page.role == role)
    }

    /// Returns the last address of the previous server.
    pub fn address(&self) -> Option<SocketAddr> {
        self.kept.address
    }

    /// Stores the base URL of the pages, and ensures that each page has an unopened link: that of the previous server,
    /// if there is one.
    ///
    /// # Errors
    ///
    /// It cannot be stored.
    pub fn begin(&mut self, site: &str, address: SocketAddr) -> Result<(), NoKeys> {
        self.change(|kept| {
            (kept.site, kept.address) = (site.to_string(), Some(address));
            for page in &mut kept.pages {
                if page.link == 0 || !page.opens(page.link) {
                    page.link = page.next();
                }
            }
        })
    }

    /// Creates a newer link for a page, and ends its older links and sessions.
    ///
    /// # Errors
    ///
    /// It cannot be stored. Nothing has changed then.
    pub fn renew(&mut self, role: Role) -> Result<(), NoKeys> {
        self.change(|kept| {
            if let Some(page) = kept.pages.iter_mut().find(|page| page.role == role) {
                let link = page.next();
                (page.oldest, page.link, page.opened) = (link, link, None);
            }
        })
    }

    /// Stores that a link of a page was opened.
    ///
    /// # Errors
    ///
    /// It cannot be stored. Nothing has changed then.
    pub fn open(&mut self, role: Role, number: u64) -> Result<(), NoKeys> {
        self.change(|kept| {
            if let Some(page) = kept.pages.iter_mut().find(|page| page.role == role) {
                page.opened = Some(number);
            }
        })
    }

    /// Signs a number: returns its digits, a dash, and digits of the signature.
    pub fn signed(&self, kind: Kind, role: Role, number: u64) -> String {
        let said = format!("{kind:?} {role:?} {number}");
        let tag = hmac::sign(&self.key, said.as_bytes());
        let digits = tag.as_ref().iter().map(|byte| format!("{byte:02x}")).collect::<String>();
        format!("{number:x}-{}", &digits[..DIGITS])
    }

    /// Returns the number of a signed text for this purpose; `None` if the signature is invalid.
    pub fn number(&self, kind: Kind, role: Role, told: &str) -> Option<u64> {
        let number = u64::from_str_radix(told.split_once('-')?.0, 16).ok()?;
        same(&self.signed(kind, role, number), told).then_some(number)
    }

    /// Returns the path of the newest link of a page.
    pub fn path(&self, role: Role) -> Option<String> {
        Some(role.link(&self.signed(Kind::Link, role, self.page(role)?.link)))
    }

    fn change(&mut self, change: impl FnOnce(&mut Kept)) -> Result<(), NoKeys> {
        let mut kept = self.kept.clone();
        change(&mut kept);
        if let Some(path) = self.path.as_ref().filter(|_| kept != self.kept || !self.written) {
            // After a failure the file may hold either state.
            self.written = false;
            write(path, &kept).map_err(|why| NoKeys::File { path: path.clone(), why })?;
        }
        (self.kept, self.written) = (kept, true);
        Ok(())
    }
}

impl Kept {
    fn new(mission: &str, digest: &str, pages: Vec<Page>) -> Result<Kept, NoKeys> {
        let mut bytes = [0u8; 32];
        getrandom::fill(&mut bytes)?;
        let key = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
        let (mission, digest) = (mission.to_string(), digest.to_string());
        Ok(Kept { keys: 1, mission, digest, key, site: String::new(), address: None, pages })
    }
}

/// Creates a new link to the page of a person, or of the supervisor if `person` is `None`, for the present or next
/// server with this journal. The page's previous session ends when the link is opened.
///
/// # Errors
///
/// No server has run with this journal, its file of links and sessions cannot be used, or the person has no page.
pub fn new_link(journal: &Path, person: Option<&str>) -> Result<LinkOf, NoKeys> {
    let path = path_of(journal);
    let kept = read(&path)?.ok_or(NoKeys::Missing { path })?;
    let keys = Keys::of(kept, None);
    let Some(page) = keys.pages().iter().find(|page| page.person.as_deref() == person) else {
        let names: Vec<&str> = keys.pages().iter().filter_map(|page| page.person.as_deref()).collect();
        let have = match names.as_slice() {
            [] => "only the supervisor has one".to_string(),
            names => format!("it has pages for the supervisor and {}", names.join(", ")),
        };
        let name = person.unwrap_or_default().to_string();
        return Err(NoKeys::Nobody { name, mission: keys.kept.mission.clone(), have });
    };
    let link = page.role.link(&keys.signed(Kind::Link, page.role, page.next()));
    let signed_in = page.opened.is_some();
    Ok(LinkOf { person: page.person.clone(), url: format!("{}{link}", keys.kept.site), signed_in })
}

/// Returns the path of the file of links and sessions of a journal.
fn path_of(journal: &Path) -> PathBuf {
    let mut name = journal.as_os_str().to_os_string();
    name.push(".key");
    name.into()
}

/// Compares texts in constant time for a given length.
fn same(known: &str, told: &str) -> bool {
    known.len() == told.len() && known.bytes().zip(told.bytes()).fold(0, |all, (a, b)| all | (a ^ b)) == 0
}

/// Reads a file; `None` if it does not exist.
fn read(path: &Path) -> Result<Option<Kept>, NoKeys> {
    let no = |why| NoKeys::File { path: path.into(), why };
    let foreign = || NoKeys::Foreign { path: path.into() };
    match std::fs::metadata(path) {
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(None),
        Err(e) => return Err(no(e)),
        Ok(is) if !is.is_file() || is.len() > LARGEST => return Err(foreign()),
        #[cfg(unix)]
        Ok(is) => {
            let mode = std::os::unix::fs::PermissionsExt::mode(&is.permissions()) & 0o777;
            if mode & 0o077 != 0 {
                return Err(NoKeys::Open { path: path.into(), mode });
            }
        }
        #[cfg(not(unix))]
        Ok(_) => {}
    }
    let bytes = files::read(path, LARGEST).map_err(no)?;
    let kept: Kept = serde_json::from_slice(&bytes).map_err(|_| foreign())?;
    if kept.keys == 1 && kept.key.len() == 64 { Ok(Some(kept)) } else { Err(foreign()) }
}

/// Replaces a file atomically, and syncs it to the disk.
fn write(path: &Path, kept: &Kept) -> std::io::Result<()> {
    let mut draft = files::Draft::private(path)?;
    draft.write_all(serde_json::to_string(kept)?.as_bytes())?;
    draft.write_all(b"\n")?;
    draft.keep()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn journal(name: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("hierarq-keys-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("writable");
        let journal = folder.join(name);
        let _ = std::fs::remove_file(path_of(&journal));
        journal
    }

    fn pages() -> Vec<Page> {
        vec![Page::new(Role::Supervisor, None), Page::new(Role::Person(1), Some("anna".into()))]
    }

    fn begun(journal: &Path, digest: &str) -> Keys {
        let mut keys = Keys::beside(journal, "field", digest, pages()).expect("usable");
        keys.begin("http://field.example", SocketAddr::from(([127, 0, 0, 1], 8080))).expect("writable");
        keys
    }

    /// RFC 4231, test case 2: the function is HMAC-SHA256.
    #[test]
    fn signatures_are_those_of_the_standard() {
        let tag = hmac::sign(&hmac::Key::new(hmac::HMAC_SHA256, b"Jefe"), b"what do ya want for nothing?");
        let digits: String = tag.as_ref().iter().map(|byte| format!("{byte:02x}")).collect();
        assert_eq!(digits, "5bdcc146bf60754e6a042426089575c75a003f089d2739839dec58b964ec3843");
    }

    #[test]
    fn a_signature_is_for_one_thing_alone() {
        let keys = Keys::passing("field", pages()).expect("random");
        let other = Keys::passing("field", pages()).expect("random");
        let anna = Role::Person(1);
        let told = keys.signed(Kind::Link, anna, 77);
        assert_eq!(keys.number(Kind::Link, anna, &told), Some(77));
        assert_eq!(keys.number(Kind::Session, anna, &told), None);
        assert_eq!(keys.number(Kind::Link, Role::Supervisor, &told), None);
        assert_eq!(keys.number(Kind::Link, Role::Person(11), &told), None);
        assert_eq!(other.number(Kind::Link, anna, &told), None);
        assert_eq!(keys.number(Kind::Link, anna, &told.replacen("4d-", "4e-", 1)), None);
        // Every digit is significant, and a number has only one spelling.
        for at in 0..told.len() {
            let mut changed = told.clone().into_bytes();
            changed[at] = if changed[at] == b'0' { b'1' } else { b'0' };
            let changed = String::from_utf8(changed).expect("text");
            assert_eq!(keys.number(Kind::Link, anna, &changed), None, "{changed}");
        }
        for changed in [format!("0{told}"), format!("+{told}"), told.to_uppercase(), told[..9].into(), String::new()] {
            assert_eq!(keys.number(Kind::Link, anna, &changed), None, "{changed}");
        }
    }

    #[test]
    fn links_and_sessions_outlast_a_server() {
        let journal = journal("outlast");
        let anna = Role::Person(1);
        let mut keys = begun(&journal, "d");
        let (link, number) = (keys.path(anna), keys.page(anna).expect("a page").link);
        assert_eq!(begun(&journal, "d").path(anna), link, "what nobody has opened still opens");
        keys.open(anna, number).expect("writable");
        let session = keys.signed(Kind::Session, anna, number);
        let mut again = begun(&journal, "d");
        assert_eq!(again.number(Kind::Session, anna, &session), again.page(anna).expect("a page").opened);
        assert_ne!(again.path(anna), link);
        again.renew(anna).expect("writable");
        assert_eq!(begun(&journal, "d").page(anna).expect("a page").opened, None);
        // Another mission has another key.
        assert_eq!(begun(&journal, "e").number(Kind::Session, anna, &session), None);
    }

    #[test]
    fn a_link_is_made_from_the_file_alone() {
        let journal = journal("alone");
        assert!(matches!(new_link(&journal, None), Err(NoKeys::Missing { .. })));
        let keys = begun(&journal, "d");
        let of = |person| new_link(&journal, person).expect("a link");
        let (first, second) = (of(Some("anna")), of(Some("anna")));
        let token = |link: &LinkOf| link.url.strip_prefix("http://field.example/p/1-").expect("hers").to_string();
        let numbers =
            [first, second].map(|link| keys.number(Kind::Link, Role::Person(1), &token(&link)).expect("ours"));
        assert!(numbers.iter().all(|number| *number > keys.page(Role::Person(1)).expect("a page").link));
        assert!(of(None).url.starts_with("http://field.example/s/"));
        let refused = new_link(&journal, Some("bert")).expect_err("nobody").to_string();
        assert!(
            refused.contains("`bert` has no page") && refused.contains("pages for the supervisor and anna"),
            "{refused}"
        );
    }

    #[test]
    fn a_file_of_something_else_is_left_alone() {
        let journal = journal("foreign");
        let path = path_of(&journal);
        for text in ["", "dear diary", "{}", "{\"keys\":1}"] {
            let _ = std::fs::remove_file(&path);
            std::fs::write(&path, text).expect("writable");
            #[cfg(unix)]
            std::fs::set_permissions(&path, std::os::unix::fs::PermissionsExt::from_mode(0o600)).expect("ours");
            assert!(matches!(Keys::beside(&journal, "v", "d", pages()), Err(NoKeys::Foreign { .. })), "{text}");
            assert_eq!(std::fs::read_to_string(&path).expect("readable"), text);
        }
    }

    #[cfg(unix)]
    #[test]
    fn the_file_is_for_its_owner_alone() {
        use std::os::unix::fs::PermissionsExt;
        let journal = journal("owner");
        let path = path_of(&journal);
        drop(begun(&journal, "d"));
        assert_eq!(path.metadata().expect("a file").permissions().mode() & 0o777, 0o600);
        std::fs::set_permissions(&path, PermissionsExt::from_mode(0o640)).expect("ours");
        let refused = Keys::beside(&journal, "field", "d", pages()).err().expect("open").to_string();
        assert!(refused.contains("0640") && refused.contains("chmod 600"), "{refused}");
    }
}
