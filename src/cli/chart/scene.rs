//! The contestants on a scene: each prepared, timed and compared with the exact answer.

use std::path::PathBuf;
use std::sync::atomic::Ordering;

use super::measure::{measured, memory_floor};
use super::write::{Chart, write};
use super::{ChartArgs, in_turns, peers, refuse_typed, show, threads};
use crate::accuracy::chart::{Contestant, Family, MOST_RAYS, Truth};
use crate::accuracy::comparison::Comparison;
use crate::city::GivenSite;
use crate::cli::plan::ready;
use crate::cli::plan::uavs_asked;
use crate::cli::{interrupt, messages};
use crate::coverage::{MapOptions, Uav};
use crate::error::{Error, Result, Warning};
use crate::export::Format;
use crate::los::Method;
use crate::map::{Asked, check_receivers, checked_radius, receiver_height};
use crate::memory::{FIELD_BYTES_PER_CELL, check_memory};
use crate::quantity::counted;
use crate::render::grouped;
use crate::report::{ChartReport, ChartRow, Cost};
use crate::scene::Scene;
use crate::scene::limits::warn_of_flat_earth;
use crate::scene::outside::{place_uav, warn_of_uavs_outside};

/// Bytes that a cell takes beside the scene: the scene once more on other cells, the heights and the mask of the floor, those
/// of a peer.
const BYTES_PER_CELL: usize = FIELD_BYTES_PER_CELL + 5 + 8;

pub(super) fn run(args: &ChartArgs, command: Vec<String>, outputs: &[(PathBuf, Format)]) -> Result<()> {
    refuse_typed(args, &["theta", "height"], "without `--plos`")?;
    if args.receivers.zone().is_some() {
        let text =
            format!("`--receivers {}` has no meaning here: coarser cells have other zones", args.receivers.name());
        return Err(Error::usage(116, text).with_hint("wanted ground, roof or all"));
    }
    let rx_height = receiver_height(args.rx_height)?;
    let radius_m = checked_radius(args.engine.radius)?;
    let asked = uavs_asked(&args.uav, args.uavs.as_ref(), (args.skip_bad, args.scene.hash))?;
    if asked.typed.is_empty() && args.uavs.is_none() {
        return Err(Error::usage(108, "no UAV: wanted `--uav X,Y,H` or `--uavs FILE`")
            .with_hint("`--plos` charts the P_LoS methods of a generated city without one"));
    }
    let mut scene = ready(&args.scene)?;
    let found = asked.read(scene.field.grid())?;
    scene.sources.extend(found.sources);
    scene.warnings.extend(found.warnings);
    warn_of_uavs_outside(&found.sites, scene.field.grid(), &mut scene.warnings);
    let radius = radius_m.map(|r| scene.crs_units(r));
    let place = |site: &GivenSite| place_uav(site, &scene.field, scene.field.grid(), radius);
    let uavs: Vec<Uav> = found.sites.iter().map(place).collect::<Result<_>>()?;
    check_receivers(args.receivers, &scene.field)?;
    check_memory(&args.scene.scene, scene.field.grid(), BYTES_PER_CELL + uavs.len().div_ceil(2))?;
    warn_of_flat_earth(&uavs, scene.field.grid(), radius, &mut scene.warnings);

    let asked = Asked { receivers: args.receivers, rx_height, radius, method: args.engine.method };
    let options = asked.options(scene.field.grid(), None);
    let contestants = Contestant::all(&scene.field, args.engine.method)?;
    let truth = Truth::of(&scene.field, &uavs, &options, MOST_RAYS)?;
    if truth.receivers() == 0 {
        scene.warnings.push(Warning::new(202, "no UAV has a receiver in range; shares and P_LoS are undefined"));
    }
    let planned = contestants.len() + usize::from(args.peers);
    if !args.out.quiet {
        let receivers = counted(truth.receivers(), "receiver", "receivers");
        let contestants = counted(planned as u64, "contestant", "contestants");
        messages::note(&format!("{receivers} decided exactly by {}; {contestants} to come", truth.method));
    }
    interrupt::begin_pieces();
    let arena = Arena { args, scene: &scene, uavs: &uavs, options: &options, truth: &truth };
    let (floor, rows) = arena.run(&contestants)?;
    let report = ChartReport {
        facts: scene.facts(command, Some(truth.method)),
        rx_height_m: args.rx_height,
        receivers: args.receivers.name(),
        radius_m,
        uavs: uavs.iter().cloned().zip(found.sites.iter().map(|site| site.lonlat)).collect(),
        truth: truth.clone(),
        threads: usize::from(threads(args)),
        floor,
        rows,
        planned,
    };
    let chart = Chart {
        document: report.document(),
        provenance: report.provenance(),
        table: report.table(),
        picture: show::of_scene(args, &scene, &report),
        said: report.rows.iter().map(|row| in_words(row, &report)).collect(),
        warnings: &report.facts.warnings,
        is_interrupted: report.is_interrupted(),
    };
    write(args, &chart, outputs)
}

/// Where contestants meet.
struct Arena<'a> {
    args: &'a ChartArgs,
    scene: &'a Scene,
    uavs: &'a [Uav],
    options: &'a MapOptions,
    truth: &'a Truth,
}

impl Arena<'_> {
    /// The memory floor, and the results of all contestants until the user interrupts.
    fn run(&self, contestants: &[Contestant]) -> Result<(Cost, Vec<ChartRow>)> {
        let n_planned = contestants.len() + usize::from(self.args.peers);
        in_turns(self.args, n_planned, |control| {
            let floor = memory_floor(self.scene.field.grid().n_cells(), self.args.time);
            // A map of several UAVs reads and writes everything for each.
            let n = self.uavs.len() as f64;
            let floor = Cost { cpu_s: floor.cpu_s.map(|cpu| cpu * n), wall_s: floor.wall_s * n, ..floor };
            let mut rows = Vec::new();
            let turns = contestants.iter().map(Some).chain(self.args.peers.then_some(None));
            for turn in turns {
                if interrupt::wants_to_stop() {
                    break;
                }
                rows.push(match turn {
                    Some(contestant) => self.row(contestant),
                    None => self.peer(),
                });
                control.done.fetch_add(1, Ordering::Relaxed);
            }
            (floor, rows)
        })
    }

    fn row(&self, contestant: &Contestant) -> ChartRow {
        let result = self.result(contestant);
        // Other cells may call for another exact engine.
        let method = result.as_ref().map_or(contestant.method, |(method, ..)| *method);
        ChartRow {
            method: method.to_string(),
            parameters: contestant.parameters(),
            label: contestant.label(),
            family: contestant.family(),
            result: result.map(|(_, cost, counts)| (cost, counts)),
        }
    }

    /// The engine in use, its cost and its counts, or why there are none.
    fn result(&self, contestant: &Contestant) -> std::result::Result<(Method, Cost, Comparison), String> {
        if let (Method::Ray, Some(checked)) = (contestant.method, self.truth.checked) {
            let n = self.truth.receivers();
            return Err(format!(
                "not run: {n} rays take too long; on a sample of {checked} it agrees with {}",
                self.truth.method
            ));
        }
        let prepared = contestant.prepare(&self.scene.field, self.uavs, self.options)?;
        let mapper = prepared.mapper().map_err(|e| e.to_string())?;
        let (answer, cost) = measured(self.args.time, || prepared.answer(&mapper));
        Ok((mapper.method().0, cost, self.truth.compare(&answer, contestant.ground.factor())))
    }

    fn peer(&self) -> ChartRow {
        let (parameters, result) = match peers::gdal_viewshed(&self.scene.field, self.uavs, self.args, self.truth) {
            Ok((version, answer, cost)) => (version, Ok((cost, self.truth.compare(&answer, 1)))),
            Err(reason) => (String::new(), Err(reason)),
        };
        let name = "gdal_viewshed".to_string();
        ChartRow { method: name.clone(), parameters, label: name, family: Family::Peer, result }
    }
}

/// A row in words.
fn in_words(row: &ChartRow, report: &ChartReport) -> String {
    let (cost, counts) = match &row.result {
        Ok(result) => result,
        Err(reason) => return format!("{}: {reason}", row.label),
    };
    let time = row.place().map_or_else(
        || format!("{:.3} ms wall time", 1e3 * cost.wall_s),
        |(cpu_ns, _)| format!("{cpu_ns:.2} ns of CPU time per receiver"),
    );
    let bias = report.truth.p_los_error(counts).map_or("undefined".to_string(), |error| format!("{error:+.5}"));
    let (wrong, all) = (grouped(counts.wrong()), grouped(counts.receivers));
    format!("{}: {time}, {wrong} of {all} receivers wrong, P_LoS error {bias}", row.label)
}
