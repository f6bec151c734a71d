//! Features of shared libraries that a build with all features of Hierarq needs, switched on in every build. Cargo compiles a library
//! again for another set of features, and everything that depends on it: without this crate, going from the build without features to the full
//! one
//! compiles nearly all of it twice. The crate has no code; `tests/unified.rs` compares the features of both builds.
