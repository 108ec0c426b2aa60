//! What is odd about the header of a raster, as values: a mosaic and a scene know better than some of it.

use std::fmt::Display;

use crate::error::{Result, Warning};

/// Something odd, and the file in which it is.
#[derive(Debug, Clone)]
pub(crate) struct Oddity {
    name: String,
    pub(crate) odd: Odd,
    /// Other files with the same.
    n_more: usize,
}

/// What is odd, and what is done.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub(crate) enum Odd {
    #[error("declares nodata as `{0}`, which is no number: ignored")]
    Nodata(String),
    #[error("has a mask `{0}` beside it, which is not read: declare nodata instead")]
    Mask(String),
    #[error("names no coordinate reference system: local coordinates in meters are assumed")]
    NoCrs,
    #[error("has no coordinate reference system (a `.prj` file): local coordinates in meters are assumed")]
    NoPrj,
    #[error("has GeoTIFF model type `{0}`, neither projected nor geographic: local coordinates in meters are assumed")]
    ModelType(u16),
    #[error("has damaged GeoKeys, which are ignored: {0}")]
    DamagedKeys(String),
    #[error("names a coordinate reference system that is not known ({0}): used by its name only")]
    CrsByName(String),
    #[error("names a coordinate reference system that is not understood ({0}): ignored")]
    CrsIgnored(String),
    #[error("says nowhere where it lies: its cells are taken as 1 m wide, its south-west corner as 0, 0")]
    NoPlace,
    #[error("has a later image that cannot be read and is ignored: {0}")]
    LaterImage(String),
    #[error("has its southernmost row first: its rows are turned over")]
    SouthUp,
    #[error("has a negative cell height: read as positive, north up")]
    NegativeHeight,
    #[error(
        "is in web Mercator, whose meters are stretched by 1/cos(latitude): distances and angles are off; resample it with \
         `gdalwarp -t_srs EPSG:326NN`"
    )]
    WebMercator,
    #[error("gives its heights in units of {0} m; scenes convert them")]
    Unit(f64),
    #[error("has {0} bands: the first is read as heights")]
    Bands(usize),
    #[error("is a color picture of {0} bands: the first is read as heights")]
    Colors(usize),
    #[error("stores its heights scaled: multiplied by {0}, then {1} added")]
    Scaled(f64, f64),
    #[error("is JPEG-compressed: its heights are off by up to several units, and are used as they are")]
    Jpeg,
    #[error("gives its heights in units of {0} m by its band, of {1} m by its vertical system: the band is believed")]
    TwoUnits(f64, f64),
    #[error("has tiles of several bands (`{0}` has {1}): the first is read as heights")]
    TileBands(String, usize),
    #[error("has tiles that store their heights scaled (`{0}`: multiplied by {scale}, then {offset} added)", scale = .1.0, offset = .1.1)]
    TileScaling(String, (f64, f64)),
}

impl Odd {
    fn code(&self) -> u16 {
        match self {
            Odd::Nodata(_) => 322,
            Odd::Mask(_) => 324,
            Odd::NoCrs | Odd::NoPrj | Odd::ModelType(_) => 325,
            Odd::DamagedKeys(_) | Odd::CrsByName(_) | Odd::CrsIgnored(_) => 326,
            Odd::NoPlace => 327,
            Odd::LaterImage(_) => 329,
            Odd::SouthUp | Odd::NegativeHeight => 330,
            Odd::WebMercator => 331,
            Odd::Unit(_) => 332,
            Odd::Jpeg => 334,
            Odd::Bands(_) | Odd::Colors(_) | Odd::TileBands(..) => 323,
            Odd::Scaled(..) | Odd::TileScaling(..) => 333,
            Odd::TwoUnits(..) => 372,
        }
    }

    /// Whether it is about the reference system, so that another one settles it.
    pub(crate) fn is_of_crs(&self) -> bool {
        matches!(self.code(), 325 | 326 | 331)
    }

    /// Whether it is about the place or the unit, so that those of a virtual raster settle it.
    pub(super) fn is_of_place(&self) -> bool {
        self.is_of_crs() || matches!(self, Odd::NoPlace | Odd::Unit(_))
    }
}

impl Oddity {
    pub(super) fn new(name: impl Display, odd: Odd) -> Oddity {
        Oddity { name: name.to_string(), odd, n_more: 0 }
    }

    /// The file and what is odd, on one line.
    pub(crate) fn text(&self) -> String {
        format!("`{}` {}", self.name, self.odd)
    }
}

impl From<Oddity> for Warning {
    fn from(oddity: Oddity) -> Warning {
        let warning = Warning::new(oddity.odd.code(), oddity.text());
        match oddity.n_more {
            0 => warning,
            1 => warning.within("and likewise one more tile"),
            n => warning.within(format!("and likewise {n} more tiles")),
        }
    }
}

/// What is odd about many tiles, each kind once.
pub(super) fn each_once(all: impl Iterator<Item = Oddity>) -> Vec<Oddity> {
    let mut kinds: Vec<Oddity> = Vec::new();
    for oddity in all {
        match kinds.iter_mut().find(|first| first.odd.code() == oddity.odd.code()) {
            Some(first) => first.n_more += 1,
            None => kinds.push(oddity),
        }
    }
    kinds
}

/// Opens something, and warns of what is odd about it.
pub(super) fn warned<T>(warnings: &mut Vec<Warning>, open: impl FnOnce(&mut Vec<Oddity>) -> Result<T>) -> Result<T> {
    let mut odd = Vec::new();
    let opened = open(&mut odd);
    warnings.extend(odd.into_iter().map(Warning::from));
    opened
}
