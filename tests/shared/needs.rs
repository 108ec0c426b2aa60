//! Parts that some tests need and that are not on every machine: other programs, packages of Python, data.
//!
//! A test that lacks its part says `SKIPPED` and passes, unless the part is named in `SKYSHED_NEED`: then it fails.

#![allow(dead_code, reason = "each binary uses a part")]

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Everything that `SKYSHED_NEED` may name.
const PARTS: [&str; 13] = [
    "truth",      // the shared test data
    "gdal",       // gdal-bin
    "node",       // Node.js with npm
    "typescript", // the compiler, from the npm registry
    "playwright", // playwright-core, from the npm registry
    "chromium",   // a browser
    "cgroup",     // the right to make a control group with a limit of memory
    "valgrind",   // for scripts/costs
    "qgis",       // python3-qgis, 270 MB: not installed by scripts/parts
    "python",     // Python 3.10 or later, for the tests of the package
    "shapely",    // the package for Python
    "rio_cogeo",  // the package for Python
    "mitsuba",    // the package for Python
];

/// Whether a part is there. Where it is not, standard error says so past the capture of the test harness.
///
/// # Panics
/// If the part is missing and `SKYSHED_NEED` names it, or if `SKYSHED_NEED` names what is no part.
pub(crate) fn has(part: &str, is_there: bool) -> bool {
    assert!(PARTS.contains(&part), "`{part}` is no part that tests need");
    if is_there {
        return true;
    }
    let wanted = std::env::var("SKYSHED_NEED").unwrap_or_default();
    for word in wanted.split(',').filter(|word| !word.is_empty()) {
        assert!(PARTS.contains(&word), "SKYSHED_NEED: `{word}` is none of {PARTS:?}");
        assert_ne!(word, part, "SKYSHED_NEED wants `{part}`, which is missing");
    }
    let _ = writeln!(std::io::stderr(), "SKIPPED: no `{part}`");
    false
}

/// The folder of the shared test data: `SKYSHED_TRUTH`, else the one beside the checkout.
pub(crate) fn truth() -> Option<PathBuf> {
    if let Some(folder) = std::env::var_os("SKYSHED_TRUTH") {
        let folder = PathBuf::from(folder);
        assert!(folder.is_dir(), "SKYSHED_TRUTH is `{}`, which is no folder", folder.display());
        return Some(folder);
    }
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data");
    has("truth", folder.is_dir()).then_some(folder)
}

/// Whether a program runs, and so the part that it belongs to is there.
pub(crate) fn has_program(name: &str) -> bool {
    let part = match name {
        "npm" | "npx" => "node",
        _ if name.starts_with("gdal") || name.starts_with("ogr") => "gdal",
        _ => name,
    };
    has(part, Command::new(name).arg("--version").output().is_ok())
}

/// Whether `python3` has a module.
pub(crate) fn python_with(module: &str) -> bool {
    let found = Command::new("python3").args(["-c", &format!("import {module}")]).output();
    has(module, found.is_ok_and(|output| output.status.success()))
}
