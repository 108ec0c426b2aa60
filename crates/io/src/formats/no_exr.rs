//! OpenEXR files in a build without the feature `exr`.

use std::io::Write;
use std::path::Path;

use super::ExrChannel;
use crate::error::{Error, Result};
use crate::input::Input;
use crate::raster::GeoRef;

/// Refuses to write.
///
/// # Errors
/// E402.
pub fn write_exr(_: &mut impl Write, _: &GeoRef, _: &[(String, ExrChannel<'_>)], _: &[(String, String)]) -> Result<()> {
    Err(Error::encode("an OpenEXR file", "this build has no `exr`"))
}

pub(super) fn exr_text(_: &Input, _: &str) -> Option<String> {
    None
}

pub(crate) fn is_whole_exr(_: &Path) -> bool {
    false
}
