//! Views of results: the report of a run, charts of plans, drawings of machines.

pub mod gantt;
pub mod graph;
pub mod report;
pub mod xml;
