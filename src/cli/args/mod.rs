//! Flags that commands share, beside the parts of requests: what the program makes of them.

pub(super) mod output;
pub(super) mod scene;
pub(super) mod sight;
