//! Side view of a link.

use super::Link;
use crate::answer::Answer;
use crate::coverage::SceneView;
use crate::error::{RequestError, Result};
use crate::export::Format;
use crate::picture::{Look, picture_provenance, written};
use crate::quantity::{meters, tidy};
use crate::render::{self, LinkProfile};
use crate::words::title_of;

/// Draws a link.
///
/// # Errors
/// E109 for a vertical link, which has no side view.
pub(super) fn draw(link: &Link, format: Format, look: &Look) -> Result<Vec<u8>> {
    let (scene, found) = (&link.scene, &link.found);
    if found.distance_m <= 0.0 {
        return Err(RequestError::VerticalLink.into());
    }
    // Over a curved earth the drawing is in the UAV's frame: the ray is straight and the ground
    // falls away.
    let view = SceneView::of(&scene.field, &link.uav, link.curvature)?;
    let (steps, receiver) = (view.profile(&link.receiver, found.distance_m), view.seen(&link.receiver));
    let (uav_m, receiver_m) = (found.uav.height_amsl_m, i32::try_from(receiver.z).map_or(f64::NAN, meters));
    let fall_m = |x: f64, y: f64| meters(view.drop_at(&scene.field.place(x, y)));
    let obstruction = found.obstruction.as_ref().map(|o| render::Obstruction {
        distance_m: (o.x - found.uav.x).hypot(o.y - found.uav.y) * scene.grid().meters_per_unit(),
        ray_height_m: o.ray_height_m - fall_m(o.x, o.y),
        // Nodata that blocks everything is drawn as high as the higher end of the link.
        roof_height_m: o.roof_height_m.map_or(uav_m.max(receiver_m), |roof_m| roof_m - fall_m(o.x, o.y)),
    });
    let verdict = if found.los { "line of sight" } else { "no line of sight" };
    let title = look.title_or(|| title_of(&format!("{}: {verdict}", scene.name)));
    let mut caption: Vec<String> = link.text(look)?.lines().map(str::to_string).collect();
    if link.curvature.is_some() {
        let fall_m = tidy(found.receiver.height_amsl_m - receiver_m);
        caption.push(format!("As the UAV sees it: the earth falls away, by {fall_m} m at the receiver"));
    }
    caption.extend(scene.last_lines(look));
    let profile = LinkProfile {
        title: &title,
        caption: &caption,
        heights: match link.curvature {
            Some(_) => "Height above the datum, less the fall of the earth [m]",
            None => "Height above the datum [m]",
        },
        distance_m: found.distance_m,
        uav_m,
        receiver_m,
        steps: &steps,
        obstruction,
    };
    let provenance = picture_provenance(&link.document());
    written(render::draw_link_profile(&profile), &look.form(format), &provenance)
}
