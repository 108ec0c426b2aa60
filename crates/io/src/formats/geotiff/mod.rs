//! GeoTIFF: heights in strips or tiles, with the place and the coordinate reference system in tags.
//!
//! What is read: TIFF and BigTIFF in both byte orders; strips and tiles, bands interleaved or apart; integers of 8 to 64
//! bits and floats of 16 to 64 bits; no compression, LZW, deflate, PackBits, Zstandard, LERC (plain, with deflate or
//! Zstandard) and single-band JPEG; predictors 2 and 3; the first image of a file with overviews; GDAL's nodata value,
//! scale and offset, internal masks, bands of opacity (0 is nothing) and missing (sparse) blocks. `MinIsWhite` changes no
//! height. What is not: other compressions and depths, LERC in big-endian files, color JPEG, ground control points and rotation, which are refused
//! by name; a `.msk` file beside the raster, which is reported; a `.aux.xml` file, which is not looked at.
//!
//! The first image directory is parsed ([`tags`]) and checked against the length of the file ([`header`]) before a decoder
//! sees a byte, since a header may promise what no file can hold.
//!
//! Codes of errors: E301 cannot be opened or read; E302 not a TIFF, or a header that makes no sense; E303 cut short, or
//! a header that points beyond the file, or a block that does not decode; E304 an encoding that is not read; E305 no
//! height at all; E306 rotated; E307 no regular grid; E501 more cells than fit in memory. Of warnings: W320 NaN or
//! infinite cells, W321 missing blocks, W322 unreadable nodata value, W323 several bands, W324 a mask that is not used,
//! W325 no CRS, W326 a CRS that is not known, W327 no place, W328 heights that look like nodata, W329 a later image
//! that cannot be read, W330 rows turned over, W331 web Mercator, W332 heights not in meters, W333 scaled heights, W334
//! lossy compression.

mod class_pyramid;
mod geo_tags;
mod header;
mod heights;
mod lerc;
mod overview;
mod placement;
mod plain;
mod read;
mod stored;
mod tags;
mod write;

pub use class_pyramid::{ClassImage, ClassPyramid};
pub use geo_tags::pam_sidecar;
pub use geo_tags::xml_text;
pub use plain::ClassStrips;
pub use write::{Bands, ClassColor, GeoTiffImage, TiffLayout, encode_geotiff, write_geotiff};

use std::path::{Path, PathBuf};

use header::{Codec, Image};
pub(super) use placement::meters_per_named_unit;
use placement::{Placement, read_placement};
use tags::{Directory, TiffSource, tag};

use super::file::{check_cells, reserve_cells};
use super::sample::Sample;
use super::voids::Voids;
use crate::crs::VerticalCrs;
use crate::error::{Result, Warning};
use crate::raster::{CellWindow, GeoRef, Raster};

/// Most image directories to look through for a mask.
const MAX_DIRECTORIES: usize = 64;

/// A GeoTIFF file, its header read and checked.
#[derive(Debug, Clone)]
pub struct GeoTiff {
    path: PathBuf,
    /// Length of the file when its header was read \[bytes\].
    len: u64,
    image: Image,
    mask: Option<Mask>,
    placement: Placement,
    nodata: Option<f64>,
    metadata: Metadata,
    /// The first three bands are red, green and blue.
    is_picture: bool,
}

impl GeoTiff {
    /// Opens a file and reads its header, no cell.
    ///
    /// Cost: proportional to the number of strips or tiles.
    ///
    /// # Errors
    /// If the file cannot be opened, is no TIFF, is cut short, is encoded in a way that is not read, or lies on no
    /// north-up grid.
    pub fn open(path: &Path, warnings: &mut Vec<Warning>) -> Result<GeoTiff> {
        let (mut source, first) = TiffSource::open(path)?;
        let directory = source.directory(first)?;
        let image = Image::parse(&mut source, &directory)?;
        let placement = read_placement(&mut source, &directory, (image.n_rows, image.n_cols), warnings)?;
        let nodata = match directory.text(&mut source, tag::GDAL_NODATA)? {
            None => None,
            Some(text) => {
                let nodata = nodata_in(image.sample, &text);
                if nodata.is_none() {
                    let text = format!("`{}` declares nodata as `{text}`, which is no number: ignored", path.display());
                    warnings.push(Warning::new(322, text));
                }
                nodata
            }
        };
        let metadata = directory.text(&mut source, tag::GDAL_METADATA)?.unwrap_or_default();
        let metadata = Metadata::parse(&metadata);
        let mask = match find_mask(&mut source, &directory, &image, first, warnings) {
            Some(image) => Some(Mask { image, band: 0 }),
            None => alpha_band(&mut source, &directory, image.n_bands)?.map(|band| Mask { image: image.clone(), band }),
        };
        let is_picture = directory.integer(&mut source, tag::PHOTOMETRIC)? == Some(2) && image.n_bands >= 3;
        let tiff =
            GeoTiff { path: path.to_owned(), len: source.len(), image, mask, placement, nodata, metadata, is_picture };
        tiff.warn_of_encoding(warnings);
        Ok(tiff)
    }

    fn warn_of_encoding(&self, warnings: &mut Vec<Warning>) {
        let path = self.path.display();
        let mut sidecar = self.path.clone().into_os_string();
        sidecar.push(".msk");
        if Path::new(&sidecar).exists() {
            let text = format!("the mask `{}` beside `{path}` is not read: declare nodata instead", sidecar.display());
            warnings.push(Warning::new(324, text));
        }
        if self.image.codec == Codec::Jpeg {
            let text = format!(
                "`{path}` is JPEG-compressed: its heights are off by up to several units, and are used as they are"
            );
            warnings.push(Warning::new(334, text));
        }
        let of_band = self.metadata.unit.as_deref().and_then(meters_per_named_unit);
        if let (Some(band), Some(system)) = (of_band, self.placement.meters_per_height_unit)
            && (band - system).abs() > 1e-9
        {
            let text = format!(
                "`{path}` gives its heights in units of {band} m by its band, of {system} m by its vertical system: the \
                 band is believed"
            );
            warnings.push(Warning::new(372, text));
        }
        if let Some(size) = self.meters_per_height_unit().filter(|size| (size - 1.0).abs() > 1e-9) {
            let text = format!("`{path}` gives its heights in units of {size} m; scenes convert them");
            warnings.push(Warning::new(332, text));
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
        let name = |band: usize| self.metadata.names.iter().find(|(b, _)| *b == band).map(|(_, name)| name.as_str());
        (0..self.n_bands()).map(name).collect()
    }

    /// What this program wrote into the file about its origin, as one JSON text; `None` in files of others.
    pub fn provenance(&self) -> Option<&str> {
        self.metadata.provenance.as_deref()
    }

    /// Meters per unit of height, where the file says so; [`GeoTiff::read`] converts nothing.
    pub fn meters_per_height_unit(&self) -> Option<f64> {
        self.metadata.unit.as_deref().and_then(meters_per_named_unit).or(self.placement.meters_per_height_unit)
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
        if let Some(nodata) = self.nodata {
            text += &format!(", nodata {}", Number(nodata));
        }
        if self.mask.is_some() {
            text += ", mask";
        }
        text
    }

    /// Reads a part of the first band; `convert` turns a stored height into what the raster holds.
    ///
    /// Cells that hold no height (nodata, NaN, infinite, hidden by a mask, missing in a sparse file) arrive in `convert`
    /// as NaN. Heights are in the unit of the file, scaled where the file says so. `convert` is called once per cell,
    /// row by row in the order of the file. Memory is that of the result and of one band of rows.
    ///
    /// # Errors
    /// If the part does not fit in memory, the file cannot be read or decoded, or no cell of the part holds a height.
    ///
    /// # Panics
    /// If `window` is empty or reaches beyond the grid.
    pub fn read<T: bytemuck::Pod>(
        &self,
        window: CellWindow,
        warnings: &mut Vec<Warning>,
        convert: impl FnMut(f64) -> T,
    ) -> Result<Raster<T>> {
        let is_alpha = |band: usize| self.mask.as_ref().is_some_and(|mask| mask.band == band && band > 0);
        if (1..self.n_bands()).any(|band| !is_alpha(band)) {
            let path = self.path.display();
            let kind = if self.is_picture { "is a color picture of" } else { "has" };
            let text = format!("`{path}` {kind} {} bands: the first is read as heights", self.n_bands());
            warnings.push(Warning::new(323, text));
        }
        self.read_band(0, window, warnings, convert)
    }

    /// Reads a part of one band, counted from 0, as [`GeoTiff::read`] does for the first.
    ///
    /// # Errors
    /// As [`GeoTiff::read`], and if there is no such band.
    ///
    /// # Panics
    /// If `window` is empty or reaches beyond the grid.
    pub fn read_band<T: bytemuck::Pod>(
        &self,
        band: usize,
        window: CellWindow,
        warnings: &mut Vec<Warning>,
        mut convert: impl FnMut(f64) -> T,
    ) -> Result<Raster<T>> {
        let georef = self.georef().part(window);
        check_cells::<T>(&self.path, &georef)?;
        if self.is_empty() {
            // A sparse file without any block can be tiny and promise anything: no memory is taken for it.
            let mut voids = Voids::new(self.nodata);
            voids.n_missing = georef.n_cells() as u64;
            voids.report(&self.path, warnings)?;
        }
        let mut cells: Vec<T> = reserve_cells(&self.path, &georef)?;
        let (scale, offset) = self.metadata.scaling(band);
        let mut voids = Voids::new(self.nodata);
        self.for_each_stored(band, window, |row, col, stored| {
            cells.push(convert(voids.height_of(row, col, stored) * scale + offset));
        })?;
        if (scale, offset) != (1.0, 0.0) {
            let path = self.path.display();
            let text = format!("`{path}` stores its heights scaled: multiplied by {scale}, then {offset} added");
            warnings.push(Warning::new(333, text));
        }
        if self.placement.south_up {
            turn_over(&mut cells, window.n_cols);
        }
        voids.report(&self.path, warnings)?;
        Ok(Raster::new(georef, cells))
    }
}

/// Which cells hold something: those that are not 0 in a band of an image.
#[derive(Debug, Clone)]
struct Mask {
    image: Image,
    band: usize,
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
    warnings: &mut Vec<Warning>,
) -> Option<Image> {
    const REDUCED: u64 = 1;
    const MASK: u64 = 4;
    let mut warn = |source: &TiffSource, text: &str| {
        let text = format!("a later image in `{}` cannot be read and is ignored: {text}", source.path().display());
        warnings.push(Warning::new(329, text));
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
fn nodata_in(sample: Sample, text: &str) -> Option<f64> {
    let value: f64 = text.trim().parse().ok()?;
    #[expect(clippy::cast_possible_truncation, reason = "rounding to the type of the samples is the purpose")]
    let rounded = f64::from(value as f32);
    Some(if sample == Sample::F32 { rounded } else { value })
}

/// Turns the order of rows over.
fn turn_over<T>(cells: &mut [T], n_cols: usize) {
    let n_rows = cells.len() / n_cols;
    for row in 0..n_rows / 2 {
        let (north, south) = cells.split_at_mut((n_rows - 1 - row) * n_cols);
        north[row * n_cols..(row + 1) * n_cols].swap_with_slice(&mut south[..n_cols]);
    }
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

/// What GDAL's metadata tag says of the bands: a list of `<Item name=… sample=… role=…>value</Item>`.
#[derive(Debug, Clone, Default)]
struct Metadata {
    scales: Vec<(usize, f64)>,
    offsets: Vec<(usize, f64)>,
    /// Unit of the first band.
    unit: Option<String>,
    /// Names of bands.
    names: Vec<(usize, String)>,
    /// The item of this program.
    provenance: Option<String>,
}

impl Metadata {
    fn parse(xml: &str) -> Metadata {
        let mut metadata = Metadata::default();
        for item in xml.split("<Item ").skip(1) {
            let Some((attributes, rest)) = item.split_once('>') else { continue };
            let value = rest.split('<').next().unwrap_or_default();
            let attribute = |name: &str| {
                let (_, rest) = attributes.split_once(&format!("{name}=\""))?;
                rest.split('"').next()
            };
            let band: usize = attribute("sample").and_then(|band| band.parse().ok()).unwrap_or(0);
            let number = value.trim().parse().ok().filter(|number: &f64| number.is_finite());
            match (attribute("role"), number) {
                (Some("scale"), Some(number)) if number != 0.0 => metadata.scales.push((band, number)),
                (Some("offset"), Some(number)) => metadata.offsets.push((band, number)),
                (Some("unittype"), _) if band == 0 => metadata.unit = Some(value.to_owned()),
                // Values are escaped twice, as GDAL does.
                (None, _) if attribute("name") == Some("SKYSHED") => {
                    metadata.provenance = Some(unescaped(&unescaped(value)));
                }
                (Some("description"), _) => metadata.names.push((band, unescaped(&unescaped(value)))),
                _ => {}
            }
        }
        metadata
    }

    /// Factor and summand that turn the stored numbers of a band into heights.
    fn scaling(&self, band: usize) -> (f64, f64) {
        let of = |list: &[(usize, f64)]| list.iter().find(|(b, _)| *b == band).map(|(_, value)| *value);
        (of(&self.scales).unwrap_or(1.0), of(&self.offsets).unwrap_or(0.0))
    }
}

/// XML text as it was before its escaping.
fn unescaped(text: &str) -> String {
    let entities = [("&lt;", "<"), ("&gt;", ">"), ("&quot;", "\""), ("&apos;", "'"), ("&amp;", "&")];
    entities.iter().fold(text.to_owned(), |text, (entity, letter)| text.replace(entity, letter))
}

#[cfg(test)]
mod tests;
