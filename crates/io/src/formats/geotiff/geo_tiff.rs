//! A GeoTIFF whose header was read and checked: its picture, its mask, its place, and what its tags say of the heights.

use super::header::{Codec, Image};
use super::metadata::Metadata;
use super::placement::{Placement, meters_per_named_unit, read_placement};
use super::sidecar::Sidecar;
use super::tags::{Directory, TiffSource, tag};
use crate::crs::VerticalCrs;
use crate::error::{OddRaster, Oddity, Result, Warning};
use crate::formats::band::Band;
use crate::formats::oddity::warned;
use crate::formats::sample::Sample;
use crate::input::Input;
use crate::raster::GeoRef;

/// Most image directories to look through for a mask.
const MAX_DIRECTORIES: usize = 64;

/// A GeoTIFF file, its header read and checked.
#[derive(Debug, Clone)]
pub struct GeoTiff {
    pub(super) input: Input,
    /// Length of the file when its header was read \[bytes\].
    pub(super) len: u64,
    pub(super) image: Image,
    pub(super) mask: Option<Mask>,
    pub(super) placement: Placement,
    /// The nodata value of the tags, for bands of which the sidecar has none.
    nodata_of_all: Option<f64>,
    sidecar: Sidecar,
    pub(super) metadata: Metadata,
    /// The band that is read, counted from 0; `None` where nobody named one and the first is read.
    chosen: Option<usize>,
    /// Whether another band can be asked for.
    pub(super) can_choose: bool,
    /// The first three bands are red, green and blue.
    pub(super) is_picture: bool,
}

impl GeoTiff {
    /// Opens a file and reads its header, no cell.
    ///
    /// Cost: proportional to the number of strips or tiles.
    ///
    /// # Errors
    /// If the file cannot be opened, is no TIFF, is cut short, is encoded in a way that is not read, or lies on no
    /// north-up grid.
    pub fn open(input: impl Into<Input>, warnings: &mut Vec<Warning>) -> Result<GeoTiff> {
        warned(warnings, |odd| GeoTiff::open_told(&input.into(), None, odd))
    }

    /// `band` is the one to read, where one can be asked for.
    pub(in crate::formats) fn open_told(input: &Input, band: Option<&Band>, odd: &mut Vec<Oddity>) -> Result<GeoTiff> {
        let (mut source, first) = TiffSource::open(input)?;
        let directory = source.directory(first)?;
        let image = Image::parse(&mut source, &directory)?;
        let sidecar = Sidecar::of(input, odd);
        let shape = (image.n_rows, image.n_cols);
        let placement = read_placement((&mut source, &directory), &sidecar, shape, odd)?;
        let nodata_of_all = match directory.text(&mut source, tag::GDAL_NODATA)? {
            None => None,
            Some(text) => {
                let nodata = nodata_in(image.sample, &text);
                if nodata.is_none() {
                    odd.push(Oddity::new(input, OddRaster::Nodata(text)));
                }
                nodata
            }
        };
        let metadata = directory.text(&mut source, tag::GDAL_METADATA)?.unwrap_or_default();
        let mut metadata = Metadata::parse(&metadata);
        metadata.complete(&sidecar);
        let mask = match find_mask(&mut source, &directory, &image, first, odd) {
            Some(image) => Some(Mask { image, band: 0 }),
            None => alpha_band(&mut source, &directory, image.n_bands)?.map(|band| Mask { image: image.clone(), band }),
        };
        let is_picture = directory.integer(&mut source, tag::PHOTOMETRIC)? == Some(2) && image.n_bands >= 3;
        let mut tiff = GeoTiff {
            input: input.clone(),
            len: source.len(),
            image,
            mask,
            placement,
            nodata_of_all,
            sidecar,
            metadata,
            chosen: None,
            can_choose: band.is_some(),
            is_picture,
        };
        if let Some(band) = band.filter(|band| band.is_named()) {
            tiff.chosen = Some(band.index(input, &tiff.band_names())?);
        }
        tiff.tell_of_encoding(odd);
        Ok(tiff)
    }

    fn tell_of_encoding(&self, odd: &mut Vec<Oddity>) {
        let mut tell = |what| odd.push(Oddity::new(&self.input, what));
        if let Some(mask) = self.input.with_suffix(".msk") {
            tell(OddRaster::Mask(mask.to_string()));
        }
        if self.image.codec == Codec::Jpeg {
            tell(OddRaster::Jpeg);
        }
        let is_other = |a: f64, b: f64| (a - b).abs() > 1e-9;
        if let Some(text) = self.sidecar.nodata(self.band()).filter(|text| nodata_in(self.image.sample, text).is_none())
        {
            tell(OddRaster::Nodata(text.to_string()));
        }
        let of_band = self.metadata.unit(self.band()).and_then(meters_per_named_unit);
        match (of_band, self.placement.meters_per_height_unit) {
            (Some(band), Some(system)) if is_other(band, system) => tell(OddRaster::TwoUnits(band, system)),
            _ => {}
        }
        if let Some(unit) = self.meters_per_height_unit().filter(|unit| is_other(*unit, 1.0)) {
            tell(OddRaster::Unit(unit));
        }
    }

    /// Where the cells lie; rows run from north to south whatever the file does.
    pub fn georef(&self) -> &GeoRef {
        &self.placement.georef
    }

    /// Whether the rows of the file run from the south.
    pub(in crate::formats) fn is_south_up(&self) -> bool {
        self.placement.south_up
    }

    /// Whether the file stores no cell at all.
    pub(in crate::formats) fn is_empty(&self) -> bool {
        self.image.blocks.iter().all(|(_, len)| *len == 0)
    }

    /// Whether reading a part costs what the part costs.
    pub(in crate::formats) fn reads_parts(&self) -> bool {
        self.image.tiled || self.image.codec == Codec::None
    }

    /// Bytes that its largest strip or tile takes while it is unpacked; 0 where rows are read as they are.
    pub(in crate::formats) fn block_bytes(&self) -> u64 {
        let is_packed = self.image.codec != Codec::None;
        if is_packed { self.image.row_bytes().saturating_mul(self.image.block_rows as u64) } else { 0 }
    }

    /// Number of bands.
    pub fn n_bands(&self) -> usize {
        self.image.n_bands
    }

    /// What the bands are called, where the file says so.
    pub fn band_names(&self) -> Vec<Option<&str>> {
        (0..self.n_bands()).map(|band| self.metadata.name(band)).collect()
    }

    /// The band that is read, counted from 0.
    pub(in crate::formats) fn band(&self) -> usize {
        self.chosen.unwrap_or(0)
    }

    /// Whether nobody named the band that is read.
    pub(in crate::formats) fn is_first_by_default(&self) -> bool {
        self.chosen.is_none()
    }

    /// The declared nodata value of a band, as the samples can hold it.
    pub(in crate::formats) fn nodata_of(&self, band: usize) -> Option<f64> {
        let own = self.sidecar.nodata(band).and_then(|text| nodata_in(self.image.sample, text));
        own.or(self.nodata_of_all)
    }

    /// What this program wrote into the file about its origin, as one JSON text; `None` in files of others.
    pub fn provenance(&self) -> Option<&str> {
        self.metadata.provenance.as_deref()
    }

    /// Meters per unit of height, where the file says so; [`GeoTiff::read`] converts nothing.
    pub fn meters_per_height_unit(&self) -> Option<f64> {
        let of_band = self.metadata.unit(self.band()).and_then(meters_per_named_unit);
        of_band.or(self.placement.meters_per_height_unit)
    }

    /// What heights are above, where the file names it.
    pub fn vertical(&self) -> Option<&VerticalCrs> {
        self.placement.vertical.as_ref()
    }

    /// How the file is encoded, in a few words: `float32, deflate, tiles 256x256, nodata -9999`.
    pub fn description(&self) -> String {
        let image = &self.image;
        let mut text = format!("{}, {}", image.sample.name(), image.codec.name());
        text += &match image.tiled {
            true => format!(", tiles {}x{}", image.block_cols, image.block_rows),
            false => format!(", strips of {} rows", image.block_rows),
        };
        if image.n_bands > 1 {
            text += &format!(", {} bands", image.n_bands);
        }
        if let Some(nodata) = self.nodata() {
            text += &format!(", nodata {}", Number(nodata));
        }
        if self.mask.is_some() {
            text += ", mask";
        }
        text
    }
}

/// Which cells hold something: those that are not 0 in a band of an image.
#[derive(Debug, Clone)]
pub(super) struct Mask {
    pub(super) image: Image,
    pub(super) band: usize,
}

/// The band that says how opaque each cell is, after the first, which holds the heights.
fn alpha_band(source: &mut TiffSource, directory: &Directory, n_bands: usize) -> Result<Option<usize>> {
    const ALPHA: [u64; 2] = [1, 2];
    let extra = directory.integers(source, tag::EXTRA_SAMPLES)?.unwrap_or_default();
    let first = n_bands - extra.len();
    Ok(extra.iter().position(|kind| ALPHA.contains(kind)).map(|k| first + k).filter(|band| *band > 0))
}

/// The mask of the first image among the later directories; what is wrong with these is no reason to refuse the first.
fn find_mask(
    source: &mut TiffSource,
    first: &Directory,
    image: &Image,
    first_at: u64,
    odd: &mut Vec<Oddity>,
) -> Option<Image> {
    const REDUCED: u64 = 1;
    const MASK: u64 = 4;
    let mut warn = |source: &TiffSource, text: &str| {
        odd.push(Oddity::new(source.input(), OddRaster::LaterImage(text.to_string())))
    };
    let mut seen = vec![first_at];
    let mut next = first.next;
    while next != 0 && seen.len() < MAX_DIRECTORIES {
        if seen.contains(&next) {
            warn(source, "the list of images has a loop");
            return None;
        }
        seen.push(next);
        let directory = match source.directory(next) {
            Ok(directory) => directory,
            Err(error) => {
                warn(source, &error.to_string());
                return None;
            }
        };
        let kind = directory.integer(source, tag::NEW_SUBFILE_TYPE).ok().flatten().unwrap_or(0);
        if kind & MASK != 0 && kind & REDUCED == 0 {
            match Image::parse_mask(source, &directory) {
                Ok(mask) if (mask.n_rows, mask.n_cols) == (image.n_rows, image.n_cols) => return Some(mask),
                Ok(_) => warn(source, "a mask of another size"),
                Err(error) => warn(source, &error.to_string()),
            }
        }
        next = directory.next;
    }
    None
}

/// The nodata value as the samples of the file can hold it; `None` if the text is no number.
///
/// The text is rounded as the samples were, so that `-3.4028234663852886e+38` equals the lowest 32-bit float.
pub(super) fn nodata_in(sample: Sample, text: &str) -> Option<f64> {
    let value: f64 = text.trim().parse().ok()?;
    #[expect(clippy::cast_possible_truncation, reason = "rounding to the type of the samples is the purpose")]
    let rounded = f64::from(value as f32);
    Some(if sample == Sample::F32 { rounded } else { value })
}

/// A number as short as it can be told from its neighbors, with an exponent where that is shorter.
struct Number(f64);

impl std::fmt::Display for Number {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if self.0 != 0.0 && (self.0.abs() >= 1e9 || self.0.abs() < 1e-4) {
            write!(f, "{:e}", self.0)
        } else {
            write!(f, "{}", self.0)
        }
    }
}
