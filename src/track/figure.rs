//! Picture of a track: stretches with line of sight, and the user height that would be enough
//! elsewhere.

use super::TrackWalk;
use crate::answer::Answer;
use crate::coverage::{Stretch, TrackPoint, TrackState, class};
use crate::error::Result;
use crate::export::Format;
use crate::picture::{Look, crop, mark, picture_provenance, program, window_of, written};
use crate::quantity::tidy;
use crate::raster::{CellWindow, GeoRef};
use crate::render::{self, OPEN_GROUND, TrackPlan, TrackProfile, TrackStretch};
use crate::words::title_of;

pub(super) fn draw(walk: &TrackWalk, format: Format, look: &Look) -> Result<Vec<u8>> {
    let (field, points, uav) = (&walk.scene.field, &walk.track.points, &walk.uav);
    let (grid, unit) = (field.grid(), walk.facts.unit_m());
    let enough = |p: &TrackPoint| (p.along * unit, p.margin_m.map(|m| walk.rx_height_m - m));
    let enough: Vec<(f64, Option<f64>)> = points.iter().map(enough).collect();

    let window = window_around(walk);
    let part = grid.part(window);
    let mask = classes(walk, window);
    let surface = crop(&field.above_ground_m(), grid.n_cols(), window);
    let paths: Vec<Vec<[f64; 2]>> = walk.track.stretches.iter().map(|s| path_of(walk, s, &part)).collect();
    let told = walk.track.stretches.iter().zip(&paths).map(|(s, path)| TrackStretch {
        along_m: s.along.map(|along| along * unit),
        los: (s.state != TrackState::NoReceiver).then_some(s.state == TrackState::Los),
        path,
    });
    let stretches: Vec<TrackStretch<'_>> = told.collect();
    let height = format!("{} m above the datum", tidy(uav.height_amsl_m));

    let title = look.title_or(|| title_of(&format!("{}: line of sight along a track", walk.scene.name)));
    let mut caption: Vec<String> = walk.text(look)?.lines().map(str::to_string).collect();
    caption.push(format!(
        "UAV at ({}, {}), {height}; user {} m above ground; decided every {} m; {}",
        tidy(uav.x),
        tidy(uav.y),
        tidy(walk.rx_height_m),
        tidy(walk.every_m),
        program()
    ));
    caption.extend(walk.scene.last_lines(look));
    let profile = TrackProfile {
        title: &title,
        caption: &caption,
        length_m: points.last().map_or(0.0, |p| p.along * unit),
        stretches: &stretches,
        enough: &enough,
        user_m: walk.rx_height_m,
        plan: TrackPlan {
            n_cols: window.n_cols,
            n_rows: window.n_rows,
            cell_m: (grid.cell_width() * unit, grid.cell_height() * unit),
            mask: &mask,
            surface_m: &surface,
            uav: mark(&part, (uav.x, uav.y), "UAV", ""),
        },
    };
    written(render::draw_track_profile(&profile), &look.form(format), &picture_provenance(&walk.provenance()))
}

/// Returns the start, the turns and the end of a stretch, as columns and rows of a grid.
fn path_of(walk: &TrackWalk, stretch: &Stretch, grid: &GeoRef) -> Vec<[f64; 2]> {
    let points = &walk.track.points;
    let at = |along: f64| {
        let next = points.partition_point(|p| p.along < along).min(points.len() - 1);
        let [a, b] = [&points[next.saturating_sub(1)], &points[next]];
        let t = if b.along > a.along { ((along - a.along) / (b.along - a.along)).clamp(0.0, 1.0) } else { 0.0 };
        [0, 1].map(|k| a.position[k] + t * (b.position[k] - a.position[k]))
    };
    let [from, to] = stretch.along;
    let turns = points.iter().filter(|p| p.is_vertex && from < p.along && p.along < to).map(|p| p.position);
    let cells = |[x, y]: [f64; 2]| {
        let (east, north) = grid.cells_from_world(x, y);
        #[expect(clippy::cast_precision_loss, reason = "a grid has fewer than 2^53 rows")]
        let n_rows = grid.n_rows() as f64;
        [east, n_rows - north]
    };
    std::iter::once(at(from)).chain(turns).chain([at(to)]).map(cells).collect()
}

/// Returns the cells around the track and the UAV, with a border of a twelfth.
fn window_around(walk: &TrackWalk) -> CellWindow {
    let around = |[x, y]: [f64; 2]| [x, y, x, y];
    let join = |a: [f64; 4], b: [f64; 4]| [a[0].min(b[0]), a[1].min(b[1]), a[2].max(b[2]), a[3].max(b[3])];
    let places = walk.track.points.iter().map(|p| around(p.position));
    let [west, south, east, north] = places.fold(around([walk.uav.x, walk.uav.y]), join);
    let border = (east - west).max(north - south) / 12.0;
    window_of(walk.scene.grid(), std::iter::once([west - border, south - border, east + border, north + border]))
}

/// Returns the classes of the cells of a window.
fn classes(walk: &TrackWalk, window: CellWindow) -> Vec<u8> {
    let cells = walk.scene.field.cells();
    let class_of = |row: usize, col: usize| match (cells.building.contains(row, col), cells.open.contains(row, col)) {
        (true, _) => class::NOT_A_RECEIVER,
        (false, true) => OPEN_GROUND,
        (false, false) => class::NODATA,
    };
    let rows = window.row..window.row + window.n_rows;
    rows.flat_map(|row| (window.col..window.col + window.n_cols).map(move |col| class_of(row, col))).collect()
}
