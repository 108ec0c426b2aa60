//! Inputs beside a scene: files, or bytes in memory.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde::ser::SerializeMap;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use sha2::{Digest, Sha256};

/// A file by its path, or the bytes of one in memory under a name.
///
/// Setters take a path as it is: `.area("zone.geojson")`. Bytes in memory are
/// `.area(Source::held("zone.geojson", bytes))`.
///
/// JSON holds the path, or the name and the SHA-256 of the bytes. So a request over inputs in memory has an
/// identity, and names no temporary file; it cannot be read back.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Source {
    path: PathBuf,
    bytes: Option<Arc<[u8]>>,
}

impl Source {
    /// Returns bytes in memory under a name, whose extension is that of their format.
    pub fn held(name: impl Into<PathBuf>, bytes: impl Into<Arc<[u8]>>) -> Source {
        Source { path: name.into(), bytes: Some(bytes.into()) }
    }

    /// Returns the path, or the name.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the bytes in memory; `None` for a file.
    pub fn bytes(&self) -> Option<&Arc<[u8]>> {
        self.bytes.as_ref()
    }
}

impl<T: Into<PathBuf>> From<T> for Source {
    fn from(path: T) -> Self {
        Source { path: path.into(), bytes: None }
    }
}

impl Serialize for Source {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let path = self.path.to_string_lossy();
        let Some(bytes) = &self.bytes else { return serializer.serialize_str(&path) };
        let digest: String = Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect();
        let mut members = serializer.serialize_map(Some(2))?;
        members.serialize_entry("name", &path)?;
        members.serialize_entry("sha256", &digest)?;
        members.end()
    }
}

impl<'de> Deserialize<'de> for Source {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        String::deserialize(deserializer).map(Source::from)
    }
}

impl schemars::JsonSchema for Source {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Source".into()
    }

    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        schemars::json_schema!({"type": ["string", "object"]})
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_in_memory_go_by_their_digest() {
        let held = serde_json::to_value(Source::held("area.geojson", b"abc".to_vec())).expect("an object");
        // `printf abc | sha256sum`
        let digest = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert_eq!(held, serde_json::json!({"name": "area.geojson", "sha256": digest}));
        assert_eq!(serde_json::to_value(Source::from("a.csv")).expect("a text"), serde_json::json!("a.csv"));
    }
}
