//! One UAV against a whole grid of receivers, by whichever engine the scene calls for.

use std::borrow::Cow;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use rayon::prelude::*;

use super::shadow::{PlateauView, plateaus_los_in_view};
use super::{
    OnPlateaus, PlateauScene, ReceiverHeights, ShadowGrid, ShadowScene, SimdLevel, StepLength, UavPositions, link_los,
    r2_los, shadow_los, shadow_los_relief, step_los, sweep_los, xdraw_los,
};
use crate::height_field::{
    Casters, Columns, GridPositions, HeightField, Plateaus, Prisms, StandsOn, Station, TileMaxima,
};
use crate::quantity::LatticePoint;
use crate::raster::{BitGrid, CellWindow, set_bits};

/// Which engine is asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum MethodChoice {
    /// The fastest that is exact on the scene.
    #[default]
    Auto,
    /// A ray per receiver.
    Ray,
    /// The bracketed sweep, for columns.
    Sweep,
    /// Projected shadows, for prisms.
    Shadow,
    /// Samples along a ray, for columns: approximate.
    Step(StepLength),
    /// Slopes interpolated from cell to cell, for columns: approximate.
    Xdraw,
    /// The nearest ray to the perimeter, for columns: approximate.
    R2,
}

/// Which engine decides. All but the last three are exact and give the same cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// A ray per receiver.
    Ray,
    /// The bracketed sweep.
    Sweep,
    /// Projected shadows: of prisms, or of the plateaus of a raster.
    Shadow,
    /// Projected shadows for the prisms, the sweep for the terrain below them.
    ShadowSweep,
    /// Projected shadows for the prisms; a ray per receiver for a terrain on a grid of its own.
    ShadowRay,
    /// Samples along a ray: approximate.
    Step(StepLength),
    /// Slopes interpolated from cell to cell: approximate.
    Xdraw,
    /// The nearest ray to the perimeter: approximate.
    R2,
}

impl std::str::FromStr for MethodChoice {
    type Err = String;

    /// `auto`, `ray`, `sweep`, `shadow`, `step:K` (K in cells), `xdraw` or `r2`.
    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "auto" => return Ok(MethodChoice::Auto),
            "ray" => return Ok(MethodChoice::Ray),
            "sweep" => return Ok(MethodChoice::Sweep),
            "shadow" => return Ok(MethodChoice::Shadow),
            "xdraw" => return Ok(MethodChoice::Xdraw),
            "r2" => return Ok(MethodChoice::R2),
            _ => {}
        }
        let Some(cells) = text.strip_prefix("step:") else {
            return Err(format!("found `{text}`, wanted auto, ray, sweep, shadow, step:K, xdraw or r2"));
        };
        let length = cells.parse().ok().and_then(StepLength::new);
        length
            .map(MethodChoice::Step)
            .ok_or_else(|| format!("found `{text}`, wanted step:K with K from 0.02 to 1000 cells"))
    }
}

impl std::fmt::Display for Method {
    /// The word for it in documents.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.name())
    }
}

/// Why a method cannot be used on a scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct WrongMethod {
    /// What the scene lacks.
    pub why: &'static str,
    /// What to ask for instead.
    pub instead: Method,
}

impl Method {
    /// The method that a choice comes to on a scene, and why.
    ///
    /// # Errors
    /// If the choice names an engine for another kind of scene.
    pub fn choose(field: &HeightField, choice: MethodChoice) -> Result<(Method, &'static str), WrongMethod> {
        let auto = match (field.prisms().is_some(), field.columns().is_some()) {
            (true, false) => (Method::Shadow, "footprints on flat ground: shadows of flat roofs"),
            (true, true) if field.columns_can_be_swept() => {
                (Method::ShadowSweep, "footprints on terrain: shadows for the roofs, one sweep for the terrain")
            }
            (true, true) => (
                Method::ShadowRay,
                "terrain whose cells are not those of the receivers, or not of 1 m or an nth of it: shadows for the roofs, rays \
                 for the terrain",
            ),
            (false, _) if field.plateaus().is_some() => {
                (Method::Shadow, "a raster of few flat blocks: shadows of their roofs")
            }
            (false, _) => (Method::Sweep, "a raster: one sweep over its cells"),
        };
        let is_raster = field.prisms().is_none();
        match (choice, auto.0) {
            (MethodChoice::Auto, _) => Ok(auto),
            (MethodChoice::Ray, _) => Ok((Method::Ray, "asked for")),
            (MethodChoice::Sweep, _) if is_raster => Ok((Method::Sweep, "asked for")),
            (MethodChoice::Step(length), _) if is_raster => Ok((Method::Step(length), "asked for")),
            (MethodChoice::Xdraw, _) if is_raster => Ok((Method::Xdraw, "asked for")),
            (MethodChoice::R2, _) if is_raster => Ok((Method::R2, "asked for")),
            (MethodChoice::Shadow, Method::Shadow | Method::ShadowSweep | Method::ShadowRay) => {
                Ok((auto.0, "asked for"))
            }
            (MethodChoice::Sweep | MethodChoice::Step(_) | MethodChoice::Xdraw | MethodChoice::R2, _) => {
                Err(WrongMethod { why: "footprints are no raster", instead: auto.0 })
            }
            (MethodChoice::Shadow, _) => Err(WrongMethod {
                why: "no raster of few flat blocks on flat ground (of 512 × 512 cells or more)",
                instead: auto.0,
            }),
        }
    }

    /// The word for it in documents.
    pub fn name(self) -> Cow<'static, str> {
        match self {
            Method::Ray => "ray".into(),
            Method::Sweep => "sweep".into(),
            Method::Shadow => "shadow".into(),
            Method::ShadowSweep => "shadow+sweep".into(),
            Method::ShadowRay => "shadow+ray".into(),
            Method::Step(length) => format!("step:{}", length.cells()).into(),
            Method::Xdraw => "xdraw".into(),
            Method::R2 => "r2".into(),
        }
    }

    /// Whether its answer is that of `ray` for every receiver.
    pub fn is_exact(self) -> bool {
        !matches!(self, Method::Step(_) | Method::Xdraw | Method::R2)
    }

    /// `exact` or `approximate`, for captions.
    pub fn exactness(self) -> &'static str {
        if self.is_exact() { "exact" } else { "approximate" }
    }

    /// Its word with what it is worth, for captions: `sweep (exact)`.
    pub fn in_words(self) -> String {
        format!("{self} ({})", self.exactness())
    }
}

/// Receivers of one kind on the cells of a grid, ready for many UAVs.
#[derive(Debug, Clone)]
pub struct GridReceivers<'a> {
    /// The cells that hold one.
    pub cells: Cow<'a, BitGrid>,
    /// What they stand on.
    stands_on: StandsOn<'a>,
    /// How high they are above it \[1/1024 m\].
    above: i32,
    /// The lowest and the highest of `stands_on` over the cells.
    range: (i32, i32),
    /// The highest by tile, once an engine has asked for it.
    tiles: OnceLock<TileMaxima>,
}

impl<'a> GridReceivers<'a> {
    /// Receivers on some cells, `above` \[1/1024 m\] over what they stand on.
    pub fn new(cells: impl Into<Cow<'a, BitGrid>>, stands_on: StandsOn<'a>, above: i32) -> Self {
        let cells = cells.into();
        let range = match &stands_on {
            StandsOn::Flat(z) => (*z, *z),
            StandsOn::Tops(columns) => (columns.min_top(), columns.max_top()),
            StandsOn::Cells(heights) => {
                let n_cols = cells.n_cols();
                let of_row = |row: usize| {
                    let heights = &heights[row * n_cols..(row + 1) * n_cols];
                    cells.row(row).iter().zip(heights.chunks(64)).fold(NO_RANGE, |range, (word, heights)| {
                        // Most words are full or empty.
                        widest(
                            range,
                            match *word {
                                0 => NO_RANGE,
                                u64::MAX => heights.iter().fold(NO_RANGE, |r, z| widest(r, (*z, *z))),
                                word => {
                                    set_bits(&[word]).fold(NO_RANGE, |r, bit| widest(r, (heights[bit], heights[bit])))
                                }
                            },
                        )
                    })
                };
                let (low, high) = (0..cells.n_rows()).into_par_iter().map(of_row).reduce(|| NO_RANGE, widest);
                if low > high { (0, 0) } else { (low, high) }
            }
        };
        GridReceivers { cells, stands_on, above, range, tiles: OnceLock::new() }
    }

    /// Height of what the receiver of a cell stands on \[1/1024 m above the datum\].
    #[inline]
    pub fn base(&self, cell: usize) -> i32 {
        match &self.stands_on {
            StandsOn::Flat(z) => *z,
            StandsOn::Cells(heights) => heights[cell],
            StandsOn::Tops(columns) => columns.top_at(cell),
        }
    }

    /// Copies what receivers stand on in cells of one row, from cell `first` on.
    pub fn copy_bases(&self, first: usize, out: &mut [i32]) {
        match &self.stands_on {
            StandsOn::Flat(z) => out.fill(*z),
            StandsOn::Cells(heights) => out.copy_from_slice(&heights[first..first + out.len()]),
            StandsOn::Tops(columns) => columns.copy_tops(first, out),
        }
    }

    /// Whether receivers stand on the tops of these very columns.
    fn is_on_tops_of(&self, columns: &Columns) -> bool {
        match &self.stands_on {
            StandsOn::Flat(_) => false,
            // What is not held in memory is not compared.
            StandsOn::Cells(heights) => columns.tops_in_memory().is_some_and(|tops| std::ptr::eq(tops, &**heights)),
            StandsOn::Tops(on) => std::ptr::eq(*on, columns),
        }
    }

    /// What the receivers stand on, cell by cell, and how high they are above it \[1/1024 m\]; `None` on flat ground.
    pub fn bases(&self) -> Option<(&[i32], i32)> {
        match &self.stands_on {
            StandsOn::Flat(_) => None,
            StandsOn::Cells(heights) => Some((heights, self.above)),
            StandsOn::Tops(columns) => Some((columns.tops(), self.above)),
        }
    }

    /// The highest of what all cells hold that receivers stand on, by tile; found when it is first asked for.
    fn tiles(&self) -> &TileMaxima {
        // Made outside of the lock: a thread that waits for parts of the work may take up another task, which wants the tiles.
        match self.tiles.get() {
            Some(tiles) => tiles,
            None => {
                let tiles = TileMaxima::of(self.bases().map_or(&[], |(bases, _)| bases), self.cells.n_cols());
                self.tiles.get_or_init(|| tiles)
            }
        }
    }

    /// Bounds on what the receivers stand on, and how high they are above it \[1/1024 m\].
    pub fn range(&self) -> ((i32, i32), i32) {
        (self.range, self.above)
    }

    /// Height of the receiver of a cell \[1/1024 m above the datum\].
    #[inline]
    pub fn height(&self, cell: usize) -> i64 {
        i64::from(self.base(cell)) + i64::from(self.above)
    }

    /// Heights of receivers by row and column \[1/1024 m above the datum\].
    fn heights(&self) -> impl Fn(usize, usize) -> i64 + Sync + '_ {
        let n_cols = self.cells.n_cols();
        move |row, col| self.height(row * n_cols + col)
    }

    /// Height of the lowest receiver; `None` without any.
    pub fn lowest(&self) -> Option<i64> {
        self.cells.words().iter().any(|w| *w != 0).then(|| i64::from(self.range.0) + i64::from(self.above))
    }

    /// The one height of all receivers, if it is one.
    pub fn level(&self) -> Option<i64> {
        (self.range.0 == self.range.1).then(|| i64::from(self.range.0) + i64::from(self.above))
    }
}

/// The range of no heights.
const NO_RANGE: (i32, i32) = (i32::MAX, i32::MIN);

fn widest(a: (i32, i32), b: (i32, i32)) -> (i32, i32) {
    (a.0.min(b.0), a.1.max(b.1))
}

/// An engine with the solids that it works on.
#[derive(Debug, Clone)]
enum Engine<'a> {
    Ray,
    Step(&'a Columns, StepLength),
    Xdraw(&'a Columns),
    R2(&'a Columns),
    Sweep(&'a Columns),
    /// Shadows of the plateaus of columns; where those cannot decide, the sweep.
    Plateaus(&'a Columns, &'a Plateaus, ShadowGrid),
    Shadow(PrismShadows<'a>),
    /// And then the sweep for the terrain below the prisms.
    ShadowSweep(PrismShadows<'a>, &'a Columns),
    /// And then rays, which ask prisms and terrain alike.
    ShadowRay(PrismShadows<'a>),
}

/// Prisms, and where receivers stand among them.
#[derive(Debug, Clone)]
struct PrismShadows<'a> {
    prisms: &'a Prisms,
    grid: ShadowGrid,
}

impl<'a> Engine<'a> {
    /// The engine of a method over the solids of a field.
    fn new(field: &'a HeightField, method: Method, positions: &GridPositions) -> Result<Self, WrongMethod> {
        let shadows = |prisms| {
            let grid = ShadowGrid::new(positions.prisms_xs().collect(), positions.prisms_ys().collect());
            PrismShadows { prisms, grid }
        };
        Ok(match (method, field.prisms(), field.columns()) {
            (Method::Ray, ..) => Engine::Ray,
            (Method::Step(length), None, Some(columns)) => Engine::Step(columns, length),
            (Method::Xdraw, None, Some(columns)) => Engine::Xdraw(columns),
            (Method::R2, None, Some(columns)) => Engine::R2(columns),
            (Method::Sweep, None, Some(columns)) => {
                // What many threads will want is made before they do.
                columns.tiles();
                Engine::Sweep(columns)
            }
            (Method::Shadow, None, Some(columns)) => match field.plateaus() {
                Some(plateaus) => {
                    let grid = ShadowGrid::new(positions.columns_xs().collect(), positions.columns_ys().collect());
                    Engine::Plateaus(columns, plateaus, grid)
                }
                // A raster that was changed may have none any more.
                None => Engine::Sweep(columns),
            },
            (Method::Shadow, Some(prisms), None) => Engine::Shadow(shadows(prisms)),
            (Method::ShadowSweep, Some(prisms), Some(columns)) if field.columns_can_be_swept() => {
                Engine::ShadowSweep(shadows(prisms), columns)
            }
            (Method::ShadowRay, Some(prisms), Some(_)) => Engine::ShadowRay(shadows(prisms)),
            (_, prisms, columns) => {
                let (why, instead) = match (prisms, columns) {
                    (Some(_), None) => ("footprints on flat ground are no raster, and have no terrain", Method::Shadow),
                    (Some(_), Some(_)) => ("footprints on terrain are no raster", Method::ShadowRay),
                    (None, _) => ("a raster has no footprints", Method::Sweep),
                };
                return Err(WrongMethod { why, instead });
            }
        })
    }
}

/// An engine made ready for a scene: what does not depend on the UAV is done once.
#[derive(Debug, Clone)]
pub struct GridLos<'a> {
    field: &'a HeightField,
    method: Method,
    engine: Engine<'a>,
    positions: GridPositions,
    /// What casts shadows, if not all prisms do.
    casters: Option<Arc<Casters>>,
    level: SimdLevel,
    /// Whether shadows are cast in one band of rows, by one thread.
    is_one_band: bool,
    /// What the last UAV that was asked about has in view of plateaus: no result depends on it.
    last_view: Arc<Mutex<Option<Arc<PlateauView>>>>,
}

impl<'a> GridLos<'a> {
    /// Makes ready.
    ///
    /// # Errors
    /// If the method is for another kind of scene; none of those that [`Method::choose`] gives for the field is.
    pub fn new(field: &'a HeightField, method: Method) -> Result<Self, WrongMethod> {
        let positions = field.positions();
        Ok(GridLos {
            field,
            method,
            engine: Engine::new(field, method, &positions)?,
            positions,
            casters: None,
            level: SimdLevel::new(),
            is_one_band: false,
            last_view: Arc::default(),
        })
    }

    /// The same with other vector instructions: no result depends on them.
    #[must_use]
    pub fn with_level(mut self, level: SimdLevel) -> Self {
        self.level = level;
        self
    }

    /// The same with the shadows of each UAV cast by one thread, which costs less in all where many UAVs are decided at
    /// once: no result depends on it.
    #[must_use]
    pub fn in_one_band(mut self) -> Self {
        self.is_one_band = true;
        self
    }

    /// The same with shadows of some casters alone, where no other can hide a receiver that will be asked about.
    #[must_use]
    pub fn with_casters(mut self, casters: Arc<Casters>) -> Self {
        self.casters = Some(casters);
        self
    }

    /// The engine in use.
    pub fn method(&self) -> Method {
        self.method
    }

    /// Positions of the receivers.
    pub fn positions(&self) -> &GridPositions {
        &self.positions
    }

    /// UAV positions over a grid, all at height `z` \[1/1024 m above the datum\], as receivers see them; `None` unless the
    /// engine is `shadow` over prisms alone.
    pub fn uav_positions<'b>(&'b self, grid: &'b ShadowGrid, z: i64) -> Option<UavPositions<'b>> {
        let Engine::Shadow(PrismShadows { prisms, .. }) = &self.engine else { return None };
        let casters = self.casters.as_deref().unwrap_or(prisms.casters());
        Some(UavPositions { prisms, casters, grid, z, level: self.level })
    }

    /// Whether receivers are decided by one level of shadows, or by the shadows of plateaus: at a cost that grows with the
    /// rows that are asked for.
    pub fn is_by_rows(&self, uav: &Station, receivers: &GridReceivers<'_>) -> bool {
        match &self.engine {
            Engine::Shadow(_) => receivers.level().is_some(),
            Engine::Plateaus(columns, plateaus, _) => on_plateaus(columns, plateaus, uav, receivers).is_some(),
            _ => false,
        }
    }

    /// The receivers of `wanted` that are in line of sight of a UAV.
    ///
    /// `wanted` are some of the cells of `receivers`, and `window` holds them, together with all cells between them and
    /// the UAV.
    pub fn los(&self, uav: &Station, receivers: &GridReceivers<'_>, wanted: &BitGrid, window: CellWindow) -> BitGrid {
        match &self.engine {
            Engine::Ray => self.by_rays(uav, receivers, wanted),
            Engine::Step(columns, length) => self.by_links(receivers, wanted, |_, receiver| {
                step_los(columns, uav.on_columns(), receiver.on_columns(), *length)
            }),
            Engine::Xdraw(columns) => xdraw_los(columns, uav.on_columns(), &receivers.heights(), wanted, window),
            Engine::R2(columns) => r2_los(columns, uav.on_columns(), &receivers.heights(), wanted, window),
            Engine::Sweep(columns) => self.by_sweep(columns, uav, receivers, wanted, window),
            Engine::Plateaus(columns, plateaus, grid) => match on_plateaus(columns, plateaus, uav, receivers) {
                Some(on_plateaus) => {
                    let n_bands = self.n_bands();
                    let scene = PlateauScene { columns, plateaus, grid, wanted, window, level: self.level, n_bands };
                    plateaus_los_in_view(&scene, &self.view_of(&scene, uav.on_columns(), on_plateaus))
                }
                None => self.by_sweep(columns, uav, receivers, wanted, window),
            },
            Engine::Shadow(shadows) => self.by_shadows(shadows, uav, receivers, wanted),
            // What the prisms hide need not be asked of the terrain.
            Engine::ShadowSweep(shadows, columns) => {
                let left = self.by_shadows(shadows, uav, receivers, wanted);
                self.by_sweep(columns, uav, receivers, &left, window)
            }
            Engine::ShadowRay(shadows) => {
                let left = self.by_shadows(shadows, uav, receivers, wanted);
                self.by_rays(uav, receivers, &left)
            }
        }
    }

    /// Bands of rows that are worked on side by side.
    fn n_bands(&self) -> usize {
        if self.is_one_band { 1 } else { rayon::current_num_threads() }
    }

    fn by_rays(&self, uav: &Station, receivers: &GridReceivers<'_>, wanted: &BitGrid) -> BitGrid {
        self.by_links(receivers, wanted, |field, receiver| link_los(field, uav, receiver))
    }

    /// The wanted receivers for which `is_los` holds, each asked alone.
    fn by_links(
        &self,
        receivers: &GridReceivers<'_>,
        wanted: &BitGrid,
        is_los: impl Fn(&HeightField, &Station) -> bool + Sync,
    ) -> BitGrid {
        let mut los = wanted.clone();
        let (per_row, n_cols) = (wanted.words_per_row(), wanted.n_cols());
        los.words_mut().par_chunks_mut(per_row).enumerate().for_each(|(row, los)| {
            for col in set_bits(wanted.row(row)) {
                let receiver =
                    Station { place: self.positions.center(row, col), z: receivers.height(row * n_cols + col) };
                if !is_los(self.field, &receiver) {
                    los[col / 64] &= !(1 << (col % 64));
                }
            }
        });
        los
    }

    fn by_sweep(
        &self,
        columns: &Columns,
        uav: &Station,
        receivers: &GridReceivers<'_>,
        wanted: &BitGrid,
        window: CellWindow,
    ) -> BitGrid {
        let (lowest, highest) = receivers.range;
        let above = receivers.above;
        let heights = match receivers.bases() {
            Some((base, _)) if lowest < highest => {
                let tiles = (!std::ptr::eq(base, columns.tops())).then(|| receivers.tiles());
                ReceiverHeights::Over { base, above, lowest, highest, tiles }
            }
            _ => ReceiverHeights::Flat(lowest + above),
        };
        sweep_los(columns, uav.on_columns(), heights, wanted, window, self.level).los
    }

    /// What a UAV has in view of plateaus.
    ///
    /// PERF: a map that is written while it is made is decided strip by strip, so that of the last UAV is kept.
    fn view_of(&self, scene: &PlateauScene<'_>, uav: LatticePoint, receivers: OnPlateaus) -> Arc<PlateauView> {
        let last = self.last_view.lock().unwrap_or_else(PoisonError::into_inner).clone();
        let is_it = |view: &Arc<PlateauView>| (view.uav, view.receivers, view.window) == (uav, receivers, scene.window);
        match last.filter(is_it) {
            Some(view) => view,
            None => {
                let view = Arc::new(PlateauView::new(scene, uav, receivers));
                *self.last_view.lock().unwrap_or_else(PoisonError::into_inner) = Some(Arc::clone(&view));
                view
            }
        }
    }

    fn by_shadows(
        &self,
        PrismShadows { prisms, grid }: &PrismShadows<'_>,
        uav: &Station,
        receivers: &GridReceivers<'_>,
        wanted: &BitGrid,
    ) -> BitGrid {
        let n_bands = self.n_bands();
        let casters = self.casters.as_deref().unwrap_or(prisms.casters());
        let scene = ShadowScene { prisms, casters, grid, wanted, level: self.level, n_bands };
        let n_cols = wanted.n_cols();
        match receivers.level() {
            Some(z) => shadow_los(&scene, uav.on_prisms(), z).los,
            None => {
                let height = |row: usize, col: usize| receivers.base(row * n_cols + col) + receivers.above;
                shadow_los_relief(&scene, uav.on_prisms(), &height).los
            }
        }
    }
}

/// Where receivers stand on plateaus; `None` unless the shadows of these decide.
fn on_plateaus(
    columns: &Columns,
    plateaus: &Plateaus,
    uav: &Station,
    receivers: &GridReceivers<'_>,
) -> Option<OnPlateaus> {
    let on_plateaus = match receivers.level() {
        Some(z) => OnPlateaus::Level(z),
        None => receivers.is_on_tops_of(columns).then_some(OnPlateaus::Above(receivers.above))?,
    };
    // Beside the raster a UAV may be below all of it.
    let lowest = uav.z.min(i64::from(receivers.range.0) + i64::from(receivers.above));
    (lowest >= i64::from(plateaus.lowest())).then_some(on_plateaus)
}
