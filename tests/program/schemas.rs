//! The schemas and the columns in docs/ are those of the types, and a document that is not of its schema is found.

use crate::documents::{check, folder};

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
