//! Other programs on the same scene, as separate processes.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use skyshed_request::TiffLayout;

use super::measure::{median, peak_mb_of, user_time_of_children};
use super::report::Cost;
use crate::accuracy::chart::Truth;
use crate::coverage::{Seen, Uav};
use crate::error::io_words;
use crate::formats::{Bands, GeoTiffImage, RasterFile, encode_geotiff};
use crate::height_field::HeightField;
use crate::progress::Progress;
use crate::quantity::{BLOCKS_ALL, VOID, meters};
use crate::raster::{BitGrid, GeoRef};

/// Runs after the first one, whose median is taken. A program that takes more than two seconds runs
/// once.
const RUNS: usize = 3;
const ONE_RUN_S: f64 = 2.0;
/// Interval between two readings of a running program's memory.
const LOOK_EVERY: Duration = Duration::from_millis(2);
/// Height in place of nodata, below everything, so that it blocks nothing \[m\].
const NODATA_M: f32 = -9999.0;

/// Answer of a peer: its version and settings, the visible receivers of each UAV, and the cost.
pub(super) type PeerAnswer = (String, Vec<Seen>, Cost);

/// Runs `gdal_viewshed` on the surface of the scene, as a whole process that reads the surface and
/// writes the mask.
///
/// The UAV is over the center of its cell. Its height above the surface there gives the same height
/// above the datum. Receivers stand on the surface, which is the ground of every open cell.
///
/// # Errors
/// The reason for having no answer.
pub(super) fn gdal_viewshed(
    field: &HeightField,
    uavs: &[Uav],
    rx_height_m: f64,
    truth: &Truth,
    progress: &Progress,
) -> Result<PeerAnswer, String> {
    let version = version_of("gdal_viewshed")?;
    let raster = if field.prisms().is_some() { field.rasterized() } else { None };
    let field = raster.as_ref().unwrap_or(field);
    let tops = field.columns().ok_or("the scene has no raster")?.tops();
    let folder = Scratch::new()?;
    let (surface, mask) = (folder.0.join("surface.tif"), folder.0.join("mask.tif"));
    write_surface(&surface, field.grid(), tops)?;
    let mut seen = Vec::new();
    let mut sum = Cost { cpu_s: Some(0.0), wall_s: 0.0, peak_mb: None, runs: 0 };
    for (uav, exact) in uavs.iter().zip(&truth.seen) {
        let words = words_for(uav, field.grid(), tops, rx_height_m)?;
        let cost = timed(progress, || {
            // The program refuses to replace a file.
            let _ = std::fs::remove_file(&mask);
            run(Command::new("gdal_viewshed").args(&words).arg(&surface).arg(&mask))
        })?;
        sum = Cost {
            cpu_s: sum.cpu_s.zip(cost.cpu_s).map(|(a, b)| a + b),
            wall_s: sum.wall_s + cost.wall_s,
            peak_mb: cost.peak_mb.into_iter().chain(sum.peak_mb).reduce(f64::max),
            runs: sum.runs.max(cost.runs),
        };
        let los = read_mask(&mask, field.grid())?.and(&exact.receivers);
        seen.push(Seen { receivers: exact.receivers.clone(), los });
    }
    Ok((format!("{version}, whole process, UAV over the cell's center"), seen, sum))
}

/// Returns the version that a program of GDAL reports, such as `GDAL 3.6.2`.
fn version_of(program: &str) -> Result<String, String> {
    let told = Command::new(program).arg("--version").stdin(Stdio::null()).output();
    let told = told.map_err(|_| format!("{program} is not found on the PATH"))?;
    let text = String::from_utf8_lossy(&told.stdout);
    let version = text.split([',', '\n']).next().unwrap_or_default().trim();
    if version.is_empty() { Ok("GDAL of an unknown version".into()) } else { Ok(version.to_string()) }
}

/// Writes the surface as an uncompressed GeoTIFF in strips, which every program reads fast.
fn write_surface(path: &Path, grid: &GeoRef, tops: &[i32]) -> Result<(), String> {
    let height = |top: &i32| {
        #[expect(clippy::cast_possible_truncation, reason = "files of heights hold f32")]
        let height = meters(*top) as f32;
        if *top == VOID || *top == BLOCKS_ALL { NODATA_M } else { height }
    };
    let heights: Vec<f32> = tops.iter().map(height).collect();
    let bytes = encode_geotiff(&GeoTiffImage {
        georef: grid,
        bands: Bands::Float(vec![(String::new(), &heights)]),
        nodata: None,
        palette: None,
        metadata: &[],
        layout: TiffLayout::Plain,
    });
    let bytes = bytes.map_err(|e| e.to_string())?;
    std::fs::write(path, bytes).map_err(|e| format!("cannot write {}: {}", path.display(), io_words(&e)))
}

/// Returns the command-line words for a UAV, without the files.
fn words_for(uav: &Uav, grid: &GeoRef, tops: &[i32], rx_height_m: f64) -> Result<Vec<String>, String> {
    let place = &uav.station.place;
    let (east, north) = grid.cells_from_world(place.x, place.y);
    // Rows count from the north, as in GDAL. A place on an edge is in the cell to its south-east.
    let south = grid.n_rows() as f64 - north;
    let is_inside = south >= 0.0 && east >= 0.0 && south < grid.n_rows() as f64 && east < grid.n_cols() as f64;
    if !is_inside {
        return Err(format!("UAV `{}` is outside the raster", uav.id));
    }
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within the grid by the check above")]
    let top = tops[south as usize * grid.n_cols() + east as usize];
    if top == VOID || top == BLOCKS_ALL {
        return Err(format!("UAV `{}` is over a cell without a height", uav.id));
    }
    let above = uav.height_amsl_m() - meters(top);
    let numbers =
        [("-ox", place.x), ("-oy", place.y), ("-oz", above), ("-tz", rx_height_m), ("-md", 0.0), ("-cc", 0.0)];
    let plain = ["-q", "-f", "GTiff", "-vv", "1", "-iv", "0", "-ov", "0", "-co", "COMPRESS=NONE"].map(str::to_string);
    Ok(numbers.into_iter().flat_map(|(flag, v)| [flag.to_string(), v.to_string()]).chain(plain).collect())
}

/// Runs a program often enough to time it.
fn timed(progress: &Progress, mut run: impl FnMut() -> Result<Option<f64>, String>) -> Result<Cost, String> {
    let mut once = || -> Result<Cost, String> {
        let (before, start) = (user_time_of_children(), Instant::now());
        let peak_mb = run()?;
        let wall_s = start.elapsed().as_secs_f64();
        let cpu_s = before.zip(user_time_of_children()).map(|(before, after)| (after - before).as_secs_f64());
        Ok(Cost { cpu_s, wall_s, peak_mb, runs: 1 })
    };
    let first = once()?;
    if first.wall_s > ONE_RUN_S {
        return Ok(first);
    }
    let mut runs = Vec::new();
    while runs.len() < RUNS && !progress.is_stopped() {
        runs.push(once()?);
    }
    if runs.is_empty() {
        return Ok(first);
    }
    Ok(Cost {
        cpu_s: runs.iter().map(|cost| cost.cpu_s).collect::<Option<Vec<f64>>>().map(median),
        wall_s: median(runs.iter().map(|cost| cost.wall_s).collect()),
        peak_mb: runs.iter().filter_map(|cost| cost.peak_mb).reduce(f64::max),
        runs: u32::try_from(runs.len()).unwrap_or(u32::MAX),
    })
}

/// Runs a program to its end. Returns the peak of its memory \[MB\] where the system reports it.
///
/// The peak is read while the program runs. The peak reported at its end would include memory that
/// the child inherits before it becomes the program.
fn run(command: &mut Command) -> Result<Option<f64>, String> {
    let failed = |cause: String| format!("gdal_viewshed failed: {cause}");
    command.env("LC_ALL", "C").stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    let mut child = command.spawn().map_err(|e| failed(e.to_string()))?;
    let process = child.id().to_string();
    let mut peak = None;
    let status = loop {
        match child.try_wait().map_err(|e| failed(e.to_string()))? {
            Some(status) => break status,
            None => peak = peak_mb_of(&process).or(peak),
        }
        std::thread::sleep(LOOK_EVERY);
    };
    if status.success() { Ok(peak) } else { Err(failed(status.to_string())) }
}

/// Reads the visible cells of a mask of 0 and 1.
fn read_mask(path: &Path, grid: &GeoRef) -> Result<BitGrid, String> {
    let file = RasterFile::open(path, &mut Vec::new()).map_err(|e| e.to_string())?;
    let found = (file.georef().n_rows(), file.georef().n_cols());
    if found != (grid.n_rows(), grid.n_cols()) {
        return Err(format!("its mask has {} × {} cells, wanted those of the scene", found.1, found.0));
    }
    let cells = file.read(file.georef().window(), &mut Vec::new(), |v| u8::from(v > 0.5)).map_err(|e| e.to_string())?;
    let mut los = BitGrid::new(found.0, found.1);
    for row in 0..found.0 {
        cells.row(row).iter().enumerate().filter(|(_, is_los)| **is_los == 1).for_each(|(col, _)| los.insert(row, col));
    }
    Ok(los)
}

/// A folder for the files of another program, removed when dropped.
#[derive(Debug)]
struct Scratch(PathBuf);

impl Scratch {
    fn new() -> Result<Scratch, String> {
        let path = std::env::temp_dir().join(format!("skyshed-chart-{}", std::process::id()));
        // An existing folder may belong to another process.
        std::fs::create_dir(&path)
            .map_err(|e| format!("cannot make the folder {}: {}", path.display(), io_words(&e)))?;
        Ok(Scratch(path))
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}
