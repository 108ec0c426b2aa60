//! Scenes with their roofs moved, as steps of the lattice or errors of heights move them.

use crate::height_field::HeightField;
use crate::los::{CERTAIN, GridReceivers, HeightErrors, OwnErrors};
use crate::quantity::STEPS_PER_UNIT;

/// Scene with its roofs moved: what [`View`](super::View) can show a UAV instead of the scene
/// itself.
#[derive(Debug, Clone)]
pub struct MovedRoofs {
    /// Scene with its roofs moved.
    pub field: HeightField,
    receivers: OnRoofs,
}

/// Heights of the receivers on roofs that move.
#[derive(Debug, Clone)]
enum OnRoofs {
    /// As over the roofs before.
    Stay,
    /// Higher by so much \[1/1024 m\].
    RaisedBy(i32),
    /// On the roofs of the moved scene.
    OnMoved,
    /// On a height for each cell \[1/1024 m above the datum\].
    On(Vec<i32>),
}

impl MovedRoofs {
    /// Raises every roof by `steps(building)` \[1/1024 m\], receivers left where they are; `None`
    /// if a roof would leave ±32 768 m.
    ///
    /// Moves the tops of all prisms, or of the columns that are buildings; of a surface model
    /// alone, all columns. Where buildings have no numbers `steps` is called once, for 0.
    ///
    /// Cost: that of a copy; prisms are sorted into buckets again.
    pub fn by_building(field: &HeightField, steps: impl Fn(u32) -> i32) -> Option<Self> {
        Some(MovedRoofs { field: field.with_roofs_raised_by(steps)?, receivers: OnRoofs::Stay })
    }

    /// Raises the buildings of a raster by `steps(cell)` \[1/1024 m\], and receivers on them;
    /// `None` as of [`MovedRoofs::by_building`], and of footprints.
    pub(in crate::coverage) fn by_cell(field: &HeightField, steps: impl Fn(usize) -> i32) -> Option<Self> {
        Some(MovedRoofs { field: field.with_cells_raised_by(steps)?, receivers: OnRoofs::OnMoved })
    }

    /// Raises the receivers on roofs alone.
    fn with_receivers_raised_by(self, by: i32) -> Self {
        MovedRoofs { receivers: OnRoofs::RaisedBy(by), ..self }
    }

    /// Puts the receivers on roofs on a height for each cell \[1/1024 m above the datum\].
    pub(in crate::coverage) fn with_receivers_on(self, heights: Vec<i32>) -> Self {
        MovedRoofs { receivers: OnRoofs::On(heights), ..self }
    }

    /// Returns receivers on roofs as they move.
    pub(super) fn moved<'r>(&'r self, receivers: &'r GridReceivers<'_>) -> GridReceivers<'r> {
        match &self.receivers {
            OnRoofs::Stay => receivers.borrowed(),
            OnRoofs::RaisedBy(by) => receivers.raised(*by),
            OnRoofs::OnMoved => receivers.on(self.field.roofs_of_cells()),
            OnRoofs::On(heights) => receivers.on(heights),
        }
    }
}

/// Scene with all buildings as low, and as high, as errors of their heights let them be. Of a
/// surface model alone, where buildings are not known, all columns are lower and higher.
///
/// A receiver that stands on a roof of a raster moves the other way: up where roofs are low, down
/// where they are high. So both bounds hold whatever the error of its own roof is.
#[derive(Debug)]
pub struct HeightBounds {
    pub(in crate::coverage) low: MovedRoofs,
    pub(in crate::coverage) high: MovedRoofs,
    /// Largest error of each building of footprints \[1/1024 m\]; empty of a raster.
    pub(in crate::coverage) by_building: Vec<i32>,
}

impl HeightBounds {
    /// Returns the scene with heights that are off by at most `error_m`, rounded up to 1/1024 m.
    ///
    /// `None` if that is no length, or a roof would leave ±32 768 m.
    pub fn of(field: &HeightField, error_m: f64) -> Option<Self> {
        HeightBounds::by_building(field, |_| error_m)
    }

    /// Returns the scene with heights that are off by so many standard deviations of their errors;
    /// `None` as of [`HeightBounds::of`], or if there is not one error for each building.
    pub fn within(field: &HeightField, errors: &HeightErrors, deviations: f64) -> Option<Self> {
        let is_raster_by_building = field.prisms().is_none() && matches!(errors.own, OwnErrors::ByBuilding(_));
        if is_raster_by_building || !errors.are_valid(field.n_buildings()) {
            return None;
        }
        HeightBounds::by_building(field, |building| deviations * errors.of_building_m(building))
    }

    fn by_building(field: &HeightField, error_m: impl Fn(u32) -> f64) -> Option<Self> {
        #[expect(clippy::cast_possible_truncation, reason = "saturates, and is refused then")]
        let steps = |building: u32| (error_m(building) * f64::from(STEPS_PER_UNIT)).ceil() as i32;
        let n_buildings = u32::try_from(field.n_buildings()).ok()?;
        let all = if field.prisms().is_some() { 0..n_buildings } else { 0..1 };
        let is_length = |building: u32| error_m(building) >= 0.0 && steps(building) <= 1 << 25;
        all.clone().all(is_length).then_some(())?;
        let most = all.map(steps).max().unwrap_or(0);
        let low = MovedRoofs::by_building(field, |b| -steps(b))?.with_receivers_raised_by(most);
        let high = MovedRoofs::by_building(field, steps)?.with_receivers_raised_by(-most);
        Some(HeightBounds { low, high, by_building: (0..n_buildings).map(steps).collect() })
    }
}

/// Scene of footprints with the errors of their heights, ready for any number of UAVs.
#[derive(Debug)]
pub struct UncertainHeights {
    pub(in crate::coverage) errors: HeightErrors,
    /// The scene as far as errors are reckoned with.
    pub(in crate::coverage) bounds: HeightBounds,
    /// Most that a top is above the known one by an error that is reckoned with \[1/1024 m\].
    pub(in crate::coverage) reach: i32,
}

impl UncertainHeights {
    /// Makes ready; `None` if an error is no length, or makes a roof leave ±32 768 m, or if there
    /// is not one for each building.
    pub fn of(field: &HeightField, errors: &HeightErrors) -> Option<Self> {
        let bounds = HeightBounds::within(field, errors, CERTAIN)?;
        // The sum of two errors is no more than √2 of what both together are.
        let most = (0..u32::try_from(field.n_buildings()).ok()?).map(|b| errors.own_m(b)).fold(0.0, f64::max);
        #[expect(clippy::cast_possible_truncation, reason = "saturates")]
        let reach = (CERTAIN * (most + errors.shared_m) * f64::from(STEPS_PER_UNIT)).ceil() as i32;
        Some(UncertainHeights { errors: errors.clone(), bounds, reach })
    }
}
