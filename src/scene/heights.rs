//! Heights of a raster file on the lattice, for surfaces and terrains alike.

use std::path::Path;

use super::{Source, refuse_degrees};
use crate::error::{Error, Result, Warning};
use crate::quantity::{MAX_EXTENT_UNITS, VOID, height_steps};
use crate::raster::{Crs, CrsKind, GeoRef, InputKind, Raster, RasterFile};

/// A raster of heights, opened but not read.
#[derive(Debug)]
pub(super) struct HeightFile<'a> {
    path: &'a Path,
    file: RasterFile,
    georef: GeoRef,
}

/// What a raster of heights holds.
#[derive(Debug)]
pub(super) struct Heights {
    /// Heights on the lattice, [`VOID`] where there is none.
    pub(super) raster: Raster<i32>,
    /// Cells without a height.
    pub(super) n_void: u64,
    /// The files that were read.
    pub(super) sources: Vec<Source>,
}

impl<'a> HeightFile<'a> {
    /// Opens a raster; `crs` overrides what it says, or does not say, of its own.
    pub(super) fn open(path: &'a Path, crs: Option<&Crs>, warnings: &mut Vec<Warning>) -> Result<HeightFile<'a>> {
        let before = warnings.len();
        let file = RasterFile::open(path, warnings)?;
        let georef = file.georef().clone();
        let georef = match crs {
            None => georef,
            Some(crs) => {
                let said: Vec<Warning> = warnings.drain(before..).collect();
                warnings.extend(said.into_iter().filter(|w| !["W325", "W326", "W331"].contains(&w.code().as_str())));
                georef.with_crs(Some(crs.clone()))
            }
        };
        Ok(HeightFile { path, file, georef })
    }

    /// Where the cells lie.
    pub(super) fn georef(&self) -> &GeoRef {
        &self.georef
    }

    /// The same file if its coordinates can be those of a scene.
    ///
    /// # Errors
    /// E310 if they are degrees.
    pub(super) fn in_meters(self, warnings: &mut Vec<Warning>) -> Result<HeightFile<'a>> {
        check_grid(self.path, &self.georef, warnings)?;
        Ok(self)
    }

    /// Reads all heights.
    ///
    /// # Errors
    /// If the file cannot be read, no cell holds a height, or one holds a height that is out of range.
    pub(super) fn read(self, always_hash: bool, warnings: &mut Vec<Warning>) -> Result<Heights> {
        let HeightFile { path, file, georef } = self;
        let (cells, n_void) = match file.read_plain_heights(warnings)? {
            Some((raster, n_void)) => (raster.into_cells(), n_void),
            None => lattice_heights(path, &file, warnings)?,
        };
        let sources = Source::of_raster(path, &file, always_hash, warnings)?;
        Ok(Heights { raster: Raster::new(georef, cells), n_void, sources })
    }
}

/// All heights of a file on the lattice, and the number of cells that have none.
fn lattice_heights(path: &Path, file: &RasterFile, warnings: &mut Vec<Warning>) -> Result<(Vec<i32>, u64)> {
    let mut out_of_range: Option<f64> = None;
    let meters_per_unit = file.meters_per_height_unit().unwrap_or(1.0);
    let raster = file.read(file.georef().window(), warnings, |v| {
        let v = v * meters_per_unit;
        if v.is_nan() {
            return VOID;
        }
        height_steps(v).unwrap_or_else(|| {
            out_of_range.get_or_insert(v);
            VOID
        })
    })?;
    if let Some(v) = out_of_range {
        return Err(Error::site(
            205,
            format!("cannot use {}: a cell has height `{v}` m, wanted within ±32768 m", path.display()),
        )
        .with_hint("if it stands for nodata, declare it: `gdal_translate -a_nodata VALUE in.tif out.tif`"));
    }
    let n_void = raster.cells().iter().filter(|h| **h == VOID).count();
    if n_void == raster.cells().len() {
        return Err(Error::file(
            305,
            format!("cannot use {}: all {n_void} cells are nodata, wanted heights", path.display()),
        ));
    }
    Ok((raster.into_cells(), n_void as u64))
}

/// Warns where coordinates are not meters.
pub(super) fn warn_of_units(path: &Path, crs: &Crs, warnings: &mut Vec<Warning>) {
    if let CrsKind::Projected { meters_per_unit } = crs.kind()
        && (meters_per_unit - 1.0).abs() > 1e-9
    {
        warnings.push(Warning::new(
            343,
            format!(
                "{}: coordinates are in units of {meters_per_unit} m; lengths such as `--radius` and `--cell`, and heights, \
                 are in meters",
                path.display()
            ),
        ));
    }
}

/// Checks that a grid can be that of a scene.
///
/// # Errors
/// E310 if it is in degrees.
pub(super) fn check_grid(path: &Path, georef: &GeoRef, warnings: &mut Vec<Warning>) -> Result<()> {
    let Some(crs) = georef.crs() else { return Ok(()) };
    refuse_degrees(path, crs, [georef.x_min(), georef.y_min(), georef.x_max(), georef.y_max()], InputKind::Raster)?;
    warn_of_units(path, crs, warnings);
    if georef.n_cols().max(georef.n_rows()) as f64 > MAX_EXTENT_UNITS {
        warnings.push(Warning::new(
            344,
            format!("{}: more than 65536 cells a side; give `--radius` so that one map fits", path.display()),
        ));
    }
    Ok(())
}
