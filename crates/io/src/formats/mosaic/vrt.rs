//! GDAL's virtual rasters: their XML, and the supported part of it.
//!
//! Supported are sources that are placed without resampling: `SimpleSource`, and `ComplexSource`
//! with a nodata value, a factor and a summand. Rasters that compute new numbers are refused by
//! name, with the command that lets GDAL do it. These are warped, derived and pansharpened rasters,
//! look-up tables, averages, kernels and sources of another cell size.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;

use roxmltree::{Document, Node, ParsingOptions};
use skyshed_request::Band;

use super::covered::n_covered_cells;
use super::tiles::{Header, Kind, MAX_SIDE, Mosaic, Nesting, Piece, read_headers};
use super::vrt_source::Source;
use super::vrt_xml::{Vrt, read_xml};
use crate::crs;
use crate::crs::contradicts;
use crate::error::{Cause, Error, OddRaster, Oddity, Pair, ReadFault, Result, two_crs};
use crate::formats::band::{bands_in_words, index_of_band};
use crate::formats::geotiff::meters_per_named_unit;
use crate::formats::oddity::{each_once, with_true_lengths};
use crate::formats::sample::Sample;
use crate::formats::xml::{attribute, child, refuse_crowds, text_of};
use crate::input::{Input, cannot_read};
use crate::raster::GeoRef;

/// Deepest nesting of virtual rasters.
const MAX_DEPTH: usize = 4;
/// Largest number of sources of nested virtual rasters.
const MOST_NESTED_FILES: usize = 10_000;
/// Largest shift across the whole raster that still counts as north-up \[cells\].
const MAX_SHEAR_CELLS: f64 = 1e-3;

/// Raster as an XML describes it.
struct Described {
    georef: GeoRef,
    of_bands: Option<OddRaster>,
    numbers: Sample,
    /// Value of cells in no source, and of cells without a height.
    empty: f64,
    nodata: Option<f64>,
    scaling: (f64, f64),
    meters_per_height_unit: Option<f64>,
    sources: Vec<Source>,
}

impl Mosaic {
    /// Opens a virtual raster and reads the headers of its tiles, no cell.
    ///
    /// `nesting` is that of the file.
    pub(in crate::formats) fn open_vrt(path: &Path, nesting: Nesting<'_>, odd: &mut Vec<Oddity>) -> Result<Mosaic> {
        let this = std::fs::canonicalize(path).map_err(|e| cannot_read(&path.into(), &e))?;
        let Nesting { band, ancestors, n_opened, .. } = nesting;
        if ancestors.contains(&this) {
            return Err(Error::malformed(path.display(), "it is a source of itself, wanted rasters"));
        }
        if ancestors.len() >= MAX_DEPTH {
            let what = format!("virtual rasters in each other more than {MAX_DEPTH} deep");
            return Err(Error::unsupported(path.display(), what).because(Cause::ForGdal));
        }
        let ancestors: Vec<PathBuf> = ancestors.iter().cloned().chain([this]).collect();
        let xml = read_xml(path)?;
        let described = describe(path, &xml, band, odd)?;
        let (files, tile_of) = distinct(&described.sources);
        // A file named by many virtual rasters, which many others name, is opened for each.
        let is_nested = ancestors.len() > 1;
        if is_nested && n_opened.fetch_add(files.len(), Ordering::Relaxed) + files.len() > MOST_NESTED_FILES {
            let what = format!("virtual rasters in each other with more than {MOST_NESTED_FILES} sources");
            return Err(Error::read(path.display(), ReadFault::TooMany(what)).because(Cause::ForGdal));
        }
        let mut headers = read_headers(&files, Nesting { band: None, ancestors: &ancestors, ..nesting })
            .map_err(|error| error.within(format!("a source of `{}`", path.display())))?;
        // Place and reference system are those of the virtual raster.
        let of_tiles = headers.iter_mut().flat_map(|header| header.odd.drain(..));
        odd.extend(each_once(of_tiles.filter(|oddity| !oddity.odd.is_of_place())));
        for header in &headers {
            refuse_other_crs(path, &described.georef, header)?;
        }
        let shape = (described.georef.n_rows(), described.georef.n_cols());
        let mut pieces = Vec::with_capacity(described.sources.len());
        for (source, tile) in described.sources.iter().zip(tile_of) {
            source.check(path, &headers[tile])?;
            let Some(place) = source.place(path, &headers[tile].tile, shape)? else { continue };
            pieces.push(Piece {
                tile,
                band: source.band,
                row: place.origin.0,
                col: place.origin.1,
                area: place.area,
                rule: source.rule,
            });
        }
        let areas: Vec<_> = pieces.iter().map(|piece| piece.area).collect();
        let n_gaps = described.georef.n_cells() as u64 - n_covered_cells(&areas);
        let of_tiles = || headers.iter().find_map(|header| header.meters_per_height_unit);
        let unit = described.meters_per_height_unit.or_else(of_tiles);
        if let Some(unit) = unit.filter(|unit| (unit - 1.0).abs() > 1e-9) {
            odd.push(Oddity::new(path.display(), OddRaster::Unit(unit)));
        }
        let vertical = headers.iter().find_map(|header| header.vertical.clone());
        Ok(Mosaic {
            path: path.to_owned(),
            kind: Kind::VirtualRaster { numbers: described.numbers },
            of_bands: described.of_bands,
            georef: described.georef,
            tiles: headers.into_iter().map(|header| header.tile).collect(),
            pieces,
            empty: described.empty,
            nodata: described.nodata,
            scaling: described.scaling,
            meters_per_height_unit: unit,
            vertical,
            n_gaps,
        })
    }
}

/// Returns the files of the sources, each once, and for each source the index of its file.
fn distinct(sources: &[Source]) -> (Vec<Input>, Vec<usize>) {
    let mut files: Vec<Input> = Vec::new();
    let mut known: HashMap<&Path, usize> = HashMap::new();
    let tile_of = sources.iter().map(|source| {
        *known.entry(&source.path).or_insert_with(|| {
            files.push(Input::path(&source.path));
            files.len() - 1
        })
    });
    let tile_of = tile_of.collect();
    (files, tile_of)
}

fn refuse_other_crs(path: &Path, georef: &GeoRef, header: &Header) -> Result<()> {
    let (Some(wanted), Some(found)) = (georef.crs(), header.georef.crs()) else { return Ok(()) };
    if !contradicts(wanted, found) {
        return Ok(());
    }
    Err(two_crs((path.display(), wanted), (&header.tile.input, found), Pair::Tiles))
}

/// Returns the name of a band.
fn name_of<'a>(band: Node<'a, '_>) -> Option<&'a str> {
    child(band, "Description").map(text_of).filter(|name| !name.is_empty())
}

fn describe(path: &Path, xml: &str, wanted: Option<&Band>, odd: &mut Vec<Oddity>) -> Result<Described> {
    refuse_crowds(path.display(), xml)?;
    // Without document types there are no entities to expand.
    let options = ParsingOptions { allow_dtd: false, ..ParsingOptions::default() };
    let document = Document::parse_with_options(xml, options)
        .map_err(|e| Error::malformed(path.display(), format!("{e}, wanted the XML of a virtual raster")))?;
    let vrt = Vrt { path, document: &document };
    let root = document.root_element();
    if !root.tag_name().name().eq_ignore_ascii_case("VRTDataset") {
        let text = format!("`{}` at the root, wanted `VRTDataset`", root.tag_name().name());
        return Err(vrt.malformed(root, text));
    }
    if let Some(kind) = attribute(root, "subClass") {
        return Err(vrt.unsupported(root, format!("it is a `{kind}`")));
    }
    if let Some(mask) = child(root, "MaskBand") {
        return Err(vrt.unsupported(mask, "it has a mask"));
    }
    let is_band =
        |node: &Node<'_, '_>| node.is_element() && node.tag_name().name().eq_ignore_ascii_case("VRTRasterBand");
    let bands: Vec<Node<'_, '_>> = root.children().filter(is_band).collect();
    if bands.is_empty() {
        return Err(vrt.malformed(root, "it has no `VRTRasterBand`, wanted one"));
    }
    let names: Vec<Option<&str>> = bands.iter().map(|band| name_of(*band)).collect();
    let is_named = wanted.is_some_and(Band::is_named);
    let of_bands = (bands.len() > 1 && !is_named).then(|| OddRaster::Bands {
        n: bands.len(),
        names: bands_in_words(&names),
        can_choose: wanted.is_some(),
    });
    let band = bands[index_of_band(wanted.unwrap_or(&Band::First), &path.into(), &names)?];
    if let Some(kind) = attribute(band, "subClass").filter(|kind| !kind.eq_ignore_ascii_case("VRTSourcedRasterBand")) {
        return Err(vrt.unsupported(band, format!("its band is a `{kind}`")));
    }
    if let Some(mask) = child(band, "MaskBand") {
        return Err(vrt.unsupported(mask, "its band has a mask"));
    }
    let georef = placement(vrt, root, odd)?;
    let type_name = attribute(band, "dataType").unwrap_or("Byte");
    let numbers = Sample::of_gdal(type_name).ok_or_else(|| {
        vrt.error(band, ReadFault::Unsupported(format!("numbers of type `{type_name}`, wanted integers or floats")))
    })?;
    let declared = match child(band, "NoDataValue") {
        None => None,
        Some(node) if text_of(node).eq_ignore_ascii_case("nan") => Some(f64::NAN),
        Some(node) => Some(vrt.number(node, "NoDataValue", text_of(node))?),
    };
    // Rounded as the numbers are, if they are floats; an integer band never holds a fraction.
    let declared = declared.map(|nodata| if numbers.is_float() { numbers.rounded(nodata) } else { nodata });
    let is_hidden = child(band, "HideNoDataValue")
        .is_some_and(|node| ["1", "yes", "true", "on"].contains(&text_of(node).to_ascii_lowercase().as_str()));
    let scale = vrt.child_number(band, "Scale")?.filter(|scale| *scale != 0.0).unwrap_or(1.0);
    let offset = vrt.child_number(band, "Offset")?.unwrap_or(0.0);
    Ok(Described {
        georef,
        of_bands,
        numbers,
        empty: declared.map_or(0.0, |nodata| numbers.rounded(nodata)),
        nodata: declared.filter(|_| !is_hidden),
        scaling: (scale, offset),
        meters_per_height_unit: child(band, "UnitType").and_then(|node| meters_per_named_unit(text_of(node))),
        sources: Source::all_of(vrt, band, numbers)?,
    })
}

/// Reads the grid of the cells.
fn placement(vrt: Vrt<'_>, root: Node<'_, '_>, odd: &mut Vec<Oddity>) -> Result<GeoRef> {
    let side = |name: &str| {
        let text = attribute(root, name).unwrap_or_default();
        let side = text.trim().parse::<u32>().ok().filter(|side| *side > 0 && f64::from(*side) <= MAX_SIDE);
        side.map(|side| side as usize)
            .ok_or_else(|| vrt.malformed(root, format!("`{name}` is `{text}`, wanted a whole number above 0")))
    };
    let (n_rows, n_cols) = (side("rasterYSize")?, side("rasterXSize")?);
    let mut tell = |what| odd.push(Oddity::new(vrt.path.display(), what));
    let crs = child(root, "SRS").map(|node| crs::parse(text_of(node))).transpose();
    let crs = crs.unwrap_or_else(|error| {
        tell(OddRaster::CrsIgnored(error.to_string()));
        None
    });
    if child(root, "SRS").is_none() {
        tell(OddRaster::NoCrs);
    }
    let Some(node) = child(root, "GeoTransform") else {
        if let Some(list) = child(root, "GCPList") {
            let what = "it is placed by ground control points, wanted a regular grid";
            return Err(vrt.error(list, ReadFault::Irregular(what.into())).because(Cause::ControlPoints));
        }
        tell(OddRaster::NoPlace);
        return GeoRef::new((0.0, n_rows as f64), (1.0, 1.0), (n_rows, n_cols), crs)
            .ok_or_else(|| vrt.error(root, ReadFault::Irregular("its cells are no grid".into())));
    };
    let numbers: Vec<f64> =
        text_of(node).split(',').map(|text| vrt.number(node, "GeoTransform", text)).collect::<Result<_>>()?;
    let [x_min, width, shear_x, y_max, shear_y, height] = *numbers.as_slice() else {
        return Err(vrt.malformed(node, format!("`GeoTransform` has {} numbers, wanted 6", numbers.len())));
    };
    let (off_x, off_y) = ((shear_x * n_rows as f64).abs(), (shear_y * n_cols as f64).abs());
    let is_north_up = width > 0.0 && height < 0.0;
    if !is_north_up || off_x > MAX_SHEAR_CELLS * width || off_y > MAX_SHEAR_CELLS * -height {
        return Err(vrt.error(
            node,
            ReadFault::Rotated(format!("`GeoTransform` is `{}`, wanted a north-up raster", text_of(node))),
        ));
    }
    let georef = GeoRef::new((x_min, y_max), (width, -height), (n_rows, n_cols), crs)
        .ok_or_else(|| vrt.error(node, ReadFault::Irregular("`GeoTransform` gives no regular grid".into())))?;
    Ok(with_true_lengths(georef, &mut tell))
}
