//! `skyshed link`: one link, decided and explained, or links between lists.

use std::path::PathBuf;

use skyshed_io::Input;
use skyshed_request::{LinkRequest, Uavs, json};

use crate::answer::Answer;
use crate::cli::args::output::checked_files;
use crate::cli::args::scene::scene_files;
use crate::cli::args::sight::parse_receiver;
use crate::cli::failure::{Result, refusal};
use crate::cli::run::Run;
use crate::error::Error;
use crate::link::{AskedReceiver, FORMATS, LinksPlan, TABLE_FORMATS};
use crate::picture::Look;
use crate::quantity::tidy;
use crate::uav::{Uav, UavsAsked};

/// Answers a request.
///
/// # Errors
/// Errors of the request, the scene and the files.
pub(in crate::cli) fn run(request: &LinkRequest, run: &Run) -> Result<()> {
    run.refuse_data_area(&json::set_members(request))?;
    let link = &request.link;
    let plan = LinksPlan::of(request)?;
    let sight = plan.sight;
    let uavs = UavsAsked::some_of(&uavs_of(request), request.reading.options.hash)?;
    let typed = typed_receivers(request)?;
    let are_lists = uavs.table.is_some() || link.rxs.is_some() || uavs.typed.len() > 1 || typed.len() > 1;
    if are_lists {
        return many(request, run, (plan, &uavs, typed));
    }
    for (name, is_set) in [("pairs", link.pairs), ("los_only", link.los_only), ("skip_bad", request.uavs.skip_bad)] {
        if is_set {
            return Err(Error::idle(name, "for a single link").into());
        }
    }
    let outputs = checked_files(&request.out, None, (&FORMATS, &scene_files(request.scene.word(), &request.reading)))?;
    let look = Look::checked(&request.picture, &request.out.writing, &outputs)?;
    let (Some(site), Some(receiver)) = (uavs.typed.into_iter().next(), typed.into_iter().next()) else {
        return Err(Error::fault("a link has two ends").into());
    };
    let uav = Uav::new(site.x, site.y, site.height).named(site.id);
    let mut link = run.open_word(request.scene.word(), &request.reading)?.curved_link(
        uav,
        (receiver.at, receiver.height),
        sight.curvature(),
    )?;
    link.facts.command = run.command();
    if let Some(radius) = sight.radius_m().filter(|radius| link.distance_m() > *radius) {
        let distance = tidy(link.distance_m());
        let text = format!("the receiver is {distance} m from the UAV, wanted within `--radius {radius}`");
        return Err(refusal(208, text));
    }
    run.emit(&link as &dyn Answer, &outputs, (&request.out, &look))
}

/// Returns the question about UAVs: bad rows may be those of the receivers alone.
fn uavs_of(request: &LinkRequest) -> Uavs {
    let skip_bad = request.uavs.skip_bad && request.uavs.uavs.is_some();
    Uavs { skip_bad, ..request.uavs.clone() }
}

fn typed_receivers(request: &LinkRequest) -> Result<Vec<AskedReceiver>> {
    let receiver = |(k, text): (usize, &String)| {
        let (at, height) = parse_receiver(text, request.receiver.rx_height_m())?;
        Ok(AskedReceiver { id: (k + 1).to_string(), at, height })
    };
    request.link.rx.iter().enumerate().map(receiver).collect()
}

/// Decides links between lists.
fn many(
    request: &LinkRequest,
    run: &Run,
    (plan, uavs, typed): (LinksPlan, &UavsAsked, Vec<AskedReceiver>),
) -> Result<()> {
    let table = request.link.rxs.as_ref().map(Input::of);
    let files = uavs.file().into_iter().chain(table.as_ref().and_then(Input::file).map(PathBuf::from));
    let inputs: Vec<PathBuf> = scene_files(request.scene.word(), &request.reading).into_iter().chain(files).collect();
    let outputs = checked_files(&request.out, None, (&TABLE_FORMATS, &inputs))?;
    let look = Look::checked(&request.picture, &request.out.writing, &outputs)?;
    let mut scene = run.open_word(request.scene.word(), &request.reading)?;
    let found = uavs.read(scene.grid())?;
    let mut receivers = typed;
    if let Some(table) = table {
        let (skips_bad, hash) = (request.uavs.skip_bad, request.reading.options.hash);
        receivers.extend(plan.read_receivers((&table, skips_bad, hash), receivers.len() + 1, &mut scene)?);
    }
    let links = plan.decide(scene, (&found, &receivers), run.command())?;
    run.emit(&links, &outputs, (&request.out, &look))
}
