//! Occupancy grids: images and map files as `map_server` reads them, lines and distances against dense samples, ways and
//! reachability against naive searches.

use hierarq_mission::kinds::search::check::check;
use hierarq_mission::kinds::search::choose::{Options, plan};
use hierarq_mission::kinds::search::geometry::{Point, along, between, distance};
use hierarq_mission::kinds::search::ground::{Body, Ground};
use hierarq_mission::kinds::search::problem::Problem;
use hierarq_mission::kinds::search::validate::validate;
use hierarq_mission::kinds::search::ways::ActionSets;
use hierarq_mission::occupancy::{Cell, CellIndex, Image, MapFile, OccupancyGrid};
use proptest::prelude::*;

use crate::common::Random;
use crate::searched::{grid, on_grid};

const YAML: &str =
    "image: lab.pgm\nresolution: 0.5\norigin: [-1, -2, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n";

fn image(bytes: &[u8]) -> Image {
    Image::read(bytes).expect("an image")
}

fn read(yaml: &str, bytes: &[u8]) -> OccupancyGrid {
    OccupancyGrid::read(&MapFile::read(yaml).expect("a map file"), &image(bytes)).expect("a map")
}

/// Cells as text, the uppermost row first.
fn picture(grid: &OccupancyGrid) -> String {
    let sign = |cell: &Cell| match cell {
        Cell::Free => '.',
        Cell::Occupied => '#',
        Cell::Unknown => '?',
    };
    let rows: Vec<String> = grid.cells().chunks(grid.columns).rev().map(|row| row.iter().map(sign).collect()).collect();
    rows.join("/")
}

fn png(width: u32, height: u32, colour: png::ColorType, depth: png::BitDepth, data: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(colour);
    encoder.set_depth(depth);
    let mut writer = encoder.write_header().expect("a header");
    writer.write_image_data(data).expect("pixels");
    writer.finish().expect("an end");
    bytes
}

/// The same picture in every form of image gives the same cells: 0 black, 205 the grey of `map_saver`, 254 white.
#[test]
fn images_of_all_forms_give_the_same_cells() {
    let grey = [0_u8, 205, 254, 254, 254, 0];
    let wide = || grey.iter().flat_map(|g| (u16::from(*g) * 257).to_be_bytes());
    let colours = |alpha: bool| {
        let one = move |g: &u8| std::iter::repeat_n(*g, 3).chain(alpha.then_some(255)).collect::<Vec<u8>>();
        grey.iter().flat_map(one).collect::<Vec<u8>>()
    };
    let eight = png::BitDepth::Eight;
    let forms = [
        b"P2 # a comment\n3 2\n255\n0 205 254\n254 254 0\n".to_vec(),
        [&b"P5\n3 2\n# another one\n255\n"[..], &grey].concat(),
        [&b"P5 3 2 65535\n"[..], &wide().collect::<Vec<u8>>()].concat(),
        png(3, 2, png::ColorType::Grayscale, eight, &grey),
        png(3, 2, png::ColorType::Grayscale, png::BitDepth::Sixteen, &wide().collect::<Vec<u8>>()),
        png(3, 2, png::ColorType::Rgb, eight, &colours(false)),
    ];
    for (number, bytes) in forms.iter().enumerate() {
        assert_eq!(picture(&read(YAML, bytes)), "#?./..#", "form {number}");
    }
    // An opaque alpha channel is one more colour in the mode `trinary`, so that black is three quarters occupied.
    let opaque = png(3, 2, png::ColorType::Rgba, eight, &colours(true));
    assert_eq!(picture(&read(YAML, &opaque)), "#../..#");
    assert_eq!(picture(&read(&format!("{YAML}mode: scale\n"), &opaque)), "#?./..#");
}

/// The rules of `map_server`: thresholds, `negate`, the three modes, opacity.
#[test]
fn pixels_are_cells_by_the_rules_of_map_server() {
    let pgm = |values: &str| format!("P2 {} 1 255 {values}", values.split(' ').count()).into_bytes();
    // Occupancies 1, 0.66, 0.647, 0.2, 0.192, 0.
    let values = pgm("0 86 90 204 206 255");
    assert_eq!(picture(&read(YAML, &values)), "##??..");
    // Occupancies 0, 0.337, 0.353, 0.8, 0.81, 1.
    assert_eq!(picture(&read(&YAML.replace("negate: 0", "negate: 1"), &values)), ".??###");
    assert_eq!(picture(&read(&format!("{YAML}mode: raw\n"), &pgm("0 19 20 65 66 100 101 255"))), "..??##??");
    let half = png(2, 1, png::ColorType::GrayscaleAlpha, png::BitDepth::Eight, &[255, 255, 255, 128]);
    assert_eq!(picture(&read(&format!("{YAML}mode: scale\n"), &half)), ".?");
}

#[test]
fn broken_images_are_refused() {
    let big = png(1, 1, png::ColorType::Grayscale, png::BitDepth::Eight, &[7]);
    let mut huge = big.clone();
    huge[16..24].copy_from_slice(&[0, 1, 0, 0, 0, 1, 0, 0]);
    for (bytes, why) in [
        (&b""[..], "empty"),
        (b"BM6", "neither"),
        (b"P5 3", "header"),
        (b"P5 3 2 70000\n", "largest value"),
        (b"P5 3 2 255\n12345", "ends after 5 of 6"),
        (b"P2 3 2 255\n1 2 3 4 5", "ends after 5 of 6"),
        (b"P2 3 1 9\n1 2 10", "pixel (2, 0) is 10"),
        (b"P2 0 1 9\n", "no pixel"),
        (b"P5 99999 99999 255\n", "more than"),
        (&big[..40], "broken PNG"),
        (&huge, "PNG"),
    ] {
        let fault = Image::read(bytes).expect_err(why);
        assert!(fault.in_image && fault.text.contains(why) && !fault.help.is_empty(), "{why}: {}", fault.text);
    }
    // Bytes of no meaning never panic.
    let mut random = Random(3);
    for start in [&b"P2"[..], b"P5", &big[..33]] {
        for _ in 0..500 {
            let rest = (0..random.below(60)).map(|_| b"\n #0123456789\xff"[random.below(14)]).collect::<Vec<u8>>();
            let _ = Image::read(&[start, &rest].concat());
        }
    }
}

#[test]
fn mistakes_of_map_files_have_their_lines() {
    let file = MapFile::read(YAML).expect("a map file");
    assert_eq!((file.image.as_str(), file.resolution, file.origin, file.yaw), ("lab.pgm", 0.5, [-1.0, -2.0], 0.0));
    let with = |from: &str, to: &str| YAML.replace(from, to);
    let cases = [
        (String::new(), None, "it has no `image`"),
        ("- a\n- b\n".into(), Some(1), "list"),
        ("lab.pgm\n".into(), Some(1), "no mapping"),
        ("image: [\n".into(), Some(1), "no YAML"),
        (with("0.5", "-0.1"), Some(2), "`resolution` is `-0.1`"),
        (with("0.5", "0.1 m"), Some(2), "`resolution` is `0.1 m`"),
        (with("0.5", ".nan"), Some(2), "`resolution`"),
        (with("[-1, -2, 0]", "[-1, -2]"), Some(3), "three numbers"),
        (with("[-1, -2, 0]", "here"), Some(3), "three numbers"),
        (with("negate: 0", "negate: 2"), Some(4), "`negate` is `2`"),
        (with("0.65", "1.5"), Some(5), "between 0 and 1"),
        (with("0.196", "0.7"), Some(6), "above `occupied_thresh`"),
        (format!("{YAML}mode: trinray\n"), Some(7), "`mode` is `trinray`"),
        (format!("{YAML}modes: raw\n"), Some(7), "no key `modes`"),
        (format!("{YAML}image: b.pgm\n"), Some(7), "twice"),
    ];
    for (text, line, why) in cases {
        let faults = MapFile::read(&text).expect_err(why);
        assert!(faults[0].text.contains(why) && faults[0].line == line && !faults[0].in_image, "{text}: {faults:?}");
        assert!(faults.iter().all(|fault| !fault.help.is_empty()));
    }
    let other = MapFile::read(&format!("{YAML}my_key: {{ a: [1, 2], b: c }}\n")).expect("keys of others are ignored");
    assert_eq!(other, file);
}

/// A turned map has its lower left corner at the origin, and rows along `yaw`.
#[test]
fn a_map_has_a_place_and_a_direction() {
    let yaml = YAML.replace("-2, 0]", "-2, 1.5707963267948966]");
    let map = read(&yaml, b"P2 3 2 1 0 1 1 1 1 1");
    // The black pixel is the uppermost of the left column: up is against the x axis.
    assert_eq!(map.cell(map.index([-1.75, -1.75])), Some(Cell::Occupied));
    assert_eq!(map.cell(map.index([-1.25, -1.75])), Some(Cell::Free));
    assert_eq!(map.cell(map.index([-0.75, -1.75])), None);
    let middle = map.middle(map.index([-1.75, -1.75]));
    assert!(distance(middle, [-1.75, -1.75]) < 1e-12 && distance(map.corners()[0], [-1.0, -2.0]) < 1e-12);
    assert!(map.describe([-1.75, -1.75]).starts_with("pixel (0, 0) of `lab.pgm`"), "{}", map.describe([-1.75, -1.75]));
}

#[test]
fn a_grid_is_written_as_runs() {
    let map = grid(5, 30, 20);
    let text = serde_json::to_string(&map).expect("JSON");
    assert!(text.len() < 3 * map.cells().len(), "{} characters", text.len());
    assert_eq!(serde_json::from_str::<OccupancyGrid>(&text).expect("a grid"), map);
    for (from, to) in [
        ("\"columns\":30", "\"columns\":31"),
        ("\"columns\":30", "\"columns\":0"),
        ("\"rows\":20", "\"rows\":4000000000"),
    ] {
        assert!(serde_json::from_str::<OccupancyGrid>(&text.replace(from, to)).is_err());
    }
}

/// The distance (in cells) of a point from the nearest blocked cell or from outside, over all cells.
fn naive_room(map: &OccupancyGrid, p: Point) -> f64 {
    let [x, y] = map.to_cells(p);
    let (w, h) = (map.columns as f64, map.rows as f64);
    let mut least = x.min(y).min(w - x).min(h - y).max(0.0);
    for (index, _) in map.cells().iter().enumerate().filter(|(_, cell)| **cell != Cell::Free) {
        let (left, low) = ((index % map.columns) as f64, (index / map.columns) as f64);
        let (dx, dy) = ((left - x).max(x - left - 1.0).max(0.0), (low - y).max(y - low - 1.0).max(0.0));
        least = least.min(f64::hypot(dx, dy));
    }
    least
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    /// Lines and distances agree with dense samples.
    #[test]
    fn lines_over_grids_agree_with_samples(seed in 0_u64..10_000, reach in 0.05_f64..2.5) {
        let map = grid(seed, 14, 11);
        let mut random = Random(seed + 7);
        random.unit();
        for _ in 0..12 {
            let mut point = || map.to_ground([random.within(0.0, 14.0), random.within(0.0, 11.0)]);
            let (a, b) = (point(), point());
            let samples: Vec<Point> = (0..=600).map(|i| between(a, b, f64::from(i) / 600.0)).collect();
            let entered = samples.iter().any(|p| map.is_blocked(map.index(*p)));
            // A corner of a cell may be between two samples: then the line is within a sample of its border.
            let room = samples.iter().map(|p| naive_room(&map, *p)).fold(f64::INFINITY, f64::min);
            if entered {
                prop_assert!(map.crosses(a, b));
            } else if room > 0.05 {
                prop_assert!(!map.crosses(a, b), "{a:?} {b:?} {room}");
            }
            prop_assert_eq!(map.crosses(a, b), map.crosses(b, a));
            let clear = map.clear(a, b, reach * map.resolution);
            if (room - reach).abs() > 0.05 {
                prop_assert_eq!(clear, room > reach, "{:?} {:?}: room {}, reach {}", a, b, room, reach);
            }
            let near = naive_room(&map, a);
            if (near - reach).abs() > 1e-9 {
                prop_assert_eq!(map.clear(a, a, reach * map.resolution), near > reach);
            }
        }
    }

    /// Rectangles cover exactly the cells of a state, and fewer of them cover at least these.
    #[test]
    fn rectangles_cover_their_cells(seed in 0_u64..10_000, most in 1_usize..40) {
        let map = grid(seed, 23, 17);
        for (most, exact) in [(usize::MAX, true), (most, false)] {
            let all = map.rectangles(Cell::Occupied, most);
            let boxes: Vec<[Point; 2]> = all.iter().map(|corners| [map.to_cells(corners[0]), map.to_cells(corners[2])]).collect();
            prop_assert!(exact || boxes.len() <= most.max(1), "{} of {most}", boxes.len());
            for (index, cell) in map.cells().iter().enumerate() {
                let (x, y) = ((index % 23) as f64 + 0.5, (index / 23) as f64 + 0.5);
                let covering = boxes.iter().filter(|[low, high]| low[0] < x && x < high[0] && low[1] < y && y < high[1]);
                let count = covering.count();
                if exact {
                    prop_assert_eq!(count, usize::from(*cell == Cell::Occupied));
                } else {
                    prop_assert!(count <= 1 && (count == 1 || *cell != Cell::Occupied));
                }
            }
        }
    }
}

/// Middles of the cells that a point reaches over the sides of free cells.
fn flooded(map: &OccupancyGrid, from: CellIndex, fits: impl Fn(CellIndex) -> bool) -> Vec<CellIndex> {
    let mut seen = vec![from];
    let mut next = 0;
    while let Some(CellIndex { column, row }) = seen.get(next).copied() {
        next += 1;
        for (dc, dr) in [(1, 0), (-1, 0), (0, 1), (0, -1)] {
            let index = CellIndex { column: column + dc, row: row + dr };
            if map.cell(index).is_some() && !seen.contains(&index) && fits(index) {
                seen.push(index);
            }
        }
    }
    seen
}

/// A point reaches what a flood fill over free cells reaches; a body at least what one over cells in which it fits does.
#[test]
fn reachability_is_that_of_a_flood_fill() {
    let (mut apart, mut reached) = (0, 0);
    for seed in 0..40 {
        let map = grid(seed, 19, 15);
        let all = (0..15).flat_map(|row| (0..19).map(move |column| CellIndex { column, row }));
        let free: Vec<CellIndex> = all.filter(|index| !map.is_blocked(*index)).collect();
        for radius in [0.0, 0.6 * map.resolution] {
            let mut p = on_grid(map.clone(), seed);
            p.agents.truncate(1);
            p.agents[0].radius = radius;
            let fits = |index: CellIndex| {
                !map.is_blocked(index) && naive_room(&map, map.middle(index)) * map.resolution >= radius
            };
            let Some(from) = free.iter().copied().find(|index| fits(*index)) else { continue };
            let ground = Ground::new(&p, &Body::of(&p.agents[0]));
            let raster = ground.raster();
            let found = raster.reached(map.middle(from));
            let flood = flooded(&map, from, fits);
            for index in &free {
                let (is, expected) = (found.reaches(map.middle(*index)), flood.contains(index));
                let at = format!("seed {seed}, radius {radius}: {index:?} from {from:?}");
                assert!(if radius == 0.0 { is == expected } else { is || !expected }, "{at}: {is}, {expected}");
                let way = found.way(map.middle(*index)).filter(|_| is);
                assert_eq!(way.is_some(), is, "{at}");
                for two in way.iter().flatten().copied().collect::<Vec<Point>>().windows(2) {
                    assert!(ground.clear(two[0], two[1]), "{at}");
                }
                (apart, reached) = (apart + usize::from(!is), reached + usize::from(is));
            }
        }
    }
    assert!(apart > 500 && reached > 2_000, "{apart} apart, {reached} reached");
}

fn worlds(count: usize) -> Vec<(u64, Problem)> {
    let all = (0..).map(|seed| (seed, on_grid(grid(seed, 24, 18), seed)));
    all.filter(|(_, p)| check(p).is_empty()).take(count).collect()
}

/// Ways keep their radius from every blocked cell, sample by sample; the validator accepts plans and refuses ways through
/// blocked cells.
#[test]
fn ways_never_enter_blocked_cells() {
    let (mut ways, mut refused) = (0, 0);
    for (seed, p) in worlds(25) {
        let map = p.occupancy.clone().expect("a map");
        let sets = ActionSets::new(&p, 2);
        for (index, set) in sets.of.iter().enumerate() {
            let count = set.spots.len();
            for way in (0..count * count).filter_map(|i| set.way(i / count, i % count)) {
                ways += 1;
                for i in 0..=150 {
                    let at = along(&way.points, f64::from(i) / 150.0, 0.0).at;
                    let room = naive_room(&map, at) * map.resolution;
                    assert!(!map.is_blocked(map.index(at)), "seed {seed}: {at:?}");
                    assert!(room >= p.agents[index].radius - 1e-9, "seed {seed}: {room} m at {at:?}");
                }
            }
        }
        let good = plan(&p, &Options::of(&p)).expect("a plan").plan;
        let violations = validate(&p, &good);
        assert!(violations.is_empty(), "seed {seed}: {violations:?}");
        // The same plan on a map on which the middle of a way is blocked.
        for activity in good.activities.iter().filter(|activity| activity.way.len() > 1) {
            let at = map.index(along(&activity.way, 0.5, 0.0).at);
            let mut cells = map.cells().to_vec();
            cells[at.row as usize * map.columns + at.column as usize] = Cell::Unknown;
            let size = [map.columns, map.rows];
            let other =
                OccupancyGrid::new(String::new(), size, map.resolution, map.origin, map.yaw, cells).expect("a map");
            let walled = Problem { occupancy: Some(other), ..p.clone() };
            assert!(!validate(&walled, &good).is_empty(), "seed {seed}");
            refused += 1;
        }
    }
    assert!(ways > 200 && refused > 25, "{ways} ways, {refused} refused");
}
