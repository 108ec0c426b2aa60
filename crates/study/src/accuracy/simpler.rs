//! Simpler forms of a scene: larger cells, or fewer receivers over the same footprints.

use crate::city::Site;
use crate::coverage::Uav;
use crate::error::Result;
use crate::height_field::{HeightField, Pooling, Station};
use crate::quantity::Height;
use crate::raster::BitGrid;

/// Times that cells are made larger, finest first.
pub const FACTORS: [usize; 4] = [2, 4, 8, 16];

/// How a scene is made simpler.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Simpler {
    /// Cells are this many times as wide and as high: 1 is the scene itself.
    pub factor: usize,
    /// How the heights of a raster become one; `None` where only receivers become fewer, or nothing changes.
    pub pooling: Option<Pooling>,
}

impl Simpler {
    /// The scene as it is.
    pub const SAME: Simpler = Simpler { factor: 1, pooling: None };

    /// Whether it is the scene as it is.
    pub fn is_same(&self) -> bool {
        self.factor == 1
    }

    /// The simpler scene; `None` where a scene of this kind has no such form, and for the scene as it is.
    pub fn of(&self, field: &HeightField) -> Option<HeightField> {
        match self.pooling {
            _ if self.is_same() => None,
            Some(pooling) => field.coarser(self.factor, pooling),
            None => field.with_coarser_receivers(self.factor),
        }
    }

    /// The forms of a scene with cells `factors` times as large.
    pub fn forms(field: &HeightField, factors: &[usize]) -> Vec<Simpler> {
        let poolings: &[Option<Pooling>] =
            if field.prisms().is_some() { &[None] } else { &[Some(Pooling::Mean), Some(Pooling::Maximum)] };
        let of_factor = |&factor: &usize| poolings.iter().map(move |pooling| Simpler { factor, pooling: *pooling });
        factors.iter().flat_map(of_factor).collect()
    }

    /// In words, given the width of a cell of the scene \[m\]: `cells of 4 m (mean)`.
    pub fn in_words(&self, cell_m: f64) -> String {
        #[expect(clippy::cast_precision_loss, reason = "a small factor")]
        let cell = crate::quantity::tidy(cell_m * self.factor as f64);
        match self.pooling {
            Some(pooling) => format!("cells of {cell} m ({})", pooling.name()),
            None => format!("receivers every {cell} m"),
        }
    }
}

/// A UAV over another form of its scene: at the same place and the same height above the datum.
///
/// # Errors
/// As [`Uav::place`]: coarser cells may hold a building where it hovers.
pub(crate) fn moved_to(uav: &Uav, field: &HeightField) -> Result<Uav> {
    let (x, y) = (uav.station.place.x, uav.station.place.y);
    let site = Site::new(uav.id.clone(), (x, y), Height::AboveDatum(uav.height_amsl_m()));
    let placed = Uav::place(&site, field, None)?;
    // What it is above stays what it was said to be.
    Ok(Uav { station: Station { place: placed.station.place, z: uav.station.z }, ..uav.clone() })
}

/// What a map of larger cells says of the receivers of a finer one: each takes the answer of the cell that it is in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CoarseAnswer {
    /// The larger cell is in line of sight.
    Los,
    /// It is not.
    Nlos,
    /// It holds no receiver.
    None,
}

/// The answer for the receiver of row and column of the finer grid.
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
