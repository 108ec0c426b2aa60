//! Runs nothing: a package has build dependencies only beside a build script, and those of `Cargo.toml` set features of shared macros.

fn main() {}
