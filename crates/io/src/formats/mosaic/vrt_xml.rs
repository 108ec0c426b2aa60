//! XML of a virtual raster: read within limits, with errors that name a line.

use std::fmt::Display;
use std::io::Read;
use std::path::Path;

use roxmltree::{Document, Node};

use crate::error::{Cause, Error, Place, ReadFault, Result};
use crate::formats::xml::{child, text_of};
use crate::input::{Input, cannot_read};

/// Longest XML \[bytes\]: that of some hundred thousand sources.
const MAX_XML_BYTES: u64 = 256 << 20;

/// Reads the text of the file.
pub(super) fn read_xml(path: &Path) -> Result<String> {
    let input = Input::path(path);
    let (file, len) = input.open()?;
    if len > MAX_XML_BYTES {
        let what = format!("{len} bytes of XML, wanted at most {} MiB", MAX_XML_BYTES >> 20);
        return Err(Error::read(&input, ReadFault::Memory(what)));
    }
    let mut bytes = Vec::new();
    file.take(MAX_XML_BYTES).read_to_end(&mut bytes).map_err(|e| cannot_read(&input, &e))?;
    let text = String::from_utf8(bytes).map_err(|e| Error::malformed(&input, format!("{e}, wanted XML in UTF-8")))?;
    Ok(text.strip_prefix('\u{feff}').map_or(text.clone(), str::to_owned))
}

/// XML that is being read, for errors about it.
#[derive(Clone, Copy)]
pub(super) struct Vrt<'a> {
    pub(super) path: &'a Path,
    pub(super) document: &'a Document<'a>,
}

impl Vrt<'_> {
    /// Returns an error at the line of an element.
    pub(super) fn error(&self, at: Node<'_, '_>, fault: ReadFault) -> Error {
        let line = self.document.text_pos_at(at.range().start).row;
        Error::read(self.path.display(), fault).at(Place::Line(line.into()))
    }

    /// Returns E302 at the line of an element.
    pub(super) fn malformed(&self, at: Node<'_, '_>, what: impl Into<String>) -> Error {
        self.error(at, ReadFault::Malformed(what.into()))
    }

    /// Returns E304 for a feature of GDAL that this program lacks.
    pub(super) fn unsupported(&self, at: Node<'_, '_>, found: impl Display) -> Error {
        let what = format!("{found}, wanted sources that are copied cell by cell");
        self.error(at, ReadFault::Unsupported(what)).because(Cause::ForGdal)
    }

    /// Returns the number that an element or attribute holds.
    pub(super) fn number(&self, at: Node<'_, '_>, name: &str, text: &str) -> Result<f64> {
        let number = text.trim().parse().ok().filter(|number: &f64| number.is_finite());
        number.ok_or_else(|| self.malformed(at, format!("`{name}` is `{text}`, wanted a finite number")))
    }

    /// Returns the number of a child element, if there is such an element.
    pub(super) fn child_number(&self, parent: Node<'_, '_>, name: &str) -> Result<Option<f64>> {
        child(parent, name).map(|node| self.number(node, name, text_of(node))).transpose()
    }
}
