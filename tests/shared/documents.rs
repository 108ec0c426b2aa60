//! Documents are held against their schemas in `docs/schema`, wherever a test meets one.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;
use std::time::SystemTime;

use boon::{Compiler, SchemaIndex, Schemas};
use serde_json::Value;

/// The schemas that are checked in, ready to validate with.
struct Compiled {
    schemas: Schemas,
    kinds: HashMap<String, SchemaIndex>,
}

static COMPILED: LazyLock<Compiled> = LazyLock::new(|| {
    let (mut schemas, mut compiler, mut kinds) = (Schemas::new(), Compiler::new(), HashMap::new());
    for entry in std::fs::read_dir(folder()).expect("docs/schema").flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        let text = std::fs::read_to_string(entry.path()).expect("a schema");
        compiler.add_resource(&name, serde_json::from_str(&text).expect("a schema is JSON")).expect("a resource");
        let index = compiler.compile(&name, &mut schemas).unwrap_or_else(|e| panic!("{name}: {e:#}"));
        kinds.insert(format!("skyshed/{}/1", name.trim_end_matches(".json")), index);
    }
    Compiled { schemas, kinds }
});

/// The folder of the schemas.
pub(crate) fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/schema")
}

/// Refuses a document of this program that is not of its schema, wherever in a text of JSON it stands.
pub(crate) fn check(text: &str, whose: &str) {
    let Ok(value) = serde_json::from_str::<Value>(text) else { return };
    // In GeoJSON it is one member among others.
    let inner = value.get("skyshed").filter(|inner| inner.get("schema").is_some()).cloned();
    let document = inner.unwrap_or(value);
    // Files that a test keeps from other versions need not be of today's schemas.
    let Some(kind) = document["schema"].as_str().filter(|kind| kind.starts_with("skyshed/")) else { return };
    if document["version"] != env!("CARGO_PKG_VERSION") {
        return;
    }
    let index = COMPILED.kinds.get(kind).unwrap_or_else(|| panic!("{whose}: no schema of {kind} in docs/schema"));
    if let Err(error) = COMPILED.schemas.validate(&document, *index) {
        panic!("{whose}: not a document of {kind}: {error:#}\n{document:#}");
    }
}

/// Checks the documents that were written into a folder since then.
pub(crate) fn check_files(folder: &Path, since: SystemTime) {
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        let is_document = path.extension().is_some_and(|e| e == "json" || e == "geojson");
        let is_new = || entry.metadata().and_then(|m| m.modified()).is_ok_and(|time| time >= since);
        if is_document && is_new() {
            check(&std::fs::read_to_string(&path).unwrap_or_default(), &path.display().to_string());
        }
    }
}
