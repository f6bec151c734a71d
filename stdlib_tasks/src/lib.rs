//! The task library of Hierarq: one file per task type
