//! Simpler forms of a scene: larger cells, or fewer receivers over the same footprints.

use crate::city::Site;
use crate::coverage::Uav;
use crate::error::Result;
use crate::height_field::{HeightField, Pooling, Station};
use crate::quantity::Height;
use crate::raster::BitGrid;

/// Factors by which cells are enlarged, finest first.
pub const FACTORS: [usize; 4] = [2, 4, 8, 16];

/// Form of a scene with fewer cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Simpler {
    /// Factor by which cells are wider and higher: 1 is the scene itself.
    pub factor: usize,
    /// Pooling of heights of a raster; `None` if only receivers become fewer, or nothing changes.
    pub pooling: Option<Pooling>,
}

impl Simpler {
    /// The unchanged scene.
    pub const SAME: Simpler = Simpler { factor: 1, pooling: None };

    /// Returns `true` for the unchanged scene.
    pub fn is_same(&self) -> bool {
        self.factor == 1
    }

    /// Returns the simpler scene; `None` if it is the unchanged scene or does not exist.
    pub fn of(&self, field: &HeightField) -> Option<HeightField> {
        match self.pooling {
            _ if self.is_same() => None,
            Some(pooling) => field.coarser(self.factor, pooling),
            None => field.with_coarser_receivers(self.factor),
        }
    }

    /// Returns the forms of a scene with cells `factors` times as large.
    pub fn forms(field: &HeightField, factors: &[usize]) -> Vec<Simpler> {
        let poolings: &[Option<Pooling>] =
            if field.prisms().is_some() { &[None] } else { &[Some(Pooling::Mean), Some(Pooling::Maximum)] };
        let of_factor = |&factor: &usize| poolings.iter().map(move |pooling| Simpler { factor, pooling: *pooling });
        factors.iter().flat_map(of_factor).collect()
    }

    /// Returns the form in words, given the width of a cell of the scene \[m\]:
    /// `cells of 4 m (mean)`.
    pub fn in_words(&self, cell_m: f64) -> String {
        #[expect(clippy::cast_precision_loss, reason = "a small factor")]
        let cell = crate::quantity::tidy(cell_m * self.factor as f64);
        match self.pooling {
            Some(pooling) => format!("cells of {cell} m ({})", pooling.name()),
            None => format!("receivers every {cell} m"),
        }
    }
}

/// Moves a UAV to another form of its scene, at the same place and the same height above the datum.
///
/// # Errors
/// As [`Uav::place`]: coarser cells may hold a building at its place.
pub(crate) fn moved_to(uav: &Uav, field: &HeightField) -> Result<Uav> {
    let (x, y) = (uav.station.place.x, uav.station.place.y);
    let site = Site::new(uav.id.clone(), (x, y), Height::AboveDatum(uav.height_amsl_m()));
    let placed = Uav::place(&site, field, None)?;
    // What the UAV hovers over stays as it was stated for the scene itself.
    Ok(Uav { station: Station { place: placed.station.place, z: uav.station.z }, ..uav.clone() })
}

/// Answer for a receiver of a finer map: that of the larger cell which holds it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CoarseAnswer {
    /// The larger cell is in line of sight.
    Los,
    /// The larger cell is not in line of sight.
    Nlos,
    /// The larger cell holds no receiver.
    None,
}

/// Returns the answer for the receiver at a row and column of the finer grid.
#[inline]
pub fn coarse_answer(receivers: &BitGrid, los: &BitGrid, factor: usize, (row, col): (usize, usize)) -> CoarseAnswer {
    let (row, col) = (row / factor, col / factor);
    if los.contains(row, col) {
        CoarseAnswer::Los
    } else if receivers.contains(row, col) {
        CoarseAnswer::Nlos
    } else {
        CoarseAnswer::None
    }
}
