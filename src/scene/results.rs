//! Files that this program wrote, told from scenes.

use std::path::Path;

use serde_json::Value;

use crate::formats::origin_of;

/// The name of the document that a raster holds instead of heights, if this program wrote it for something else.
pub(crate) fn results_in(path: &Path) -> Option<String> {
    let origin: Value = serde_json::from_str(&origin_of(path)?).ok()?;
    (!is_city(&origin)).then(|| origin["schema"].as_str().unwrap_or_default().to_string())
}

/// Whether a file that says this of its origin is a scene.
pub(crate) fn is_city(origin: &Value) -> bool {
    origin["schema"] == "skyshed/city/1"
}
