//! A mission of any kind as a value, which is stored as `{ "NAME OF THE KIND": { .. } }`.

use std::fmt;
use std::ops::Deref;

use serde::de::{Error, IgnoredAny, MapAccess, Visitor};
use serde::ser::SerializeMap;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use serde_json::Value;

use crate::declare::{DeclaredMission, Remarks};
use crate::kind::{Kind, Mission};
use crate::kinds;

/// A mission of any kind.
#[derive(Debug)]
pub struct AnyMission(Box<dyn Mission>);

impl AnyMission {
    /// A mission of a kind as one of any kind.
    pub fn new(mission: impl Mission) -> AnyMission {
        AnyMission(Box::new(mission))
    }

    /// Builds a mission of a kind from its declaration; see [`Kind::build`].
    pub fn build(kind: &Kind, declared: &DeclaredMission, remarks: &mut Remarks) -> AnyMission {
        AnyMission((kind.build)(declared, remarks))
    }
}

impl Deref for AnyMission {
    type Target = dyn Mission;

    fn deref(&self) -> &Self::Target {
        &*self.0
    }
}

impl Clone for AnyMission {
    fn clone(&self) -> AnyMission {
        AnyMission(self.0.boxed())
    }
}

impl PartialEq for AnyMission {
    fn eq(&self, other: &AnyMission) -> bool {
        self.kind().name == other.kind().name && self.to_value() == other.to_value()
    }
}

impl Serialize for AnyMission {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(1))?;
        map.serialize_entry(self.kind().name, &self.to_value())?;
        map.end()
    }
}

impl<'de> Deserialize<'de> for AnyMission {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<AnyMission, D::Error> {
        deserializer.deserialize_map(Reader)
    }
}

struct Reader;

impl<'de> Visitor<'de> for Reader {
    type Value = AnyMission;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names: Vec<&str> = kinds::KINDS.iter().map(|kind| kind.name).collect();
        write!(f, "a mission: {}", names.join(", "))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<AnyMission, A::Error> {
        let mut found = None;
        while let Some(key) = map.next_key::<String>()? {
            match kinds::find(&key) {
                Some(kind) => {
                    let mission = (kind.read)(map.next_value::<Value>()?).map_err(A::Error::custom)?;
                    found = Some(AnyMission(mission));
                }
                None => drop(map.next_value::<IgnoredAny>()?),
            }
        }
        found.ok_or_else(|| A::Error::custom("the mission has an unknown kind"))
    }
}
