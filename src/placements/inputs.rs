//! Areas, weights and candidates of a search, read and checked.

use skyshed_io::Input;

use skyshed_request::Whom;

use super::plan::{CandidatesFrom, SearchPlan};
use crate::city::{Area, GivenSite, Source};
use crate::error::{InputError, LimitError, PlacesError, Result, Warning, warned};
use crate::formats::RasterFile;
use crate::height_field::HeightField;
use crate::placement::{CandidateRules, Candidates, PlaceGrid, Spot, Weights};
use crate::quantity::{Height, tidy};
use crate::raster::GeoRef;
use crate::read::{read_area, read_sites};
use crate::read::{refuse_two_crs, source_of};
use crate::scene::Scene;
use crate::uav::bad_rows;
use crate::zones::{Zone, ZoneMap};
use skyshed_io::error::Pair;

/// Most candidates of a search.
const MOST_CANDIDATES: usize = 10_000_000;

/// Contents of the files beside the scene.
#[derive(Debug)]
pub(super) struct Inputs {
    /// Grid of the candidates; `None` if they come from a file.
    pub(super) places: Option<PlaceGrid>,
    /// Places of a file, by number; empty for candidates on a grid.
    pub(super) sites: Vec<GivenSite>,
    /// Heights to try; empty where candidates have their own.
    pub(super) heights: Vec<Height>,
    pub(super) area: Option<Area>,
    pub(super) weights: Option<Weights>,
    pub(super) sources: Vec<Source>,
    spots: Vec<Spot>,
    within: Option<Area>,
    keep_out: Option<Area>,
}

impl Inputs {
    pub(super) fn read(plan: &SearchPlan, scene: &Scene, warnings: &mut Vec<Warning>) -> Result<Inputs> {
        let (grid, heights) = (scene.grid(), plan.heights.clone());
        let area = |input: &Option<Input>| input.as_ref().map(|input| read_area(input, grid)).transpose();
        let refuse_many = |n: usize| LimitError::Candidates { n, most: MOST_CANDIDATES };
        let mut sites: Vec<GivenSite> = Vec::new();
        let (places, spots) = match &plan.from {
            CandidatesFrom::File { input, skips_bad } => {
                sites = warned(warnings, |odd| read_sites(input, grid, 1, bad_rows(*skips_bad, odd)))?;
                let at = |place: usize, level: usize, height: Height| Spot {
                    place,
                    level,
                    x: sites[place].x,
                    y: sites[place].y,
                    height,
                    antenna: sites[place].antenna,
                };
                let own = (0..sites.len()).map(|k| at(k, 0, sites[k].height));
                let spots: Vec<Spot> = if heights.is_empty() {
                    own.collect()
                } else {
                    let each = |level: usize| (0..sites.len()).map(move |k| (k, level));
                    (0..heights.len()).flat_map(each).map(|(k, level)| at(k, level, heights[level])).collect()
                };
                (None, spots)
            }
            CandidatesFrom::Grid { step_m } => {
                let step = step_m / grid.meters_per_unit();
                let places = PlaceGrid::over(grid, step).ok_or_else(|| refuse_many(usize::MAX))?;
                let n = places.grid.n_cells().saturating_mul(heights.len());
                if n > MOST_CANDIDATES {
                    return Err(refuse_many(n).into());
                }
                let spots = places.spots(&heights);
                (Some(places), spots)
            }
        };
        let spots = match plan.shard {
            Some(shard) => shard.part(spots),
            None => spots,
        };
        let read_weights = plan.weights.as_deref().filter(|_| plan.goal.whom == Whom::Weights);
        Ok(Inputs {
            places,
            sites,
            heights,
            area: area(&plan.area)?,
            weights: read_weights.map(|path| warned(warnings, |odd| weights(path, grid, odd))).transpose()?,
            sources: plan.inputs().map(|input| Ok(source_of(&input, plan.hash)?)).collect::<Result<_>>()?,
            spots,
            within: area(&plan.within)?,
            keep_out: area(&plan.keep_out)?,
        })
    }

    /// Returns the rules that candidates must obey.
    pub(super) fn rules<'a>(
        &'a self,
        over: Option<(&'a [Zone], &'a ZoneMap)>,
        clearance: i32,
        radius: Option<f64>,
    ) -> CandidateRules<'a> {
        let (within, keep_out) = (self.within.as_ref(), self.keep_out.as_ref());
        CandidateRules { over, within, keep_out, clearance, radius }
    }

    /// Returns the candidates that obey `rules`. Fails if there is none.
    pub(super) fn candidates(&self, field: &HeightField, rules: &CandidateRules<'_>) -> Result<Candidates> {
        let candidates = Candidates::of(&self.spots, field, rules)?;
        if candidates.kept.is_empty() {
            let reasons: Vec<String> =
                candidates.skipped.reasons().iter().filter(|r| r.1 > 0).map(|(why, n)| format!("{n} {why}")).collect();
            let (total, reasons) = (candidates.skipped.total(), reasons.join(", "));
            return Err(PlacesError::NoCandidate { total, reasons }.into());
        }
        Ok(candidates)
    }
}

/// Reads the weights of receivers from a raster. A receiver gets the value of the raster cell that
/// contains it. It gets 0 outside the raster and on cells without data.
fn weights(path: &std::path::Path, grid: &GeoRef, odd: &mut Vec<skyshed_io::Warning>) -> Result<Weights> {
    let file = RasterFile::open(path, odd)?;
    refuse_two_crs((path.display(), file.georef().crs()), ("the scene", grid.crs()), Pair::WeightsScene)?;
    let raster = file.read(file.georef().window(), odd, |v| v)?;
    if let Some(at) = raster.cells().iter().position(|w| *w < 0.0) {
        let (n_cols, value) = (raster.georef().n_cols(), raster.cells()[at]);
        let (row, col) = (at / n_cols + 1, at % n_cols + 1);
        let why = format!("row {row}, column {col} holds `{}`, wanted 0 or more", tidy(value));
        return Err(InputError::Weights { name: path.display().to_string(), why }.into());
    }
    let from = raster.georef();
    let weight_at = |cell: usize| {
        let (x, y) = grid.world_from_cell(cell / grid.n_cols(), cell % grid.n_cols());
        let (east, north) = from.cells_from_world(x, y);
        if !(east >= 0.0 && north >= 0.0 && east < from.n_cols() as f64 && north < from.n_rows() as f64) {
            return 0.0;
        }
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "inside the raster")]
        let (col, from_south) = (east as usize, north as usize);
        let value = raster.row(from.n_rows() - 1 - from_south)[col];
        if value.is_finite() { value } else { 0.0 }
    };
    let of_cells: Vec<f64> = (0..grid.n_cells()).map(weight_at).collect();
    Weights::new(&of_cells, grid.n_cols()).ok_or_else(|| PlacesError::NoWeights(path.display().to_string()).into())
}
