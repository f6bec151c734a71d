//! People in the 3D replay: their tracked points, where the controller took them to be.

use runtime::Program;
use runtime::program::{HumanProgram, SignalProgram};
use runtime::record::series::SeriesRecorder;
use serde_json::{Value as Json, json};

use super::scene::round;

/// Numbers of a point in a sample: position and uncertainty, in m.
const STRIDE: usize = 4;

/// Data of the people of whom a point was known at some sample.
pub(super) fn people(program: &Program, series: &SeriesRecorder) -> Vec<Json> {
    program.interface.humans.iter().filter_map(|human| person(program, human, series)).collect()
}

fn person(program: &Program, human: &HumanProgram, series: &SeriesRecorder) -> Option<Json> {
    let points: Vec<&SignalProgram> = human.points.iter().map(|&s| &program.interface.signals[s]).collect();
    let mut data = Vec::with_capacity(series.signals.len() * points.len() * STRIDE);
    for table in &series.signals {
        points.iter().for_each(|point| data.extend(sample(point, table)));
    }
    if data.iter().all(|x| x.is_nan()) {
        return None;
    }
    let of_person = |point: &SignalProgram| {
        point.name.strip_prefix(&human.name).map_or(&point.name[..], |rest| rest.trim_start_matches('.')).to_string()
    };
    let names: Vec<String> = points.iter().map(|point| of_person(point)).collect();
    Some(json!({ "name": human.name, "points": names, "links": human.links, "data": data }))
}

/// Position and uncertainty; NaN while nobody knows where the point is.
fn sample(point: &SignalProgram, table: &[f64]) -> [f64; STRIDE] {
    if table[point.known_at()] <= 0.0 {
        return [f64::NAN; STRIDE];
    }
    let value = |i: usize| round(table[point.at + 1 + i]);
    let uncertainty = if point.motion.is_some() { round(table[point.uncertainty_at()]) } else { 0.0 };
    [value(0), value(1), value(2), uncertainty]
}
