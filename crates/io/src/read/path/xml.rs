//! XML of paths: elements by their names, in any namespace.

use roxmltree::{Document, Node};

use crate::error::{Error, MOST_FOUND, Result, shortened};
use crate::formats::refuse_crowds;
use crate::input::Input;

/// Parses XML without a document type, which may hold entities.
pub(super) fn parse_xml<'a>(input: &Input, text: &'a str) -> Result<Document<'a>> {
    refuse_crowds(input, text)?;
    Document::parse(text).map_err(|e| {
        let found = shortened(&e.to_string(), MOST_FOUND).into_owned();
        Error::malformed(input, format!("{found}, wanted GPX or KML"))
    })
}

/// Returns the child elements of a name, in any namespace.
pub(super) fn named<'a, 'b: 'a>(parent: Node<'a, 'b>, name: &'static str) -> impl Iterator<Item = Node<'a, 'b>> {
    parent.children().filter(move |node| node.tag_name().name() == name)
}

/// Returns the text of a child element, unless it is empty.
pub(super) fn text_of(parent: Node<'_, '_>, name: &'static str) -> Option<String> {
    let text = named(parent, name).next()?.text()?.trim();
    (!text.is_empty()).then(|| text.to_string())
}
