//! Every document that the suite meets is one of its schema, and the schemas in docs/ are those of the types.

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

fn folder() -> PathBuf {
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

#[test]
fn the_schemas_in_docs_are_those_of_the_types() {
    let is_made_anew = std::env::var_os("SKYSHED_WRITE_DOCS").is_some();
    for (kind, schema) in skyshed::schemas::documents() {
        let (path, text) = (folder().join(format!("{kind}.json")), format!("{schema:#}\n"));
        if is_made_anew {
            std::fs::create_dir_all(folder()).expect("docs/schema");
            std::fs::write(&path, &text).expect("a schema");
        }
        let found = std::fs::read_to_string(&path).unwrap_or_default();
        assert!(found == text, "{} is not that of the types: SKYSHED_WRITE_DOCS=1 makes it anew", path.display());
    }
    let n = std::fs::read_dir(folder()).expect("docs/schema").count();
    assert_eq!(n, skyshed::schemas::documents().len(), "docs/schema holds one file for each kind");
}

#[test]
fn every_column_says_what_it_means() {
    for (kind, columns) in skyshed::schemas::tables() {
        assert!(columns.len() >= 4, "{kind}");
        for column in columns {
            assert!(column.meaning.len() >= 5, "the column `{}` of the table `{kind}`", column.name);
        }
    }
}

/// What the page says of tables: what was written by hand, then the columns of each.
fn page_of_tables(page: &str) -> String {
    let mark = page.find("<!--").and_then(|start| Some(start + page[start..].find('\n')? + 1)).expect("a mark");
    let mut text = page[..mark].to_string();
    for (kind, columns) in skyshed::schemas::tables() {
        text += &format!("\n### {kind}\n\n| column | meaning |\n|---|---|\n");
        for column in columns {
            text += &format!("| `{}` | {} |\n", column.name, column.meaning.replace('|', "\\|").replace('\n', " "));
        }
    }
    text
}

#[test]
fn the_columns_in_docs_are_those_of_the_types() {
    let path = folder().with_file_name("tables.md");
    let found = std::fs::read_to_string(&path).expect("docs/tables.md");
    let page = page_of_tables(&found);
    if std::env::var_os("SKYSHED_WRITE_DOCS").is_some() {
        std::fs::write(&path, page).expect("docs/tables.md");
        return;
    }
    assert!(found == page, "docs/tables.md is not that of the types: SKYSHED_WRITE_DOCS=1 makes it anew");
}

#[test]
fn a_document_with_a_member_of_no_schema_is_found() {
    let of = |more: &str| {
        let text = format!(
            r#"{{"schema": "skyshed/repairs/1", "version": "{}", "command": [], "method": "none", "scene": {{"name": "a",
            "cols": 1, "rows": 1, "cell_m": [1, 1], "extent": [0, 0, 1, 1], "crs": null, "seed": null, "sources": []}},
            "warnings": [], "repairs": 0{more}}}"#,
            env!("CARGO_PKG_VERSION")
        );
        std::panic::catch_unwind(move || check(&text, "this test"))
    };
    assert!(of("").is_ok());
    assert!(of(r#", "no_such_member": 1"#).is_err());
}
