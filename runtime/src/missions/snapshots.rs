//! Maps of a few instants of a run, evenly spread over the part of it that is over.

use mission::kind::Execution;
use mission::map::Map;

/// The most maps that are kept while the run goes on.
const MOST: usize = 12;

/// The map at an instant.
#[derive(Clone, Debug, PartialEq)]
pub struct MapAt {
    /// Time since the start of the mission, in s.
    pub time: f64,
    /// The map.
    pub map: Map,
    /// Position of each of the robots of the map, in m.
    pub positions: Vec<[f64; 2]>,
}

impl MapAt {
    fn new(time: f64, execution: &dyn Execution) -> MapAt {
        let map = execution.map();
        let at = |member: usize| {
            let [x, y, _] = execution.measure("position", Some(member));
            [x, y]
        };
        let positions = (0..map.moving.len()).map(at).collect();
        MapAt { time, map, positions }
    }
}

/// Maps of a run whose end is not known yet: whenever there are too many, every second one is dropped.
#[derive(Debug)]
pub struct Snapshots {
    maps: Vec<MapAt>,
    /// Instants from one map to the next.
    stride: u32,
    /// The mission is over, and its map does not change any more.
    over: bool,
}

impl Snapshots {
    pub fn new() -> Snapshots {
        Snapshots { maps: Vec::new(), stride: 1, over: false }
    }

    /// Keeps the map of an instant, if it is its turn.
    pub fn instant(&mut self, number: u32, time: f64, execution: &dyn Execution) {
        if self.over || !number.is_multiple_of(self.stride) {
            return;
        }
        self.over = execution.done().is_some();
        if self.maps.len() == MOST {
            let mut index = 0;
            self.maps.retain(|_| {
                index += 1;
                index % 2 == 1
            });
            self.stride *= 2;
            if !number.is_multiple_of(self.stride) {
                return;
            }
        }
        self.maps.push(MapAt::new(time, execution));
    }

    /// At most six of the maps, evenly spread.
    pub fn finish(self) -> Vec<MapAt> {
        let every = self.maps.len().div_ceil(6).max(1);
        self.maps.into_iter().step_by(every).collect()
    }
}
