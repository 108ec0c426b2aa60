//! One link, decided and explained: its margin, what stands in its way, and what lies below it from the side.

use super::{Uav, height_over};
use crate::error::UavError;
use crate::height_field::{HeightField, RoofPlane, Station};
use crate::los::{
    HORIZON, LeastHeight, LeastHeights, Obstruction, columns_crossed, link_least_receiver_heights, prisms_crossed,
};
use crate::quantity::{BLOCKS_ALL, Height, STEPS_PER_UNIT, VOID, meters};

/// What was found of a link.
#[derive(Debug, Clone, PartialEq)]
pub struct ExplainedLink {
    /// Whether it is in line of sight; exact.
    pub los: bool,
    /// Receiver height less the least height in line of sight \[m\]; `None` if no receiver height is enough.
    pub margin_m: Option<f64>,
    /// Horizontal distance \[m\].
    pub distance_m: f64,
    /// Elevation angle of the UAV from the receiver \[deg\].
    pub elevation_deg: f64,
    /// What stands in the way; `None` in line of sight.
    pub obstruction: Option<LinkObstacle>,
}

/// What stands in the way of a link: the obstacle that asks for the highest receiver.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinkObstacle {
    /// What it is.
    pub kind: ObstacleKind,
    /// Obstructing point, east \[CRS units\].
    pub x: f64,
    /// Obstructing point, north \[CRS units\].
    pub y: f64,
    /// Height of the ray there \[m above the datum\].
    pub ray_height_m: f64,
    /// Height of the obstacle there \[m above the datum\]; `None` for nodata that blocks everything.
    pub top_m: Option<f64>,
}

/// What an obstacle is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ObstacleKind {
    /// A building, by its number (see [`HeightField::building_id`]).
    Building(u32),
    /// A cell of the terrain below footprints, by row and column.
    Terrain((usize, usize)),
    /// Flat ground, beyond the horizon of a curved earth.
    Horizon,
    /// A cell of a surface model.
    Cell((usize, usize)),
    /// Nodata that blocks everything.
    Nodata((usize, usize)),
}

/// A stretch below a link whose height is constant, or rises or falls evenly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProfileStep {
    /// Start \[m from the UAV\].
    pub from_m: f64,
    /// End \[m from the UAV\].
    pub to_m: f64,
    /// Height where it starts and where it ends \[m\].
    pub heights_m: [f64; 2],
    /// What it is.
    pub kind: StepKind,
}

/// What a step of a profile is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StepKind {
    /// Ground.
    Terrain,
    /// A roof.
    Building,
}

/// A receiver's end of a link, at a position \[CRS units\].
///
/// # Errors
/// If there is no ground or roof for its height to be above, or it would be inside a building or below the ground.
pub fn place_receiver(field: &HeightField, (x, y): (f64, f64), height: Height) -> Result<Station, UavError> {
    let place = field.place(x, y);
    let (ground, roof) = (field.ground_at(&place), field.roof_at(&place));
    // Over footprints a point on a free wall is outdoors, although the roof to its north-east is its roof.
    let inside = if field.prisms().is_some() { field.inside_prisms_below(&place) } else { roof.unwrap_or(VOID) };
    let ground_m = (ground != VOID).then(|| meters(ground));
    match height_over(field, &place, height)? {
        z if z < inside => Err(UavError::InsideBuilding { amsl_m: meters(z), roof_m: meters(inside), ground_m }),
        z if ground != VOID && z < ground => {
            Err(UavError::BelowGround { amsl_m: meters(z), surface_m: meters(ground), ground_m })
        }
        z => Ok(Station { place, z: i64::from(z) }),
    }
}

/// Decides a link, and finds what stands in its way.
pub fn explain_link(field: &HeightField, uav: &Uav, receiver: &Station) -> ExplainedLink {
    let least_heights = link_least_receiver_heights(field, &uav.station, receiver);
    let LeastHeights { prisms, columns, is_los: los, .. } = least_heights;
    let steps = f64::from(STEPS_PER_UNIT);
    #[expect(clippy::cast_precision_loss, reason = "heights are at most 2^27 steps")]
    let (uav_z, receiver_z) = (uav.station.z as f64 / steps, receiver.z as f64 / steps);
    let (from, to) = (receiver.place, uav.station.place);
    let distance_m = (to.x - from.x).hypot(to.y - from.y) * field.grid().meters_per_unit();

    // The least visible height is never below what the receiver stands on: the roof if it is on or above one, else the ground.
    let ground = field.ground_at(&receiver.place);
    let roof = field.roof_at(&receiver.place).filter(|roof| receiver.z >= i64::from(*roof));
    let floor = match (roof, ground) {
        (Some(roof), _) => f64::from(roof),
        (None, VOID) => f64::NEG_INFINITY,
        (None, ground) => f64::from(ground),
    };
    let least = least_heights.height_steps().max(floor) / steps;
    let margin = receiver_z - least;
    let margin = if los { margin.max(0.0) } else { margin.min(-f64::MIN_POSITIVE) };

    let higher = match (&prisms, &columns) {
        (LeastHeight::At(p), LeastHeight::At(c)) => {
            let (a, b) = (prisms.height_steps(), least_heights.columns_height_steps());
            let prisms_win = a > b || (a >= b && p.near <= c.near);
            if prisms_win { Some((*p, true)) } else { Some((*c, false)) }
        }
        (LeastHeight::At(p), LeastHeight::Clear) => Some((*p, true)),
        (LeastHeight::Clear, LeastHeight::At(c)) => Some((*c, false)),
        (LeastHeight::Clear, LeastHeight::Clear) => None,
    };
    let obstruction = higher.filter(|_| !los).map(|(o, of_prisms)| {
        // The obstructing point is the end of the crossing nearest the lower terminal.
        let t = if uav_z >= receiver_z { o.near } else { o.far };
        LinkObstacle {
            kind: kind_of(field, &o, of_prisms),
            x: from.x + t * (to.x - from.x),
            y: from.y + t * (to.y - from.y),
            ray_height_m: receiver_z + t * (uav_z - receiver_z),
            top_m: (o.top != BLOCKS_ALL).then(|| meters(o.top)),
        }
    });
    ExplainedLink {
        los,
        margin_m: margin.is_finite().then_some(margin),
        distance_m,
        elevation_deg: (uav_z - receiver_z).atan2(distance_m).to_degrees(),
        obstruction,
    }
}

fn kind_of(field: &HeightField, obstruction: &Obstruction, of_prisms: bool) -> ObstacleKind {
    if obstruction.obstacle == HORIZON {
        return ObstacleKind::Horizon;
    }
    if let Some(prisms) = field.prisms().filter(|_| of_prisms) {
        return ObstacleKind::Building(prisms.pieces()[obstruction.obstacle].building);
    }
    let n_cols = field.columns().map_or(1, |columns| columns.n_cols());
    let cell = (obstruction.obstacle / n_cols, obstruction.obstacle % n_cols);
    match field.prisms() {
        _ if obstruction.top == BLOCKS_ALL => ObstacleKind::Nodata(cell),
        Some(_) => ObstacleKind::Terrain(cell),
        None => ObstacleKind::Cell(cell),
    }
}

/// Ground and roofs below a link of some length \[m\], for its side view: terrain first, each kind from the UAV on.
pub fn link_profile(field: &HeightField, uav: &Uav, receiver: &Station, distance_m: f64) -> Vec<ProfileStep> {
    // Fractions count from the receiver, the picture's distances from the UAV.
    let step = |(near, far): (f64, f64), top: i32, kind: StepKind| ProfileStep {
        from_m: (1.0 - far) * distance_m,
        to_m: (1.0 - near) * distance_m,
        heights_m: [meters(top); 2],
        kind,
    };
    let mut steps: Vec<ProfileStep> = Vec::new();
    match field.columns() {
        None => {
            let ground = [field.ground_at(&receiver.place), field.ground_at(&uav.station.place)];
            let flat = ground.into_iter().filter(|g| *g != VOID).min();
            steps.extend(flat.map(|z| step((0.0, 1.0), z, StepKind::Terrain)));
        }
        Some(columns) => {
            let mut crossed = columns_crossed(columns, uav.station.on_columns(), receiver.on_columns());
            // The receiver's own cell is exempt from blocking, not from being there.
            let own = columns.cell_at(receiver.on_columns().x, receiver.on_columns().y);
            let first = crossed.first().map_or(1.0, |c| c.1);
            crossed.extend(own.map(|cell| (cell, 0.0, first)));
            for (cell, near, far) in crossed {
                let top = columns.tops()[cell];
                if top == VOID || top == BLOCKS_ALL {
                    continue;
                }
                let (ground, roof) = field.column_parts(cell);
                steps.extend(ground.map(|z| step((near, far), z, StepKind::Terrain)));
                steps.extend(roof.map(|z| step((near, far), z, StepKind::Building)));
            }
        }
    }
    if let Some(prisms) = field.prisms() {
        let (to, from) = (uav.station.on_prisms(), receiver.on_prisms());
        for (piece, near, far) in prisms_crossed(prisms, to, from) {
            let piece = &prisms.pieces()[piece];
            let flat = step((near, far), piece.top, StepKind::Building);
            let height_m = |plane: &RoofPlane, t: f64| {
                #[expect(clippy::cast_precision_loss, reason = "told in meters")]
                let at = |from: i64, to: i64| from as f64 + t * (to - from) as f64;
                plane.height(at(from.x, to.x), at(from.y, to.y)) / f64::from(STEPS_PER_UNIT)
            };
            let heights_m = prisms.plane(piece).map(|plane| [far, near].map(|t| height_m(&plane, t)));
            steps.push(heights_m.map_or(flat, |heights_m| ProfileStep { heights_m, ..flat }));
        }
    }
    merged(steps)
}

/// Joins level steps of the same height and kind that follow each other.
fn merged(mut steps: Vec<ProfileStep>) -> Vec<ProfileStep> {
    let order = |kind: StepKind| matches!(kind, StepKind::Building);
    steps.sort_by(|a, b| order(a.kind).cmp(&order(b.kind)).then(a.from_m.total_cmp(&b.from_m)));
    let mut joined: Vec<ProfileStep> = Vec::with_capacity(steps.len());
    for step in steps {
        match joined.last_mut() {
            Some(last)
                if last.kind == step.kind
                    && [last.heights_m, step.heights_m]
                        .as_flattened()
                        .iter()
                        .all(|h| (h - last.heights_m[0]).abs() < 1e-9)
                    && (last.to_m - step.from_m).abs() < 1e-6 =>
            {
                last.to_m = step.to_m;
            }
            _ => joined.push(step),
        }
    }
    joined
}
