//! Picture of a track: stretches with line of sight, and heights along it.

use super::TrackWalk;
use crate::answer::Answer;
use crate::coverage::{TrackPoint, TrackState, Uav, Way, WayHeights, WayRun, WayStretches, class};
use crate::error::Result;
use crate::export::Format;
use crate::picture::{Look, crop, mark, picture_provenance, program, window_of, written};
use crate::quantity::{counted, tidy};
use crate::raster::{CellWindow, GeoRef};
use crate::render::{self, FlightHeights, Mark, OPEN_GROUND, TrackHeights, TrackPlan, TrackProfile, TrackStretch};
use crate::words::title_of;

/// Places at which the heights below a flight are drawn.
const PLACES: f64 = 1500.0;

pub(super) fn draw(walk: &TrackWalk, format: Format, look: &Look) -> Result<Vec<u8>> {
    let (grid, unit) = (walk.scene.grid(), walk.facts.unit_m());
    let window = window_around(walk);
    let part = grid.part(window);
    let mask = classes(walk, window);
    let surface = crop(&walk.scene.field.above_ground_m(), grid.n_cols(), window);
    let starts = Way::starts(&walk.ways, unit);
    let paths = Paths { walk, part: &part, starts: &starts };
    let [all, each] = [vec![&walk.all], walk.each.iter().collect::<Vec<_>>()]
        .map(|of| of.into_iter().map(|seen| paths.of(&seen.stretches)).collect::<Vec<_>>());
    let stretches = told(&all[0]);
    let is_one = walk.uavs.len() == 1;
    let named = walk.uavs.iter().zip(&each).filter(|_| !is_one);
    let of_each: Vec<_> = named.map(|(uav, own)| (uav.id.clone(), told(own))).collect();

    let title = look.title_or(|| title_of(&format!("{}: line of sight along a track", walk.scene.name)));
    let told = walk.words_of_none() + &walk.words_of_all();
    let mut caption: Vec<String> = told.lines().map(str::to_string).collect();
    caption.push(words_of(walk));
    caption.extend(walk.scene.last_lines(look));
    let (enough, flight) = match walk.rx_height_m {
        Some(user_m) if is_one => (enough_of(walk, user_m, &starts)?, Vec::new()),
        _ => (Vec::new(), flight_of(walk)),
    };
    let heights = match walk.rx_height_m {
        Some(user_m) if is_one => TrackHeights::Walk { enough: &enough, user_m },
        _ => TrackHeights::Flight(&flight),
    };
    let label = |uav: &Uav| if is_one { "UAV".to_string() } else { uav.id.clone() };
    let labels: Vec<String> = walk.uavs.iter().map(label).collect();
    let places = walk.uavs.iter().map(|uav| uav.station.place);
    let uavs: Vec<Mark<'_>> = places.zip(&labels).map(|(at, label)| mark(&part, (at.x, at.y), label, "")).collect();
    let profile = TrackProfile {
        title: &title,
        caption: &caption,
        length_m: starts.last().copied().unwrap_or(0.0),
        stretches: &stretches,
        of_each: &of_each,
        heights,
        plan: TrackPlan {
            n_cols: window.n_cols,
            n_rows: window.n_rows,
            cell_m: (grid.cell_width() * unit, grid.cell_height() * unit),
            mask: &mask,
            surface_m: &surface,
            uavs: &uavs,
        },
    };
    written(render::draw_track_profile(&profile), &look.form(format), &picture_provenance(&walk.provenance()))
}

/// Returns the words about UAVs and user in the caption.
fn words_of(walk: &TrackWalk) -> String {
    let uavs = match &walk.uavs[..] {
        [uav] => {
            let at = &uav.station.place;
            format!("UAV at ({}, {}), {} m above the datum", tidy(at.x), tidy(at.y), tidy(uav.height_amsl_m()))
        }
        uavs => counted(uavs.len() as u64, "UAV", "UAVs"),
    };
    let user = walk.rx_height_m.map_or("a flight".to_string(), |m| format!("user {} m above ground", tidy(m)));
    let decided = match walk.curvature {
        None => "stretches computed exactly".to_string(),
        Some(_) => format!("decided every {} m", tidy(walk.every_m)),
    };
    format!("{uavs}; {user}; {decided}; {}", program())
}

/// A stretch along all ways one after the other, with its path on the plan.
type Drawn = ([f64; 2], Option<bool>, Vec<[f64; 2]>);

struct Paths<'a> {
    walk: &'a TrackWalk,
    part: &'a GeoRef,
    starts: &'a [f64],
}

impl Paths<'_> {
    /// Returns stretches as they are drawn: legs of one state that follow each other as one.
    fn of(&self, stretches: &WayStretches) -> Vec<Drawn> {
        let drawn = |run: WayRun<'_>| {
            let (first, last, along_m) = (run.first(), run.last(), run.along_m());
            let start = self.starts[first.way];
            let path = run.0.iter().map(|s| (s, s.at[0])).chain([(last, last.at[1])]);
            let path = path.map(|(s, t)| self.cells(self.walk.ways[s.way].place(s.leg, t).0)).collect();
            let los = first.state.has_receiver().then_some(first.state == TrackState::Los);
            (along_m.map(|m| start + m), los, path)
        };
        stretches.runs().map(drawn).collect()
    }

    /// Returns a position as column and row.
    fn cells(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let (east, north) = self.part.cells_from_world(x, y);
        #[expect(clippy::cast_precision_loss, reason = "a grid has fewer than 2^53 rows")]
        let n_rows = self.part.n_rows() as f64;
        [east, n_rows - north]
    }
}

fn told(drawn: &[Drawn]) -> Vec<TrackStretch<'_>> {
    drawn.iter().map(|(along_m, los, path)| TrackStretch { along_m: *along_m, los: *los, path }).collect()
}

/// Returns the heights above ground that would be enough for a walk below one UAV.
fn enough_of(walk: &TrackWalk, user_m: f64, starts: &[f64]) -> Result<Vec<(f64, Option<f64>)>> {
    let points = walk.points()?;
    let mut enough = Vec::new();
    for (way, of_way) in points.iter().flatten().enumerate() {
        let spans = walk.ways[way].spans(walk.facts.unit_m());
        let of = |p: &TrackPoint| (starts[way] + spans[p.leg.0].at(p.leg.1).0, p.margin_m.map(|m| user_m - m));
        enough.extend(of_way.iter().map(of));
    }
    Ok(enough)
}

/// Returns the heights along a flight, and of what is below.
fn flight_of(walk: &TrackWalk) -> Vec<FlightHeights> {
    let walk_m = walk.rx_height_m.unwrap_or(0.0);
    let of = |WayHeights { along_m, user_m, ground_m, roof_m, .. }| FlightHeights { along_m, user_m, ground_m, roof_m };
    WayHeights::sample(&walk.scene.field, &walk.ways, (walk_m, PLACES)).into_iter().map(of).collect()
}

/// Returns the cells around the track and the UAVs, with a border of a twelfth.
fn window_around(walk: &TrackWalk) -> CellWindow {
    let around = |[x, y]: [f64; 2]| [x, y, x, y];
    let join = |a: [f64; 4], b: [f64; 4]| [a[0].min(b[0]), a[1].min(b[1]), a[2].max(b[2]), a[3].max(b[3])];
    let vertices = walk.ways.iter().flat_map(|way| &way.vertices).map(|of| of.vertex.position);
    let uavs = walk.uavs.iter().map(|uav| [uav.station.place.x, uav.station.place.y]);
    let bounds = vertices.chain(uavs).map(around).reduce(join).unwrap_or_default();
    let [west, south, east, north] = bounds;
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
