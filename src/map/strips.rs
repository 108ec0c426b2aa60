//! Map of a raster that does not fit in memory: the same numbers, strip by strip.

use std::path::{Path, PathBuf};
use std::time::Instant;

use skyshed_request::{Layer, Receivers, TiffLayout};

use super::coverages::Coverages;
use super::drawing::MapDrawing;
use super::job::{Done, MapJob};
use super::needs::MapNeeds;
use super::raster_files::add_raster;
use super::report::{MapReport, MaskDigest, SiteFacts};
use super::save_checks::{look_of, mask_values};
use crate::answer::{Answer, Output, Rows, RunFacts, Spent, Timing, add_outputs};
use crate::city::{STRIP_ROWS, Site, WindowedBase, WindowedSolids};
use crate::coverage::{MapOptions, SiteCoverage, StreamedMapper, Uav};
use crate::earth::warn_of_flat_earth;
use crate::error::{Error, LimitError, RequestError, Result, Warning, warned};
use crate::export::{Batch, Format, MapResult, add_mask_geotiff};
use crate::formats::{ClassPyramid, RasterFile};
use crate::height_field::HeightField;
use crate::los::Method;
use crate::memory::{ANY_WORK, bytes_of_cells, cells_of, check_bytes, lacking, memory_words};
use crate::picture::{Look, picture_provenance};
use crate::progress::Progress;
use crate::quantity::MAX_EXTENT_UNITS;
use crate::raster::GeoRef;
use crate::read::StreamedSurface;
use crate::scene::Scene;
use crate::scene::placing::{place_all, warn_of_uavs_outside};
use crate::sight::{check_receivers, warn_of_no_p_los};
use crate::uav::UavsFound;
use crate::words::pretty;

/// Returns the reason why a raster is not read into memory, in words; `None` if it is.
///
/// Strips were requested, or a map takes more than the free memory or than `--max-memory` allows.
pub(crate) fn reason_for_strips(job: &MapJob) -> Option<String> {
    let (grid, bytes) = job.scene.size_of_raster(&job.word)?;
    if job.request.memory.strips {
        return Some("strips are asked for".into());
    }
    let with = |per_cell: f64| lacking(bytes.saturating_add(bytes_of_cells(&grid, per_cell)).saturating_add(ANY_WORK));
    // Bytes of outputs are a reason for strips only where strips can make them.
    let of_outputs = || {
        let is_alone = job.uavs.typed.len() == 1 && job.uavs.table.is_none();
        let per_cell = MapNeeds::of_one(grid.n_cells(), &[Layer::Los], &job.known_outputs()).bytes_per_cell();
        with(per_cell).filter(|_| is_alone && check_strips(job).is_ok())
    };
    let (needed, limit) = with(layer_bytes_per_cell(job, &grid).max(1.0)).or_else(of_outputs)?;
    Some(format!("in memory a map takes {}, more than {limit}", memory_words(needed)))
}

/// Classes of a mask as a picture shows them: the middle cell of each block of `factor` × `factor`
/// cells. So each class keeps its share. The most frequent class of a block would not do that.
struct Shown {
    /// Cells along a side of a block: a power of two, so that rows of tiles hold whole blocks.
    factor: usize,
    /// Columns of the mask.
    n_cols: usize,
    /// Classes of the rows so far.
    classes: Vec<u8>,
}

impl Shown {
    /// Returns the picture of a mask of this grid without any rows.
    fn new(grid: &GeoRef) -> Self {
        const LARGEST: usize = 2048;
        let factor = grid.n_rows().max(grid.n_cols()).div_ceil(LARGEST).next_power_of_two().min(STRIP_ROWS);
        Shown { factor, n_cols: grid.n_cols(), classes: Vec::new() }
    }

    /// Adds the next rows.
    fn add(&mut self, mask: &[u8]) {
        let (factor, n_cols) = (self.factor, self.n_cols);
        for rows in mask.chunks(factor * n_cols) {
            let row = (factor / 2).min(rows.len() / n_cols - 1);
            let cols = (0..n_cols.div_ceil(factor)).map(|col| (col * factor + factor / 2).min(n_cols - 1));
            self.classes.extend(cols.map(|col| rows[row * n_cols + col]));
        }
    }
}

/// Copies a raster that does not fit in memory to tiles on the disk, and notes that.
pub(crate) fn on_disk(job: &MapJob, progress: &Progress, warnings: &mut Vec<Warning>) -> Result<StreamedSurface> {
    let scratch = job.request.memory.scratch.clone().map_or_else(std::env::temp_dir, PathBuf::from);
    if !scratch.is_dir() {
        return Err(RequestError::Scratch(scratch.display().to_string()).into());
    }
    let options = job.scene.of_raster()?;
    let files = terrain_file(job)?.into_iter().chain([RasterFile::open(job.path(), &mut Vec::new())?]);
    let on_disk = files.map(|file| StreamedSurface::bytes_on_disk(&job.scene.grid_of(&file))).sum();
    let (on_disk, folder) = (memory_words(on_disk), scratch.display());
    let why = reason_for_strips(job).unwrap_or_else(|| "parts of it cannot be read alone".into());
    (progress.note)(&format!("{why}: heights go to {on_disk} of tiles in {folder}"));
    let scene = warned(warnings, |odd| StreamedSurface::read(job.path(), &options, &scratch, odd))?;
    job.scene.warn_of_raster(job.path(), warnings)?;
    Ok(scene)
}

/// Refuses maps that strips cannot make, before anything is copied. This includes maps that do not
/// fit in memory even so.
pub(crate) fn check_strips(job: &MapJob) -> Result<()> {
    let refuse = |what| {
        Err(LimitError::Strips { word: job.word.display().to_string(), what, are_asked: job.request.memory.strips }
            .into())
    };
    let formats = job.outputs.iter().map(|path| Ok(Format::of(path)?)).collect::<Result<Vec<_>>>()?;
    for (path, format) in job.outputs.iter().zip(&formats) {
        let is_made = matches!(format, Format::GeoTiff | Format::Csv | Format::Json | Format::GeoJson | Format::Stdout)
            || format.is_picture();
        if !is_made {
            return refuse(format!("{} cannot be made", path.display()));
        }
    }
    let is_made = |layer: &Layer| matches!(layer, Layer::Los | Layer::Margin | Layer::LeastReceiverHeight);
    if let Some(layer) = job.plan.layers.iter().find(|layer| !is_made(layer)) {
        return refuse(format!("the layer `{}` cannot be made", layer.name()));
    }
    if job.plan.layers[0] != Layer::Los && formats.iter().any(|format| format.is_picture()) {
        return refuse("no picture but of `los` can be made".into());
    }
    let asked = [
        ("a tolerance", job.plan.tolerance.is_some()),
        ("intervals of errors of heights", job.plan.heights.are_any()),
        ("counts by zone", job.plan.tells_zones),
        ("a height curve", job.curve.is_wanted()),
        ("counts over time", job.over_time.is_wanted()),
        ("polygons of coverage", job.save.forms.polygons.is_some()),
        ("a picture of cells alone", job.save.forms.bare),
        ("the plain layout of a GeoTIFF", job.save.forms.tif_layout == Some(TiffLayout::Plain)),
        ("receivers of one zone", job.plan.sight.receivers().zone().is_some()),
    ];
    if let Some((what, _)) = asked.iter().find(|(_, is_asked)| *is_asked) {
        return refuse(format!("{what} cannot be made"));
    }
    let file = RasterFile::open(job.path(), &mut Vec::new())?;
    let what = format!("{}, even strip by strip,", cells_of(&job.scene.grid_of(&file)));
    check_bytes(&job.word.display(), &what, strip_memory(job)?)
}

/// Returns the bytes per cell of layers of heights with the mask beside them; 0 without such
/// layers. They stay whole while they are made and written.
fn layer_bytes_per_cell(job: &MapJob, grid: &GeoRef) -> f64 {
    let layers = &job.plan.layers;
    let is_any = layers.iter().any(|layer| layer.is_measure());
    if is_any { MapNeeds::of_one(grid.n_cells(), layers, &job.known_outputs()).bytes_per_cell() } else { 0.0 }
}

/// Bytes that the sweep remembers for each cell of the longer side. Over a generated city of 16384²
/// cells it took 6.4 kB.
const REMEMBERED_BYTES: u64 = 8 << 10;

/// Bytes of a picture for each of its pixels: a scene with larger cells, its classes, and colors.
const BYTES_PER_PIXEL: u64 = 28;

/// Returns the bytes that strips and the rows remembered by the sweep take.
///
/// # Errors
/// E501 if the grid is larger than a lattice.
fn strip_memory(job: &MapJob) -> Result<u64> {
    let file = RasterFile::open(job.path(), &mut Vec::new())?;
    let grid = job.scene.grid_of(&file);
    let (n_rows, n_cols, n_cells) = (grid.n_rows(), grid.n_cols(), grid.n_cells() as u64);
    if n_rows.max(n_cols) as f64 > MAX_EXTENT_UNITS {
        return Err(LimitError::LargeRaster { word: job.word.display().to_string(), n_cols, n_rows }.into());
    }
    let n_kinds = if job.plan.sight.receivers() == Receivers::All { 2 } else { 1 };
    let n_sets = n_kinds * if job.plan.sight.radius_m().is_some() { 3 } else { 2 };
    // Cells of the terrain below one cell of the surface.
    let finer = match terrain_file(job)? {
        Some(terrain) => {
            let below = terrain.georef();
            (grid.cell_width() * grid.cell_height() / (below.cell_width() * below.cell_height())).max(1.0)
        }
        None => 0.0,
    };
    // A strip as it is read, as lines, and as it is written, with the terrain below it; then the
    // tiles of a GeoTIFF.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "an estimate")]
    let strips = ((4.0 + finer) * (4 * STRIP_ROWS * n_rows.max(n_cols)) as f64) as u64;
    let remembered = REMEMBERED_BYTES * n_rows.max(n_cols) as u64;
    let draws = job.outputs.iter().any(|path| Format::of(path).is_ok_and(Format::is_picture));
    let n_pixels = if draws { grid.coarser(Shown::new(&grid).factor).n_cells() as u64 } else { 0 };
    Ok(n_cells / 8 * n_sets
        + n_pixels * BYTES_PER_PIXEL
        + bytes_of_cells(&grid, layer_bytes_per_cell(job, &grid))
        + strips
        + remembered
        + n_cells / 64
        + file.block_bytes()
        + ANY_WORK)
}

/// Opens the terrain, if there is one.
fn terrain_file(job: &MapJob) -> Result<Option<RasterFile>> {
    Ok(job.scene.options.terrain.as_deref().map(|path| RasterFile::open(path, &mut Vec::new())).transpose()?)
}

/// Checked run of a map strip by strip.
pub(crate) struct StripsRun<'a> {
    pub(crate) job: &'a MapJob,
    pub(crate) outputs: &'a [Output],
    pub(crate) start: Instant,
    /// Hash of the unit of work that this run performs; `None` for a run that is no unit.
    pub(crate) unit: Option<String>,
    pub(crate) progress: &'a Progress,
}

impl StripsRun<'_> {
    /// Copies the heights to the disk, then maps.
    pub(crate) fn read(self, uavs: impl FnOnce(&GeoRef) -> Result<UavsFound>) -> Result<Done> {
        check_strips(self.job)?;
        let mut warnings: Vec<Warning> = Vec::new();
        let scene = on_disk(self.job, self.progress, &mut warnings)?;
        self.over(&scene, warnings, uavs)
    }

    /// Makes the map and writes its files.
    pub(crate) fn over(
        self,
        scene: &StreamedSurface,
        mut warnings: Vec<Warning>,
        uavs: impl FnOnce(&GeoRef) -> Result<UavsFound>,
    ) -> Result<Done> {
        let (plan, progress) = (&self.job.plan, self.progress);
        let grid = scene.grid();
        let mut timing = Timing { read: self.start.elapsed().as_secs_f64(), ..Timing::default() };
        let radius = plan.sight.radius_on(grid);
        let found = uavs(grid)?;
        warnings.extend(found.warnings.iter().cloned());
        warn_of_uavs_outside(&found.sites, grid, &mut warnings);
        let uav = self.uav(scene, (&found, radius), &mut warnings)?;
        check_receivers(plan.sight.receivers(), scene.base() == WindowedBase::Surface)?;
        warn_of_flat_earth(std::slice::from_ref(&uav), grid, &plan.sight, &mut warnings);

        let options = MapOptions { layers: plan.height_layers(), ..plan.sight.options(grid, None) };
        let n_kinds = if plan.sight.receivers() == Receivers::All { 2 } else { 1 };
        progress.begin(grid.n_cells() as u64 * n_kinds);
        let before_los = Instant::now();
        let has_tif = self.outputs.iter().any(|(_, format)| *format == Format::GeoTiff);
        let mut beside_layers = Vec::new();
        let has_layers = plan.layers.iter().any(|layer| layer.is_measure());
        let mask_values = mask_values(&self.job.save);
        let mut pyramid = ClassPyramid::new((grid.n_rows(), grid.n_cols()));
        let mut digest = MaskDigest::new(grid);
        let mut shown = self.has_picture().then(|| Shown::new(grid));
        let mapper = StreamedMapper::new(scene, &options, progress.control())?;
        let mut coverage = mapper.map(&uav, progress.control(), |_, mask| {
            digest.add(mask);
            if let Some(shown) = &mut shown {
                shown.add(mask);
            }
            if has_tif && has_layers {
                beside_layers.extend_from_slice(mask);
                return Ok(());
            }
            if has_tif { Ok(pyramid.push(&mask_values.of(mask))?) } else { Ok(()) }
        })?;
        coverage.mask = beside_layers.into();
        progress.end();
        timing.los = before_los.elapsed().as_secs_f64();

        let tally = (coverage.uav.id.as_str(), &coverage.tally);
        warn_of_no_p_los("UAV", std::iter::once(tally), &mut warnings);
        let report = MapReport {
            facts: RunFacts {
                command: self.job.command.clone(),
                method: Some(Method::Sweep),
                scene_name: scene.name.clone(),
                grid: grid.clone(),
                sources: [scene.sources.clone(), found.sources].concat(),
                seed: None,
                warnings,
                unit: self.unit.clone(),
            },
            sight: plan.sight,
            union_zones: None,
            sites: vec![SiteFacts { lonlat: found.sites[0].lonlat, ..SiteFacts::of(&coverage, None) }],
            union: coverage.tally,
            heights: plan.heights,
            tolerance: None,
            tile: None,
            span: None,
            idle: None,
            digest: digest.finish(),
        };
        let before_write = Instant::now();
        (progress.begin_writing)();
        let batch = Batch::new(self.job.save.writing.overwrite).asking(progress.check);
        let mut batch = batch.sealing(self.unit.is_some());
        let spent = Spent { write: 0.0, total: self.start.elapsed().as_secs_f64() };
        let files = StripFiles { run: &self, scene, report: &report, timing, coverage: &coverage, pyramid, shown };
        add_outputs(&files, &mut batch, self.outputs, (&look_of(&self.job.save), spent))?;
        let written = batch.commit()?;
        timing.write = before_write.elapsed().as_secs_f64();
        timing.total = self.start.elapsed().as_secs_f64();
        Ok(Done::of(report, timing, WHY, (None, None), written))
    }

    fn has_picture(&self) -> bool {
        self.outputs.iter().any(|(_, format)| format.is_picture())
    }

    /// Places the one UAV of the run.
    fn uav(
        &self,
        scene: &StreamedSurface,
        (found, radius): (&UavsFound, Option<f64>),
        warnings: &mut Vec<Warning>,
    ) -> Result<Uav> {
        if found.sites.len() != 1 {
            let n = found.sites.len();
            return Err(LimitError::StripsOfMany { word: self.job.word.display().to_string(), n }.into());
        }
        if found.home.is_some() {
            return Err(Error::idle("strips", "for a mission whose heights are above its home"));
        }
        let place = |site: &Site| Ok(Uav::place_streamed(site, scene, radius)?);
        place_all(found, place, warnings)?.pop().ok_or(Error::fault("no UAV is left of one"))
    }
}

/// Reason for the method of strips, in words.
const WHY: &str = "strip by strip";

/// Inputs of the files of a map made strip by strip.
struct StripFiles<'a> {
    run: &'a StripsRun<'a>,
    scene: &'a StreamedSurface,
    report: &'a MapReport,
    timing: Timing,
    coverage: &'a SiteCoverage,
    pyramid: ClassPyramid,
    shown: Option<Shown>,
}

impl Answer for StripFiles<'_> {
    fn document(&self, spent: Option<Spent>) -> serde_json::Value {
        self.report.document(spent.map(|spent| self.timing.with(spent)))
    }

    fn table(&self) -> Rows {
        self.report.table()
    }

    fn add(&self, batch: &mut Batch, path: &Path, format: Format, look: &Look) -> Result<()> {
        match (format, &self.shown) {
            (Format::GeoTiff, _) if !self.coverage.mask.is_empty() => {
                let provenance = self.provenance().to_string();
                let result = MapResult {
                    georef: self.scene.grid(),
                    sites: std::slice::from_ref(self.coverage),
                    n_uavs: 1,
                    overlay: None,
                    layers: &self.run.job.plan.layers,
                    provenance: &provenance,
                    tif_layout: TiffLayout::default(),
                    mask_values: mask_values(&self.run.job.save),
                };
                add_raster(batch, &result, path, format)
            }
            (Format::GeoTiff, _) => {
                let provenance = self.provenance().to_string();
                let of = (self.scene.grid(), self.coverage.uav.id.as_str(), provenance.as_str());
                Ok(add_mask_geotiff(batch, path, &self.pyramid, of, mask_values(&self.run.job.save))?)
            }
            (Format::GeoJson, _) => Ok(batch.add(path, pretty(&self.report.geojson()).as_bytes())?),
            (_, Some(shown)) if format.is_picture() => Ok(batch.add(path, &self.picture(shown, format, look)?)?),
            _ => Ok(()),
        }
    }
}

impl StripFiles<'_> {
    /// Draws the picture over a scene with larger cells: the highest surface in each, and the
    /// classes `shown`.
    fn picture(&self, shown: &Shown, format: Format, look: &Look) -> Result<Vec<u8>> {
        let StripFiles { scene: surface, report, coverage, .. } = *self;
        let factor = shown.factor;
        let grid = surface.grid().coarser(factor);
        let field = HeightField::build(&grid, surface.highest(factor)?).field;
        let map = Coverages {
            scene: Scene::of_field(surface.name.clone(), field, report.facts.warnings.clone()),
            sites: vec![SiteCoverage::of_mask(&coverage.uav, shown.classes.clone().into(), coverage.tally)],
            overlay: None,
            layers: vec![Layer::Los],
            report: report.clone(),
            why: WHY,
            options: MapOptions::default(),
        };
        let drawing = MapDrawing {
            of: &map,
            look,
            counts: Some(coverage.tally),
            note: (factor > 1).then(|| {
                format!("Drawn smaller: a pixel shows one of {factor} × {factor} cells, the counts are those of all")
            }),
        };
        drawing.draw(format, &picture_provenance(&report.document(None)))
    }
}
