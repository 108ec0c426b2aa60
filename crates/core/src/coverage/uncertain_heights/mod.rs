//! What hangs on heights of buildings that may be off.
//!
//! [`height_errors`] says how errors are distributed, and how likely a link is clear then. Of maps, [`sure`] tells what holds whatever heights are
//! within bounds, [`p_los`] the probability of each receiver, [`redrawn`] how much P_LoS varies, and [`deciding`] which buildings decide the most.

mod deciding;
mod height_errors;
mod on_roofs;
mod p_los;
mod redrawn;
mod sure;

pub use deciding::Deciding;
pub use height_errors::{HeightErrors, OwnErrors};
pub use p_los::UncertainHeights;
pub use redrawn::{CORRELATION_M, RedrawnCounts, RedrawnHeights};
pub use sure::{HeightBounds, Sure};

use super::map::{Mapper, SiteCoverage};
use super::{Control, MapOptions};
use crate::error::{MapError, Result};
use crate::height_field::HeightField;

/// A scene with its heights as they may be, for the layers that were asked for.
#[derive(Debug)]
pub(super) struct Uncertain {
    sure: Option<HeightBounds>,
    p_los: Option<UncertainHeights>,
}

impl Uncertain {
    /// Makes ready what the options ask for; nothing if they ask for no such layer.
    ///
    /// # Errors
    /// E118.
    pub(super) fn of(field: &HeightField, options: &MapOptions) -> Result<Option<Box<Uncertain>>> {
        let MapOptions { height_errors, sigma, layers, .. } = options;
        if layers.p_los && field.prisms().is_none() {
            return Err(MapError::RasterProbabilities.into());
        }
        let wrong = || MapError::HeightErrors;
        let sure = layers.sure.then(|| HeightBounds::within(field, height_errors, *sigma).ok_or_else(wrong));
        let p_los = layers.p_los.then(|| UncertainHeights::of(field, height_errors).ok_or_else(wrong));
        if sure.is_none() && p_los.is_none() {
            return Ok(None);
        }
        Ok(Some(Box::new(Uncertain { sure: sure.transpose()?, p_los: p_los.transpose()? })))
    }
}

impl Mapper<'_> {
    /// Makes ready the layers that tell what hangs on errors of heights, if the options ask for any: maps have none without this.
    ///
    /// # Errors
    /// E118 for errors that cannot be, and for probabilities of a raster.
    pub fn with_height_errors(self) -> Result<Self> {
        Ok(Mapper { uncertain: Uncertain::of(self.field, &self.options)?, ..self })
    }

    /// Adds the layers to the map of a UAV.
    pub(super) fn add_uncertain(&self, map: &mut SiteCoverage, control: &Control) -> Result<()> {
        let Some(uncertain) = &self.uncertain else { return Ok(()) };
        if let Some(bounds) = &uncertain.sure {
            map.sure = Some(layer(&self.sure(&map.uav, bounds)?));
            control.check()?;
        }
        if let Some(heights) = &uncertain.p_los {
            map.p_los = Some(self.p_los(&map.uav, heights, control)?);
        }
        Ok(())
    }
}

/// 0 for receivers that are never in line of sight, 1 for those that surely are and 2 for those that may be; NaN elsewhere.
fn layer(sure: &Sure) -> Vec<f32> {
    let n_cols = sure.receivers.n_cols();
    let mut values = vec![f32::NAN; sure.receivers.n_rows() * n_cols];
    for (cells, value) in [(&sure.receivers, 0.0), (&sure.possibly, 2.0), (&sure.surely, 1.0)] {
        cells.cells().for_each(|(row, col)| values[row * n_cols + col] = value);
    }
    values
}
