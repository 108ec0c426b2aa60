//! Data flows one way: each module of the crate uses only earlier ones.

use std::collections::BTreeSet;
use std::path::Path;

/// The stages in order, each with the earlier stages that it may use. `digest`, `error`, `quantity` and `overlay` are usable
/// everywhere and use nothing.
const ALLOWED: [(&str, &[&str]); 17] = [
    ("digest", &[]),
    ("error", &[]),
    ("quantity", &[]),
    ("overlay", &[]),
    ("raster", &[]),
    ("scene", &["raster"]),
    ("height_field", &["raster", "scene"]),
    ("los", &["raster", "scene", "height_field"]),
    ("zones", &["raster", "scene", "height_field"]),
    ("coverage", &["raster", "scene", "height_field", "los"]),
    ("los_probability", &["raster", "scene", "height_field", "los"]),
    ("placement", &["raster", "scene", "height_field", "los", "zones", "coverage", "los_probability"]),
    ("accuracy", &["raster", "scene", "height_field", "los", "zones", "coverage", "los_probability"]),
    (
        "render",
        &["raster", "scene", "height_field", "los", "zones", "coverage", "los_probability", "placement", "accuracy"],
    ),
    (
        "export",
        &["raster", "scene", "height_field", "los", "zones", "coverage", "los_probability", "placement", "accuracy"],
    ),
    (
        "report",
        &["raster", "scene", "height_field", "los", "zones", "coverage", "los_probability", "placement", "accuracy"],
    ),
    (
        "cli",
        &[
            "raster",
            "scene",
            "height_field",
            "los",
            "zones",
            "coverage",
            "los_probability",
            "placement",
            "accuracy",
            "render",
            "export",
            "report",
        ],
    ),
];

/// Stages that do no I/O and read no clock and no environment.
const PURE: [&str; 10] = [
    "quantity",
    "overlay",
    "height_field",
    "los",
    "zones",
    "coverage",
    "los_probability",
    "placement",
    "accuracy",
    "render",
];

/// What a pure stage must not mention.
const IMPURE: [&str; 6] = ["std::fs", "std::env", "std::time", "std::io::stdout", "std::net", "std::process"];

fn sources(folder: &Path, found: &mut Vec<(String, String)>) {
    let mut entries: Vec<_> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    entries.sort();
    for path in entries {
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push((path.display().to_string(), std::fs::read_to_string(&path).unwrap()));
        }
    }
}

/// The stages that a source file names as `crate::STAGE`, comments left out.
fn used(text: &str) -> BTreeSet<String> {
    let code = text.lines().filter(|l| !l.trim_start().starts_with("//"));
    code.flat_map(|line| line.match_indices("crate::").map(|(at, word)| line[at + word.len()..].to_string()))
        .map(|rest| rest.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect())
        .collect()
}

fn stage_files(stage: &str) -> Vec<(String, String)> {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut found = Vec::new();
    let file = src.join(format!("{stage}.rs"));
    if file.is_file() {
        found.push((file.display().to_string(), std::fs::read_to_string(&file).unwrap()));
    } else {
        sources(&src.join(stage), &mut found);
    }
    found
}

#[test]
fn a_stage_uses_only_earlier_stages() {
    let stages: Vec<&str> = ALLOWED.iter().map(|(stage, _)| *stage).collect();
    let mut n_uses = 0;
    for (stage, allowed) in ALLOWED {
        for (file, text) in stage_files(stage) {
            for other in used(&text).iter().filter(|u| stages.contains(&u.as_str()) && *u != stage) {
                let everywhere =
                    ["digest", "error", "quantity", "overlay"].contains(&other.as_str()) && !["error"].contains(&stage);
                assert!(everywhere || allowed.contains(&other.as_str()), "{file} uses crate::{other}");
                n_uses += 1;
            }
        }
    }
    assert!(n_uses > 40, "only {n_uses} uses were seen: the test reads the wrong files");
}

#[test]
fn every_module_has_its_place_in_the_order() {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let known: BTreeSet<String> = ALLOWED.iter().map(|(stage, _)| (*stage).to_string()).collect();
    let found: BTreeSet<String> = std::fs::read_dir(src)
        .unwrap()
        .map(|e| e.unwrap().path().file_stem().unwrap().to_string_lossy().into_owned())
        .filter(|name| !["lib", "main"].contains(&name.as_str()))
        .collect();
    assert_eq!(found, known);
}

#[test]
fn the_middle_stages_do_no_io() {
    for stage in PURE {
        for (file, text) in stage_files(stage) {
            // Tests at the end of a file may read what they like.
            let code = text.split("#[cfg(test)]").next().unwrap_or_default();
            for word in IMPURE {
                assert!(!code.contains(word), "{file} mentions {word}");
            }
        }
    }
}
