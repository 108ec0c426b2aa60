//! `skyshed link`: one link, decided and explained.

use skyshed_request::{LinkRequest, Range, Sight, json};

use crate::answer::Answer;
use crate::cli::args::output::checked_files;
use crate::cli::args::scene::scene_files;
use crate::cli::args::sight::parse_receiver;
use crate::cli::failure::{Result, refusal};
use crate::cli::run::Run;
use crate::link::FORMATS;
use crate::picture::Look;
use crate::quantity::tidy;
use crate::sight::SightPlan;
use crate::uav::{Uav, site_of};

/// Answers a request.
///
/// # Errors
/// Errors of the request, the scene and the files.
pub(in crate::cli) fn run(request: &LinkRequest, run: &Run) -> Result<()> {
    run.refuse_data_area(&json::set_members(request))?;
    let site = site_of(request.link.uav.as_deref().unwrap_or_default(), "1".into())?;
    let range = Range { radius: request.link.radius, ..Range::default() };
    let sight = SightPlan::of(&Sight { receiver: request.receiver, range, earth: request.earth, ..Sight::default() })?;
    let radius_m = sight.radius_m();
    let (receiver, height) =
        parse_receiver(request.link.rx.as_deref().unwrap_or_default(), request.receiver.rx_height_m())?;
    let outputs = checked_files(&request.out, None, (&FORMATS, &scene_files(request.scene.word(), &request.reading)))?;
    let look = Look::checked(&request.picture, &request.out.writing, &outputs)?;
    let uav = Uav::new(site.x, site.y, site.height).named(site.id);
    let mut link = run.open_word(request.scene.word(), &request.reading)?.curved_link(
        uav,
        (receiver, height),
        sight.curvature(),
    )?;
    link.facts.command = run.command();
    if let Some(radius) = radius_m.filter(|radius| link.distance_m() > *radius) {
        let distance = tidy(link.distance_m());
        let text = format!("the receiver is {distance} m from the UAV, wanted within `--radius {radius}`");
        return Err(refusal(208, text));
    }
    run.emit(&link as &dyn Answer, &outputs, (&request.out, &look))
}
