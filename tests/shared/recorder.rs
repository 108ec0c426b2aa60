//! Keeps the digests of all masks that the suite makes, so that two builds can be held against each other (`scripts/digests`).

use std::collections::BTreeSet;
use std::io::Write;
use std::path::Path;

/// Adds the digests that a run told, on standard output or in documents of its folder, to the file that
/// `SKYSHED_DIGESTS` names.
pub(crate) fn record(folder: &Path, words: &[&str], out: &str) {
    let Some(file) = std::env::var_os("SKYSHED_DIGESTS") else { return };
    let test = std::thread::current().name().unwrap_or("?").to_string();
    let line = words.join(" ").replace(folder.to_str().unwrap_or("?"), ".");
    let mut found: BTreeSet<String> =
        digests(out).map(|digest| format!("{test}\t{line}\tanswer\t{digest}\n")).collect();
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        if path.extension().is_some_and(|e| e == "json")
            && let Ok(text) = std::fs::read_to_string(&path)
        {
            let name = entry.file_name().to_string_lossy().into_owned();
            found.extend(digests(&text).map(|digest| format!("{test}\t{line}\t{name}\t{digest}\n")));
        }
    }
    let mut file = std::fs::OpenOptions::new().create(true).append(true).open(file).expect("the file of digests");
    // One write, so that lines of two tests do not mix.
    file.write_all(found.into_iter().collect::<String>().as_bytes()).expect("the file of digests");
}

/// What stands behind each `"digest"` of a text.
fn digests(text: &str) -> impl Iterator<Item = &str> {
    text.split("\"digest\":").skip(1).filter_map(|rest| rest.split('"').nth(1))
}
