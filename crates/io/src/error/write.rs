//! Files that cannot be written.

use thiserror::Error as Words;

use skyshed_request::Layer;

use crate::export::Format;

/// Reason why a file cannot be written.
#[derive(Debug, Clone, PartialEq, Words)]
#[non_exhaustive]
pub enum WriteFault {
    /// E104: an output without an extension to set its format; the allowed formats.
    #[error("it has no extension, which tells the format")]
    NoExtension(Vec<Format>),
    /// E104: an unknown extension; the allowed formats.
    #[error("unknown extension `.{0}`")]
    Extension(String, Vec<Format>),
    /// E105: a format of other commands; the allowed formats.
    #[error("this command does not write that format")]
    NotThisFormat(Vec<Format>),
    /// E105: a format that is a feature of the build, which was left out.
    #[error("this build does not write that format")]
    NotBuilt,
    /// E105: an output that is named twice.
    #[error("it is named twice")]
    Twice,
    /// E105: a sidecar that two outputs need.
    #[error("two outputs of this run need it")]
    Needed,
    /// E105: an output that is a folder.
    #[error("it is a folder")]
    Folder,
    /// E105: an output that exists and is no file.
    #[error("it is a folder, a pipe or a device, wanted a file")]
    NoFile,
    /// E105: an output that is an input of the run.
    #[error("it is an input of this run")]
    Input,
    /// E105: an output whose sidecar is an input of the run.
    #[error("its sidecar {0} is an input of this run")]
    SidecarIsInput(String),
    /// E105: an output that would become a tile of an input of the run.
    #[error("it would be a tile of the folder that this run reads")]
    Tile,
    /// E106: an output that exists.
    #[error("it exists")]
    Exists,
    /// E106: an output that was made by another while the run worked.
    #[error("it exists, made while this run worked")]
    ExistsMeanwhile,
    /// E107: a format of one layer for several; their number.
    #[error("{name} holds one layer of one site, found {1}", name = if *.0 == Format::Bil { "a .bil file" } else { "an ASCII grid" })]
    OneLayer(Format, usize),
    /// E107: a format that shows a layer that was not chosen.
    #[error("it shows line of sight, which is not among the layers")]
    Without(Layer),
    /// E107: sets of more UAVs than a float holds, beside measures.
    #[error("`which` of more than 24 sites beside measures")]
    SetsBesideMeasures,
    /// E107: sets that leave no number for nodata, beside counts.
    #[error("`count` beside `which` of 32 sites or more")]
    SetsBesideCounts,
    /// E109: footprints that are no boxes; their number, and the number of all.
    #[error("{0} of {1} footprints are not rectangles parallel to the axes, as buildings of ns-3 are")]
    NoBoxes(usize, usize),
    /// E401: the system refuses to write the file.
    #[error("{0}")]
    Refused(String),
    /// E401: a scratch file that the system refuses to write.
    #[error("{0}")]
    Scratch(String),
    /// E402: content that the format cannot hold.
    #[error("{0}")]
    Encode(String),
    /// E502: more corners than a mesh can count.
    #[error("it has more than 2^31 corners")]
    Corners,
}

impl WriteFault {
    /// Returns the verb of the failed step.
    pub(super) fn verb(&self) -> &'static str {
        if matches!(self, WriteFault::Encode(_)) { "encode" } else { "write" }
    }

    pub(super) fn number(&self) -> u16 {
        use WriteFault::*;
        match self {
            NoExtension(_) | Extension(..) => 104,
            Exists | ExistsMeanwhile => 106,
            OneLayer(..) | Without(_) | SetsBesideMeasures | SetsBesideCounts => 107,
            NoBoxes(..) => 109,
            Refused(_) | Scratch(_) => 401,
            Encode(_) => 402,
            Corners => 502,
            _ => 105,
        }
    }
}
