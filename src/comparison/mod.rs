//! Comparison of placements: their maps, the differences between them, and the clarity of these
//! differences.

mod document;
mod facts;
mod figure;
mod live_door;
mod masks;
mod outcome;
mod report;
mod tables;

pub(crate) use document::{CompareDocument, CompareRow};

use std::path::{Path, PathBuf};
use std::time::Instant;

use serde_json::{Map, Value};
use skyshed_request::{CompareOptions, HeightErrors, SceneOptions, Sight, filled, json};

use figure::Figure;
use masks::{SavedMask, Setting, read_masks};
pub(crate) use outcome::Comparison;
use report::CompareReport;
use tables::{Tables, margin_facts, pairs_of, tables};

use crate::answer::{Answer, CommandFacts, Rows, RunFacts, Spent};
use crate::city_statistics::bootstrap::RatioEstimate;
use crate::coverage::{
    CellGroups, KeepMasks, Mapper, MarginSample, Overlay, RedrawnCounts, SiteCoverage, Tally, Together, count_sets,
    is_nodata_below,
};
use crate::error::{Error, LimitError, PlacesError, RequestError, Result, Warning};
use crate::export::{self, Batch, Format, add_comparison};
use crate::height_errors::{HeightErrorsPlan, HeightsOfDifference};
use crate::los::Method;
use crate::map::{MaskDigest, SiteFacts};
use crate::memory::Needs;
use crate::picture::{Look, drawn, picture_provenance, written};
use crate::progress::Progress;
use crate::raster::{CellBlocks, LargeVec};
use crate::read::source_of;
use crate::render;
use crate::scene::Scene;
use crate::sight::{SightPlan, warn_of_no_p_los};
use crate::uav::UavsFound;
use crate::words::p_los_words;
use crate::zones::{NONE, ZoneMap};
use facts::{IntervalFacts, Origin, PairFacts, PlacementFacts};

/// Output formats of a comparison.
pub(crate) const FORMATS: [Format; 8] =
    [Format::Html, Format::Png, Format::Svg, Format::Pdf, Format::GeoTiff, Format::Csv, Format::Json, Format::Stdout];

/// Most placements: the number of their pairs grows with the square.
const MOST_PLACEMENTS: usize = 16;
/// Most blocks of ground: each is drawn a thousand times.
const MOST_BLOCKS: usize = 1 << 16;
/// Sampled receivers for each placement, whose margins are computed.
const MARGIN_SAMPLE: usize = 1 << 16;
/// Confidence of the intervals.
const CONFIDENCE: f64 = 0.95;
/// Plan of a comparison.
#[derive(Debug)]
pub(crate) struct ComparisonPlan {
    pub(crate) sight: SightPlan,
    /// Standard deviations of building height errors.
    pub(crate) heights: HeightErrorsPlan,
    /// Files with masks of earlier runs.
    pub(crate) masks: Vec<PathBuf>,
    /// `true` if these files are hashed, however large they are.
    pub(crate) hash: bool,
    /// Edge of the blocks of ground that are resampled \[m\].
    pub(crate) block_m: f64,
    /// Seed of the resampling.
    pub(crate) seed: u64,
    /// `true` if a raster of all pairs is written.
    pub(crate) draws_pairs: bool,
    /// Words of the scene and of its options, for the live page of a scene whose solids were kept.
    pub(crate) scene_words: Vec<String>,
}

impl ComparisonPlan {
    /// Fills in the defaults of a question over a scene that is read with some options.
    ///
    /// # Errors
    /// E113.
    pub(crate) fn of(
        (sight, heights): (&Sight, &HeightErrors),
        compare: &CompareOptions,
        reading: &SceneOptions,
    ) -> Result<ComparisonPlan> {
        let plan = ComparisonPlan {
            sight: SightPlan::of(sight)?,
            heights: HeightErrorsPlan::of(heights, None)?,
            masks: compare.mask.iter().map(|path| path.0.clone()).collect(),
            hash: reading.hash,
            block_m: filled(compare.block, CompareOptions::defaults().block),
            seed: reading.seed_or_default(),
            scene_words: Vec::new(),
            draws_pairs: true,
        };
        plan.check()?;
        Ok(plan)
    }
}

/// A mask and its origin.
struct Placed {
    id: String,
    origin: Origin,
    mask: LargeVec<u8>,
    tally: Tally,
    margins: Option<MarginSample>,
}

/// Maps of the UAVs, their engine, and their counts with heights redrawn.
struct Mapped {
    placed: Vec<Placed>,
    method: Option<Method>,
    redrawn: Option<RedrawnCounts>,
}

/// Refuses errors of heights without two UAVs to map. `members` are those of the request that are set.
///
/// # Errors
/// E116.
pub(crate) fn check_heights(members: &Map<String, Value>, n_uavs: usize) -> Result<()> {
    const OPTIONS: [&str; 3] = ["height_error", "height_bias", "height_error_field"];
    match n_uavs < 2 {
        true => Ok(json::refuse(members, &OPTIONS, "without two UAVs: saved maps are not made anew")?),
        false => Ok(()),
    }
}

/// Checks the number of placements. A comparison needs two, and becomes unclear above a limit.
///
/// # Errors
/// E108, E502.
pub(crate) fn check_number(n: usize) -> Result<()> {
    match n {
        0 | 1 => Err(RequestError::TooFewToCompare(n).into()),
        n if n > MOST_PLACEMENTS => Err(LimitError::Placements { n, most: MOST_PLACEMENTS }.into()),
        _ => Ok(()),
    }
}

impl ComparisonPlan {
    /// Checks the numbers, before any work.
    ///
    /// # Errors
    /// E113.
    pub(crate) fn check(&self) -> Result<()> {
        if self.block_m <= 0.0 {
            return Err(Error::number("the edge of blocks", self.block_m, "above 0 m"));
        }
        Ok(())
    }

    /// Maps the UAVs, reads the saved masks, and compares all of them.
    ///
    /// # Errors
    /// E2xx for UAVs that cannot be there; errors of the files; E108 for fewer than two placements;
    /// E502 for too many placements or blocks.
    pub(crate) fn compare(
        &self,
        mut scene: Scene,
        found: &UavsFound,
        command: CommandFacts,
        progress: &Progress,
    ) -> Result<Comparison> {
        self.check()?;
        let uavs = scene.place(found, None, &self.sight)?;
        let grid = scene.grid().clone();
        let blocks = CellBlocks::new(&grid, grid.meters_per_unit(), self.block_m);
        if blocks.count() > MOST_BLOCKS {
            return Err(LimitError::Blocks { n: blocks.count(), edge_m: self.block_m, most: MOST_BLOCKS }.into());
        }
        let n_bands = if self.draws_pairs { pairs_of(uavs.len()).len() + 1 } else { 0 };
        Needs::of_comparison(uavs.len() + self.masks.len() + n_bands).check(&scene)?;
        let zones = scene.zones()?;
        let before_los = Instant::now();
        let Mapped { mut placed, method, redrawn } = self.mapped(&scene, zones.as_deref(), (found, &uavs), progress)?;
        scene.timing.los = before_los.elapsed().as_secs_f64();
        for path in &self.masks {
            placed.extend(self.saved(path, &mut scene)?);
        }
        check_number(placed.len())?;
        check_ids(&placed)?;
        warn_of_no_p_los("placement", placed.iter().map(|p| (p.id.as_str(), &p.tally)), &mut scene.warnings);
        let facts = RunFacts { command, ..scene.facts(method) };
        let heights = self.heights.over(&scene.field);
        let (overlay, mut report) = self.report((facts, heights), &placed, &blocks, zones.as_deref());
        if let Some(redrawn) = &redrawn {
            // Saved masks are not redrawn, and come last.
            for pair in report.pairs.iter_mut().filter(|pair| pair.first.max(pair.second) < uavs.len()) {
                let is_known = pair.groups[0].difference.value.is_some();
                pair.heights = HeightsOfDifference::of(redrawn, (pair.first, pair.second)).filter(|_| is_known);
            }
        }
        let masks = placed.into_iter().map(|p| p.mask).collect();
        let asked = found.sites.iter().map(|given| given.site.clone()).collect();
        Ok(Comparison { scene, masks, overlay, report, uavs: asked, scene_words: self.scene_words.clone() })
    }

    fn report(
        &self,
        (facts, heights): (RunFacts, HeightErrorsPlan),
        placed: &[Placed],
        blocks: &CellBlocks,
        zones: Option<&ZoneMap>,
    ) -> (Overlay, CompareReport) {
        let grid = &facts.grid;
        let masks: Vec<&[u8]> = placed.iter().map(|p| p.mask.as_slice()).collect();
        let mut overlay = Overlay::new(grid.n_cells());
        masks.iter().for_each(|mask| overlay.add(mask));
        let intervals = IntervalFacts { confidence: CONFIDENCE, block_m: self.block_m, seed: self.seed };
        let no_zones = if zones.is_none() { vec![NONE; grid.n_cells()] } else { Vec::new() };
        let codes = zones.map_or(no_zones.as_slice(), ZoneMap::codes);
        let cells = CellGroups { blocks, groups: codes, n_cols: grid.n_cols() };
        let Tables { mut shares, differences } = tables(&masks, &cells, &intervals);
        let mut pairs: Vec<_> = pairs_of(placed.len()).into_iter().zip(differences).collect();
        // A UAV over no data has counts, but no P_LoS.
        let is_unknown = |k: usize| placed[k].tally.is_over_nodata;
        let of_unknown = |estimate: &mut RatioEstimate| (estimate.value, estimate.interval) = (None, None);
        for k in (0..placed.len()).filter(|k| is_unknown(*k)) {
            shares[k].iter_mut().for_each(|group| of_unknown(&mut group.p_los));
        }
        for (_, groups) in pairs.iter_mut().filter(|((a, b), _)| is_unknown(*a) || is_unknown(*b)) {
            groups.iter_mut().for_each(|group| of_unknown(&mut group.difference));
        }
        let mut union = Tally::of_mask(overlay.union());
        union.is_over_nodata = (0..placed.len()).any(is_unknown);
        let placement = |(p, groups): (&Placed, _)| PlacementFacts {
            id: p.id.clone(),
            origin: p.origin.clone(),
            tally: p.tally,
            groups,
            margins: p.margins.as_ref().map(|sample| margin_facts(sample, codes)),
        };
        let report = CompareReport {
            sight: self.sight,
            intervals,
            has_zones: zones.is_some(),
            placements: placed.iter().zip(shares).map(placement).collect(),
            pairs: pairs
                .into_iter()
                .map(|((first, second), groups)| PairFacts { first, second, groups, heights: None })
                .collect(),
            heights,
            union,
            seen_by: overlay.seen_by(placed.len()),
            sets: count_sets(&masks),
            digest: MaskDigest::of(grid, masks.iter().copied()),
            facts,
        };
        (overlay, report)
    }

    /// Maps the UAVs and samples margins of their receivers. The method is `None` without UAVs.
    fn mapped(
        &self,
        scene: &Scene,
        zones: Option<&ZoneMap>,
        (found, uavs): (&UavsFound, &[crate::coverage::Uav]),
        progress: &Progress,
    ) -> Result<Mapped> {
        if uavs.is_empty() {
            return Ok(Mapped { placed: Vec::new(), method: None, redrawn: None });
        }
        let options = self.sight.options(scene.grid(), zones);
        let mut mapper = Mapper::new(&scene.field, &options)?;
        mapper.drop_idle(uavs);
        progress.begin(scene.grid().n_cells() as u64 * uavs.len() as u64);
        let maps = mapper.map_many(uavs, (KeepMasks::Always, &Together::default()), progress.control(), |_| {}, |_| {});
        progress.end();
        let placed = |site: SiteCoverage| {
            let lonlat = found.lonlat_of(&site.uav.id);
            Ok(Placed {
                id: site.uav.id.clone(),
                origin: Origin::Uav(Box::new(SiteFacts { lonlat, ..SiteFacts::of(&site, zones) })),
                margins: Some(mapper.seen_from(&site.uav)?.margin_sample(&site, MARGIN_SAMPLE)),
                tally: site.tally,
                mask: site.mask,
            })
        };
        let placed = maps?.sites.into_iter().map(placed).collect::<Result<_>>()?;
        let redrawn = self.heights.over(&scene.field).redrawn(&mapper, uavs, progress)?;
        Ok(Mapped { placed, method: Some(mapper.method().0), redrawn })
    }

    /// Returns the placements of a file of masks. The file becomes a source of the run.
    fn saved(&self, path: &Path, scene: &mut Scene) -> Result<Vec<Placed>> {
        let setting = Setting { scene: Path::new(&scene.word), grid: scene.field.grid(), sight: &self.sight };
        let masks = read_masks(path, &setting, &mut scene.warnings)?;
        scene.sources.push(source_of(path, self.hash)?);
        let field = &scene.field;
        let tally_of = |saved: &SavedMask| {
            let mut tally = Tally::of_mask(&saved.mask);
            tally.is_over_nodata =
                saved.place.is_some_and(|at| is_nodata_below(&field.place(at.x, at.y), field, field.grid()));
            tally
        };
        let placed = masks.into_iter().map(|saved| Placed {
            tally: tally_of(&saved),
            id: saved.id,
            origin: Origin::File { path: saved.path, place: saved.place },
            mask: saved.mask,
            margins: None,
        });
        Ok(placed.collect())
    }
}

fn check_ids(placed: &[Placed]) -> Result<()> {
    let mut seen = std::collections::HashSet::new();
    match placed.iter().find(|p| !seen.insert(&p.id)) {
        Some(twice) => Err(PlacesError::Twice { what: "placements", id: twice.id.clone() }.into()),
        None => Ok(()),
    }
}

impl Answer for Comparison {
    fn document(&self, spent: Option<Spent>) -> Value {
        self.report.document(spent.map(|spent| self.scene.timing.with(spent)))
    }

    fn table(&self) -> Rows {
        self.report.table()
    }

    fn warnings(&self) -> &[Warning] {
        &self.report.facts.warnings
    }

    fn notes(&self, spent: Spent) -> Vec<String> {
        let report = &self.report;
        let of = |p: &PlacementFacts| {
            let share = p_los_words(p.tally.p_los());
            format!("{}: P_LoS {share}, {} of {} receivers", p.id, p.tally.los, p.tally.receivers)
        };
        let (method, los) = (report.facts.method_in_words(), self.scene.timing.los);
        let last = format!("method {method}: line of sight {los:.3} s of {:.2} s", spent.total);
        let pairs = report.pairs.iter().map(|pair| report.sentence(pair));
        std::iter::once(report.verdict()).chain(report.placements.iter().map(of)).chain(pairs).chain([last]).collect()
    }

    fn add(&self, batch: &mut Batch, path: &Path, format: Format, look: &Look) -> Result<()> {
        let provenance = self.provenance();
        match format {
            Format::GeoTiff => {
                let ids: Vec<&str> = self.report.placements.iter().map(|p| p.id.as_str()).collect();
                let pairs: Vec<(usize, usize)> = self.report.pairs.iter().map(|p| (p.first, p.second)).collect();
                let masks: Vec<&[u8]> = self.masks.iter().map(LargeVec::as_slice).collect();
                let comparison = export::Comparison {
                    georef: self.scene.grid(),
                    ids: &ids,
                    masks: &masks,
                    pairs: &pairs,
                    overlay: &self.overlay,
                    provenance: &provenance.to_string(),
                };
                add_comparison(batch, &comparison, path)?;
                let style = render::qgis_style(render::FirstBand::Mask);
                Ok(batch.add(&path.with_extension("qml"), style.as_bytes())?)
            }
            Format::Html => {
                let live = self.live(look);
                let page = Figure::new(self, look).page(&provenance, live.as_ref());
                Ok(batch.add(path, &drawn(page.map(String::into_bytes))?)?)
            }
            _ => {
                let provenance = picture_provenance(&provenance);
                let figure = Figure::new(self, look);
                let sheet = figure.with_sheet(render::draw_compare_sheet);
                Ok(batch.add(path, &written(sheet, &look.form(format), &provenance)?)?)
            }
        }
    }
}
