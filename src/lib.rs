//! Hierarq.
