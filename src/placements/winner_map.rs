//! Coverage map of the winner, or of the UAVs chosen together.

use std::path::Path;

use skyshed_request::{Layer, TiffLayout, Whom};

use super::Placements;
use crate::answer::Answer;
use crate::coverage::{ManyMaps, Overlay, Tally};
use crate::error::{PlacesError, Result};
use crate::export::{Batch, Format, MapResult, MaskValues};
use crate::map::{SiteFacts, add_raster};
use crate::picture::{Look, mark, picture_provenance, shown_classes, written};
use crate::render::{self, MapPicture, Mark, grouped};
use crate::words::unbreakable;

/// Adds the map of the winners to a batch.
///
/// # Errors
/// E209 without a winner.
pub(super) fn add(job: &Placements, batch: &mut Batch, path: &Path, format: Format, look: &Look) -> Result<()> {
    let Some(maps) = &job.winner_maps else {
        return Err(PlacesError::NoWinner(path.display().to_string()).into());
    };
    if format != Format::GeoTiff {
        return Ok(batch.add(path, &picture(job, maps, format, look)?)?);
    }
    let result = MapResult {
        georef: job.scene.grid(),
        sites: &maps.sites,
        n_uavs: maps.sites.len(),
        overlay: None,
        layers: &[Layer::Los],
        provenance: &job.provenance().to_string(),
        tif_layout: TiffLayout::Cog,
        mask_values: MaskValues::Classes,
    };
    add_raster(batch, &result, path, format)
}

fn picture(job: &Placements, maps: &ManyMaps, format: Format, look: &Look) -> Result<Vec<u8>> {
    let grid = job.scene.field.grid();
    let unit = grid.meters_per_unit();
    let facts: Vec<SiteFacts> = maps.sites.iter().map(|site| SiteFacts::of(site, None)).collect();
    let labels: Vec<String> = facts.iter().map(|site| format!("UAV {}", site.id)).collect();
    let heights: Vec<String> = facts.iter().map(SiteFacts::height_words).collect();
    let marks: Vec<Mark<'_>> = facts
        .iter()
        .zip(labels.iter().zip(&heights))
        .map(|(site, (label, height))| mark(grid, (site.x, site.y), label, height))
        .collect();
    let sight = &job.report.sight;
    let (receivers_name, others_name) = match job.report.goal.whom {
        Whom::Area => ("cells of the area", "Buildings"),
        _ => sight.receivers().cell_names(&job.scene.field),
    };
    let n_sites = u32::try_from(facts.len()).unwrap_or(u32::MAX);
    let mask = match (&maps.overlay, maps.sites.as_slice()) {
        (None, [only]) => only.mask.as_slice(),
        (overlay, _) => overlay.as_ref().map_or(&[][..], Overlay::union),
    };
    let mask = &*shown_classes(mask, &job.scene.field, grid.window());
    let layer = match &maps.overlay {
        None => render::Layer::Los(mask),
        Some(overlay) => render::Layer::Count { count: overlay.count(), mask, n_sites },
    };
    let in_range = if sight.is_limited() { " in range" } else { "" };
    let share = |tally: &Tally| match tally.p_los() {
        Some(p) => {
            let (los, receivers) = (grouped(tally.los), grouped(tally.receivers));
            format!("P_LoS = {p:.4} ({los} of {receivers} {receivers_name}{in_range})")
        }
        None => format!("P_LoS undefined: {}", tally.reason()),
    };
    let of_site = |site: &SiteFacts| {
        let (height, at) = (site.height_words(), site.position().in_words());
        format!("UAV {}: {height} at {at}, {}", site.id, share(&site.tally))
    };
    // Captions print the first line darkest. With several UAVs it holds the share of all together.
    let of_all = maps.overlay.as_ref().map(|o| format!("Seen by at least one: {}", share(&Tally::of_mask(o.union()))));
    let mut caption: Vec<String> = of_all.into_iter().chain(facts.iter().take(MOST_LINES).map(of_site)).collect();
    if facts.len() > MOST_LINES {
        caption.push(format!("and {} more UAVs", facts.len() - MOST_LINES));
    }
    let how = if facts.len() > 1 { "chosen one by one among" } else { "the best of" };
    caption.push(format!("Goal {}: {how} {} candidates", job.report.goal.text, grouped(job.report.n_candidates)));
    caption.push(sight.in_words(grid, &job.scene, job.report.facts.method));
    caption.extend(job.scene.last_lines(look));
    let subject = if facts.len() > 1 { "What the chosen UAVs see of" } else { "What the best UAV sees of" };
    let title = unbreakable(&format!("{subject} {}", job.scene.name));
    let surface = job.scene.field.above_ground_m();
    let picture = MapPicture {
        title: &title,
        caption: &caption,
        n_cols: grid.n_cols(),
        n_rows: grid.n_rows(),
        cell_m: (grid.cell_width() * unit, grid.cell_height() * unit),
        layer,
        surface_m: Some(&surface),
        uavs: &marks,
        is_in_air: false,
        receivers_name,
        others_name,
        counts: None,
    };
    written(render::draw_map(&picture), &look.form(format), &picture_provenance(&job.provenance()))
}

/// Most UAVs that the caption lists.
const MOST_LINES: usize = 6;
