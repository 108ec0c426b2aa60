//! Whole maps past prisms, for receivers at one height or at many.

use crate::dispatch;
use rayon::prelude::*;

use super::band::{BandJob, TILE};
use super::cast::Cast;
use super::plane::Plane;
use super::scene::{Receivers, ShadowLos, ShadowScene, cells_at_uav};
use crate::quantity::LatticePoint;
use crate::raster::BitGrid;

/// Finds the wanted cells whose receivers, all at height `z` \[1/1024 m above the datum\], are in
/// line of sight of `uav` past the prisms. Every cell is equal to [`super::super::prisms_los`].
///
/// On a curved earth receivers must be below the UAV, with rays that fall all the way;
/// [`GridLos`](super::super::GridLos) decides other receivers by `ray`.
///
/// Cost: the rows of the shadows; see the module. Positions may differ by at most 2^27 lattice
/// steps along each axis (not checked).
pub fn shadow_los(scene: &ShadowScene<'_>, uav: LatticePoint, z: i64) -> ShadowLos {
    match scene.plane(scene.wanted, uav) {
        Some(plane) => {
            let cast = Cast::new(scene.casters, &plane, (z, z));
            cast_all(scene, scene.wanted.in_rows(plane.rows.0..plane.rows.1), &plane, &Receivers::Level(z), &cast)
        }
        None => nothing(scene),
    }
}

/// Decides like [`shadow_los`], for `cells` in place of the wanted ones of the scene.
pub(super) fn shadow_los_among(scene: &ShadowScene<'_>, cells: BitGrid, uav: LatticePoint, z: i64) -> BitGrid {
    match scene.plane(&cells, uav) {
        Some(plane) => {
            let cast = Cast::new(scene.casters, &plane, (z, z));
            cast_all(scene, cells, &plane, &Receivers::Level(z), &cast).los
        }
        None => cells,
    }
}

/// Decides like [`shadow_los`], for receivers at differing heights: `height(row, col)` \[1/1024 m
/// above the datum\] of each wanted cell. On a curved earth each ray must fall, or rise, all the
/// way.
///
/// Cost: one comparison, eight receivers at a time, for each shadow that their tile does not
/// settle.
pub fn shadow_los_relief(
    scene: &ShadowScene<'_>,
    uav: LatticePoint,
    height: &(impl Fn(usize, usize) -> i32 + Sync),
) -> ShadowLos {
    let wanted = scene.wanted;
    let (relief, (lowest, highest)) = Receivers::relief(wanted, height);
    let Some(plane) = scene.plane(wanted, uav) else { return nothing(scene) };
    let cast = Cast::new(scene.casters, &plane, (i64::from(lowest), i64::from(highest)));
    cast_all(scene, wanted.in_rows(plane.rows.0..plane.rows.1), &plane, &relief, &cast)
}

/// Returns the result if no cell is wanted.
fn nothing(scene: &ShadowScene<'_>) -> ShadowLos {
    ShadowLos { los: scene.wanted.clone(), count: 0, asked: 0 }
}

/// Casts shadows on receivers of a scene. On entry `los` holds all the cells with a receiver, on
/// return those in line of sight.
fn cast_all(
    scene: &ShadowScene<'_>,
    mut los: BitGrid,
    plane: &Plane,
    receivers: &Receivers,
    cast: &Cast<'_>,
) -> ShadowLos {
    let at_uav = cells_at_uav(scene.grid, plane, &los);
    let words_per_row = los.words_per_row();
    let n_tiles = (plane.rows.1 - plane.rows.0).div_ceil(TILE);
    let rows_per_band = n_tiles.div_ceil(scene.n_bands.max(1)) * TILE;
    let (first, end) = (plane.rows.0 * words_per_row, plane.rows.1 * words_per_row);
    let in_band = |(k, words): (usize, &mut [u64])| {
        let first = plane.rows.0 + k * rows_per_band;
        let rows = (first, first + words.len() / words_per_row);
        let job = BandJob { scene, plane, receivers, rows, at_uav: &at_uav };
        dispatch!(scene.level, simd => job.cast(simd, cast, words))
    };
    let bands = &mut los.words_mut()[first..end];
    let counts = if n_tiles * TILE <= rows_per_band {
        in_band((0, bands))
    } else {
        let counts = bands.par_chunks_mut(rows_per_band * words_per_row).enumerate().map(in_band);
        counts.reduce(|| (0, 0), |a, b| (a.0 + b.0, a.1 + b.1))
    };
    ShadowLos { los, count: counts.0, asked: counts.1 }
}
