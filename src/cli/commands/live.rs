//! `skyshed live`: a page in which a UAV is dragged over the city.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use skyshed_io::Input;
use skyshed_request::{LiveRequest, Uavs, json};

use crate::cli::args::output::checked_files;
use crate::cli::args::scene::{scene_files, scene_words};
use crate::cli::failure::{Result, refusal};
use crate::cli::run::Run;
use crate::cli::say;
use crate::error::Error;
use crate::export::Format;
use crate::live::{FORMATS, LivePage, LivePlan};
use crate::picture::Look;
use crate::sight::SightPlan;
use crate::track::TrackAsked;
use crate::uav::UavsAsked;

/// Answers a request.
///
/// # Errors
/// Errors of the request, the scene and the files.
pub(in crate::cli) fn run(request: &LiveRequest, run: &Run) -> Result<()> {
    json::refuse(&json::set_members(request), &["method"], "for a page: it uses the fastest exact engine")
        .map_err(Error::from)?;
    json::refuse(&json::set_members(request), &["width", "dpi"], "for a page, which is as wide as its window")
        .map_err(Error::from)?;
    let hash = request.reading.options.hash;
    let track = match &request.track.track {
        Some(file) => Some(TrackAsked::of((Input::of(file), request.uavs.skip_bad, hash), &request.track)?),
        None => {
            json::refuse(&json::set_members(&request.track), &["every", "follow_ground"], "without a track")
                .map_err(Error::from)?;
            None
        }
    };
    // Bad rows may be those of the track alone.
    let skip_bad = request.uavs.skip_bad && (track.is_none() || request.uavs.uavs.is_some());
    let uavs = UavsAsked::of(&Uavs { skip_bad, ..request.uavs.clone() }, hash)?;
    let files = uavs.file().into_iter().chain(track.iter().filter_map(|track| track.file.file().map(PathBuf::from)));
    let inputs: Vec<PathBuf> = scene_files(request.scene.word(), &request.reading).into_iter().chain(files).collect();
    let mut outputs = checked_files(&request.out, None, (&FORMATS, &inputs))?;
    let opens = outputs.is_empty() && !request.out.files.json;
    if opens {
        outputs.push((temporary(request.scene.word())?, Format::Html));
    }
    let look = Look::checked(&request.picture, &request.out.writing, &outputs)?;
    let plan = LivePlan {
        uavs,
        track,
        sight: SightPlan::of(&request.sight)?,
        scene_words: scene_words(request.scene.word(), &request.reading),
        command: run.command(),
    };
    let page = LivePage::open(&run.reader(&request.reading), request.scene.word(), plan)?;
    if !opens {
        return run.emit(&page, &outputs, (&request.out, &look));
    }
    run.emit(&page, &outputs, (&request.out, &look))?;
    if open::that_detached(&outputs[0].0).is_err() {
        say::note("no browser could be started: open the file in one");
    }
    Ok(())
}

/// Returns the path of a scene's page in a new temporary folder, which is not removed.
///
/// # Errors
/// E401.
fn temporary(scene: &OsStr) -> Result<PathBuf> {
    let stem = Path::new(scene).file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let name: String = stem.chars().map(|c| if c.is_alphanumeric() { c } else { '-' }).collect();
    let folder = tempfile::Builder::new().prefix("skyshed-").tempdir();
    let folder = folder.map_err(|e| refusal(401, format!("cannot make a folder for the page: {e}")))?;
    Ok(folder.keep().join(format!("{name}.html")))
}
