//! One link, decided and explained: its margin, what stands in its way, and what lies below it from
//! the side.

use super::height_over;
use super::view::SceneView;
use crate::error::UavError;
use crate::height_field::{Curvature, HeightField, Place, RoofPlane, Station};
use crate::los::{
    HORIZON, LeastHeight, LeastHeights, Obstruction, columns_crossed, link_least_receiver_heights, prisms_crossed,
};
use crate::quantity::{BLOCKS_ALL, Height, STEPS_PER_UNIT, VOID, meters};

/// Decision about a link, and what stands in its way.
#[derive(Debug, Clone, PartialEq)]
pub struct ExplainedLink {
    /// Line of sight; exact.
    pub los: bool,
    /// Receiver height less the least height in line of sight \[m\]; `None` if no receiver height
    /// is enough.
    pub margin_m: Option<f64>,
    /// Horizontal distance \[m\].
    pub distance_m: f64,
    /// Elevation angle of the UAV from the receiver \[deg\].
    pub elevation_deg: f64,
    /// Obstacle; `None` in line of sight.
    pub obstruction: Option<LinkObstacle>,
}

/// Obstacle of a link that asks for the highest receiver.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinkObstacle {
    /// Kind of the obstacle.
    pub kind: ObstacleKind,
    /// Obstructing point, east \[CRS units\].
    pub x: f64,
    /// Obstructing point, north \[CRS units\].
    pub y: f64,
    /// Height of the ray there \[m above the datum\].
    pub ray_height_m: f64,
    /// Height of the obstacle there \[m above the datum\]; `None` for nodata that blocks
    /// everything.
    pub top_m: Option<f64>,
}

/// Kind of an obstacle.
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
    /// Kind of the step.
    pub kind: StepKind,
}

/// Kind of a step of a profile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StepKind {
    /// Ground.
    Terrain,
    /// A roof.
    Building,
}

/// Returns a receiver's end of a link, at a position \[CRS units\].
///
/// # Errors
/// If there is no ground or roof for its height to be above, or it would be inside a building or
/// below the ground.
pub fn place_receiver(field: &HeightField, (x, y): (f64, f64), height: Height) -> Result<Station, UavError> {
    let place = field.place(x, y);
    let (ground, inside) = (field.ground_at(&place), indoors_below(field, &place));
    let ground_m = (ground != VOID).then(|| meters(ground));
    match height_over(field, &place, height)? {
        z if z < inside => Err(UavError::InsideBuilding { amsl_m: meters(z), roof_m: meters(inside), ground_m }),
        z if ground != VOID && z < ground => {
            Err(UavError::BelowGround { amsl_m: meters(z), surface_m: meters(ground), ground_m })
        }
        z => Ok(Station { place, z: i64::from(z) }),
    }
}

/// Returns the height below which a place is inside a building; [`VOID`] if it is not.
pub(super) fn indoors_below(field: &HeightField, place: &Place) -> i32 {
    // Over footprints a point on a free wall is outdoors, although the roof to its north-east is
    // its roof.
    match field.prisms() {
        Some(_) => field.inside_prisms_below(place),
        None => field.roof_at(place).unwrap_or(VOID),
    }
}

/// Returns the margin \[m\] of a receiver at height `z`, with the least visible height not below
/// `floor` \[1/1024 m\]; `None` if no receiver height is enough.
pub(super) fn margin_m(least: &LeastHeights, z: i64, floor: f64) -> Option<f64> {
    #[expect(clippy::cast_precision_loss, reason = "heights are at most 2^27 steps")]
    let margin = (z as f64 - least.height_steps().max(floor)) / f64::from(STEPS_PER_UNIT);
    // The sign is decided exactly; rounding must not turn it.
    let margin = if least.is_los { margin.max(0.0) } else { margin.min(-f64::MIN_POSITIVE) };
    margin.is_finite().then_some(margin)
}

impl SceneView<'_> {
    /// Decides the link to a receiver, and finds what stands in its way. All heights are above the
    /// datum.
    pub fn link(&self, receiver: &Station) -> ExplainedLink {
        let (uav, from) = (self.uav().station, self.lowered(receiver));
        let field = self.field();
        let least = link_least_receiver_heights(field, &uav, &from);
        let (dx, dy) = (uav.place.x - from.place.x, uav.place.y - from.place.y);
        let distance_m = dx.hypot(dy) * field.grid().meters_per_unit();
        // The receiver stands on the roof if it is on or above one, else on the ground.
        let ground = field.ground_at(&from.place);
        let roof = field.roof_at(&from.place).filter(|roof| from.z >= i64::from(*roof));
        let floor = match (roof, ground) {
            (Some(roof), _) => f64::from(roof),
            (None, VOID) => f64::NEG_INFINITY,
            (None, ground) => f64::from(ground),
        };
        // From the receiver's horizontal the UAV is as much lower as the receiver is from the
        // UAV's.
        let rise = uav.z - receiver.z - i64::from(self.drop_at(&receiver.place));
        #[expect(clippy::cast_precision_loss, reason = "heights are at most 2^27 steps")]
        let rise_m = rise as f64 / f64::from(STEPS_PER_UNIT);
        ExplainedLink {
            los: least.is_los,
            margin_m: margin_m(&least, from.z, floor),
            distance_m,
            elevation_deg: rise_m.atan2(distance_m).to_degrees(),
            obstruction: if least.is_los { None } else { self.obstacle(&from, &least, distance_m) },
        }
    }

    /// Finds the obstacle that asks for the highest receiver, of a link whose receiver is as it is
    /// seen.
    fn obstacle(&self, receiver: &Station, least: &LeastHeights, distance_m: f64) -> Option<LinkObstacle> {
        let LeastHeights { prisms, columns, .. } = least;
        let (highest, of_prisms) = match (prisms, columns) {
            (LeastHeight::At(p), LeastHeight::At(c)) => {
                let (a, b) = (prisms.height_steps(), least.columns_height_steps());
                let prisms_win = a > b || (a >= b && p.near <= c.near);
                if prisms_win { (p, true) } else { (c, false) }
            }
            (LeastHeight::At(p), LeastHeight::Clear) => (p, true),
            (LeastHeight::Clear, LeastHeight::At(c)) => (c, false),
            (LeastHeight::Clear, LeastHeight::Clear) => return None,
        };
        let uav = &self.uav().station;
        #[expect(clippy::cast_precision_loss, reason = "heights are at most 2^27 steps")]
        let [uav_m, receiver_m] = [uav, receiver].map(|end| end.z as f64 / f64::from(STEPS_PER_UNIT));
        // The obstructing point is the end of the crossing nearest the lower end of the link.
        let t = if uav_m >= receiver_m { highest.near } else { highest.far };
        let along = |from: f64, to: f64| from + t * (to - from);
        let (x, y) = (along(receiver.place.x, uav.place.x), along(receiver.place.y, uav.place.y));
        let kind = kind_of(self.field(), highest, of_prisms);
        let drop_m = match kind {
            ObstacleKind::Cell(cell) => meters(self.drop_of_cell(cell)),
            ObstacleKind::Terrain(cell) => meters(self.drop_of_terrain(cell)),
            _ => 0.0,
        };
        Some(LinkObstacle {
            kind,
            x,
            y,
            ray_height_m: self.ray_above_datum_m(along(receiver_m, uav_m), (x, y), receiver, distance_m),
            top_m: (highest.top != BLOCKS_ALL).then(|| meters(highest.top) + drop_m),
        })
    }

    /// Returns the height above the datum \[m\] of a ray at a position, from that of the straight
    /// line between the ends of a link of some length.
    fn ray_above_datum_m(&self, line_m: f64, (x, y): (f64, f64), receiver: &Station, distance_m: f64) -> f64 {
        let Some(curvature) = self.curvature() else { return line_m };
        if self.field().prisms().is_none() {
            return line_m + meters(self.drop_at(&self.field().place(x, y)));
        }
        // The ray sags between its ends, b·t(1 − t) with the drop b of one end from the other.
        let (from, to) = (&self.uav().station.place, &receiver.place);
        let (dx, dy) = (to.x - from.x, to.y - from.y);
        let t = ((x - from.x) * dx + (y - from.y) * dy) / (dx * dx + dy * dy).max(f64::MIN_POSITIVE);
        line_m - curvature.drop_m(distance_m) * t * (1.0 - t)
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

impl SceneView<'_> {
    /// Returns ground and roofs below the link to a receiver, for a side view of some length \[m\].
    ///
    /// Heights are those that the UAV sees. Terrain comes first, each kind from the UAV on.
    pub fn profile(&self, receiver: &Station, distance_m: f64) -> Vec<ProfileStep> {
        let (field, uav, receiver) = (self.field(), &self.uav().station, self.lowered(receiver));
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
                let ground = [field.ground_at(&receiver.place), field.ground_at(&uav.place)];
                let flat = ground.into_iter().filter(|g| *g != VOID).min();
                steps.extend(flat.map(|z| step((0.0, 1.0), z, StepKind::Terrain)));
            }
            Some(columns) => {
                let mut crossed = columns_crossed(columns, uav.on_columns(), receiver.on_columns());
                // The receiver's own cell is exempt from blocking, not from being there.
                let own = columns.cell_at(receiver.on_columns().x, receiver.on_columns().y);
                let first = crossed.first().map_or(1.0, |c| c.1);
                crossed.extend(own.map(|cell| (cell, 0.0, first)));
                for (cell, near, far) in crossed {
                    let (ground, roof) = field.column_parts(cell);
                    steps.extend(ground.map(|z| step((near, far), z, StepKind::Terrain)));
                    steps.extend(roof.map(|z| step((near, far), z, StepKind::Building)));
                }
            }
        }
        if let Some(prisms) = field.prisms() {
            let (to, from) = (uav.on_prisms(), receiver.on_prisms());
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
        let steps = merged(steps);
        match self.curvature().filter(|_| field.prisms().is_some()) {
            Some(curvature) => steps.iter().flat_map(|step| fallen(step, curvature, distance_m)).collect(),
            None => steps,
        }
    }
}

/// Cuts a step of footprints or the ground below into short ones that a curved earth draws down.
fn fallen(step: &ProfileStep, curvature: Curvature, distance_m: f64) -> Vec<ProfileStep> {
    const PARTS: f64 = 256.0;
    // A roof no longer than some of them is one step.
    const WHOLE: f64 = 4.0;
    let (length, whole) = (distance_m / PARTS, step.to_m - step.from_m);
    let is_whole = step.kind == StepKind::Building && whole <= WHOLE * length;
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "at most so many parts")]
    let n = if is_whole { 1 } else { (whole / length).ceil().clamp(1.0, PARTS) as u32 };
    let at = |k: u32| step.from_m + whole * f64::from(k) / f64::from(n);
    let part = |k: u32| {
        let (from_m, to_m) = (at(k), at(k + 1));
        let fall_m = curvature.drop_m(0.5 * (from_m + to_m));
        ProfileStep { from_m, to_m, heights_m: step.heights_m.map(|m| m - fall_m), kind: step.kind }
    };
    (0..n).map(part).collect()
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
