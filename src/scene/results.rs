//! Output files of this program, distinguished from scenes.

use std::path::Path;

use serde_json::Value;

use crate::formats::origin_of;

/// Returns the schema of the document in a raster of this program that holds results instead of
/// heights. `None` for other rasters.
pub(crate) fn results_in(path: &Path) -> Option<String> {
    let origin: Value = serde_json::from_str(&origin_of(path)?).ok()?;
    (!is_city(&origin)).then(|| origin["schema"].as_str().unwrap_or_default().to_string())
}

/// Returns `true` if the origin of a file is that of a scene.
pub(crate) fn is_city(origin: &Value) -> bool {
    origin["schema"] == "skyshed/city/1"
}
