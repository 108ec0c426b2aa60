//! `skyshed link`: one link, decided and explained.

use super::args::LinkArgs;
use super::plan::{input_paths, parse_receiver, parse_uav, ready};
use super::{interrupt, messages};
use crate::city::Site;
use crate::coverage::Uav;
use crate::error::{Error, Result};
use crate::export::{Batch, Format, OutputRules, check_outputs};
use crate::height_field::Station;
use crate::los::Method;
use crate::los::{LeastHeight, Obstruction, columns_crossed, link_least_receiver_heights, prisms_crossed};
use crate::map::{checked_radius, receiver_height};
use crate::quantity::{BLOCKS_ALL, Height, MAX_EXTENT_UNITS, STEPS_PER_UNIT, VOID, height_steps, meters, tidy};
use crate::render::{self, LinkProfile, PictureForm, ProfileStep, StepKind};
use crate::report::{LinkReport, ObstructionReport};
use crate::scene::Scene;
use crate::scene::limits::warn_of_drop;
use crate::scene::outside::{place_uav, warn_of_uavs_outside};
use crate::words::{pretty, title_of};

const FORMATS: [Format; 5] = [Format::Png, Format::Svg, Format::Pdf, Format::Json, Format::Stdout];

pub(super) fn run(args: &LinkArgs, command: Vec<String>) -> Result<()> {
    let rx = match (&args.track, &args.rx) {
        (Some(track), _) => return super::track::run(args, track, command),
        (None, Some(rx)) => rx,
        (None, None) => return Err(Error::usage(108, "no receiver: wanted `--rx X,Y` or `--track FILE`")),
    };
    let site = parse_uav(&args.uav, "1".into())?;
    receiver_height(args.rx_height)?;
    let radius_m = checked_radius(args.engine.radius)?;
    let (x, y, height) = parse_receiver(rx, args.rx_height)?;
    let outputs = check_outputs(
        &args.output,
        OutputRules {
            allowed: &FORMATS,
            inputs: &input_paths(&args.scene),
            overwrite: args.out.overwrite,
            bare: false,
        },
    )?;
    args.size.refuse_without_picture(&outputs)?;
    let mut scene = ready(&args.scene)?;
    warn_of_uavs_outside(std::slice::from_ref(&site), scene.field.grid(), &mut scene.warnings);
    check_extent(&scene, &site, (x, y))?;
    let reach = (x - site.x).abs().max((y - site.y).abs()).max(1.0);
    let uav = place_uav(&site, &scene.field, scene.field.grid(), Some(reach))?;
    let receiver = receiver(&scene, x, y, height)?;
    let distance = (receiver.place.x - site.x).hypot(receiver.place.y - site.y);
    warn_of_drop(distance * scene.field.grid().meters_per_unit(), &mut scene.warnings);
    let report = explain(&scene, &uav, &receiver, command);
    if let Some(radius) = radius_m.filter(|r| report.distance_m > *r) {
        return Err(Error::site(
            208,
            format!("the receiver is {} m from the UAV, wanted within `--radius {radius}`", tidy(report.distance_m)),
        ));
    }

    interrupt::begin_writing();
    let mut batch = Batch::new(args.out.overwrite);
    for (path, format) in &outputs {
        let bytes = match format {
            Format::Json => pretty(&report.document()).into_bytes(),
            Format::Png | Format::Svg | Format::Pdf => {
                picture(&scene, &uav, &receiver, &report, &args.size.form(*format))?
            }
            _ => continue,
        };
        interrupt::check()?;
        batch.add(path, &bytes)?;
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

/// The lattice must hold the link.
pub(super) fn check_extent(scene: &Scene, site: &Site, (x, y): (f64, f64)) -> Result<()> {
    let frames = [scene.field.prisms_frame(), scene.field.columns_frame()];
    for frame in frames.into_iter().flatten() {
        let extent = ((x - site.x) / frame.unit_x).abs().max(((y - site.y) / frame.unit_y).abs());
        if extent > MAX_EXTENT_UNITS {
            return Err(Error::site(
                203,
                format!(
                    "cannot decide the link from ({}, {}) to ({x}, {y}): it spans {extent:.0} units, wanted at most \
                     {MAX_EXTENT_UNITS}",
                    site.x, site.y
                ),
            )
            .with_hint("check the coordinate reference systems of both ends"));
        }
    }
    Ok(())
}

/// The receiver's end: on ground or roof that is there, not inside a building.
fn receiver(scene: &Scene, x: f64, y: f64, height: Height) -> Result<Station> {
    let field = &scene.field;
    let place = field.place(x, y);
    let what = format!("cannot place the receiver at ({x}, {y}) with height {height}");
    let (ground, roof) = (field.ground_at(&place), field.roof_at(&place));
    let base = match height {
        Height::AboveDatum(_) => 0,
        Height::AboveGround(_) if ground == VOID => {
            return Err(Error::site(204, format!("{what}: no ground is known there"))
                .with_hint(format!("give the height above the datum: `{}amsl`", height.value())));
        }
        Height::AboveGround(_) => ground,
        Height::AboveRoof(_) if field.is_surface_only() => {
            return Err(Error::site(204, format!("{what}: with a surface model alone no roof is known")));
        }
        Height::AboveRoof(_) => roof.ok_or_else(|| Error::site(204, format!("{what}: no building is there")))?,
    };
    let z = height_steps(height.value())
        .and_then(|h| base.checked_add(h))
        .ok_or_else(|| Error::site(205, format!("{what}: wanted within ±32768 m of the datum")))?;
    // Over footprints a point on a free wall is outdoors, although the roof to its north-east is its roof.
    let inside = if field.prisms().is_some() { field.inside_prisms_below(&place) } else { roof.unwrap_or(VOID) };
    if z < inside {
        return Err(Error::site(
            201,
            format!(
                "{what}: {} m above the datum is inside a building with its roof at {} m",
                tidy(meters(z)),
                tidy(meters(inside))
            ),
        )
        .with_hint(format!("on the roof it is `{}roof`", height.value().max(0.0))));
    }
    if ground != VOID && z < ground {
        return Err(Error::site(
            202,
            format!("{what}: {} m above the datum is below the ground at {} m", meters(z), meters(ground)),
        ));
    }
    Ok(Station { place, z: i64::from(z) })
}

fn explain(scene: &Scene, uav: &Uav, receiver: &Station, command: Vec<String>) -> LinkReport {
    let field = &scene.field;
    let (prisms, columns) = link_least_receiver_heights(field, &uav.station, receiver);
    let los = prisms.is_met_by(receiver.z) && columns.is_met_by(receiver.z);
    let steps = f64::from(STEPS_PER_UNIT);
    #[expect(clippy::cast_precision_loss, reason = "heights are at most 2^27 steps")]
    let (uav_z, receiver_z) = (uav.station.z as f64 / steps, receiver.z as f64 / steps);
    let unit = field.grid().meters_per_unit();
    let (from, to) = (receiver.place, uav.station.place);
    let distance_m = (to.x - from.x).hypot(to.y - from.y) * unit;

    // The least visible height is never below what the receiver stands on: the roof if it is on or above one, else the ground.
    let ground = field.ground_at(&receiver.place);
    let roof = field.roof_at(&receiver.place).filter(|roof| receiver.z >= i64::from(*roof));
    let floor = match (roof, ground) {
        (Some(roof), _) => f64::from(roof),
        (None, VOID) => f64::NEG_INFINITY,
        (None, ground) => f64::from(ground),
    };
    let least = prisms.height_steps().max(columns.height_steps()).max(floor) / steps;
    let margin = receiver_z - least;
    let margin = if los { margin.max(0.0) } else { margin.min(-f64::MIN_POSITIVE) };

    let columns_kind = if field.prisms().is_some() { "terrain" } else { "cell" };
    let higher = match (&prisms, &columns) {
        (LeastHeight::At(p), LeastHeight::At(c)) => {
            let (a, b) = (prisms.height_steps(), columns.height_steps());
            let prisms_win = a > b || (a >= b && p.near <= c.near);
            if prisms_win { Some((*p, true)) } else { Some((*c, false)) }
        }
        (LeastHeight::At(p), LeastHeight::Clear) => Some((*p, true)),
        (LeastHeight::Clear, LeastHeight::At(c)) => Some((*c, false)),
        (LeastHeight::Clear, LeastHeight::Clear) => None,
    };
    let obstruction = higher.filter(|_| !los).map(|(o, of_prisms)| {
        let t = obstructing_fraction(&o, uav_z >= receiver_z);
        let piece = field.prisms().filter(|_| of_prisms).map(|p| p.pieces()[o.obstacle]);
        let cell = field.columns().filter(|_| !of_prisms).map(|c| (o.obstacle / c.n_cols(), o.obstacle % c.n_cols()));
        ObstructionReport {
            kind: match (o.top, of_prisms) {
                (BLOCKS_ALL, _) => "nodata",
                (_, true) => "building",
                (_, false) => columns_kind,
            },
            id: piece.map(|p| field.building_id(p.building).to_string()),
            cell,
            x: from.x + t * (to.x - from.x),
            y: from.y + t * (to.y - from.y),
            ray_height_m: receiver_z + t * (uav_z - receiver_z),
            roof_height_m: (o.top != BLOCKS_ALL).then(|| meters(o.top)),
        }
    });
    LinkReport {
        facts: scene.facts(command, Some(Method::Ray)),
        uav: [to.x, to.y, uav_z],
        receiver: [from.x, from.y, receiver_z],
        los,
        margin_m: margin.is_finite().then_some(margin),
        distance_m,
        elevation_deg: (uav_z - receiver_z).atan2(distance_m).to_degrees(),
        obstruction,
    }
}

/// The obstructing point: the end of the crossing nearest the lower terminal.
fn obstructing_fraction(obstruction: &Obstruction, receiver_is_lower: bool) -> f64 {
    if receiver_is_lower { obstruction.near } else { obstruction.far }
}

fn in_words(report: &LinkReport) -> String {
    let place = |e: &[f64; 3]| format!("({}, {}), {} m", tidy(e[0]), tidy(e[1]), tidy(e[2]));
    let mut text = format!(
        "{}: UAV at {} to receiver at {} above the datum\n",
        if report.los { "LoS" } else { "NLoS" },
        place(&report.uav),
        place(&report.receiver)
    );
    text += &format!(
        "distance {} m, elevation angle {}°, margin {}\n",
        tidy(report.distance_m),
        tidy(report.elevation_deg),
        report.margin_m.map_or("none: no receiver height is enough".to_string(), |m| format!("{m:.3} m"))
    );
    if let Some(o) = &report.obstruction {
        let name = match (&o.id, o.cell) {
            (Some(id), _) => format!("building `{id}`"),
            (None, Some((row, col))) => format!("{} at row {row}, column {col}", o.kind),
            (None, None) => o.kind.to_string(),
        };
        let roof = o.roof_height_m.map_or("which blocks everything".to_string(), |r| format!("roof height {r:.3} m"));
        text += &format!(
            "obstructed by {name}: obstructing point ({}, {}), ray height {:.3} m, {roof}\n",
            tidy(o.x),
            tidy(o.y),
            o.ray_height_m,
        );
    }
    text
}

fn picture(scene: &Scene, uav: &Uav, receiver: &Station, report: &LinkReport, form: &PictureForm) -> Result<Vec<u8>> {
    let field = &scene.field;
    if report.distance_m <= 0.0 {
        return Err(Error::usage(109, "cannot draw the side view of a vertical link"));
    }
    let steps = profile(scene, uav, receiver, report.distance_m);
    let obstruction = report.obstruction.as_ref().map(|o| render::Obstruction {
        distance_m: (o.x - report.uav[0]).hypot(o.y - report.uav[1]) * field.grid().meters_per_unit(),
        ray_height_m: o.ray_height_m,
        // Nodata that blocks everything is drawn as high as the UAV.
        roof_height_m: o.roof_height_m.unwrap_or(report.uav[2].max(report.receiver[2])),
    });
    let verdict = if report.los { "line of sight" } else { "no line of sight" };
    let title = title_of(&format!("{}: {verdict}", scene.name));
    let mut caption: Vec<String> = in_words(report).lines().map(str::to_string).collect();
    caption.extend(scene.limits_in_words());
    let profile = LinkProfile {
        title: &title,
        caption: &caption,
        height_name: "Height above the datum",
        distance_m: report.distance_m,
        uav: ("UAV", report.uav[2]),
        receiver: ("Receiver", report.receiver[2]),
        steps: &steps,
        obstruction,
    };
    let provenance = [("skyshed".to_string(), report.document().to_string())];
    let drawn = render::draw_link_profile(&profile, form, &provenance);
    drawn.map_err(|e| Error::internal(403, format!("cannot draw the picture: {e}")))
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
