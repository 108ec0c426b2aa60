//! The map of the winner, or of those chosen together.

use std::path::Path;

use super::goal::Whom;
use super::outputs::Writer;
use crate::coverage::{Control, KeepMasks, ManyMaps, Overlay, Tally, Uav};
use crate::error::{Error, Result};
use crate::export::{Batch, Format, Layer, MapResult, MaskValues, add_map};
use crate::formats::TiffLayout;
use crate::map::Receivers;
use crate::map::{cell_names, height_words, setting_line};
use crate::picture::{mark, undrawable};
use crate::render::{self, MapPicture, Mark, grouped};
use crate::report::SiteFacts;
use crate::words::{picture_provenance, unbreakable};
use crate::zones::Zone;

/// Maps the winners and adds the map to a batch.
pub(super) fn add(job: &Writer<'_>, batch: &mut Batch, path: &Path, format: Format) -> Result<()> {
    if job.winners.is_empty() {
        let text = format!("cannot write {}: there is no winner to map", path.display());
        return Err(Error::site(209, text).with_hint("without `--map` the other results are written"));
    }
    // Names are those that were given, if they tell the UAVs apart.
    let ids: std::collections::HashSet<&str> = job.winners.iter().map(|uav| uav.id.as_str()).collect();
    let are_named = ids.len() == job.winners.len() && !ids.contains("");
    let id = |k: usize, uav: &Uav| if are_named { uav.id.clone() } else { (k + 1).to_string() };
    let named: Vec<Uav> =
        job.winners.iter().enumerate().map(|(k, uav)| Uav { id: id(k, uav), ..uav.clone() }).collect();
    let maps = job.mapper.map_many(&named, KeepMasks::Always, &Control::default(), |_| {}, |_| {})?;
    if format != Format::GeoTiff {
        return Ok(batch.add(path, &picture(job, &maps, format)?)?);
    }
    let provenance = job.report.provenance().to_string();
    let result = MapResult {
        georef: job.scene.field.grid(),
        sites: &maps.sites,
        layers: &[Layer::Los],
        provenance: &provenance,
        tif_layout: TiffLayout::Cog,
        mask_values: MaskValues::Classes,
    };
    Ok(add_map(batch, &result, path, format)?)
}

fn picture(job: &Writer<'_>, maps: &ManyMaps, format: Format) -> Result<Vec<u8>> {
    let grid = job.scene.field.grid();
    let unit = grid.meters_per_unit();
    let facts: Vec<SiteFacts> = maps.sites.iter().map(|site| SiteFacts::of(site, None)).collect();
    let labels: Vec<String> = facts.iter().map(|site| format!("UAV {}", site.id)).collect();
    let heights: Vec<String> = facts.iter().map(height_words).collect();
    let marks: Vec<Mark<'_>> = facts
        .iter()
        .zip(labels.iter().zip(&heights))
        .map(|(site, (label, height))| mark(grid, (site.x, site.y), label, height))
        .collect();
    let receivers = receivers_of(job);
    let (receivers_name, others_name) = match job.goal.whom {
        Whom::Area => ("cells of the area", "Other cells"),
        _ => cell_names(receivers, &job.scene.field),
    };
    let n_sites = u32::try_from(facts.len()).unwrap_or(u32::MAX);
    let layer = match (&maps.overlay, maps.sites.as_slice()) {
        (None, [only]) => render::Layer::Los(&only.mask),
        (overlay, _) => render::Layer::Count {
            count: overlay.as_ref().map_or(&[], Overlay::count),
            mask: overlay.as_ref().map_or(&[], Overlay::union),
            n_sites,
        },
    };
    let in_range = if job.report.radius_m.is_some() { " in range" } else { "" };
    let share = |tally: &Tally| match tally.p_los() {
        Some(p) => {
            let (los, receivers) = (grouped(tally.los), grouped(tally.receivers));
            format!("P_LoS = {p:.4} ({los} of {receivers} {receivers_name}{in_range})")
        }
        None => format!("P_LoS undefined: {}", tally.reason()),
    };
    let mut caption: Vec<String> = facts
        .iter()
        .take(MOST_LINES)
        .map(|site| {
            format!("UAV {}: {} at {}, {}", site.id, height_words(site), site.position().in_words(), share(&site.tally))
        })
        .collect();
    if let Some(overlay) = &maps.overlay {
        caption.push(format!("Seen by at least one: {}", share(&Tally::of_mask(overlay.union()))));
    }
    let how = if facts.len() > 1 { "chosen one by one among" } else { "the best of" };
    caption.push(format!("Goal {}: {how} {} candidates", job.report.goal, grouped(job.report.n_candidates)));
    caption.push(setting_line(
        job.scene,
        receivers,
        (job.report.rx_height_m, job.report.radius_m),
        job.report.facts.method,
    ));
    caption.extend(job.scene.limits_in_words());
    caption.extend(job.args.words.credit(job.scene.attribution.as_ref()));
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
        receivers_name,
        others_name,
        counts: None,
    };
    let provenance = picture_provenance(&job.report.provenance());
    let form = job.args.words.size.form(format);
    render::draw_map(&picture, &form, &provenance).map_err(undrawable)
}

/// More UAVs than this are not listed in the caption.
const MOST_LINES: usize = 6;

/// The receivers that the goal counts, as they are typed for a map.
pub(super) fn receivers_of(job: &Writer<'_>) -> Receivers {
    match job.goal.whom {
        Whom::Zone(Zone::Street) => Receivers::Street,
        Whom::Zone(Zone::Crossroad) => Receivers::Crossroad,
        Whom::Zone(Zone::Courtyard) => Receivers::Courtyard,
        Whom::Zone(Zone::Rooftop) => Receivers::Roof,
        _ => job.args.receivers,
    }
}
