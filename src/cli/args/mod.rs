//! What can be typed, as `--help` documents it: the words that commands share. Each command adds its own beside its code.

pub(super) mod height_errors;
pub(super) mod output;
pub(super) mod scene;
pub(super) mod sight;
pub(super) mod words;
