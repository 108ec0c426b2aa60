//! A link from the side.

use super::Link;
use crate::answer::Answer;
use crate::coverage::Uav;
use crate::error::{RequestError, Result};
use crate::export::Format;
use crate::height_field::Station;
use crate::los::{columns_crossed, prisms_crossed};
use crate::picture::{Look, picture_provenance, written};
use crate::quantity::{BLOCKS_ALL, VOID, meters};
use crate::render::{self, LinkProfile, ProfileStep, StepKind};
use crate::scene::Scene;
use crate::words::title_of;

/// Draws a link.
///
/// # Errors
/// E109 for a vertical link, which has no side.
pub(super) fn draw(link: &Link, format: Format, look: &Look) -> Result<Vec<u8>> {
    let (scene, found) = (&link.scene, &link.found);
    if found.distance_m <= 0.0 {
        return Err(RequestError::VerticalLink.into());
    }
    let steps = profile(scene, &link.uav, &link.receiver, found.distance_m);
    let (uav_m, receiver_m) = (found.uav.height_amsl_m, found.receiver.height_amsl_m);
    let obstruction = found.obstruction.as_ref().map(|o| render::Obstruction {
        distance_m: (o.x - found.uav.x).hypot(o.y - found.uav.y) * scene.grid().meters_per_unit(),
        ray_height_m: o.ray_height_m,
        // Nodata that blocks everything is drawn as high as the UAV.
        roof_height_m: o.roof_height_m.unwrap_or(uav_m.max(receiver_m)),
    });
    let verdict = if found.los { "line of sight" } else { "no line of sight" };
    let title = look.title_or(|| title_of(&format!("{}: {verdict}", scene.name)));
    let mut caption: Vec<String> = link.text(look)?.lines().map(str::to_string).collect();
    caption.extend(scene.last_lines(look));
    let profile = LinkProfile {
        title: &title,
        caption: &caption,
        distance_m: found.distance_m,
        uav_m,
        receiver_m,
        steps: &steps,
        obstruction,
    };
    let provenance = picture_provenance(&link.document());
    written(render::draw_link_profile(&profile), &look.form(format), &provenance)
}

/// Ground and roofs below a link, for its side view.
fn profile(scene: &Scene, uav: &Uav, receiver: &Station, distance_m: f64) -> Vec<ProfileStep> {
    let field = &scene.field;
    // Fractions count from the receiver, the picture's distances from the UAV.
    let step = |(near, far): (f64, f64), top: i32, kind: StepKind| ProfileStep {
        from_m: (1.0 - far) * distance_m,
        to_m: (1.0 - near) * distance_m,
        height_m: meters(top),
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
        for (piece, near, far) in prisms_crossed(prisms, uav.station.on_prisms(), receiver.on_prisms()) {
            steps.push(step((near, far), prisms.pieces()[piece].top, StepKind::Building));
        }
    }
    merged(steps)
}

/// Joins steps of the same height and kind that follow each other.
fn merged(mut steps: Vec<ProfileStep>) -> Vec<ProfileStep> {
    let order = |kind: StepKind| matches!(kind, StepKind::Building);
    steps.sort_by(|a, b| order(a.kind).cmp(&order(b.kind)).then(a.from_m.total_cmp(&b.from_m)));
    let mut joined: Vec<ProfileStep> = Vec::with_capacity(steps.len());
    for step in steps {
        match joined.last_mut() {
            Some(last)
                if last.kind == step.kind
                    && (last.height_m - step.height_m).abs() < 1e-9
                    && (last.to_m - step.from_m).abs() < 1e-6 =>
            {
                last.to_m = step.to_m;
            }
            _ => joined.push(step),
        }
    }
    joined
}
