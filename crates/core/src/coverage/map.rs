//! Maps: every receiver of the grid against one UAV, or against many with the scene made ready once.

use std::borrow::Cow;
use std::sync::Arc;
use std::sync::atomic::Ordering;

use super::cell_classes::{RowSets, write_classes};
use super::cell_heights::{CellHeights, FoundHeights};
use super::curved::{CurvedScene, check_roofs};
use super::elevation::RowElevations;
use super::range::{Heights, Range};
use super::row_bands::{BAND_CELLS, EachPart, Row, in_bands, in_buffers, split};
use super::stability::{Answers, Decided, ShiftedRoofs};
use super::uncertain_heights::Uncertain;
use super::{Control, HeightLayers, MapOptions, Receivers, Stability, Tally, Uav};
use crate::error::{MapError, Result};
use crate::height_field::{Casters, HeightField, Station};
use crate::los::{GridLos, GridReceivers, Method, WrongMethod, height_by_cell, link_los};
use crate::raster::{BitGrid, CellWindow, LargeVec};

/// The coverage of one UAV: shape `[n_rows, n_cols]` each, columns running fastest, row 0 north.
#[derive(Debug, Clone)]
pub struct SiteCoverage {
    /// The UAV.
    pub uav: Uav,
    /// Classes of [`super::class`].
    pub mask: LargeVec<u8>,
    /// Receiver height less the least visible height \[m\]; ≥ 0 exactly where LoS, NaN where there is no receiver.
    pub margin: Option<Vec<f32>>,
    /// Least receiver height in line of sight \[m above the datum\], never below what the receiver stands on.
    pub least_receiver_height: Option<Vec<f32>>,
    /// Least UAV height over its place that sees the receiver \[m above the datum\], never below the surface there; +∞
    /// where none within ±32 768 m does.
    pub least_height: Option<Vec<f32>>,
    /// How stable the answers are.
    pub stability: Option<Stability>,
    /// Who is in line of sight whatever heights of buildings are within their errors: 0 never, 1 surely, 2 possibly; NaN where there is no
    /// receiver.
    pub sure: Option<Vec<f32>>,
    /// Probability of line of sight with the errors of heights, NaN where there is no receiver.
    pub p_los: Option<Vec<f32>>,
    /// Counts.
    pub tally: Tally,
}

impl SiteCoverage {
    /// The coverage of a UAV without layers.
    pub fn of_mask(uav: &Uav, mask: LargeVec<u8>, tally: Tally) -> Self {
        SiteCoverage { mask, ..SiteCoverage::of_tally(uav, tally) }
    }

    /// The columns of a window alone, of a coverage of its rows, which have so many.
    fn cropped(self, window: CellWindow, n_cols: usize) -> Self {
        fn part<T: Copy>(cells: &[T], window: CellWindow, n_cols: usize) -> Vec<T> {
            let rows = cells.chunks(n_cols);
            rows.flat_map(|row| &row[window.col..window.col + window.n_cols]).copied().collect()
        }
        // Of a layer of all rows.
        let of_rows =
            |cells: &[f32]| part(&cells[window.row * n_cols..(window.row + window.n_rows) * n_cols], window, n_cols);
        let of_layer = |layer: Option<Vec<f32>>| layer.map(|layer| part(&layer, window, n_cols));
        let mask: LargeVec<u8> = part(&self.mask, window, n_cols).into();
        SiteCoverage {
            tally: self.tally.with_others_of(&mask),
            mask,
            margin: of_layer(self.margin),
            least_receiver_height: of_layer(self.least_receiver_height),
            least_height: of_layer(self.least_height),
            stability: self.stability.map(|of_all| Stability { turns: of_rows(&of_all.turns), ..of_all }),
            sure: self.sure.as_deref().map(of_rows),
            p_los: self.p_los.as_deref().map(of_rows),
            uav: self.uav,
        }
    }

    /// The coverage of a UAV without a mask and layers.
    pub(super) fn of_tally(uav: &Uav, tally: Tally) -> Self {
        SiteCoverage {
            uav: uav.clone(),
            mask: LargeVec::default(),
            margin: None,
            least_receiver_height: None,
            least_height: None,
            stability: None,
            sure: None,
            p_los: None,
            tally: tally.of_uav(uav),
        }
    }
}

/// What a UAV sees, as sets of cells.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Seen {
    /// The receivers in range.
    pub receivers: BitGrid,
    /// Those in line of sight.
    pub los: BitGrid,
}

/// Maps what one UAV sees: [`Mapper::new`] and [`Mapper::map`] in one.
pub fn map_site(field: &HeightField, uav: &Uav, options: &MapOptions, control: &Control) -> Result<SiteCoverage> {
    Mapper::new(field, options)?.map(uav, control)
}

/// A scene and options made ready for any number of UAVs.
#[derive(Debug)]
pub struct Mapper<'a> {
    pub(super) field: &'a HeightField,
    pub(super) options: MapOptions,
    /// Shared by all threads.
    pub(super) engine: GridLos<'a>,
    /// The engine for many UAVs of which each has a thread of its own.
    pub(super) alone: GridLos<'a>,
    pub(super) why: &'static str,
    /// Receivers on the ground, on roofs, or both.
    pub(super) receivers: Vec<GridReceivers<'a>>,
    /// World x of the columns of cells, whole words of them \[CRS units\].
    pub(super) xs: Vec<f64>,
    /// The scene with other roofs, where stability is asked for.
    pub(super) roofs: Option<Box<ShiftedRoofs>>,
    /// The scene with roofs of other heights, where layers tell of errors: see [`Mapper::with_height_errors`].
    pub(super) uncertain: Option<Box<Uncertain>>,
}

impl<'a> Mapper<'a> {
    /// Makes ready what does not depend on the UAV.
    ///
    /// # Errors
    /// E118 if the options ask for an engine that cannot decide this scene, for layers of heights beside an approximate one, or for roofs
    /// that slope over a curved earth.
    pub fn new(field: &'a HeightField, options: &MapOptions) -> Result<Self> {
        let refuse = |wrong: WrongMethod| MapError::Method { why: wrong.why, instead: wrong.instead.name() };
        let (method, why) = Method::choose(field, options.method).map_err(refuse)?;
        if !method.is_exact() && options.layers != HeightLayers::default() {
            return Err(MapError::ApproximateLayers { method: method.name() }.into());
        }
        if options.curvature.is_some() {
            check_roofs(field)?;
        }
        let cells = field.cells();
        let shape = (field.grid().n_rows(), field.grid().n_cols());
        let told_of = options.window.map(|window| BitGrid::of_window(shape, window));
        let within = |cells: &'a BitGrid| {
            let sets = options.within.iter().chain(&told_of);
            sets.fold(Cow::Borrowed(cells), |cells, set| Cow::Owned(cells.into_owned().and(set)))
        };
        let ground = || GridReceivers::new(within(&cells.open), field.ground_of_cells(), options.rx_height);
        let roof = || GridReceivers::new(within(&cells.building), field.roof_of_cells(), options.rx_height);
        let air = || {
            let free = field.free_above_ground(options.rx_height);
            let free = options.within.iter().chain(&told_of).fold(free, |cells, set| cells.and(set));
            GridReceivers::new(free, field.ground_of_cells(), options.rx_height)
        };
        let receivers = match options.receivers {
            Receivers::Ground => vec![ground()],
            Receivers::Roof => vec![roof()],
            Receivers::All => vec![ground(), roof()],
            Receivers::Air => vec![air()],
        };
        let n_cols = field.grid().n_cols();
        let mut xs: Vec<f64> = (0..n_cols).map(|col| field.grid().world_from_cell(0, col).0).collect();
        xs.resize(n_cols.div_ceil(64) * 64, 0.0);
        let engine = GridLos::new(field, method).map_err(refuse)?;
        let mut alone = engine.clone();
        alone.is_one_band = true;
        let roofs = options.layers.stability.then(|| Box::new(ShiftedRoofs::of(field)));
        Ok(Mapper { field, options: options.clone(), engine, alone, why, receivers, xs, roofs, uncertain: None })
    }

    /// The scene.
    pub fn field(&self) -> &'a HeightField {
        self.field
    }

    /// The engine that decides, and why it was chosen.
    pub fn method(&self) -> (Method, &'static str) {
        (self.engine.method(), self.why)
    }

    /// Whether the antenna of the run serves some elevations alone.
    pub fn limits_elevations(&self) -> bool {
        self.options.antenna.elevations_deg().is_some()
    }

    /// The cells that hold receivers, in range or not.
    pub fn receiver_cells(&self) -> BitGrid {
        let grid = self.field.grid();
        let none = BitGrid::new(grid.n_rows(), grid.n_cols());
        self.receivers.iter().fold(none, |all, receivers| all.or(&receivers.cells))
    }

    /// Casts the shadows of these alone.
    pub(super) fn cast_only(&mut self, casters: Casters) {
        let casters = Some(Arc::new(casters));
        self.engine.casters.clone_from(&casters);
        self.alone.casters = casters;
    }

    /// The cells in range of a UAV.
    pub(super) fn range_of(&self, uav: &Uav) -> Range<'_> {
        Range::of(self.engine.positions(), uav, &self.options, self.receiver_heights())
    }

    /// How high the receivers are.
    pub(super) fn receiver_heights(&self) -> Heights {
        let of = |receivers: &GridReceivers<'_>| {
            let (lowest, highest) = receivers.heights_range();
            Heights { lowest, highest, are_flat: receivers.are_on_flat_ground() }
        };
        Heights::of_all(self.receivers.iter().map(of))
    }

    /// How many receivers a UAV has in range, and how many of them are in line of sight: what [`Mapper::map`] counts,
    /// without a mask. For many UAVs at once: each is the work of one thread.
    pub fn count(&self, uav: &Uav) -> (u64, u64) {
        if let Some(curved) = CurvedScene::around(self, uav) {
            return curved.mapper(self).count(uav);
        }
        let range = self.range_of(uav);
        self.receivers.iter().fold((0, 0), |sum, receivers| {
            let (wanted, los) = self.decide(&self.alone, uav, (receivers, &range));
            (sum.0 + wanted.as_ref().unwrap_or(&receivers.cells).count(), sum.1 + los.count())
        })
    }

    /// The receivers that a UAV has in range, and those of them in line of sight, as sets of cells.
    pub fn seen(&self, uav: &Uav) -> Seen {
        if let Some(curved) = CurvedScene::around(self, uav) {
            return curved.mapper(self).seen(uav);
        }
        let grid = self.field.grid();
        let range = self.range_of(uav);
        let none = || BitGrid::new(grid.n_rows(), grid.n_cols());
        self.receivers.iter().fold(Seen { receivers: none(), los: none() }, |sum, receivers| {
            let (wanted, los) = self.decide(&self.alone, uav, (receivers, &range));
            let wanted = wanted.as_ref().unwrap_or(&receivers.cells);
            Seen { receivers: sum.receivers.or(wanted), los: sum.los.or(&los) }
        })
    }

    /// The cells that hold receivers in range of a UAV.
    pub fn receivers_in_range(&self, uav: &Uav) -> BitGrid {
        if let Some(curved) = CurvedScene::around(self, uav) {
            return curved.mapper(self).receivers_in_range(uav);
        }
        let range = self.range_of(uav);
        let grid = self.field.grid();
        let none = BitGrid::new(grid.n_rows(), grid.n_cols());
        self.receivers.iter().fold(none, |all, receivers| all.or(&range.cut_receivers(receivers)))
    }

    /// The cells in range of a UAV, whether they hold receivers or not; `None` if all are. A cell without a receiver has no elevation, so
    /// that only distance and azimuth leave it out.
    pub fn cells_in_range(&self, uav: &Uav) -> Option<BitGrid> {
        if let Some(curved) = CurvedScene::around(self, uav) {
            return curved.mapper(self).cells_in_range(uav);
        }
        let range = self.range_of(uav);
        let grid = self.field.grid();
        if range.is_everywhere() {
            return None;
        }
        let mut cells = range.cut(&BitGrid::full(grid.n_rows(), grid.n_cols()));
        for receivers in self.receivers.iter().filter(|_| range.limits_elevations()) {
            let in_range = range.cut_receivers(receivers);
            cells = cells.and(&(*receivers.cells).clone().xor(&in_range).complement());
        }
        Some(cells)
    }

    /// Whether the receiver of a row and column is in line of sight, in range or not, by one exact ray; `None` without a
    /// receiver there.
    pub fn is_los(&self, uav: &Uav, (row, col): (usize, usize)) -> Option<bool> {
        if let Some(curved) = CurvedScene::around(self, uav) {
            return curved.mapper(self).is_los(uav, (row, col));
        }
        let (receivers, _) = self.receivers_at((row, col)).next()?;
        let cell = row * self.field.grid().n_cols() + col;
        let receiver = Station { place: self.engine.positions().center(row, col), z: receivers.height(cell) };
        Some(link_los(self.field, &uav.station, &receiver))
    }

    /// The receivers in range, where not all are, and those in line of sight.
    fn decide(&self, engine: &GridLos<'_>, uav: &Uav, (receivers, range): (&GridReceivers<'_>, &Range<'_>)) -> Decided {
        let wanted = (!range.is_everywhere()).then(|| range.cut_receivers(receivers));
        self.decide_wanted(engine, uav, (receivers, range), wanted)
    }

    /// Some receivers in range, and those of them in line of sight; all receivers there are, if `wanted` is `None`.
    fn decide_wanted(
        &self,
        engine: &GridLos<'_>,
        uav: &Uav,
        (receivers, range): (&GridReceivers<'_>, &Range<'_>),
        wanted: Option<BitGrid>,
    ) -> Decided {
        let los = {
            let wanted = wanted.as_ref().unwrap_or(&receivers.cells);
            engine.los(&uav.station, receivers, wanted, range.window())
        };
        (wanted, los)
    }

    /// Maps what a UAV sees.
    ///
    /// Cost: that of the engine (see [`crate::los`]), plus a walk per receiver and solid for layers of heights, of which the
    /// sweep finds margins and ceilings without one. Shared by all threads of the current pool.
    pub fn map(&self, uav: &Uav, control: &Control) -> Result<SiteCoverage> {
        let mut map = self.map_in_parts(uav, control, None, true)?;
        self.add_uncertain(&mut map, control)?;
        Ok(match self.options.window {
            Some(window) => map.cropped(window, self.field.grid().n_cols()),
            None => map,
        })
    }

    /// Maps what a UAV sees, and calls `each_part` with one part of the mask after another, from the north, while others are made. Unless
    /// `keep`, that is all there is of the mask, and there are no layers of heights.
    pub(super) fn map_in_parts(
        &self,
        uav: &Uav,
        control: &Control,
        mut each_part: Option<EachPart<'_>>,
        keep: bool,
    ) -> Result<SiteCoverage> {
        if let Some(curved) = CurvedScene::checked_around(self, uav)? {
            let mut map = curved.mapper(self).map_in_parts(uav, control, each_part, keep)?;
            curved.raise(&mut map, self.told_rows());
            return Ok(map);
        }
        let (n_rows, n_cols) = (self.field.grid().n_rows(), self.field.grid().n_cols());
        let told = self.told_rows();
        let layers = if keep { self.options.layers } else { HeightLayers::default() };
        let range = self.range_of(uav);
        let map =
            OneMap { mapper: self, uav, range: &range, control, heights: CellHeights::new(self.field, uav, layers) };
        // Rows enough for every thread, also of wide grids; all of them where nobody takes parts.
        let n_at_once = match &each_part {
            Some(_) => BAND_CELLS.div_ceil(n_cols).max(8 * rayon::current_num_threads()),
            None => n_rows,
        };
        let mut hand_over = |cells: &[u8]| match &mut each_part {
            Some(each_part) if !map.is_stopped() => each_part(cells),
            _ => {}
        };
        let (decided, found) = map.decide(layers);
        if !keep {
            let fill = |row: usize, mask: &mut [u8]| {
                let (margin, least_height, least_receiver_height) = (&mut [][..], &mut [][..], &mut [][..]);
                map.fill(&decided, &[], row, &mut Row { mask, margin, least_receiver_height, least_height })
            };
            let tally = in_buffers(told, n_cols, n_at_once, fill, &mut hand_over);
            control.check()?;
            return Ok(SiteCoverage::of_tally(uav, tally));
        }
        let (first, n_told) = (told.start, told.len());
        let n_cells = n_told * n_cols;
        let layer = |wanted: bool| if wanted { vec![f32::NAN; n_cells] } else { Vec::new() };
        let mut mask = LargeVec::<u8>::zeroed(n_cells);
        let mut margin = layer(layers.margin);
        let mut least_receiver_height = layer(layers.least_receiver_height);
        let mut least_height = layer(layers.least_height);
        let rows = split(&mut mask, n_told, n_cols)
            .zip(split(&mut margin, n_told, n_cols))
            .zip(split(&mut least_receiver_height, n_told, n_cols))
            .zip(split(&mut least_height, n_told, n_cols))
            .map(|(((mask, margin), least_receiver_height), least_height)| Row {
                mask,
                margin,
                least_receiver_height,
                least_height,
            })
            .enumerate();
        let tally = in_bands(rows, n_at_once, |row, out| map.fill(&decided, &found, first + row, out), &mut hand_over);
        control.check()?;
        let answers = Answers {
            field: self.field,
            engine: &self.engine,
            receivers: &self.receivers,
            options: &self.options,
            heights: self.receiver_heights(),
            uav,
            range: &range,
            decided: &decided,
        };
        let stability = self.roofs.as_ref().map(|roofs| answers.stability(roofs, control)).transpose()?;
        let some = |wanted: bool, values: Vec<f32>| wanted.then_some(values);
        Ok(SiteCoverage {
            mask,
            margin: some(layers.margin, margin),
            least_receiver_height: some(layers.least_receiver_height, least_receiver_height),
            least_height: some(layers.least_height, least_height),
            stability,
            ..SiteCoverage::of_tally(uav, tally)
        })
    }

    /// The rows that are told of: those of the window.
    fn told_rows(&self) -> std::ops::Range<usize> {
        let n_rows = self.field.grid().n_rows();
        self.options.window.map_or(0..n_rows, |window| window.row..window.row + window.n_rows)
    }

    /// The receivers of a cell, on the ground or on the roof.
    pub(super) fn receivers_at(
        &self,
        cell: (usize, usize),
    ) -> impl Iterator<Item = (&GridReceivers<'a>, (usize, usize))> {
        self.receivers.iter().filter(move |r| r.cells.contains(cell.0, cell.1)).map(move |r| (r, cell))
    }

    fn elevations<'b>(&'b self, uav: &Uav, receivers: &'b GridReceivers<'b>, row: usize) -> RowElevations<'b> {
        let grid = self.field.grid();
        RowElevations {
            xs: &self.xs,
            n_cols: grid.n_cols(),
            uav: (uav.station.place.x, uav.station.place.y, uav.station.z),
            y: grid.world_from_cell(row, 0).1,
            meters_per_unit: self.options.meters_per_unit,
            receivers,
            first_cell: row * grid.n_cols(),
        }
    }
}

/// A map that is being made.
struct OneMap<'m, 'a> {
    mapper: &'m Mapper<'a>,
    uav: &'m Uav,
    range: &'m Range<'m>,
    control: &'m Control,
    heights: CellHeights<'m>,
}

impl OneMap<'_, '_> {
    fn is_stopped(&self) -> bool {
        self.control.stop.load(Ordering::Relaxed)
    }

    /// What all receivers come to, kind by kind; and the least heights that are asked for, if the engine finds them at once.
    fn decide(&self, layers: HeightLayers) -> (Vec<Decided>, Vec<FoundHeights>) {
        let Mapper { engine, receivers, .. } = self.mapper;
        let of_kind = |receivers: &GridReceivers<'_>| {
            let mut found = FoundHeights::default();
            let wanted = (!self.range.is_everywhere()).then(|| self.range.cut_receivers(receivers));
            if self.is_stopped() {
                return ((wanted, BitGrid::new(receivers.cells.n_rows(), receivers.cells.n_cols())), found);
            }
            let (uav, cells) = (&self.uav.station, wanted.as_ref().unwrap_or(&receivers.cells));
            if layers.least_height {
                let lowest = i64::from(self.heights.lowest_uav_height());
                found.of_uav = engine.least_uav_heights(uav, cells, lowest, &height_by_cell(receivers));
            }
            let at_once = (layers.margin || layers.least_receiver_height)
                .then(|| engine.los_and_least_heights(uav, receivers, cells, self.range.window()));
            match at_once.flatten() {
                Some((los, heights)) => {
                    found.of_receivers = Some(heights);
                    ((wanted, los), found)
                }
                None => (self.mapper.decide_wanted(engine, self.uav, (receivers, self.range), wanted), found),
            }
        };
        receivers.iter().map(of_kind).unzip()
    }

    /// Fills one row of every output.
    fn fill(&self, decided: &[Decided], found: &[FoundHeights], row: usize, out: &mut Row<'_>) -> Tally {
        let mut tally = Tally::default();
        if self.is_stopped() {
            return tally;
        }
        let mapper = self.mapper;
        let n_cols = mapper.field.grid().n_cols();
        let mut sets = RowSets::new(mapper.field.cells(), row, (self.range, row));
        for (k, (receivers, (wanted, los))) in mapper.receivers.iter().zip(decided).enumerate() {
            let wanted = wanted.as_ref().unwrap_or(&receivers.cells).row(row);
            sets.add(receivers.cells.row(row), wanted, los.row(row));
            tally.add_receivers(&mapper.elevations(self.uav, receivers, row), wanted, los.row(row));
            if let Some(found) = found.get(k) {
                self.heights.fill(out, mapper.engine.positions(), receivers, row, (wanted, los.row(row)), found);
            }
        }
        tally.add_others(&sets, n_cols);
        write_classes(&sets, out.mask);
        self.control.done.fetch_add(n_cols as u64, Ordering::Relaxed);
        tally
    }
}
