//! One place where a scene becomes what a UAV sees.
//!
//! * [`Mapper`] makes a scene ready once.
//! * [`Mapper::seen_from`] returns the [`View`] of one UAV: heights lowered by the curve of the
//!   earth, receivers, engine, and range.
//! * [`View::with_roofs`] shows the same UAV a scene whose roofs are moved ([`MovedRoofs`]), and
//!   [`View::with_uav`] moves the UAV.
//! * [`SceneView`] holds the heights alone, for questions about single links.
//! * [`WindowedView`] is the view of a scene that is read window by window.
//!
//! Nothing outside of this folder bends or moves a scene.

mod mapper;
mod moved_roofs;
mod scene;
mod windowed;

use std::borrow::Cow;
use std::sync::Arc;

pub use mapper::Mapper;
pub use moved_roofs::{HeightBounds, MovedRoofs, UncertainHeights};
pub use scene::{SceneView, check_drop};
pub(super) use windowed::WindowedView;

use super::Uav;
use super::elevation::RowElevations;
use super::options::Stand;
use super::range::{Heights, Range};
use crate::error::Result;
use crate::height_field::{Bulge, Drops, GridPositions, HeightField, Station};
use crate::los::{ClearProbabilities, GridHeights, GridLos, GridReceivers, HeightErrors, height_by_cell};
use crate::quantity::STEPS_PER_UNIT;
use crate::raster::{BitGrid, CellWindow};
use mapper::refused;

/// One UAV's view of the scene of a [`Mapper`]: what questions about the UAV are asked of.
#[derive(Debug)]
pub struct View<'v> {
    pub(super) mapper: &'v Mapper<'v>,
    scene: SceneView<'v>,
    /// Engine over moved roofs; `None` where roofs are those of the mapper's scene.
    moved: Option<GridLos<'v>>,
    /// Receivers as they are seen, kind by kind.
    receivers: Vec<GridReceivers<'v>>,
    pub(super) range: Arc<Range<'v>>,
    /// Window that holds all cells in range, and all cells between them and the UAV.
    pub(super) window: CellWindow,
}

/// Receivers of one kind as a UAV sees them.
#[derive(Debug, Clone, Copy)]
pub(super) struct SeenReceivers<'k> {
    pub(super) view: &'k View<'k>,
    kind: usize,
    pub(super) receivers: &'k GridReceivers<'k>,
}

/// Receivers of one kind in range, and those of them in line of sight.
#[derive(Debug, Clone)]
pub(super) struct Decided<'k> {
    pub(super) in_range: Cow<'k, BitGrid>,
    pub(super) los: BitGrid,
}

/// Threads among which one question is shared.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Threads {
    /// All of the current pool.
    All,
    /// The calling one: costs less in all where many UAVs are decided at once.
    One,
}

impl Mapper<'_> {
    /// Returns the view of a UAV.
    ///
    /// # Errors
    /// E118 for an earth so curved that heights would leave the lattice.
    pub fn seen_from<'v>(&'v self, uav: &'v Uav) -> Result<View<'v>> {
        let mut scene = SceneView { scene: self.field, uav, curve: None };
        let heights = heights_of(&self.receivers);
        if let Some(curvature) = self.options.curvature {
            let (place, meters_per_unit) = (&uav.station.place, self.options.meters_per_unit);
            let drops = Drops::new(self.positions(), place, curvature, meters_per_unit);
            // Receivers may be lower by as much as any cell is.
            let most = drops.most(self.field.grid().window());
            let lowered = Heights { lowest: heights.lowest.saturating_sub(most), are_flat: false, ..heights };
            let window = Range::of(self.positions(), uav, &self.options, lowered).window();
            // Rasters are lowered by whole steps of the lattice, prisms are exact.
            let is_flat = || self.field.prisms().is_none() && drops.most(window) == 0;
            if window.n_rows > 0 && window.n_cols > 0 && !is_flat() {
                scene = scene.curved(curvature, drops, window)?;
            }
        }
        let receivers: Vec<_> = self.receivers.iter().map(|of_kind| scene.lower(of_kind.borrowed())).collect();
        let range = Range::of(self.positions(), uav, &self.options, heights_of(&receivers));
        let window = range.window();
        Ok(View { mapper: self, scene, moved: None, receivers, range: Arc::new(range), window })
    }
}

/// Returns bounds on the heights of receivers of all kinds.
fn heights_of(receivers: &[GridReceivers<'_>]) -> Heights {
    Heights::of_all(receivers.iter().map(|of_kind| {
        let (lowest, highest) = of_kind.heights_range();
        Heights { lowest, highest, are_flat: of_kind.are_on_flat_ground() }
    }))
}

impl SceneView<'_> {
    /// Returns whether receivers are lowered with the ground: in rasters they are.
    fn lowers_receivers(&self) -> bool {
        self.curve.is_some() && self.scene.prisms().is_none()
    }

    /// Returns receivers at their heights as they are seen.
    fn lower<'r>(&self, receivers: GridReceivers<'r>) -> GridReceivers<'r> {
        match &self.curve {
            Some(curve) if self.lowers_receivers() => receivers.lowered(&curve.drops, curve.window),
            _ => receivers,
        }
    }
}

impl<'v> View<'v> {
    /// Returns the same UAV's view of a scene with its roofs moved. Nobody comes into range by
    /// that, or leaves it.
    pub(super) fn with_roofs<'x>(&'x self, roofs: &'x MovedRoofs) -> Result<View<'x>> {
        let engine = GridLos::new(&roofs.field, self.mapper.engine.method()).map_err(refused)?;
        let scene = self.scene.over(&roofs.field);
        let moved = |(kind, receivers): (usize, &'x GridReceivers<'_>)| {
            let is_on_roofs = self.mapper.stands_on_roofs(kind);
            scene.lower(if is_on_roofs { roofs.moved(receivers) } else { receivers.borrowed() })
        };
        let receivers = self.mapper.receivers.iter().enumerate().map(moved).collect();
        let (range, window) = (Arc::clone(&self.range), self.window);
        Ok(View { mapper: self.mapper, scene, moved: Some(engine), receivers, range, window })
    }

    /// Returns the view after a small move of the UAV, over heights as they are seen from before.
    /// Nobody comes into range by that, or leaves it.
    pub(super) fn with_uav<'x>(&'x self, uav: &'x Uav) -> View<'x> {
        let range = Range::of(self.positions(), uav, &self.mapper.options, heights_of(&self.receivers));
        View {
            mapper: self.mapper,
            scene: SceneView { uav, ..self.scene.clone() },
            moved: self.moved.clone(),
            receivers: self.receivers.iter().map(GridReceivers::borrowed).collect(),
            range: Arc::clone(&self.range),
            window: self.range.window_with(&range),
        }
    }

    /// Returns the UAV.
    pub fn uav(&self) -> &'v Uav {
        self.scene.uav
    }

    /// Returns heights as the UAV sees them, for questions about single links.
    pub fn scene(&self) -> &SceneView<'v> {
        &self.scene
    }

    pub(super) fn field(&self) -> &HeightField {
        self.scene.field()
    }

    pub(super) fn positions(&self) -> &GridPositions {
        self.mapper.positions()
    }

    /// Returns the largest drop in the window \[1/1024 m\]; 0 over a flat earth.
    pub(super) fn most_drop(&self) -> i64 {
        self.scene.curve.as_ref().map_or(0, |curve| curve.drops.most(self.window))
    }

    /// Returns a set without cells.
    pub(super) fn no_cells(&self) -> BitGrid {
        let grid = self.mapper.field.grid();
        BitGrid::new(grid.n_rows(), grid.n_cols())
    }

    /// Returns receivers, kind by kind.
    pub(super) fn receivers(&self) -> impl Iterator<Item = SeenReceivers<'_>> + Clone {
        let of = |(kind, receivers)| SeenReceivers { view: self, kind, receivers };
        self.receivers.iter().enumerate().map(of)
    }

    /// Returns receivers of a cell: on the ground, on the roof, or none.
    pub(super) fn receivers_at(&self, (row, col): (usize, usize)) -> impl Iterator<Item = SeenReceivers<'_>> {
        self.receivers().filter(move |of_kind| of_kind.receivers.cells.contains(row, col))
    }

    /// Turns a layer of heights of receivers \[m\] into heights above the datum, in rows from
    /// `first` on.
    pub(super) fn raise(&self, heights: &mut [f32], first: usize) {
        let Some(curve) = self.scene.curve.as_ref().filter(|_| self.scene.lowers_receivers()) else { return };
        let n_cols = self.mapper.field.grid().n_cols();
        for (row, heights) in (first..).zip(heights.chunks_mut(n_cols)) {
            heights.iter_mut().enumerate().for_each(|(col, z)| *z = curve.drops.raised(*z, (row, col)));
        }
    }

    fn engine(&self, threads: Threads) -> Cow<'_, GridLos<'_>> {
        let engine = match (&self.moved, threads) {
            (Some(moved), _) => moved,
            (None, Threads::All) => &self.mapper.engine,
            (None, Threads::One) => &self.mapper.alone,
        };
        let Some(curve) = &self.scene.curve else { return Cow::Borrowed(engine) };
        // As many meters to the steps of both axes, or none.
        let (step_x, step_y) = self.positions().step_lengths();
        let unit_m = step_x * f64::from(STEPS_PER_UNIT) * self.mapper.options.meters_per_unit;
        let bulge = step_x.total_cmp(&step_y).is_eq().then(|| Bulge::new(curve.curvature, unit_m));
        Cow::Owned(engine.over(&curve.field, bulge.flatten()))
    }
}

impl Mapper<'_> {
    /// Returns whether receivers of a kind stand on what moves with roofs: on roofs, or on a
    /// surface model alone.
    pub(super) fn stands_on_roofs(&self, kind: usize) -> bool {
        self.field.is_surface_only() || self.options.receivers.stands()[kind] == Stand::Roof
    }
}

impl<'k> SeenReceivers<'k> {
    /// Returns whether they move with roofs.
    pub(super) fn are_on_roofs(&self) -> bool {
        self.view.mapper.stands_on_roofs(self.kind)
    }

    /// Returns whether each moves with the building below it.
    pub(super) fn are_on_footprints(&self) -> bool {
        self.are_on_roofs() && self.view.field().prisms().is_some()
    }

    /// Returns the cells of those in range.
    pub(super) fn in_range(&self) -> Cow<'k, BitGrid> {
        match self.view.range.is_everywhere() {
            true => Cow::Borrowed(&*self.receivers.cells),
            false => Cow::Owned(self.view.range.cut_receivers(self.receivers)),
        }
    }

    /// Returns whether the receiver of a cell is in range.
    pub(super) fn is_in_range(&self, cell: (usize, usize)) -> bool {
        self.view.range.contains(self.receivers, cell)
    }

    /// Returns those in range, and who of them is in line of sight.
    pub(super) fn decided(&self, threads: Threads) -> Decided<'k> {
        let in_range = self.in_range();
        Decided { los: self.los(&in_range, threads), in_range }
    }

    /// Returns those of some receivers in range that are in line of sight.
    pub(super) fn los(&self, wanted: &BitGrid, threads: Threads) -> BitGrid {
        self.view.engine(threads).los(&self.view.uav().station, self.receivers, wanted, self.view.window)
    }

    /// Returns those of some receivers in range that are in line of sight, and least heights over
    /// their cells; `None` where a walk along each link is needed.
    pub(super) fn los_and_least_heights(&self, wanted: &BitGrid, threads: Threads) -> Option<(BitGrid, GridHeights)> {
        let View { window, .. } = *self.view;
        self.view.engine(threads).los_and_least_heights(&self.view.uav().station, self.receivers, wanted, window)
    }

    /// Returns least heights of the UAV from `lowest` \[1/1024 m above the datum\] that see some
    /// receivers in range; `None` where a walk along each link is needed.
    pub(super) fn least_uav_heights(&self, wanted: &BitGrid, lowest: i64) -> Option<GridHeights> {
        let height = self.height_by_cell();
        self.view.engine(Threads::All).least_uav_heights(&self.view.uav().station, wanted, lowest, &height)
    }

    /// Returns heights of receivers by row and column \[1/1024 m\].
    pub(super) fn height_by_cell(&self) -> impl Fn(usize, usize) -> i32 + Sync + use<'_> {
        height_by_cell(self.receivers)
    }

    /// Returns probabilities of line of sight of receivers in some cells; `None` where a walk along
    /// each link is needed.
    pub(super) fn clear_probabilities(&self, cells: &BitGrid, errors: &HeightErrors) -> Option<ClearProbabilities> {
        self.view.engine(Threads::All).clear_probabilities(&self.view.uav().station, self.receivers, cells, errors)
    }

    /// Returns the receiver of a cell.
    pub(super) fn station(&self, (row, col): (usize, usize)) -> Station {
        Station { place: self.view.positions().center(row, col), z: self.height((row, col)) }
    }

    /// Returns the height of the receiver of a cell \[1/1024 m\].
    #[inline]
    pub(super) fn height(&self, (row, col): (usize, usize)) -> i64 {
        self.receivers.height(row * self.receivers.cells.n_cols() + col)
    }

    /// Returns the height of what the receiver of a cell stands on \[1/1024 m\].
    #[inline]
    pub(super) fn base(&self, (row, col): (usize, usize)) -> i32 {
        self.receivers.base(row * self.receivers.cells.n_cols() + col)
    }

    /// Returns elevations of the UAV from the receivers of a row.
    pub(super) fn elevations(&self, row: usize) -> RowElevations<'k> {
        let mapper = self.view.mapper;
        let n_cols = mapper.field.grid().n_cols();
        let Station { place, z } = self.view.uav().station;
        RowElevations {
            xs: &mapper.xs,
            n_cols,
            uav: (place.x, place.y, z),
            y: mapper.field.grid().world_from_cell(row, 0).1,
            meters_per_unit: mapper.options.meters_per_unit,
            receivers: self.receivers,
            first_cell: row * n_cols,
        }
    }
}
