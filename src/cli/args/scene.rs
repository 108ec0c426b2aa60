//! The scene of a command.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use skyshed_io::read::named_files;
use skyshed_request::{Reading, json};

/// Returns a scene and the options that change it, as words of any command line.
pub(crate) fn scene_words(scene: &OsStr, reading: &Reading) -> Vec<String> {
    // Hashing inputs does not change the scene.
    let mut members = json::set_members(&reading.options);
    members.retain(|name, _| name != "hash");
    std::iter::once(scene.display().to_string()).chain(json::words(&members)).collect()
}

/// Returns the files that a scene names, for the refusal to overwrite them.
pub(crate) fn scene_files(scene: &OsStr, reading: &Reading) -> Vec<PathBuf> {
    let named = named_files(Path::new(scene));
    named.into_iter().chain(reading.options.files().map(|path| path.0.clone())).collect()
}

/// Returns the layer that was read: as typed, or else the name of the file, which is the name of
/// its only layer.
pub(crate) fn layer_of(scene: &OsStr, reading: &Reading) -> String {
    let stem = || Path::new(scene).file_stem().unwrap_or_default().to_string_lossy().into_owned();
    reading.options.layer.clone().unwrap_or_else(stem)
}
