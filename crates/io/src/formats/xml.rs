//! XML as GDAL writes it: names in any case of letters, and few attributes.

use std::fmt::Display;

use roxmltree::Node;

use crate::error::{Error, ReadFault, Result};

/// Returns the first child element of a name; like GDAL in any case of letters.
pub(super) fn child<'a, 'b>(parent: Node<'a, 'b>, name: &str) -> Option<Node<'a, 'b>> {
    parent.children().find(|node| node.is_element() && node.tag_name().name().eq_ignore_ascii_case(name))
}

/// Returns an attribute, in any case of letters.
pub(super) fn attribute<'a>(node: Node<'a, '_>, name: &str) -> Option<&'a str> {
    node.attributes().find(|attribute| attribute.name().eq_ignore_ascii_case(name)).map(|attribute| attribute.value())
}

/// Returns the text in an element, without blanks around it.
pub(super) fn text_of<'a>(node: Node<'a, '_>) -> &'a str {
    node.text().unwrap_or_default().trim()
}

/// Largest number of attributes of an element, and of namespaces of a file; the parser compares
/// each with all others.
const MOST_ATTRIBUTES: usize = 500;

/// Refuses elements with more attributes, and files with more namespaces, than any file of GDAL
/// has.
pub(crate) fn refuse_crowds(name: impl Display, xml: &str) -> Result<()> {
    let mut rest = xml;
    let mut n_namespaces = 0;
    while let Some(start) = rest.find('<') {
        rest = &rest[start..];
        let outside = [("<!--", "-->"), ("<![CDATA[", "]]>"), ("<?", "?>")];
        if let Some((begin, end)) = outside.into_iter().find(|(begin, _)| rest.starts_with(begin)) {
            rest = rest[begin.len()..].split_once(end).map_or("", |(_, after)| after);
            continue;
        }
        // Each value in quotes belongs to an attribute.
        let (mut n_attributes, mut quote) = (0, None);
        let end = rest.find(|c| match (quote, c) {
            (Some(open), c) if c == open => {
                quote = None;
                false
            }
            (None, '"' | '\'') => {
                n_attributes += 1;
                quote = Some(c);
                false
            }
            (quote, c) => quote.is_none() && c == '>',
        });
        let (tag, after) = rest.split_at(end.unwrap_or(rest.len()));
        n_namespaces += tag.matches("xmlns").count();
        if n_attributes.max(n_namespaces) > MOST_ATTRIBUTES {
            let what = format!("more than {MOST_ATTRIBUTES} attributes or namespaces, wanted fewer");
            return Err(Error::read(name, ReadFault::TooMany(what)));
        }
        rest = after;
    }
    Ok(())
}
