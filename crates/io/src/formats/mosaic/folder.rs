//! A folder of tiles on one grid.

use std::path::Path;
use std::sync::atomic::AtomicUsize;

use super::covered::{covered_area, n_covered_cells};
use super::numbers::Rule;
use super::tiles::{Header, Kind, MAX_SIDE, Mosaic, Nesting, Piece, read_headers};
use skyshed_request::Band;

use crate::crs::Turn;
use crate::error::{Cause, Error, OddRaster, Oddity, Pair, ReadFault, Result, Wanted, two_crs};
use crate::format::{FileFormat, FileKind};
use crate::formats::oddity::{each_once, with_true_lengths};
use crate::input::{Input, cannot_read};
use crate::packed::files_of;
use crate::raster::{Crs, CrsKind, GeoRef};

/// Largest distance between the grids of two tiles \[cells\].
const MAX_SHIFT_CELLS: f64 = 1e-3;

impl Mosaic {
    /// Opens a folder of tiles and reads their headers, no cell.
    ///
    /// `open` reads the header of a tile of any format; `band` is the one to read, where the caller
    /// can choose one.
    pub(in crate::formats) fn open_folder(
        path: &Path,
        band: Option<&Band>,
        open: fn(&Input, Nesting<'_>) -> Result<Header>,
        odd: &mut Vec<Oddity>,
    ) -> Result<Mosaic> {
        let nesting = Nesting { band, ancestors: &[], n_opened: &AtomicUsize::new(0), open };
        Mosaic::open_tiles(path, &tile_files(path)?, nesting, odd)
    }

    /// Opens tiles of a folder or an archive, whose path is given, and reads their headers.
    pub(in crate::formats) fn open_tiles(
        path: &Path,
        tiles: &[Input],
        nesting: Nesting<'_>,
        odd: &mut Vec<Oddity>,
    ) -> Result<Mosaic> {
        let mut headers = read_headers(tiles, nesting)?;
        // Lengths are those in the middle of the whole mosaic.
        let of_tiles = headers.iter_mut().flat_map(|header| header.odd.drain(..));
        odd.extend(each_once(of_tiles.filter(|oddity| !oddity.is_web_mercator())));
        tell_of_bands(path, &headers, nesting.band, odd);
        bring_together(&mut headers);
        let Some(first) = headers.first() else { return Err(no_tiles(path)) };
        // Tiles without a CRS are taken to be in that of the rest.
        let named = headers.iter().find(|header| header.georef.crs().is_some());
        for other in &headers[1..] {
            if let Some(named) = named {
                refuse_other_crs(named, other)?;
            }
            refuse_other_grid(path, first, other)?;
        }
        let georef = common_grid(path, &headers)?;
        let georef = with_true_lengths(georef, &mut |of_all| odd.push(Oddity::new(path.display(), of_all)));
        let (first_col, first_row) = cells_from(&headers[0].georef, &georef);
        let place = |(k, header): (usize, &Header)| {
            // Both are whole numbers to a thousandth, so their difference is one.
            let (col, row) = cells_from(&headers[0].georef, &header.georef);
            #[expect(clippy::cast_possible_truncation, reason = "within the checked size of the mosaic")]
            let (row, col) = ((row - first_row).round() as i64, (col - first_col).round() as i64);
            let area = covered_area(
                (georef.n_rows(), georef.n_cols()),
                (header.tile.n_rows, header.tile.n_cols),
                (row, col),
                None,
            )?;
            Some(Piece { tile: k, band: header.tile.numbers.band, row, col, area, rule: Rule::Heights })
        };
        let pieces: Vec<Piece> = headers.iter().enumerate().filter_map(place).collect();
        let areas: Vec<_> = pieces.iter().map(|piece| piece.area).collect();
        let n_gaps = georef.n_cells() as u64 - n_covered_cells(&areas);
        Ok(Mosaic {
            path: path.to_owned(),
            kind: Kind::Folder,
            of_bands: None,
            vertical: headers.iter().find_map(|header| header.vertical.clone()),
            meters_per_height_unit: headers.iter().find_map(|header| header.meters_per_height_unit),
            georef,
            tiles: headers.into_iter().map(|header| header.tile).collect(),
            pieces,
            empty: f64::NAN,
            nodata: Some(f64::NAN),
            scaling: (1.0, 0.0),
            n_gaps,
        })
    }
}

/// Moves tiles in degrees on both sides of 180 degrees side by side.
fn bring_together(headers: &mut [Header]) {
    /// Largest cell of tiles in degrees that name no system \[deg\].
    const MOST: f64 = 0.1;
    let is_in_degrees = |header: &Header| match header.georef.crs() {
        Some(crs) => matches!(crs.kind(), CrsKind::Geographic),
        None => header.georef.cell_width() < MOST && header.georef.x_min() >= -180.0 && header.georef.x_max() <= 180.0,
    };
    if !headers.iter().all(is_in_degrees) {
        return;
    }
    let eastings: Vec<f64> = headers.iter().map(|header| header.georef.x_min()).collect();
    let Some(turn) = Turn::over(&eastings, 360.0) else { return };
    for georef in headers.iter_mut().map(|header| &mut header.georef) {
        let (corner, cell) =
            ((turn.apply(georef.x_min()), georef.y_max()), (georef.cell_width(), georef.cell_height()));
        let moved = GeoRef::new(corner, cell, (georef.n_rows(), georef.n_cols()), georef.crs().cloned());
        *georef = moved.unwrap_or_else(|| georef.clone());
    }
}

/// Returns the rasters in a folder, also those in archives, sorted by name.
fn tile_files(folder: &Path) -> Result<Vec<Input>> {
    let failed = |e: std::io::Error| cannot_read(&folder.into(), &e);
    let mut paths = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        let is_hidden = path.file_name().is_some_and(|name| name.to_string_lossy().starts_with('.'));
        if !is_hidden && path.is_file() {
            paths.push(path);
        }
    }
    paths.sort();
    let mut tiles = Vec::new();
    for input in paths.into_iter().map(Input::path) {
        match input.extension().as_str() {
            "tif" | "tiff" | "asc" | "xyz" => tiles.push(input),
            // Text beside the tiles mostly describes them.
            "txt" if matches!(FileFormat::of(&input), Ok(FileFormat::Xyz)) => tiles.push(input),
            "gz" | "zip" => tiles.extend(packed_rasters(&input)?),
            _ => {}
        }
    }
    if tiles.is_empty() { Err(no_tiles(folder)) } else { Ok(tiles) }
}

/// Returns the rasters in an archive, and in those inside of it.
///
/// # Errors
/// Errors of an archive that cannot be read.
pub(in crate::formats) fn packed_rasters(input: &Input) -> Result<Vec<Input>> {
    let is_raster = |(file, format): (Input, FileFormat)| (format.kind() == Some(FileKind::Raster)).then_some(file);
    Ok(files_of(input)?.into_iter().filter_map(is_raster).collect())
}

fn no_tiles(folder: &Path) -> Error {
    Error::read(folder.display(), ReadFault::Nothing(Wanted::Tiles))
}

/// Returns west and north edge of a grid in cells of another one, east and south of its north-west
/// corner.
fn cells_from(reference: &GeoRef, grid: &GeoRef) -> (f64, f64) {
    (
        (grid.x_min() - reference.x_min()) / reference.cell_width(),
        (reference.y_max() - grid.y_max()) / reference.cell_height(),
    )
}

fn refuse_other_crs(first: &Header, other: &Header) -> Result<()> {
    match (first.georef.crs(), other.georef.crs()) {
        (Some(a), Some(b)) if !a.same_as(b) => {
            let [one, two] = [first, other].map(|header| &header.tile.input);
            Err(two_crs((one, a), (two, b), Pair::Tiles))
        }
        _ => Ok(()),
    }
}

/// Refuses a tile that is not on the grid of the first one, or has another unit of height.
fn refuse_other_grid(folder: &Path, first: &Header, other: &Header) -> Result<()> {
    let (one, two) = (&first.georef, &other.georef);
    let refuse = |found: String, wanted: &str| {
        let [a, b] = [first, other].map(|header| &header.tile.input);
        let what = format!("its tiles `{a}` and `{b}` {found}, wanted {wanted}");
        Err(Error::read(folder.display(), ReadFault::Irregular(what)).because(Cause::OtherGrid))
    };
    let drift = |a: f64, b: f64, n: usize| (a - b).abs() * n as f64 > MAX_SHIFT_CELLS * a;
    if drift(one.cell_width(), two.cell_width(), two.n_cols())
        || drift(one.cell_height(), two.cell_height(), two.n_rows())
    {
        let size = |grid: &GeoRef| format!("{}×{}", grid.cell_width(), grid.cell_height());
        return refuse(format!("have cells of {} and {}", size(one), size(two)), "one size");
    }
    let (col, row) = cells_from(one, two);
    let off = |position: f64| (position - position.round()).abs();
    // NaN fails both comparisons.
    if !(off(col) <= MAX_SHIFT_CELLS && off(row) <= MAX_SHIFT_CELLS) {
        let text = format!("are {:.4} cells east and {:.4} cells south off a common grid", off(col), off(row));
        return refuse(text, "at most 0.001");
    }
    let (a, b) = (first.meters_per_height_unit.unwrap_or(1.0), other.meters_per_height_unit.unwrap_or(1.0));
    if (a - b).abs() > 1e-9 {
        return refuse(format!("give heights in units of {a} m and {b} m"), "one unit");
    }
    Ok(())
}

/// Returns the smallest grid that holds all tiles.
fn common_grid(folder: &Path, headers: &[Header]) -> Result<GeoRef> {
    let first = &headers[0].georef;
    let grids = || headers.iter().map(|header| &header.georef);
    let x_min = grids().map(GeoRef::x_min).fold(f64::INFINITY, f64::min);
    let y_max = grids().map(GeoRef::y_max).fold(f64::NEG_INFINITY, f64::max);
    let x_max = grids().map(GeoRef::x_max).fold(f64::NEG_INFINITY, f64::max);
    let y_min = grids().map(GeoRef::y_min).fold(f64::INFINITY, f64::min);
    let (width, height) = (first.cell_width(), first.cell_height());
    let (n_cols, n_rows) = (((x_max - x_min) / width).round(), ((y_max - y_min) / height).round());
    let too_far = || {
        let what = format!("its tiles lie in {n_cols} columns x {n_rows} rows, wanted at most {MAX_SIDE} a side");
        Error::read(folder.display(), ReadFault::Memory(what)).because(Cause::FarTile)
    };
    if !(n_cols <= MAX_SIDE && n_rows <= MAX_SIDE) {
        return Err(too_far());
    }
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "at least 1, at most 2^31 − 1")]
    let shape = (n_rows as usize, n_cols as usize);
    let crs: Option<&Crs> = grids().find_map(GeoRef::crs);
    GeoRef::new((x_min, y_max), (width, height), shape, crs.cloned()).ok_or_else(too_far)
}

/// Warns of tiles with several bands, and of scaled tiles. Both are read as single files are.
fn tell_of_bands(folder: &Path, headers: &[Header], band: Option<&Band>, odd: &mut Vec<Oddity>) {
    let mut tell = |of_tiles| odd.push(Oddity::new(folder.display(), of_tiles));
    let is_named = band.is_some_and(Band::is_named);
    if let Some(header) = headers.iter().find(|header| header.n_bands > 1 && !is_named) {
        let (tile, n) = (header.tile.input.to_string(), header.n_bands);
        tell(OddRaster::TileBands { tile, n, can_choose: band.is_some() });
    }
    if let Some(tile) = headers.iter().map(|header| &header.tile).find(|tile| tile.numbers.scaling != (1.0, 0.0)) {
        tell(OddRaster::TileScaling(tile.input.to_string(), tile.numbers.scaling));
    }
}
