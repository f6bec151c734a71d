//! Limits on connections: few without a session, with a limit for each address, and some for each session.
//!
//! A connection is a stranger's until one of its requests presents a session. If strangers have no place left, the
//! oldest connection of the address with most of them ends: a client with many connections displaces only its own ones,
//! and a new device has time to present its session. Connections of sessions are counted separately.

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
pub struct Place {
    from: IpAddr,
    ends: Notify,
    asked: AtomicBool,
}

impl Place {
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
struct Taken {
    strangers: Vec<Arc<Place>>,
    known: Vec<(Role, Arc<Place>)>,
}

/// All connections of a server.
#[derive(Debug, Default)]
pub struct Places(Mutex<Taken>);

/// A connection that occupies its place until this is dropped.
#[derive(Clone, Debug)]
pub struct Held(Arc<Holding>);

#[derive(Debug)]
struct Holding {
    places: Arc<Places>,
    place: Arc<Place>,
}

impl Drop for Holding {
    fn drop(&mut self) {
        let mut taken = self.places.taken();
        taken.strangers.retain(|other| !Arc::ptr_eq(other, &self.place));
        taken.known.retain(|(_, other)| !Arc::ptr_eq(other, &self.place));
    }
}

impl Held {
    /// Returns the connection.
    pub fn place(&self) -> &Place {
        &self.0.place
    }

    /// Registers that the connection presents a session of this role. If the session has too many connections, its
    /// oldest one ends.
    pub fn shows(&self, role: Role) {
        let Holding { places, place } = &*self.0;
        let mut taken = places.taken();
        // A connection that has ended is in neither list.
        let Some(at) = taken.strangers.iter().position(|other| Arc::ptr_eq(other, place)) else { return };
        let place = taken.strangers.remove(at);
        taken.known.push((role, place));
        let of_session = |(other, _): &(Role, Arc<Place>)| *other == role;
        if taken.known.iter().filter(|known| of_session(known)).count() > OF_A_SESSION
            && let Some(oldest) = taken.known.iter().position(of_session)
        {
            taken.known.remove(oldest).1.ends.notify_one();
        }
    }
}

impl Places {
    fn taken(&self) -> MutexGuard<'_, Taken> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Returns a place for a connection from this address; if necessary it replaces another stranger's.
    pub fn take(self: &Arc<Places>, from: IpAddr) -> Held {
        let from = network(from);
        let mut taken = self.taken();
        if taken.of(from) >= OF_AN_ADDRESS {
            taken.end(from);
        } else if taken.strangers.len() >= STRANGERS {
            taken.end_one();
        }
        let place = Arc::new(Place { from, ends: Notify::new(), asked: AtomicBool::new(false) });
        taken.strangers.push(place.clone());
        Held(Arc::new(Holding { places: self.clone(), place }))
    }

    /// Ends one connection of a stranger, if there is one: the system has no resources left.
    pub fn make_room(&self) {
        self.taken().end_one();
    }
}

impl Taken {
    fn of(&self, from: IpAddr) -> usize {
        self.strangers.iter().filter(|place| place.from == from).count()
    }

    /// Ends the oldest connection of the address with the most connections.
    fn end_one(&mut self) {
        if let Some(most) = self.strangers.iter().map(|place| place.from).max_by_key(|from| self.of(*from)) {
            self.end(most);
        }
    }

    /// Ends the oldest connection of an address.
    fn end(&mut self, from: IpAddr) {
        if let Some(oldest) = self.strangers.iter().position(|place| place.from == from) {
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
    fn has_ended(held: &Held) -> bool {
        let mut ended = std::pin::pin!(held.place().ended());
        ended.as_mut().poll(&mut std::task::Context::from_waker(std::task::Waker::noop())).is_ready()
    }

    #[test]
    fn who_has_most_gives_way() {
        let places = Arc::new(Places::default());
        let mut many: Vec<Held> = Vec::new();
        for hostile in 0..4 {
            many.extend((0..OF_AN_ADDRESS).map(|_| places.take(address(hostile))));
        }
        assert_eq!(many.len(), STRANGERS, "all places are taken");
        let few: Vec<Held> = (0..9).map(|_| places.take(address(9))).collect();
        let lost = many.iter().filter(|held| has_ended(held)).count();
        assert_eq!((few.iter().filter(|held| has_ended(held)).count(), lost), (0, 9));
        // A full address replaces its own oldest connection.
        let late = places.take(address(9));
        drop(many);
        let own: Vec<Held> = (0..OF_AN_ADDRESS).map(|_| places.take(address(9))).collect();
        assert!(has_ended(&few[0]) && has_ended(&late) && !own.iter().any(has_ended));
    }

    #[test]
    fn connections_of_a_session_are_counted_apart() {
        let places = Arc::new(Places::default());
        let known: Vec<Held> = (0..=OF_A_SESSION).map(|_| places.take(address(1))).collect();
        known.iter().for_each(|held| held.shows(Role::Person(3)));
        let hostile: Vec<Held> = (0..2 * STRANGERS).map(|_| places.take(address(1))).collect();
        assert!(has_ended(&known[0]), "the session has one too many");
        assert!(!known[1..].iter().any(has_ended), "strangers take nothing from sessions");
        assert_eq!(hostile.iter().filter(|held| !has_ended(held)).count(), OF_AN_ADDRESS);
        drop((known, hostile));
        let taken = places.taken();
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
        /// Every new connection gets a place; all limits hold, and an address below its limit loses no connection to
        /// another one.
        #[test]
        fn bounds_hold(comers in prop::collection::vec((0u8..9, prop::option::weighted(0.2, 0usize..3)), 1..900)) {
            let places = Arc::new(Places::default());
            let mut all = Vec::new();
            for (from, role) in comers {
                let held = places.take(address(from));
                if let Some(role) = role {
                    held.shows(Role::Person(role));
                }
                all.push(held);
                let taken = places.taken();
                prop_assert!(taken.strangers.len() <= STRANGERS);
                prop_assert!((0..9).all(|from| taken.of(address(from)) <= OF_AN_ADDRESS));
                for role in 0..3 {
                    prop_assert!(taken.known.iter().filter(|known| known.0 == Role::Person(role)).count() <= OF_A_SESSION);
                }
            }
            let taken = places.taken();
            prop_assert!(taken.known.last().is_none_or(|last| all.iter().any(|held| Arc::ptr_eq(&held.0.place, &last.1))));
        }
    }
}
