//! Limits on connections: few without a session, with a limit for each address, and some for each session.
//!
//! A connection is a stranger's until one of its requests presents a session. If strangers have no place left, the
//! oldest connection of the address with most of them ends: a client with many connections displaces only its own ones,
//! and a new device has time to present its session. Connections of sessions are counted separately.

use std::collections::BTreeMap;
use std::net::{IpAddr, Ipv6Addr};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use tokio::sync::Notify;

use super::access::Role;

/// Maximum number of connections without a session.
pub const STRANGERS: usize = 256;
/// Maximum number of these for one address.
pub const OF_AN_ADDRESS: usize = 64;
/// Maximum number of connections with the same session: a browser opens six, and one browser has few pages.
pub const OF_A_SESSION: usize = 16;

/// A connection.
#[derive(Debug)]
pub struct Connection {
    from: IpAddr,
    ends: Notify,
    asked: AtomicBool,
}

impl Connection {
    /// Waits until another connection has replaced this one.
    pub async fn ended(&self) {
        self.ends.notified().await;
    }

    /// Registers that the header of a request has arrived.
    pub fn asks(&self) {
        self.asked.store(true, Ordering::Relaxed);
    }

    /// Returns true if a request header has arrived.
    pub fn asked(&self) -> bool {
        self.asked.load(Ordering::Relaxed)
    }
}

/// Connections, the oldest first.
#[derive(Debug, Default)]
struct Table {
    strangers: Vec<Arc<Connection>>,
    known: Vec<(Role, Arc<Connection>)>,
}

/// All connections of a server.
#[derive(Debug, Default)]
pub struct Connections(Mutex<Table>);

/// Guard of a connection: it is removed from the table when the last clone is dropped.
#[derive(Clone, Debug)]
pub struct ConnectionGuard(Arc<Registration>);

#[derive(Debug)]
struct Registration {
    connections: Arc<Connections>,
    connection: Arc<Connection>,
}

impl Drop for Registration {
    fn drop(&mut self) {
        let mut taken = self.connections.taken();
        taken.strangers.retain(|other| !Arc::ptr_eq(other, &self.connection));
        taken.known.retain(|(_, other)| !Arc::ptr_eq(other, &self.connection));
    }
}

impl ConnectionGuard {
    /// Returns the connection.
    pub fn connection(&self) -> &Connection {
        &self.0.connection
    }

    /// Registers that the connection presents a session of this role. If the session has too many connections, its
    /// oldest one ends.
    pub fn shows(&self, role: Role) {
        let Registration { connections, connection } = &*self.0;
        let mut taken = connections.taken();
        // A connection that has ended is in neither list.
        let Some(at) = taken.strangers.iter().position(|other| Arc::ptr_eq(other, connection)) else { return };
        let connection = taken.strangers.remove(at);
        taken.known.push((role, connection));
        let of_session = |(other, _): &(Role, Arc<Connection>)| *other == role;
        if taken.known.iter().filter(|known| of_session(known)).count() > OF_A_SESSION
            && let Some(oldest) = taken.known.iter().position(of_session)
        {
            taken.known.remove(oldest).1.ends.notify_one();
        }
    }
}

impl Connections {
    fn taken(&self) -> MutexGuard<'_, Table> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Registers a connection from this address; if necessary it replaces another stranger's.
    pub fn take(self: &Arc<Connections>, from: IpAddr) -> ConnectionGuard {
        let from = network(from);
        let mut taken = self.taken();
        if taken.of(from) >= OF_AN_ADDRESS {
            taken.end(from);
        } else if taken.strangers.len() >= STRANGERS {
            taken.end_one();
        }
        let connection = Arc::new(Connection { from, ends: Notify::new(), asked: AtomicBool::new(false) });
        taken.strangers.push(connection.clone());
        ConnectionGuard(Arc::new(Registration { connections: self.clone(), connection }))
    }

    /// Ends one connection of a stranger, if there is one: the system has no resources left.
    pub fn make_room(&self) {
        self.taken().end_one();
    }
}

impl Table {
    fn of(&self, from: IpAddr) -> usize {
        self.strangers.iter().filter(|connection| connection.from == from).count()
    }

    /// Ends the oldest connection of the address with the most connections.
    fn end_one(&mut self) {
        // One pass: a count for each connection would make every new one cost as much as the square of their number.
        let mut counts: BTreeMap<IpAddr, usize> = BTreeMap::new();
        self.strangers.iter().for_each(|connection| *counts.entry(connection.from).or_default() += 1);
        if let Some(most) = self.strangers.iter().map(|connection| connection.from).max_by_key(|from| counts.get(from))
        {
            self.end(most);
        }
    }

    /// Ends the oldest connection of an address.
    fn end(&mut self, from: IpAddr) {
        if let Some(oldest) = self.strangers.iter().position(|connection| connection.from == from) {
            self.strangers.remove(oldest).ends.notify_one();
        }
    }
}

/// Returns the address for counting: for IPv6 the 64-bit network, since a device may use all addresses of its network.
fn network(address: IpAddr) -> IpAddr {
    match address.to_canonical() {
        IpAddr::V6(v6) => IpAddr::V6(Ipv6Addr::from_bits(v6.to_bits() >> 64 << 64)),
        v4 => v4,
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn address(n: u8) -> IpAddr {
        IpAddr::from([10, 0, 0, n])
    }

    /// Returns true if another connection has replaced this one. Polls once.
    fn has_ended(held: &ConnectionGuard) -> bool {
        let mut ended = std::pin::pin!(held.connection().ended());
        ended.as_mut().poll(&mut std::task::Context::from_waker(std::task::Waker::noop())).is_ready()
    }

    #[test]
    fn who_has_most_gives_way() {
        let connections = Arc::new(Connections::default());
        let mut many: Vec<ConnectionGuard> = Vec::new();
        for hostile in 0..4 {
            many.extend((0..OF_AN_ADDRESS).map(|_| connections.take(address(hostile))));
        }
        assert_eq!(many.len(), STRANGERS, "all places are taken");
        let few: Vec<ConnectionGuard> = (0..9).map(|_| connections.take(address(9))).collect();
        let lost = many.iter().filter(|held| has_ended(held)).count();
        assert_eq!((few.iter().filter(|held| has_ended(held)).count(), lost), (0, 9));
        // A full address replaces its own oldest connection.
        let late = connections.take(address(9));
        drop(many);
        let own: Vec<ConnectionGuard> = (0..OF_AN_ADDRESS).map(|_| connections.take(address(9))).collect();
        assert!(has_ended(&few[0]) && has_ended(&late) && !own.iter().any(has_ended));
    }

    #[test]
    fn connections_of_a_session_are_counted_apart() {
        let connections = Arc::new(Connections::default());
        let known: Vec<ConnectionGuard> = (0..=OF_A_SESSION).map(|_| connections.take(address(1))).collect();
        known.iter().for_each(|held| held.shows(Role::Person(3)));
        let hostile: Vec<ConnectionGuard> = (0..2 * STRANGERS).map(|_| connections.take(address(1))).collect();
        assert!(has_ended(&known[0]), "the session has one too many");
        assert!(!known[1..].iter().any(has_ended), "strangers take nothing from sessions");
        assert_eq!(hostile.iter().filter(|held| !has_ended(held)).count(), OF_AN_ADDRESS);
        drop((known, hostile));
        let taken = connections.taken();
        assert!(taken.strangers.is_empty() && taken.known.is_empty());
    }

    #[test]
    fn a_device_has_one_network() {
        let of = |text: &str| network(text.parse().expect("an address"));
        assert_eq!(of("2001:db8:1:2:3:4:5:6"), of("2001:db8:1:2::9"));
        assert_ne!(of("2001:db8:1:2::9"), of("2001:db8:1:3::9"));
        assert_eq!(of("::ffff:10.0.0.7"), of("10.0.0.7"));
        assert_ne!(of("10.0.0.7"), of("10.0.0.8"));
    }

    proptest! {
        /// Every new connection is registered; all limits hold, and an address below its limit loses no connection to
        /// another one.
        #[test]
        fn bounds_hold(comers in prop::collection::vec((0u8..9, prop::option::weighted(0.2, 0usize..3)), 1..900)) {
            let connections = Arc::new(Connections::default());
            let mut all = Vec::new();
            for (from, role) in comers {
                let held = connections.take(address(from));
                if let Some(role) = role {
                    held.shows(Role::Person(role));
                }
                all.push(held);
                let taken = connections.taken();
                prop_assert!(taken.strangers.len() <= STRANGERS);
                prop_assert!((0..9).all(|from| taken.of(address(from)) <= OF_AN_ADDRESS));
                for role in 0..3 {
                    prop_assert!(taken.known.iter().filter(|known| known.0 == Role::Person(role)).count() <= OF_A_SESSION);
                }
            }
            let taken = connections.taken();
            prop_assert!(taken.known.last().is_none_or(|last| all.iter().any(|held| Arc::ptr_eq(&held.0.connection, &last.1))));
        }
    }
}
