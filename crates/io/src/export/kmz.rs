//! KMZ: a KML document and its pictures in one ZIP file.

use std::io::{Cursor, Write};

use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

use crate::error::{Error, Result};

/// Encodes a KMZ file: the document as `doc.kml`, which readers look for first, and the pictures
/// that it names.
///
/// # Errors
/// E402 if ZIP cannot hold them.
pub fn encode_kmz(document: &str, pictures: &[(String, Vec<u8>)]) -> Result<Vec<u8>> {
    let refused = |cause: zip::result::ZipError| Error::encode("a KMZ file", cause);
    // A fixed date, so that the same input gives the same bytes. PNG is packed already.
    let options =
        |method| SimpleFileOptions::default().compression_method(method).last_modified_time(DateTime::default());
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    archive.start_file("doc.kml", options(CompressionMethod::Deflated)).map_err(refused)?;
    archive.write_all(document.as_bytes()).map_err(|cause| refused(cause.into()))?;
    for (name, bytes) in pictures {
        archive.start_file(name.as_str(), options(CompressionMethod::Stored)).map_err(refused)?;
        archive.write_all(bytes).map_err(|cause| refused(cause.into()))?;
    }
    Ok(archive.finish().map_err(refused)?.into_inner())
}
