//! Memory for the cells of a grid, refused beyond a limit.

use std::fmt::Display;

use crate::error::{Cause, Error, ReadFault, Result};
use crate::raster::GeoRef;

/// Largest memory for the cells of one read \[bytes\].
const MAX_READ_BYTES: u64 = 16 << 30;

/// Returns an empty vector with room for all cells of `georef`.
pub(crate) fn reserve_cells<T>(name: &dyn Display, georef: &GeoRef) -> Result<Vec<T>> {
    check_cells::<T>(name, georef)?;
    let mut cells = Vec::new();
    let reserved = cells.try_reserve_exact(georef.n_cells());
    reserved.map_err(|_| too_many_cells::<T>(name, georef, "more than there is"))?;
    Ok(cells)
}

/// Refuses more cells than may be held in memory.
pub(super) fn check_cells<T>(name: &dyn Display, georef: &GeoRef) -> Result<()> {
    if georef.n_cells() as u128 * size_of::<T>() as u128 > u128::from(MAX_READ_BYTES) {
        return Err(too_many_cells::<T>(name, georef, &format!("wanted at most {} GiB", MAX_READ_BYTES >> 30)));
    }
    Ok(())
}

fn too_many_cells<T>(name: &dyn Display, georef: &GeoRef, why: &str) -> Error {
    let (n_rows, n_cols) = (georef.n_rows(), georef.n_cols());
    let needed = georef.n_cells() as f64 * size_of::<T>() as f64 / f64::powi(2.0, 30);
    let what = format!("{n_cols} columns x {n_rows} rows need {needed:.1} GiB of memory, {why}");
    Error::read(name, ReadFault::Memory(what)).because(Cause::LargeRaster)
}
