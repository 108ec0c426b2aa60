//! `skyshed link --track`: line of sight along a user's track.

use std::path::Path;

use super::args::LinkArgs;
use super::link::check_extent;
use super::plan::{input_paths, parse_uav, ready};
use super::{interrupt, messages};
use crate::coverage::{TrackState, along_track};
use crate::error::{Error, Result, Warning};
use crate::export::{Batch, Format, OutputRules, check_outputs, with_suffix};
use crate::los::Method;
use crate::map::receiver_height;
use crate::quantity::{counted, tidy};
use crate::read::read_track;
use crate::read::source_of;
use crate::render::{self, PictureForm, TrackProfile, TrackStretch};
use crate::report::TrackReport;
use crate::scene::limits::warn_of_drop;
use crate::scene::outside::{place_uav, warn_of_uavs_outside};
use crate::uav::bad_rows;
use crate::words::{pretty, title_of};

const FORMATS: [Format; 6] = [Format::Png, Format::Svg, Format::Pdf, Format::Csv, Format::Json, Format::Stdout];

/// More places than this are refused.
const MOST_PLACES: f64 = 1e6;

pub(super) fn run(args: &LinkArgs, path: &Path, command: Vec<String>) -> Result<()> {
    let site = parse_uav(&args.uav, "1".into())?;
    let rx_height = receiver_height(args.rx_height)?;
    if args.every <= 0.0 {
        return Err(Error::usage(113, format!("`--every` is `{}`, wanted above 0 m", args.every)));
    }
    if args.engine.radius.is_some() {
        return Err(Error::usage(116, "`--radius` has no meaning together with `--track`"));
    }
    let inputs: Vec<_> = input_paths(&args.scene).into_iter().chain([path.to_path_buf()]).collect();
    let rules = OutputRules { allowed: &FORMATS, inputs: &inputs, overwrite: args.out.overwrite, bare: false };
    let outputs = check_outputs(&args.output, rules)?;
    args.size.refuse_without_picture(&outputs)?;
    let mut scene = ready(&args.scene)?;
    warn_of_uavs_outside(std::slice::from_ref(&site), scene.field.grid(), &mut scene.warnings);
    let bad = bad_rows(args.skip_bad, &mut scene.warnings);
    let places = read_track(path, scene.field.grid().crs(), bad)?;
    scene.sources.push(source_of(path, args.scene.hash)?);
    let length: f64 = places.windows(2).map(|e| (e[1][0] - e[0][0]).hypot(e[1][1] - e[0][1])).sum();
    let unit = scene.field.grid().meters_per_unit();
    if length * unit / args.every > MOST_PLACES {
        let text = format!("cannot walk {} m of track in steps of {} m", tidy(length * unit), args.every);
        return Err(Error::limit(502, text).with_hint("choose longer steps: `--every M`"));
    }
    let mut reach = 1.0_f64;
    for place in &places {
        check_extent(&scene, &site, (place[0], place[1]))?;
        reach = reach.max((place[0] - site.x).abs()).max((place[1] - site.y).abs());
    }
    let uav = place_uav(&site, &scene.field, scene.field.grid(), Some(reach))?;
    let farthest = places.iter().map(|[x, y]| (x - site.x).hypot(y - site.y)).fold(0.0, f64::max);
    warn_of_drop(farthest * unit, &mut scene.warnings);
    let track = along_track(&scene.field, &uav, &places, rx_height, args.every / unit);
    let n_outside = track.points.iter().filter(|p| p.state == TrackState::NoReceiver).count();
    if n_outside > 0 {
        let places = counted(n_outside as u64, "place", "places");
        let text = format!(
            "{places} of {} on the track hold no receiver: inside a building, or without a ground",
            track.points.len()
        );
        scene.warnings.push(Warning::new(202, text));
    }
    let report = TrackReport {
        facts: scene.facts(command, Some(Method::Ray)),
        rx_height_m: args.rx_height,
        every_m: args.every,
        uav: [uav.station.place.x, uav.station.place.y, uav.height_amsl_m()],
        track,
    };

    interrupt::begin_writing();
    let mut batch = Batch::new(args.out.overwrite);
    for (path, format) in &outputs {
        interrupt::check()?;
        match format {
            Format::Json => batch.add(path, pretty(&report.document()).as_bytes())?,
            Format::Csv => {
                batch.add(path, &args.out.table(&report.table())?)?;
                batch.add(&with_suffix(path, ".json"), pretty(&report.provenance()).as_bytes())?;
            }
            Format::Png | Format::Svg | Format::Pdf => {
                let title = title_of(&format!("{}: line of sight along a track", scene.name));
                batch.add(path, &picture((&title, scene.limits_in_words()), &report, &args.size.form(*format))?)?;
            }
            _ => {}
        }
    }
    let files = batch.commit()?;
    if !args.out.quiet {
        messages::warnings(&scene.warnings);
    }
    messages::wrote(&files, args.out.quiet);
    if args.out.json || outputs.iter().any(|(_, f)| *f == Format::Stdout) {
        messages::answer(&pretty(&report.document()))
    } else {
        messages::answer(&in_words(&report))
    }
}

fn in_words(report: &TrackReport) -> String {
    let length = |state| tidy(report.length_m(state));
    let stretches = report.track.stretches.iter().filter(|s| s.state == TrackState::Nlos).count();
    let share = report.share().map_or("undefined: no place holds a receiver".to_string(), |p| format!("{p:.4}"));
    let mut text = format!(
        "P_LoS along the track {share}: {} m with line of sight, {} m without in {}, the longest {} m\n",
        length(TrackState::Los),
        length(TrackState::Nlos),
        counted(stretches as u64, "stretch", "stretches"),
        tidy(report.longest_without_m())
    );
    if report.length_m(TrackState::NoReceiver) > 0.0 {
        text += &format!("{} m without a receiver\n", length(TrackState::NoReceiver));
    }
    text
}

/// Where the user has line of sight, and how high would be enough elsewhere.
fn picture((title, limits): (&str, Option<String>), report: &TrackReport, form: &PictureForm) -> Result<Vec<u8>> {
    let unit = report.facts.meters_per_unit;
    let stretch = |s: &crate::coverage::Stretch| TrackStretch {
        along_m: s.along.map(|along| along * unit),
        los: match s.state {
            TrackState::Los => Some(true),
            TrackState::Nlos => Some(false),
            TrackState::NoReceiver => None,
        },
    };
    let stretches: Vec<TrackStretch> = report.track.stretches.iter().map(stretch).collect();
    let enough = |p: &crate::coverage::TrackPoint| (p.along * unit, p.margin_m.map(|m| report.rx_height_m - m));
    let enough: Vec<(f64, Option<f64>)> = report.track.points.iter().map(enough).collect();
    let mut caption: Vec<String> = in_words(report).lines().map(str::to_string).collect();
    caption.push(format!(
        "UAV at ({}, {}), {} m above the datum; user {} m above ground; decided every {} m; skyshed {}",
        tidy(report.uav[0]),
        tidy(report.uav[1]),
        tidy(report.uav[2]),
        tidy(report.rx_height_m),
        tidy(report.every_m),
        env!("CARGO_PKG_VERSION")
    ));
    caption.extend(limits);
    let profile = TrackProfile {
        title,
        caption: &caption,
        length_m: report.track.points.last().map_or(0.0, |p| p.along * unit),
        stretches: &stretches,
        enough: &enough,
        user_m: report.rx_height_m,
    };
    let provenance = [("skyshed".to_string(), report.provenance().to_string())];
    let drawn = render::draw_track_profile(&profile, form, &provenance);
    drawn.map_err(|cause| Error::internal(403, format!("cannot draw the picture: {cause}")))
}
