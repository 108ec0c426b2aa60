//! A GeoTIFF whose header was read and checked: its picture, its mask, its place, and the tags
//! about its heights.

use super::header::{Codec, Image};
use super::metadata::Metadata;
use super::placement::{Placement, meters_per_named_unit, read_placement};
use super::sidecar::Sidecar;
use super::tags::{Directory, TiffSource, tag};
use skyshed_request::Band;

use crate::crs::VerticalCrs;
use crate::error::{OddRaster, Oddity, Result, Warning};
use crate::formats::band::index_of_band;
use crate::formats::oddity::warned;
use crate::formats::sample::Sample;
use crate::input::Input;
use crate::raster::GeoRef;

/// Largest number of image directories that are searched for a mask.
const MAX_DIRECTORIES: usize = 64;

/// GeoTIFF file whose header is read and checked.
#[derive(Debug, Clone)]
pub struct GeoTiff {
    pub(super) input: Input,
    /// Length of the file when its header was read \[bytes\].
    pub(super) len: u64,
    pub(super) image: Image,
    pub(super) mask: Option<Mask>,
    pub(super) placement: Placement,
    /// Nodata value of the tags, for bands without one in the sidecar.
    nodata_of_all: Option<f64>,
    sidecar: Sidecar,
    pub(super) metadata: Metadata,
    /// Band that is read, counted from 0; `None` where none was named and the first is read.
    chosen: Option<usize>,
    /// `true` if the caller can choose another band.
    pub(super) can_choose: bool,
    /// `true` if the first three bands are red, green and blue.
    pub(super) is_picture: bool,
}

impl GeoTiff {
    /// Opens a file and reads its header, no cell.
    ///
    /// Cost: proportional to the number of strips or tiles.
    ///
    /// # Errors
    /// If the file cannot be opened, is no TIFF, is cut short, has an unsupported encoding, or lies
    /// on no north-up grid.
    pub fn open(input: impl Into<Input>, warnings: &mut Vec<Warning>) -> Result<GeoTiff> {
        warned(warnings, |odd| GeoTiff::open_told(&input.into(), None, odd))
    }

    /// Opens as [`GeoTiff::open`], with oddities as values. `band` is the band to read, where the
    /// caller can choose one.
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
            tiff.chosen = Some(index_of_band(band, input, &tiff.band_names())?);
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

    /// Returns the grid of the cells; its rows run from north to south in any file.
    pub fn georef(&self) -> &GeoRef {
        &self.placement.georef
    }

    /// Returns `true` when the rows of the file run from the south.
    pub(in crate::formats) fn is_south_up(&self) -> bool {
        self.placement.south_up
    }

    /// Returns `true` when the file stores no cell at all.
    pub(in crate::formats) fn is_empty(&self) -> bool {
        self.image.blocks.iter().all(|(_, len)| *len == 0)
    }

    /// Returns `true` when the cost of reading a part is that of the part.
    pub(in crate::formats) fn reads_parts(&self) -> bool {
        self.image.tiled || self.image.codec == Codec::None
    }

    /// Returns the size of the largest strip or tile while it is unpacked \[bytes\]; 0 where rows
    /// are read as they are.
    pub(in crate::formats) fn block_bytes(&self) -> u64 {
        let is_packed = self.image.codec != Codec::None;
        if is_packed { self.image.row_bytes().saturating_mul(self.image.block_rows as u64) } else { 0 }
    }

    /// Returns the number of bands.
    pub fn n_bands(&self) -> usize {
        self.image.n_bands
    }

    /// Returns the names of the bands, where the file has them.
    pub fn band_names(&self) -> Vec<Option<&str>> {
        (0..self.n_bands()).map(|band| self.metadata.name(band)).collect()
    }

    /// Returns the band that is read, counted from 0.
    pub(in crate::formats) fn band(&self) -> usize {
        self.chosen.unwrap_or(0)
    }

    /// Returns `true` when no band was named.
    pub(in crate::formats) fn is_first_by_default(&self) -> bool {
        self.chosen.is_none()
    }

    /// Returns the declared nodata value of a band, as the samples can hold it.
    pub(in crate::formats) fn nodata_of(&self, band: usize) -> Option<f64> {
        let own = self.sidecar.nodata(band).and_then(|text| nodata_in(self.image.sample, text));
        own.or(self.nodata_of_all)
    }

    /// Returns the provenance that this program wrote into the file, as one JSON text; `None` in
    /// files of other programs.
    pub fn provenance(&self) -> Option<&str> {
        self.metadata.provenance.as_deref()
    }

    /// Returns the meters per unit of height, where the file names the unit; [`GeoTiff::read`]
    /// converts nothing.
    pub fn meters_per_height_unit(&self) -> Option<f64> {
        let of_band = self.metadata.unit(self.band()).and_then(meters_per_named_unit);
        of_band.or(self.placement.meters_per_height_unit)
    }

    /// Returns the vertical system, where the file names it.
    pub fn vertical(&self) -> Option<&VerticalCrs> {
        self.placement.vertical.as_ref()
    }

    /// Returns the encoding in a few words: `float32, deflate, tiles 256x256, nodata -9999`.
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

/// Mask of a raster: cells that are not 0 in a band of an image hold a value.
#[derive(Debug, Clone)]
pub(super) struct Mask {
    pub(super) image: Image,
    pub(super) band: usize,
}

/// Returns the band with the opacity of each cell. It follows the first band, which holds the
/// heights.
fn alpha_band(source: &mut TiffSource, directory: &Directory, n_bands: usize) -> Result<Option<usize>> {
    const ALPHA: [u64; 2] = [1, 2];
    let extra = directory.integers(source, tag::EXTRA_SAMPLES)?.unwrap_or_default();
    let first = n_bands - extra.len();
    Ok(extra.iter().position(|kind| ALPHA.contains(kind)).map(|k| first + k).filter(|band| *band > 0))
}

/// Finds the mask of the first image among the later directories. Faults of these are no reason to
/// refuse the first image.
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

/// Returns the nodata value as the samples of the file can hold it; `None` if the text is no
/// number.
pub(super) fn nodata_in(sample: Sample, text: &str) -> Option<f64> {
    let value: f64 = text.trim().parse().ok()?;
    #[expect(clippy::cast_possible_truncation, reason = "rounding to the type of the samples is the purpose")]
    let rounded = f64::from(value as f32);
    Some(if sample == Sample::F32 { rounded } else { value })
}

/// Number whose text is as short as it can be read back, with an exponent below 1e-4 and from 1e9
/// on.
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
