//! Heat map of a search: the value of each place, as colors over the city.

use skyshed_request::Whom;

use super::Placements;
use super::report::PlaceFacts;
use super::words::in_words;
use crate::answer::Answer;
use crate::error::Result;
use crate::export::Format;
use crate::picture::{Look, crs_words, mark, picture_provenance, program, written};
use crate::placement::PlaceGrid;
use crate::quantity::{Height, tidy};
use crate::render::{self, Layer, MapPicture, Mark};
use crate::words::{capitalized, unbreakable};

pub(super) fn draw(job: &Placements, places: &PlaceGrid, format: Format, look: &Look) -> Result<Vec<u8>> {
    let grid = job.scene.field.grid();
    let unit = grid.meters_per_unit();
    let values = job.values(places, f32::NAN);
    let place_of = |cell: usize| {
        let (x, y) = grid.world_from_cell(cell / grid.n_cols(), cell % grid.n_cols());
        places.grid.cell_at(x, y).map(|(row, col)| row * places.grid.n_cols() + col)
    };
    let of_cells: Vec<f32> = (0..grid.n_cells()).map(|cell| place_of(cell).map_or(f32::NAN, |p| values[p])).collect();
    let outlines = outlines(job);
    let (name, of_unit) = job.quantity();
    let named: Vec<(String, &PlaceFacts)> = match (&job.report.several, &job.report.winner) {
        (Some(several), _) => several.places.iter().map(|p| (format!("UAV {}", p.rank), p)).collect(),
        (None, Ok(winner)) => vec![("Best UAV".to_string(), winner)],
        (None, Err(_)) => Vec::new(),
    };
    let heights: Vec<String> = named.iter().map(|(_, place)| place.height_words()).collect();
    let marks: Vec<Mark<'_>> = named
        .iter()
        .zip(&heights)
        .map(|((label, place), height)| mark(grid, (place.x, place.y), label, height))
        .collect();
    let title = look.title_or(|| unbreakable(&format!("Where to hover over {}", job.scene.name)));
    let caption = caption(job, look);
    let none = match (job.report.goal.at_least.is_some(), job.scene.field.outside_data().is_some()) {
        (false, false) => "No candidate",
        (false, true) => "No candidate, or no data",
        (true, false) => "Share not reached, or no candidate",
        (true, true) => "Share not reached, no candidate, or no data",
    };
    let picture = MapPicture {
        title: &title,
        caption: &caption,
        n_cols: grid.n_cols(),
        n_rows: grid.n_rows(),
        cell_m: (grid.cell_width() * unit, grid.cell_height() * unit),
        layer: Layer::Heat { values: &of_cells, outlines: &outlines, name, unit: of_unit, none },
        surface_m: None,
        uavs: &marks,
        is_in_air: false,
        receivers_name: "receivers",
        others_name: "Buildings",
        counts: None,
    };
    written(render::draw_map(&picture), &look.form(format), &picture_provenance(&job.provenance()))
}

/// Returns heights in words. A long list becomes its length, its first and its last height.
fn heights_in_words(heights: &[String]) -> String {
    const MOST: usize = 4;
    let words = |typed: &String| match typed.parse::<Height>() {
        Ok(Height::AboveGround(h)) => format!("{} m above ground", tidy(h)),
        Ok(Height::AboveRoof(h)) => format!("{} m above roofs", tidy(h)),
        Ok(Height::AboveDatum(h)) => format!("{} m above the datum", tidy(h)),
        Err(_) => typed.clone(),
    };
    match heights {
        [] => "heights of their own".into(),
        [first, .., last] if heights.len() > MOST => {
            format!("{} heights from {} to {}", heights.len(), words(first), words(last))
        }
        few => few.iter().map(words).collect::<Vec<_>>().join(", "),
    }
}

/// Marks building cells with open ground beside them.
fn outlines(job: &Placements) -> Vec<bool> {
    let grid = job.scene.field.grid();
    let cells = job.scene.field.cells();
    let (n_rows, n_cols) = (grid.n_rows(), grid.n_cols());
    let is_outline = |row: usize, col: usize| {
        let beside = [(row.wrapping_sub(1), col), (row + 1, col), (row, col.wrapping_sub(1)), (row, col + 1)];
        let is_open = |(row, col): (usize, usize)| row < n_rows && col < n_cols && cells.open.contains(row, col);
        cells.building.contains(row, col) && beside.into_iter().any(is_open)
    };
    (0..n_rows).flat_map(|row| (0..n_cols).map(move |col| (row, col))).map(|(row, col)| is_outline(row, col)).collect()
}

fn caption(job: &Placements, look: &Look) -> Vec<String> {
    let report = &job.report;
    let mut lines: Vec<String> = in_words(report).iter().map(|line| capitalized(line)).collect();
    let receivers = report.sight.receivers();
    let whom = match report.goal.whom {
        Whom::Area => format!("{} cells of the area", receivers.name()),
        Whom::Weights => format!("{} cells by weight", receivers.name()),
        Whom::Receivers | Whom::Zone(_) => receivers.cell_names(&job.scene.field).0.to_string(),
    };
    let over: Vec<&str> = job.over.iter().map(|zone| zone.name()).collect();
    let over = if over.is_empty() { String::new() } else { format!(" over zones {}", over.join(", ")) };
    let range = report.sight.range_in_words();
    lines.push(format!(
        "Goal {} over {whom}{range}; candidates every {} m{over} at {}; receivers {} m high; method {}; {}; {}",
        report.goal.text,
        report.step_m.map_or(String::new(), tidy),
        heights_in_words(&report.heights),
        tidy(report.sight.rx_height_m()),
        report.facts.method_in_words(),
        crs_words(job.scene.grid()),
        program()
    ));
    lines.extend(job.scene.last_lines(look));
    lines
}
