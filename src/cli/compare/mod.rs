//! `skyshed compare`: placements side by side.

mod args;
mod masks;
mod show;
mod tables;
mod write;

use std::path::{Path, PathBuf};
use std::time::Instant;

pub(super) use args::CompareArgs;
use masks::{Setting, read_masks};
use tables::{Tables, margin_facts, pairs_of, tables};
use write::Writer;

use super::plan::{input_paths, outputs_with_table, ready};
use super::{interrupt, messages};
use crate::city::GivenSite;
use crate::cli::plan::uavs_asked;
use crate::coverage::{CellGroups, KeepMasks, Mapper, Overlay, SiteCoverage, Tally, Uav, class, count_sets};
use crate::error::{Error, Result, Warning};
use crate::export::{Batch, Format, OutputRules};
use crate::los::Method;
use crate::map::{Asked, check_receivers, checked_radius, receiver_height};
use crate::memory::check_memory;
use crate::raster::{CellBlocks, LargeVec};
use crate::read::source_of;
use crate::report::{CompareReport, IntervalFacts, Origin, PairFacts, PlacementFacts, SiteFacts, Timing, digest};
use crate::scene::Scene;
use crate::scene::limits::warn_of_flat_earth;
use crate::scene::outside::{place_uav, warn_of_uavs_outside};
use crate::words::pretty;
use crate::zones::{NONE, ZoneMap};

/// Formats of `skyshed compare`.
const FORMATS: [Format; 8] =
    [Format::Html, Format::Png, Format::Svg, Format::Pdf, Format::GeoTiff, Format::Csv, Format::Json, Format::Stdout];

/// Most placements: their pairs grow with the square.
const MOST_PLACEMENTS: usize = 16;
/// Most blocks of ground: each is drawn a thousand times.
const MOST_BLOCKS: usize = 1 << 16;
/// Receivers per placement whose margins are asked for.
const MARGIN_SAMPLE: usize = 1 << 16;
/// Confidence of the intervals.
const CONFIDENCE: f64 = 0.95;
/// What all masks laid over each other, the zones and a picture's surface take.
const BYTES_PER_CELL: usize = 5 + 1 + 4;

/// A mask, and where it comes from.
struct Placed {
    id: String,
    origin: Origin,
    mask: LargeVec<u8>,
    tally: Tally,
    margins: Option<crate::coverage::MarginSample>,
}

pub(super) fn run(args: &CompareArgs, command: Vec<String>) -> Result<()> {
    let start = Instant::now();
    let rx_height = receiver_height(args.rx_height)?;
    let radius_m = checked_radius(args.engine.radius)?;
    if args.block <= 0.0 {
        return Err(Error::usage(113, format!("`--block` is `{}`, wanted above 0 m", args.block)));
    }
    let outputs = outputs(args)?;
    let asked = uavs_asked(&args.uav, args.uavs.as_ref(), (args.skip_bad, args.scene.hash))?;
    let n_typed = asked.typed.len();
    if args.uavs.is_none() && args.mask.is_empty() {
        check_number(n_typed)?;
    }

    let mut scene = ready(&args.scene)?;
    let grid = scene.field.grid().clone();
    let found = asked.read(&grid)?;
    scene.sources.extend(found.sources);
    scene.warnings.extend(found.warnings);
    warn_of_uavs_outside(&found.sites, &grid, &mut scene.warnings);
    let radius = radius_m.map(|r| scene.crs_units(r));
    let place = |site: &GivenSite| place_uav(site, &scene.field, &grid, radius);
    let uavs: Vec<Uav> = found.sites.iter().map(place).collect::<Result<_>>()?;
    check_receivers(args.receivers, &scene.field)?;
    let blocks = CellBlocks::new(&grid, grid.meters_per_unit(), args.block);
    if blocks.count() > MOST_BLOCKS {
        let text =
            format!("cannot resample {} blocks of {} m, wanted at most {MOST_BLOCKS}", blocks.count(), args.block);
        return Err(Error::limit(502, text).with_hint("choose larger blocks: `--block M`"));
    }
    let n_bands = if outputs.iter().any(|(_, f)| *f == Format::GeoTiff) { pairs_of(uavs.len()).len() + 1 } else { 0 };
    check_memory(&args.scene.scene, &grid, uavs.len() + args.mask.len() + n_bands + BYTES_PER_CELL)?;
    warn_of_flat_earth(&uavs, &grid, radius, &mut scene.warnings);
    let zones = scene.zones();

    let before_los = Instant::now();
    let asked = Asked { receivers: args.receivers, rx_height, radius, method: args.engine.method };
    let (mut placed, method) = mapped(&scene, zones.as_ref(), &asked, (&found.sites, &uavs), args.out.quiet)?;
    scene.timing.los = before_los.elapsed().as_secs_f64();
    for path in &args.mask {
        placed.extend(saved(path, args, &mut scene)?);
    }
    check_number(placed.len())?;
    check_ids(&placed)?;
    for p in placed.iter().filter(|p| p.tally.receivers == 0) {
        let text = format!("placement `{}` has no receiver: {}; P_LoS is undefined", p.id, p.tally.reason());
        scene.warnings.push(Warning::new(202, text));
    }

    let masks: Vec<&[u8]> = placed.iter().map(|p| p.mask.as_slice()).collect();
    let mut overlay = Overlay::new(grid.n_cells());
    masks.iter().for_each(|mask| overlay.add(mask));
    let intervals = IntervalFacts { confidence: CONFIDENCE, block_m: args.block, seed: args.scene.seed };
    let no_zones = if zones.is_none() { vec![NONE; grid.n_cells()] } else { Vec::new() };
    let codes = zones.as_ref().map_or(no_zones.as_slice(), ZoneMap::codes);
    let cells = CellGroups { blocks: &blocks, groups: codes, n_cols: grid.n_cols() };
    let Tables { shares, differences } = tables(&masks, &cells, &intervals);
    let pairs = pairs_of(placed.len()).into_iter().zip(differences);
    let report = CompareReport {
        facts: scene.facts(command, method),
        rx_height_m: args.rx_height,
        receivers: args.receivers.name(),
        radius_m,
        intervals,
        has_zones: zones.is_some(),
        placements: placed
            .iter()
            .zip(shares)
            .map(|(p, groups)| PlacementFacts {
                id: p.id.clone(),
                origin: p.origin.clone(),
                tally: p.tally,
                groups,
                margins: p.margins.as_ref().map(|sample| margin_facts(sample, codes)),
            })
            .collect(),
        pairs: pairs.map(|((first, second), groups)| PairFacts { first, second, groups }).collect(),
        union: Tally::of_mask(overlay.union()),
        seen_by: seen_by(&overlay, placed.len()),
        sets: count_sets(&masks),
        digest: digest(&grid, masks.iter().copied()),
    };
    let before_write = Instant::now();
    let timing = Timing { total: start.elapsed().as_secs_f64(), ..scene.timing };
    interrupt::begin_writing();
    let mut batch = Batch::new(args.out.overwrite);
    let writer = Writer { args, scene: &scene, masks: &masks, overlay: &overlay, report: &report, timing };
    for (path, format) in &outputs {
        writer.add(&mut batch, path, *format)?;
    }
    let files = batch.commit()?;
    scene.timing.write = before_write.elapsed().as_secs_f64();
    scene.timing.total = start.elapsed().as_secs_f64();
    say(args, &report, scene.timing, (&outputs, &files))
}

/// The files to write, checked before any work.
fn outputs(args: &CompareArgs) -> Result<Vec<(PathBuf, Format)>> {
    let inputs: Vec<PathBuf> =
        input_paths(&args.scene).into_iter().chain(args.uavs.clone()).chain(args.mask.clone()).collect();
    let rules = OutputRules { allowed: &FORMATS, inputs: &inputs, overwrite: args.out.overwrite, bare: false };
    let outputs = outputs_with_table(&args.output, args.csv.as_ref(), rules)?;
    args.words.refuse_without_picture(&outputs)?;
    Ok(outputs)
}

/// A comparison needs two placements, and does not become clearer beyond a number.
fn check_number(n: usize) -> Result<()> {
    match n {
        0 | 1 => Err(Error::usage(108, format!("cannot compare: found {n} placements, wanted at least 2"))
            .with_hint("repeat `--uav X,Y,H`, or give `--uavs FILE` or `--mask FILE`")),
        n if n > MOST_PLACEMENTS => {
            let text = format!("cannot compare {n} placements, wanted at most {MOST_PLACEMENTS}");
            Err(Error::limit(502, text).with_hint("`skyshed map` makes maps and tables of any number"))
        }
        _ => Ok(()),
    }
}

fn check_ids(placed: &[Placed]) -> Result<()> {
    let mut seen = std::collections::HashSet::new();
    match placed.iter().find(|p| !seen.insert(&p.id)) {
        Some(twice) => Err(Error::site(207, format!("two placements are named `{}`, wanted different ids", twice.id))),
        None => Ok(()),
    }
}

/// Maps the UAVs and asks a sample of their receivers for margins; says which engine it was, if any was needed.
fn mapped(
    scene: &Scene,
    zones: Option<&ZoneMap>,
    asked: &Asked,
    (sites, uavs): (&[GivenSite], &[Uav]),
    quiet: bool,
) -> Result<(Vec<Placed>, Option<Method>)> {
    if uavs.is_empty() {
        return Ok((Vec::new(), None));
    }
    let options = asked.options(scene.field.grid(), zones);
    let mut mapper = Mapper::new(&scene.field, &options)?;
    mapper.drop_idle(uavs);
    let progress = interrupt::progress(quiet);
    let control = progress.control();
    let total = scene.field.grid().n_cells() as u64 * uavs.len() as u64;
    progress.begin(total);
    let maps = messages::with_progress(&progress, "receivers", quiet, || {
        mapper.map_many(uavs, KeepMasks::Always, control, |_| {}, |_| {})
    })?;
    let placed = |(site, given): (SiteCoverage, &GivenSite)| Placed {
        id: site.uav.id.clone(),
        origin: Origin::Uav(Box::new(SiteFacts { lonlat: given.lonlat, ..SiteFacts::of(&site, zones) })),
        margins: Some(mapper.margin_sample(&site, MARGIN_SAMPLE)),
        tally: site.tally,
        mask: site.mask,
    };
    Ok((maps.sites.into_iter().zip(sites).map(placed).collect(), Some(mapper.method().0)))
}

/// Placements from a file of masks, which becomes a source of the run.
fn saved(path: &Path, args: &CompareArgs, scene: &mut Scene) -> Result<Vec<Placed>> {
    let setting = Setting {
        scene: Path::new(&args.scene.scene),
        grid: scene.field.grid(),
        rx_height_m: args.rx_height,
        receivers: args.receivers.name(),
        radius_m: args.engine.radius,
    };
    let masks = read_masks(path, &setting, &mut scene.warnings)?;
    scene.sources.push(source_of(path, args.scene.hash)?);
    let placed = masks.into_iter().map(|saved| Placed {
        id: saved.id,
        origin: Origin::File { path: saved.path, place: saved.place },
        tally: Tally::of_mask(&saved.mask),
        mask: saved.mask,
        margins: None,
    });
    Ok(placed.collect())
}

/// Receivers of any placement that 0, 1, 2 … of `n` see.
fn seen_by(overlay: &Overlay, n: usize) -> Vec<u64> {
    let mut counts = vec![0; n + 1];
    for (class, count) in overlay.union().iter().zip(overlay.count()) {
        if matches!(*class, class::NLOS | class::LOS) {
            counts[*count as usize] += 1;
        }
    }
    counts
}

/// Says what came out, and answers on standard output.
fn say(
    args: &CompareArgs,
    report: &CompareReport,
    timing: Timing,
    (outputs, files): (&[(PathBuf, Format)], &[PathBuf]),
) -> Result<()> {
    if !args.out.quiet {
        messages::warnings(&report.facts.warnings);
        messages::note(&report.verdict());
        for p in &report.placements {
            let share = p.tally.p_los().map_or("undefined".to_string(), |p| format!("{p:.4}"));
            messages::note(&format!("{}: P_LoS {share}, {} of {} receivers", p.id, p.tally.los, p.tally.receivers));
        }
        report.pairs.iter().for_each(|pair| messages::note(&report.sentence(pair)));
        messages::note(&format!(
            "method {}: line of sight {:.3} s of {:.2} s",
            report.facts.method_in_words(),
            timing.los,
            timing.total
        ));
    }
    messages::wrote(files, args.out.quiet);
    if args.out.json || outputs.iter().any(|(_, f)| *f == Format::Stdout) {
        return messages::answer(&pretty(&report.document(Some(timing))));
    }
    if outputs.is_empty() {
        return messages::answer(&String::from_utf8_lossy(&args.out.table(&report.table())?));
    }
    Ok(())
}
