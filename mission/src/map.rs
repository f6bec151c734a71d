//! The map of a mission as data: signs, lines, polygons and names in the order in which they are drawn, x to the right and y upwards.

/// A map.
#[derive(Clone, Debug, PartialEq)]
pub struct Map {
    /// Description, for people who do not see it.
    pub title: &'static str,
    /// Pixels of a metre at the most.
    pub most_scale: f64,
    /// Points that the map must show (m).
    pub extent: Vec<[f64; 2]>,
    /// Points that names must not cover (m).
    pub clear: Vec<[f64; 2]>,
    /// Content, in order.
    pub shapes: Vec<Shape>,
    /// Everybody who moves on it.
    pub moving: Vec<Moving>,
    /// Signs with their meanings.
    pub legend: Vec<(Sign, &'static str)>,
}

/// A robot or a person that moves on a map.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Moving {
    /// Label.
    pub label: String,
    /// A person; else a robot.
    pub is_person: bool,
}

impl Moving {
    /// A robot with a label.
    pub fn robot(label: impl Into<String>) -> Moving {
        Moving { label: label.into(), is_person: false }
    }
}

/// Something drawn.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// A sign.
    Sign {
        /// Form.
        sign: Sign,
        /// Position (m).
        at: [f64; 2],
        /// Text under the pointer.
        title: Option<String>,
    },
    /// A line.
    Line {
        /// Form.
        line: Line,
        /// Its points (m), at least two.
        points: Vec<[f64; 2]>,
        /// Text under the pointer.
        title: Option<String>,
    },
    /// A polygon.
    Region {
        /// Meaning.
        region: Region,
        /// Its corners (m), at least three.
        corners: Vec<[f64; 2]>,
        /// Text under the pointer.
        title: Option<String>,
    },
    /// Rectangles that belong together.
    Regions {
        /// Meaning.
        region: Region,
        /// Their corners (m).
        rectangles: Vec<[[f64; 2]; 4]>,
        /// Text under the pointer.
        title: Option<String>,
    },
    /// A name beside a sign.
    Name {
        /// Position of the sign (m).
        at: [f64; 2],
        /// Text.
        text: String,
    },
}

/// Form of a sign.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sign {
    /// The base of a robot.
    Base,
    /// A person.
    Person,
    /// A working robot.
    Worker,
    /// A place where a robot waits.
    Stop,
    /// An object, in the colour of a group; none: nobody takes it.
    Object(Option<usize>),
    /// The place to which an object is brought, in the colour of its group.
    Target(usize),
}

/// Meaning of a polygon.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Region {
    /// The ground on which everybody moves.
    Ground,
    /// An obstacle.
    Solid,
    /// Nothing is known of it.
    Unknown,
    /// It attracts.
    Attracts,
    /// It repels.
    Repels,
    /// A belief of this height.
    Belief(Shade),
    /// A field that attracts with this strength.
    AttractsNear(Shade),
    /// A field that repels with this strength.
    RepelsNear(Shade),
}

/// Height of a value relative to the greatest one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shade {
    /// Up to a quarter.
    Faint,
    /// Up to half.
    Light,
    /// Up to three quarters.
    Medium,
    /// More.
    Strong,
}

impl Shade {
    /// All shades, from the lowest one.
    pub const ALL: [Shade; 4] = [Shade::Faint, Shade::Light, Shade::Medium, Shade::Strong];

    /// Returns the shade of a share of the greatest value; none: the share is next to nothing.
    pub fn of(share: f64) -> Option<Shade> {
        let least = 0.02;
        (share > least).then(|| Shade::ALL[((4.0 * share).ceil() as usize).clamp(1, 4) - 1])
    }

    /// Returns the greatest share that has the shade, in percent.
    pub fn percent(self) -> usize {
        25 * (self as usize + 1)
    }
}

/// Form of a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Line {
    /// A path of a robot.
    Path,
    /// The part of it near a person.
    Near,
    /// From an agent to the object that it fetches.
    Fetch,
    /// The path of an object, in the colour of its group.
    Carry(usize),
    /// A wall.
    Wall,
    /// A path that was considered.
    Considered,
}

impl Shape {
    /// A sign with a text under the pointer.
    pub fn sign(sign: Sign, at: [f64; 2], title: String) -> Shape {
        Shape::Sign { sign, at, title: Some(title) }
    }
}

#[cfg(test)]
mod tests {
    use super::Shade;

    #[test]
    fn shades_are_quarters() {
        let of = |share| Shade::of(share);
        assert_eq!([of(-0.5), of(0.0), of(0.02), of(f64::NAN)], [None; 4]);
        assert_eq!([of(0.1), of(0.25)], [Some(Shade::Faint); 2]);
        assert_eq!([of(0.26), of(0.5), of(0.75)], [Some(Shade::Light), Some(Shade::Light), Some(Shade::Medium)]);
        assert_eq!([of(0.8), of(1.0), of(1.2)], [Some(Shade::Strong); 3]);
        assert_eq!(Shade::ALL.map(Shade::percent), [25, 50, 75, 100]);
    }
}
